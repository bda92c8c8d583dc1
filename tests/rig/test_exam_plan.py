"""The exams: planned from a seed alone, each form asked alike, the sealed ones in the sealed exam only."""

import hashlib
import importlib.util
import sys
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.rig import FORM_SETS
from flexmodal.structure.arm import plane_normal

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def load(name: str):
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


exam_question, exam_forms, exam_plan = load("exam_question"), load("exam_forms"), load("exam_plan")


def test_the_exam_of_own_forms_is_the_one_that_was_published():
    """Effects that came later stand behind."""
    asked = [(q.name, q.robot, q.kind, q.effects, q.seed) for q in exam_plan.plan(20261128)]
    asked, later = asked[:120], asked[120:]
    assert {q[3] for q in later} == {(name,) for name in exam_plan.SINCE}
    assert hashlib.sha256(repr(asked).encode()).hexdigest().startswith("501c3af09062d91d")
    assert all(q.forms == () and q.arm == 0 for q in exam_plan.plan(20261128))


@pytest.mark.parametrize("which", FORM_SETS)
def test_an_exam_of_forms_asks_each_of_its_own_alike(which):
    table = FORM_SETS[which]
    questions = exam_plan.plan(4, forms=which)
    assert questions == exam_plan.plan(4, forms=which)
    assert questions != exam_plan.plan(5, forms=which)
    singles = Counter((q.effects[0], q.forms[0]) for q in questions if q.kind == "single")
    assert singles == {(name, form): 3 for name, forms in table.items() for form in forms}
    own = {(name, form) for name, forms in table.items() for form in forms} | {
        (name, "own") for name in exam_question.OUTSIDE
    }
    assert {pair for q in questions for pair in zip(q.effects, q.forms, strict=True)} <= own
    kinds = Counter(q.kind for q in questions)
    assert {kind for kind in kinds if kinds[kind]} == {"single", "pair", "several", "nothing", "outside"}
    assert {len(q.effects) for q in questions if q.kind == "several"} == {3, 4, 5}
    assert len({q.name for q in questions}) == len({q.seed for q in questions}) == len(questions)
    assert {q.robot for q in questions} == {"fanuc_s360", "six_link", "six_axis", "arm"}
    assert all((q.arm > 0) == (q.robot == "arm") for q in questions)


def test_make_exam_asks_every_set_of_forms():
    text = (BENCHMARKS.parent / "Makefile").read_text(encoding="utf-8")
    said = next(line for line in text.splitlines() if line.startswith("FORM_SETS :="))
    assert said.split()[2:] == list(FORM_SETS)


def test_an_arm_has_places_for_what_is_hidden_in_it(tmp_path):
    """A twist needs an arm that is not planar, whichever arm the seed would give."""
    question = exam_question.Question("1", "arm", "single", ("link_flexibility",), 1, ("twisting",), 0)
    for arm in range(8):
        robot = exam_question.find_robot(replace(question, arm=arm), tmp_path / str(arm))
        assert plane_normal(robot) is None


@pytest.mark.slow
def test_a_question_is_posed_without_telling_what_is_hidden(tmp_path):
    question = exam_question.Question(
        "1", "arm", "pair", ("time_delay", "joint_coupling"), 3, ("all_pass", "idler"), 17
    )
    exam_question.pose(question, tmp_path / "campaign", tmp_path / "truth" / "1.toml")
    told = (tmp_path / "truth" / "1.toml").read_text()
    assert 'form = "all_pass"' in told
    assert 'form = "idler"' in told
    for file in (tmp_path / "campaign").rglob("*.toml"):
        for secret in (b"idler", b"all_pass", b"time_delay", b"coupling", b"seed = "):
            assert secret not in file.read_bytes()
    robot = flexmodal.load(tmp_path / "campaign" / "robot" / "robot.toml")
    assert len(read_campaign(tmp_path / "campaign").postures) == exam_question.POSTURES
    assert set(robot.joints) == {f"q{n}" for n in range(1, len(robot.joints) + 1)}


def row(kind, hidden, forms, said):
    named = sorted(name for name, _ in said) == sorted(name for name, _ in hidden)
    placed = sorted(said) == sorted(hidden)
    return {"kind": kind, "hidden": hidden, "forms": forms, "said": said, "effect": named, "place": placed}


def test_tables_count_what_was_named():
    gain, delay = ("sensor_gain", "tip"), ("time_delay", "tip")
    said_three = [delay, gain, delay]
    rows = [
        row("single", [gain], ["aged"], [gain]),
        row("single", [gain], ["aged"], [("sensor_gain", "elbow")]),
        row("single", [gain], ["aged"], [delay]),
        row("single", [gain], ["inverted"], []),
        row("pair", [gain, delay], ["aged", "bessel"], [gain]),
        row("several", [gain, delay, ("added_mass", "l")], ["aged", "bessel", "two"], said_three),
    ]
    text = exam_forms.by_form(rows)
    assert "| sensor_gain | aged | 2/3 | 1/3 | 67 % | time_delay (1) |" in text
    assert "| sensor_gain | inverted | 0/1 | 0/1 | 0 % | nothing (1) |" in text
    counts = exam_forms.at_once(rows)
    assert "| 2 | 1 | 0 | 0 | 1 of 2 | 0 |" in counts
    assert "| 3 | 1 | 0 | 0 | 2 of 3 | 1 |" in counts


def test_effects_that_re_tuning_takes_up_are_told_apart():
    """Of three pairs one has an effect that no measurement tells of; the page counts without it too."""
    load("exam_lawfree")
    report = load("exam_report")
    pairs = [
        {"retuned": [3.0, 0.02], "effect": False},
        {"retuned": [3.0, 0.2], "effect": True},
        {"retuned": [0.4, 7.0], "effect": False},
        {"retuned": [], "effect": True},
    ]
    (line,) = report.that_tell([{"retuned": [], "effect": True}], pairs)
    assert line.startswith(
        "| two effects hidden, each 0.1 noise floors or more with all else re-tuned: named "
    )
    assert line.endswith("| 1 of 2 (50 %) |")


def test_effects_are_counted_by_what_re_tuning_leaves_of_them():
    mass, lag, play = ("added_mass", "a"), ("time_delay", "b"), ("clearance", "c")
    rows = [
        {"kind": "pair", "hidden": [mass, lag], "said": [lag], "retuned": [0.05, 7.0]},
        {"kind": "single", "hidden": [mass], "said": [mass], "retuned": [0.4]},
        {"kind": "single", "hidden": [mass], "said": [lag], "retuned": [0.9]},
        {"kind": "outside", "hidden": [play], "said": [], "retuned": [0.9]},
    ]
    found = exam_forms.by_height(rows)
    counted = found[found.index("|---|---:|---:|") + 1 :]
    assert [line for line in counted if not line.endswith("| 0 of 0 | 0 of 0 |")] == [
        "| 0 to 0.1 | 0 of 0 | 0 of 1 |",
        "| 0.3 to 1 | 1 of 2 | 0 of 0 |",
        "| 3 and more | 0 of 0 | 1 of 1 |",
    ]
    assert exam_forms.by_height([{**row, "retuned": []} for row in rows]) == []


@pytest.mark.slow
def test_the_truth_of_other_forms_tells_how_high_an_effect_stands_re_tuned(tmp_path):
    question = next(q for q in exam_plan.plan(8, forms="looked") if q.kind == "single")
    exam_question.pose(question, tmp_path / "campaign", tmp_path / "truth.toml")
    (hidden,) = tomllib.loads((tmp_path / "truth.toml").read_text(encoding="utf-8"))["effect"]
    assert 0 < hidden["times_noise_floor_retuned"] < 1.2 * hidden["times_noise_floor"]

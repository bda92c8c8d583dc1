"""The improved robot, loaded from its files, has the receptances of the diagnosis' final model."""

import re
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import read_urdf
from flexmodal.diagnosis.effects import Context, bearing_flexibility, catalogue, link_motion
from flexmodal.diagnosis.effects.behind_spring import BEHIND
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.rod import springs, tightened
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.diagnosis.improved.extend import extend
from flexmodal.diagnosis.placed import Placed
from flexmodal.errors import InvalidRequest
from flexmodal.identification import observe
from flexmodal.model import check
from flexmodal.model.collision import scene_of
from flexmodal.rig import simulate
from flexmodal.structure import robot_space
from flexmodal.structure.arm import bodies_of
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.solution import solved
from flexmodal.structure.structure import Axis

from .conftest import NEXT, effect_of

STRUCTURAL = (
    "link_flexibility", "base_flexibility", "servo_compliance", "structural_damping", "joint_coupling",
    "bearing_flexibility",
    "added_mass", "local_absorber", "local_absorber" + NEXT, "base_flexibility" + NEXT,
    "link_flexibility" + NEXT,
    "servo_compliance" + NEXT, "bearing_flexibility" + NEXT,
)  # fmt: skip
ROBOTS = ("fanuc_s360", "six_link", "six_axis")
ROOT = Path(__file__).parents[2]
SEEN = {}
"""What was measured, by context."""


def seen_by(robot, observations):
    """The context of observations, which are kept for it."""
    context = Context.of(robot, observations)
    SEEN[context] = observations
    return context


@pytest.fixture(scope="session")
def context_of():
    """What a short campaign on a robot shows; made once for each."""
    made = {}

    def context(name):
        if name not in made:
            campaign = simulate(
                flexmodal.load(name), postures=2, points=3, references=2, trials=2, averages=2, seed=3,
                record_length=1.0, band=(2.0, 120.0),
            ).campaign  # fmt: skip
            # the rig gives the base mass; so does the card it writes
            made[name] = seen_by(flexmodal.load(name), observe(campaign))
        return made[name]

    return context


def drawn(context, placed, seed):
    """A hypothesis with effects, and coordinates off the card and off the centres of the priors."""
    hypothesis = Hypothesis(context, robot_space(context.robot))
    for effect, where in placed:
        hypothesis = hypothesis.and_also(Placed(effect_of(effect), where))
    random = np.random.default_rng(seed)
    low, high = hypothesis.space.bounds
    size = [min(0.3 * p.deviation, 0.2) for p in hypothesis.space]
    x = np.clip(random.normal(0, 1, len(low)) * size, low, high)
    soft = 3 * context.band[1]  # what gives next to nothing is left out of files
    for name, value in (("position", 0.42), ("along", 0.8), ("mount_frequency", soft), ("other", 0.3)):
        for k, parameter in enumerate(hypothesis.space):
            if parameter.name.endswith(f".{name}"):
                x[k] = parameter.coordinate(value)
    for k, parameter in enumerate(hypothesis.space):  # what no file holds
        coupling = parameter.name.startswith("joint_coupling@")
        if (coupling and parameter.name.endswith((".inertia", "_time"))) or parameter.name.endswith(
            ("relaxing", ".integral", ".lag", ".wheel", "sway", ".loaded")
        ):
            x[k] = low[k]
        if parameter.name.endswith(".belt"):
            x[k] = high[k]
        if ".loss_ratio_" in parameter.name:  # held to first order
            x[k] = 0.0
    return hypothesis, x


def receptances(robot, observations):
    """By the loaded robot, for every observation."""
    points = {p.id: p.name for p in observations.campaign.points}
    value = np.zeros((len(observations), len(observations.axis)), dtype=complex)
    for row in range(len(observations)):
        posture = dict(observations.postures[int(observations.posture[row])].q)
        response, reference = (
            f"{points[int(number)]}:{'xyz'[int(way) - 1]}"
            for number, way in (observations.response[row], observations.reference[row])
        )
        found = robot.frf(posture, observations.axis.frequency, response=response, reference=reference)
        value[row] = found.value[:, 0, 0]
    return value


def written(diagnosed, hypothesis, x, folder):
    """Extend, write, check, load."""
    observations = SEEN[hypothesis.context]
    diagnosis = replace(
        diagnosed, model=hypothesis, x=x, deviation=np.zeros(len(x)), frfs=observations,
        predicted={"after": observations.value},
    )  # fmt: skip
    extension = extend(diagnosis)
    card = extension.write(folder)
    report = check(card)
    assert report.is_sound, report.faults
    return extension, flexmodal.load(card)


def bare(hypothesis, x):
    """What the model predicts, without what the end of a record does to a measurement."""
    observations = SEEN[hypothesis.context]
    axis = Axis(observations.axis.frequency, observations.axis.middle)
    value = np.zeros((len(observations), len(axis)), dtype=complex)
    for group in hypothesis.groups(x, observations, slopes=False):
        part = group.part
        value[part.observations] = solved(group.structures, axis, part.entries).value[part.entry]
    return value


def agreement(loaded, hypothesis, x):
    """Largest relative difference; the smallest receptances beside a thousandth of the posture's largest."""
    observations = SEEN[hypothesis.context]
    truth = bare(hypothesis, x)
    found = receptances(loaded, observations)
    worst = 0.0
    for posture in range(len(observations.postures)):
        rows = observations.posture == posture
        size = np.abs(truth[rows])
        worst = max(
            worst, float(np.max(np.abs(found - truth)[rows] / np.maximum(size, 1e-3 * size.max(axis=0))))
        )
    return worst


@pytest.mark.parametrize(
    ("parameter", "value", "says"),
    [
        ("inertia", 2.0, "lack its idler"),
        ("damping_time", 3e-3, "lack its damper, 0.003 s"),
        ("ratio", 1.0, None),
    ],
)
def test_what_no_file_holds_of_a_coupling_is_told(context_of, diagnosed, tmp_path, parameter, value, says):
    hypothesis, x = drawn(context_of("fanuc_s360"), [("joint_coupling", "q1+q3")], seed=2)
    for k, known in enumerate(hypothesis.space):
        if known.name == f"joint_coupling@q1+q3.{parameter}":
            x[k] = known.coordinate(value)
    extension, _ = written(diagnosed, hypothesis, x, tmp_path)
    told = [note for note in extension.notes if "the spring between q1 and q3" in note]
    assert len(told) == (says is not None)
    assert all(says in note for note in told)


@pytest.mark.parametrize(("robot", "where"), [("fanuc_s360", "q1+q3"), ("six_axis", "q2+q3")])
def test_a_rod_is_in_the_files_as_in_the_mean_posture(robot, where, context_of, diagnosed, tmp_path):
    context = context_of(robot)
    hypothesis, x = drawn(context, [("joint_coupling" + NEXT, where)], seed=2)
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    assert f"the rod between {where.replace('+', ' and ')}" in "".join(extension.notes)
    values = hypothesis.space.values(x)
    placement = Placement.still(context, where, hypothesis.values_of(hypothesis.placed[0], values))
    joints = list(context.robot.joints)
    expected = np.diag([values[f"stiffness.{name}"] for name in joints])
    for arm in context.arms:
        for row, stiffness in springs(Assembly(arm), placement):
            expected = expected + stiffness * np.outer(row, row) / len(context.arms)
        pull = placement["rod_pull"] * placement["rod_stiffness"]
        expected = expected + pull * tightened(Assembly(arm), placement) / len(context.arms)
    assert list(loaded.joints) == joints
    np.testing.assert_allclose(loaded.stiffness, expected, rtol=1e-6)
    assert np.count_nonzero(expected) > len(joints)


def by_themselves(monkeypatch):
    """Let a link twist and shear at each of its cuts by itself, as that in files does."""
    pieces = link_motion._pieces

    def alone(context, where, places):
        return [
            (share * part, ((place, 1.0),))
            for share, cuts in pieces(context, where, places)
            for place, part in cuts
        ]

    monkeypatch.setattr(link_motion, "_pieces", alone)
    monkeypatch.setattr(link_motion, "_sections", link_motion._sections.__wrapped__)


@pytest.mark.parametrize("level", ["", NEXT])
def test_a_link_seen_between_its_ends_twists_in_the_files_at_each_place_by_itself(
    level, context_of, diagnosed, tmp_path, monkeypatch
):
    placed = [("link_flexibility" + level, "link_4")]
    hypothesis, x = drawn(context_of("six_axis"), placed, seed=1)
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    off = agreement(loaded, hypothesis, x)
    assert "in the files link_4 twists and shears in each place by itself, not evenly" in extension.notes
    by_themselves(monkeypatch)
    alone, x = drawn(context_of("six_axis"), placed, seed=1)
    assert agreement(loaded, alone, x) < off / 5 < 1.2e-3, (
        "what the slide of a crack is shared out to differs"
    )


@pytest.mark.some(3)
@pytest.mark.parametrize(
    ("name", "robot"),
    [
        pytest.param(name, robot, marks=[] if (number + k) % 3 else [pytest.mark.slow])
        for number, name in enumerate(STRUCTURAL)
        for k, robot in enumerate(ROBOTS)
    ],
)
def test_each_effect(name, robot, context_of, diagnosed, tmp_path, monkeypatch):
    context = context_of(robot)
    drive = bearing_flexibility._drive

    def undamped(assembly, placement):  # the files lack what a mesh damps, as a note says
        drive(Mock(spec=Assembly, wraps=assembly, add_damper=lambda *_: None), placement)

    monkeypatch.setattr(bearing_flexibility, "_drive", undamped)
    monkeypatch.setattr(bearing_flexibility, "_turned", lambda placement, joint: 0.0)  # nor this, as well
    by_themselves(monkeypatch)
    where = effect_of(name).places(context)
    for number, place in enumerate(where[:: max(1, len(where) // 2)]):
        hypothesis, x = drawn(context, [(name, place)], seed=number)
        folder = tmp_path / str(number)
        folder.mkdir()
        extension, loaded = written(diagnosed, hypothesis, x, folder)
        # 1e-12 of the arm's mass between two joints, 1e-8 in a base without any; parts of a link whose
        # inertia is less than that of a thin rod have none that a body could have, as a note says;
        # a loop hardly integrates or lags at its bounds, nor does a belt give or a link sway
        noted = any("nearest that a body can have" in note for note in extension.notes)
        lags = any(parameter.name.endswith(".lag") for parameter in hypothesis.space)
        exact = 1e-5 if any(".mesh_" in parameter.name for parameter in hypothesis.space) else 1e-6
        gives = any(parameter.name.endswith(".belt") for parameter in hypothesis.space)
        allowed = 6e-3 if gives else 1e-3 if noted else 1e-4 if lags else exact
        assert agreement(loaded, hypothesis, x) < allowed, (place, extension.notes)
        assert loaded.is_planar == context.robot.is_planar
        plain, _ = drawn(context, [], seed=number)
        assert agreement(loaded, plain, x[: len(plain.space)]) > 1e-3  # the effect is there at all


def test_a_bearing_that_turns_with_its_joint_is_in_the_files_as_in_the_first_posture(
    context_of, diagnosed, tmp_path
):
    context = context_of("six_axis")
    hypothesis, x = drawn(context, [("bearing_flexibility" + NEXT, "q5")], seed=3)
    for k, known in enumerate(hypothesis.space):
        if known.name.endswith(".follows") or ".mesh_" in known.name:
            x[k] = known.coordinate(1.0 if known.name.endswith(".follows") else 0.0)
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    assert "as they lie in the first posture; they turn by 1 of its angle" in "".join(extension.notes)
    observations = SEEN[context]
    off = np.abs(receptances(loaded, observations) / bare(hypothesis, x) - 1).max(axis=-1)
    first = observations.posture == 0
    assert off[first].max() < 1e-5 < 1e-3 < off[~first].max()


@pytest.mark.parametrize("robot", ["fanuc_s360", "six_axis"])
def test_a_spring_behind_a_joints_own_is_in_the_files_as_for_small_swings(
    robot, context_of, diagnosed, tmp_path
):
    context = context_of(robot)
    hypothesis, x = drawn(context, [("nonlinear_stiffness", "q2")], seed=4)
    hypothesis = hypothesis.without(("nonlinear_stiffness", "q2")).and_also(Placed(BEHIND, "q2"))
    law = {"behind_softer": 0.7, "behind_frequency": 90.0, "change": 0.0}
    x = hypothesis.start(hypothesis.placed[-1], law, x[: len(hypothesis.base)])
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    assert agreement(loaded, hypothesis, x) < 1e-6
    assert "as it is for small swings" in "".join(extension.notes)
    without = hypothesis.start(
        hypothesis.placed[-1], {**law, "behind_softer": 0.3}, x[: len(hypothesis.base)]
    )
    assert agreement(loaded, hypothesis, without) > 0.05


def test_a_liquid_is_frozen_in_the_files(context_of, diagnosed, tmp_path):
    """All of it hangs there, and a note says how much of it does not go along."""
    context = context_of("six_axis")
    hypothesis, x = drawn(context, [("added_mass" + NEXT, context.links[-1])], seed=1)
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    values = hypothesis.space.values(x)
    mass, part = (values[f"added_mass@{context.links[-1]}.{name}"] for name in ("mass", "sloshing"))
    assert any(f"{part:.3g} of it stays behind sideways" in note for note in extension.notes)
    plain = sum(body.mass for body in bodies_of(context.robot.urdf).values())
    assert sum(body.mass for body in bodies_of(loaded.urdf).values()) > plain + 0.5 * mass


def test_each_joint_takes_its_loss_into_the_files(context_of, diagnosed, tmp_path):
    hypothesis, x = drawn(context_of("fanuc_s360"), [("structural_damping", "joints")], seed=1)
    ratios = {}
    for k, parameter in enumerate(hypothesis.space):
        if ".loss_ratio_" in parameter.name:
            x[k] = (-0.6, 0.5, 0.3, -0.4)[len(ratios) % 4]
            ratios[parameter.name.rpartition("loss_ratio_")[2]] = float(np.exp(x[k]))
    common = hypothesis.space.values(x)["structural_damping@joints.loss_factor"]
    _, loaded = written(diagnosed, hypothesis, x, tmp_path)
    for joint, ratio in ratios.items():
        assert loaded.joints[joint].loss_factor == pytest.approx(common * ratio, rel=1e-9)
    truth, found = bare(hypothesis, x), receptances(loaded, SEEN[hypothesis.context])
    there = np.abs(truth) > 1e-3 * np.abs(truth).max()
    assert np.sqrt(np.mean(np.abs(np.log(found[there] / truth[there])) ** 2)) < 0.01


ALL = {
    "fanuc_s360": ("link_1", "q2", "q1+q2", "link_1", "link_3"),
    "six_axis": ("link_2", "q2", "q2+q3", "link_2", "link_3"),
}


@pytest.mark.parametrize("robot", ALL)
def test_all_at_once(robot, context_of, diagnosed, tmp_path):
    """On top of one another: a payload beyond the hinge of a link, a coupling on a joint with a motor."""
    link, joint, pair, loaded_link, hung = ALL[robot]
    context = context_of(robot)
    placed = [
        ("added_mass", loaded_link), ("link_flexibility", link), ("servo_compliance", joint),
        ("joint_coupling", pair), ("structural_damping", "joints"), ("local_absorber", hung),
        ("base_flexibility", "base"),
    ]  # fmt: skip
    hypothesis, x = drawn(context, placed, seed=5)
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    assert agreement(loaded, hypothesis, x) < 1e-5
    assert set(loaded.commanded) == set(context.robot.commanded)
    assert extension.card.source.count(" and ") == 6
    payload = next(j for j in loaded.urdf.joints if j.name == f"{loaded_link}_payload")
    assert payload.parent.startswith(f"{link}_beyond_")
    assert loaded.frf(
        "posture" if "posture" in loaded.postures else next(iter(loaded.postures)), [0.0]
    ).value.size


def test_points_beyond_the_cut_move_with_it(context_of, diagnosed, tmp_path):
    context = context_of("fanuc_s360")
    hypothesis, x = drawn(context, [("link_flexibility", "link_1")], seed=1)
    _, loaded = written(diagnosed, hypothesis, x, tmp_path)
    far = [name for name, point in context.robot.points.items() if point.link == "link_1"]
    assert far
    last = max(link.name for link in loaded.urdf.links if link.name.startswith("link_1_beyond_"))
    for name in far:
        assert loaded.points[name].link == last
        before, after = (robot.at("configuration_2").position(name) for robot in (context.robot, loaded))
        np.testing.assert_allclose(after, before, atol=1e-12)


def test_re_tuned_parameters_are_in_the_files(context_of, diagnosed, tmp_path):
    context = context_of("fanuc_s360")
    hypothesis, x = drawn(context, [], seed=7)
    values = hypothesis.space.values(x)
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    for name, joint in loaded.joints.items():
        assert joint.stiffness == values[f"stiffness.{name}"]
        assert joint.damping == values[f"damping.{name}"]
    for name in ("link_1", "link_3"):
        link, card = loaded.urdf.link_by_name[name], context.robot.urdf.link_by_name[name]
        assert link.mass == values[f"mass.{name}"]
        grown = values[f"mass.{name}"] / card.mass * values[f"inertia.{name}"]
        np.testing.assert_allclose(link.inertia[1, 1], card.inertia[1, 1] * grown, rtol=1e-12)
    assert "re-tuned on the campaign" in extension.card.source
    assert loaded.name == "fanuc_s360_diagnosed"
    assert set(loaded.postures) >= set(context.robot.postures)
    assert set(loaded.families) == set(context.robot.families)


@pytest.mark.parametrize(
    ("effect", "place", "why"),
    [
        ("sensor_mass", 0, "is of the sensors"),
        ("sensor_gain", 0, "is of the sensors"),
        ("time_delay", 0, "is of the sensors"),
        ("sensor_misalignment", 0, "is of the sensors"),
        ("coulomb_friction", 1, "depends on the force"),
        ("nonlinear_stiffness", 1, "depends on the force"),
    ],
)
def test_what_files_cannot_hold_is_noted(effect, place, why, context_of, diagnosed, tmp_path):
    context = context_of("fanuc_s360")
    where = catalogue()[effect].places(context)[place]
    hypothesis, x = drawn(context, [(effect, where)], seed=2)
    extension, loaded = written(diagnosed, hypothesis, x, tmp_path)
    (note,) = extension.notes
    assert note.startswith(f"{effect} at {where} (")
    assert why in note
    assert f"# {note}\n" in (tmp_path / "robot.toml").read_text(encoding="utf-8")
    assert len(loaded.urdf.links) == len(context.robot.urdf.links)


def test_an_effect_of_somebody_else_without_a_hook(context_of, diagnosed, tmp_path):
    context = context_of("fanuc_s360")
    foreign = replace(catalogue()["added_mass"], name="theirs", extend=None)
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(Placed(foreign, "link_1"))
    extension, _ = written(diagnosed, hypothesis, np.zeros(len(hypothesis.space)), tmp_path)
    assert "says nothing of how it changes the files" in extension.notes[0]


def test_names_that_are_taken(context_of):
    draft = Draft(context_of("fanuc_s360").robot, {})
    assert draft.fresh("link_1") == "link_1_2"
    assert draft.fresh("link_1") == "link_1_3"
    assert draft.fresh("location_1") == "location_1_2"


def full_card(robot, folder):
    """The robot, loaded from a card that says all that a card can, but for couplings and loss factors."""
    text = (ROOT / "robots" / robot.name / "robot.toml").read_text(encoding="utf-8")
    urdf = f'urdf = "{robot.urdf.path}"\nsrdf = "arm.srdf"'
    text = re.sub(r"^urdf = .*$", lambda _: urdf, text, flags=re.MULTILINE)
    joint = "[joint.q1]\n"
    assert joint in text
    text = text.replace(joint, f"{joint}rotor_inertia = 0.5\nlower = 0.6\nupper = 1.7\nscale = 0.4\n")
    text += """
        [obstacle.table]
        box = [1.0, 1.0, 0.1]
        xyz = [0.0, 0.0, -0.9]
        [obstacle.near]
        sphere = 0.02
        xyz = [-0.05, 0.0, 0.0]
        link = "link_1"
        [obstacle.far]
        cylinder = [0.02, 0.1]
        xyz = [0.8, 0.0, 0.0]
        rpy = [0.1, 0.2, 0.3]
        link = "link_1"
    """
    folder.mkdir()
    (folder / "arm.srdf").write_text('<robot name="arm"/>', encoding="utf-8")
    (folder / "robot.toml").write_text(text, encoding="utf-8")
    return flexmodal.load(folder / "robot.toml")


def test_nothing_of_the_card_is_lost(context_of, diagnosed, tmp_path):
    context = context_of("fanuc_s360")
    robot = full_card(context.robot, tmp_path / "old")
    seen = seen_by(robot, SEEN[context])
    hypothesis = Hypothesis(seen, robot_space(robot))
    hypothesis = hypothesis.and_also(Placed(catalogue()["link_flexibility"], "link_1"))
    (tmp_path / "new").mkdir()
    _, loaded = written(diagnosed, hypothesis, np.zeros(len(hypothesis.space)), tmp_path / "new")
    assert loaded.families == robot.families
    assert loaded.srdf == robot.srdf
    assert loaded.title == robot.title
    assert {name: loaded.postures[name] for name in robot.postures} == robot.postures
    for name, joint in robot.joints.items():
        assert replace(loaded.joints[name], stiffness=joint.stiffness, damping=joint.damping) == joint
    assert loaded.obstacles["table"] == robot.obstacles["table"]
    assert loaded.obstacles["near"] == robot.obstacles["near"]
    far = loaded.obstacles["far"]  # beyond the place where the link is cut
    assert far.link.startswith("link_1_beyond")
    assert (far.cylinder, far.rpy) == (robot.obstacles["far"].cylinder, robot.obstacles["far"].rpy)
    for obstacle in ("near", "far"):  # as far from the table as it was, by the collision shapes of both
        before, after = (to_the_table(arm, obstacle) for arm in (robot, loaded))
        assert before > 0
        assert after == pytest.approx(before, abs=1e-12)


def to_the_table(robot, obstacle):
    """Distance in a bent posture [m]."""
    scene = scene_of(robot)
    found = dict(zip(map(frozenset, scene.pairs), scene.distances(robot.at("configuration_2")), strict=True))
    (pair,) = (pair for pair in found if {one.split()[-1] for one in pair} == {obstacle, "table"})
    return found[pair]


def test_meshes_are_still_found(diagnosed, context_of, tmp_path):
    """A URDF with a mesh beside it; the new one stands in another folder."""
    source = tmp_path / "source"
    (source / "meshes").mkdir(parents=True)
    (source / "meshes" / "part.stl").write_bytes(b"solid")
    context = context_of("fanuc_s360")
    text = context.robot.urdf.text.replace(
        '<link name="link_3">',
        '<link name="link_3"><visual><geometry><mesh filename="meshes/part.stl"/></geometry></visual>', 1,
    )  # fmt: skip
    (source / "arm.urdf").write_text(text, encoding="utf-8")
    robot = replace(context.robot, urdf=read_urdf(source / "arm.urdf"))
    moved = seen_by(robot, SEEN[context])
    hypothesis = Hypothesis(moved, robot_space(robot))
    out = tmp_path / "a" / "robot"
    out.mkdir(parents=True)
    _, loaded = written(diagnosed, hypothesis, np.zeros(len(hypothesis.space)), out)
    assert loaded.urdf.link_by_name["link_3"].meshes == ("../../source/meshes/part.stl",)
    assert loaded.urdf.warnings == ()


def test_an_extended_robot_can_be_identified_again(context_of, diagnosed, tmp_path):
    """Couplings and motors count in a fit; loss factors are refused, since a fit finds them itself."""
    context = context_of("fanuc_s360")
    hypothesis, x = drawn(context, [("joint_coupling", "q1+q2"), ("servo_compliance", "q1")], seed=3)
    _, loaded = written(diagnosed, hypothesis, x, tmp_path)
    again = Hypothesis(seen_by(loaded, SEEN[context]), robot_space(loaded))
    truth, found = bare(hypothesis, x), bare(again, np.zeros(len(again.space)))
    np.testing.assert_allclose(found, truth, rtol=1e-6, atol=1e-9 * np.abs(truth).max())
    other = tmp_path / "other"
    other.mkdir()
    hypothesis, x = drawn(context, [("structural_damping", "joints")], seed=3)
    _, loaded = written(diagnosed, hypothesis, x, other)
    with pytest.raises(InvalidRequest, match="loss_factor"):
        robot_space(loaded)

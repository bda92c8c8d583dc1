"""What `--json` prints: the keys and types that the format promises, and the numbers of the Python API."""

import math

import numpy as np
import pytest

import flexmodal

FANUC = ("fanuc_s360", "--posture", "configuration_1")
POINTS = ("--response", "location_1:+z", "--reference", "location_2:-z")


def is_numbers(values):
    return isinstance(values, list) and all(type(value) is float and math.isfinite(value) for value in values)


def test_robots(cli):
    ran = cli("robots", "--json")
    listed = ran.json()["robots"]
    assert (ran.status, ran.err) == (0, "")
    assert [robot["name"] for robot in listed] == [robot.name for robot in flexmodal.robots()]
    for found in listed:
        assert set(found) == {
            "name",
            "title",
            "joints",
            "pseudo_joints",
            "points",
            "postures",
            "families",
            "tool",
        }
        for key in ("joints", "pseudo_joints", "points", "postures", "families"):
            assert all(isinstance(name, str) for name in found[key])
    fanuc = listed[0]
    assert fanuc["joints"] == ["q1", "q2", "rho", "q3"]  # in URDF order
    assert (fanuc["pseudo_joints"], fanuc["tool"]) == (["rho"], "tool")


@pytest.mark.parametrize("form", ["receptance", "mobility", "inertance"])
def test_frf(cli, form):
    ran = cli("frf", *FANUC, "--frequencies", "0:20:0.5", *POINTS, "--form", form, "--json")
    found = ran.json()
    assert ran.err == ""
    assert set(found) == {
        "robot",
        "posture",
        "form",
        "unit",
        "response",
        "reference",
        "frequency",
        "re",
        "im",
    }
    assert (found["robot"], found["form"]) == ("fanuc_s360", form)
    assert (found["response"], found["reference"]) == ("location_1:+z", "location_2:-z")
    assert found["unit"] == {"receptance": "m/N", "mobility": "m/(s·N)", "inertance": "m/(s²·N)"}[form]
    assert set(found["posture"]) == {"q1", "q2", "q3"}
    assert is_numbers(found["frequency"])
    assert is_numbers(found["re"])
    assert is_numbers(found["im"])
    expected = flexmodal.load("fanuc_s360").frf(
        "configuration_1",
        np.arange(0, 20.5, 0.5),
        response="location_1:+z",
        reference="location_2:-z",
        form=form,
    )
    # Both are one calculation, and JSON carries every digit: equal, not close.
    np.testing.assert_array_equal(found["frequency"], expected.frequency)
    np.testing.assert_array_equal(np.array(found["re"]) + 1j * np.array(found["im"]), expected.value[:, 0, 0])


def test_frf_of_several_pairs_is_nested_by_response_and_reference(cli):
    ran = cli(
        "frf", *FANUC, "--frequencies", "1,7.5", "--json",
        "--response", "location_1:+z", "--response", "tool:+ry", "--response", "tool:+x",
        "--reference", "tool:+z", "--reference", "tool:+ry",
    )  # fmt: skip
    found = ran.json()
    assert found["response"] == ["location_1:+z", "tool:+ry", "tool:+x"]
    assert found["reference"] == ["tool:+z", "tool:+ry"]
    assert found["unit"] == [["m/N", "m/(N·m)"], ["rad/N", "rad/(N·m)"], ["m/N", "m/(N·m)"]]
    assert np.shape(found["re"]) == np.shape(found["im"]) == (3, 2, 2)  # response, reference, line
    expected = flexmodal.load("fanuc_s360").frf(
        "configuration_1", [1.0, 7.5], response=found["response"], reference=found["reference"]
    )
    value = np.array(found["re"]) + 1j * np.array(found["im"])
    np.testing.assert_array_equal(value.transpose(2, 0, 1), expected.value)


def test_modes(cli):
    ran = cli("modes", *FANUC, "--json")
    listed = ran.json()["modes"]
    assert ran.err == ""
    expected = flexmodal.load("fanuc_s360").modes("configuration_1")
    assert len(listed) == len(expected.pole) == 4
    sizes = []
    for place, found in enumerate(listed):
        assert set(found) == {"frequency", "damping_ratio", "pole", "overdamped", "shape"}
        assert found["frequency"] == expected.frequency[place]
        assert found["damping_ratio"] == expected.damping_ratio[place]
        assert complex(*found["pole"]) == expected.pole[place]
        assert found["overdamped"] is False
        assert list(found["shape"]) == ["q1", "q2", "rho", "q3"]
        shape = np.array([complex(*pair) for pair in found["shape"].values()])
        np.testing.assert_array_equal(shape, expected.shape[:, place])
        sizes.append(abs(complex(*found["pole"])))
    assert sizes == sorted(sizes)


def test_a_real_pole_is_one_entry_marked_overdamped(cli, urdf):
    ran = cli("modes", urdf(), "--posture", "q1=0.5", "--stiffness", "q1=100", "--damping", "1e4", "--json")
    listed = ran.json()["modes"]
    assert [mode["overdamped"] for mode in listed] == [True, True]
    assert all(mode["pole"][1] == 0 and mode["pole"][0] < 0 for mode in listed)
    # The slow one of a heavily damped joint is −k/c.
    assert listed[0]["pole"][0] == pytest.approx(-100 / 1e4, rel=1e-3)


def test_measures(cli):
    ran = cli("measures", "six_link", "--posture", "start_2", "--json")
    found = ran.json()
    assert ran.err == ""
    assert set(found) == {"stiffness", "mobility", "static_receptance", "receptance", "tool"}
    expected = flexmodal.load("six_link").measures("start_2")
    assert found["stiffness"] == expected.stiffness
    assert found["mobility"] == expected.mobility
    assert found["static_receptance"] == expected.static_receptance
    assert found["receptance"] is None
    assert found["tool"] == list(expected.tool)


def test_measures_at_a_frequency_along_a_direction_of_position_alone(cli):
    ran = cli(
        "measures", "six_link", "--posture", "start_2", "--frequency", "5", "--direction", "tip:+x",
        "--task", "position", "--json",
    )  # fmt: skip
    expected = flexmodal.load("six_link").measures(
        "start_2", direction="tip:+x", frequency=5.0, task="position"
    )
    found = ran.json()
    assert complex(*found["receptance"]) == expected.receptance
    assert found["stiffness"] == expected.stiffness


SEARCH = ("optimise", "six_link", "--hold", "-2,2", "--starts", "2")


def test_optimise(cli):
    ran = cli(*SEARCH, "--frequency", "5", "--start", "start_2", "--seed", "4", "--json")
    found = ran.json()
    assert ran.err == ""  # no bar where there is no terminal
    assert set(found) == {
        "posture",
        "objective",
        "start",
        "start_as_given",
        "unit",
        "tool",
        "collisions",
        "converged",
        "starts",
        "optima",
    }
    arm = flexmodal.load("six_link")
    problem = flexmodal.PostureProblem(
        arm,
        flexmodal.ReceptanceObjective((flexmodal.PointDirection("tool", "z"),), np.array([5.0])),
        flexmodal.Hold.at(arm, (-2.0, 2.0)),
    )
    outcome = flexmodal.optimise(problem, start="start_2", starts=2, seed=4)
    assert found["posture"] == dict(outcome.best.posture.values)
    assert found["objective"] == outcome.best.objective == found["optima"][0]["objective"]
    assert found["start"] == outcome.start
    assert found["unit"] == "m/N"
    assert found["tool"] == list(outcome.tool)
    assert found["converged"] is True
    assert ran.status == 0
    assert found["starts"] == outcome.starts == sum(optimum["hits"] for optimum in found["optima"])
    keys = {"posture", "objective", "hits", "equals"}
    assert [set(optimum) for optimum in found["optima"]] == [keys] * len(outcome.optima)
    assert found["start_as_given"]["objective"] == outcome.compared.objective
    assert found["collisions"] == {"checked": False}
    objectives = [optimum["objective"] for optimum in found["optima"]]
    assert objectives == sorted(objectives)
    # The objective is what the frf command says of the posture found.
    text = ",".join(f"{joint}={value!r}" for joint, value in found["posture"].items())
    frf = cli("frf", "six_link", "--posture", text, "--frequencies", "5", "--json").json()
    assert found["objective"] == pytest.approx(abs(complex(frf["re"][0], frf["im"][0])), rel=1e-12)


def test_a_seed_repeats_exactly_and_another_does_not(cli):
    first, again, other = (
        cli(*SEARCH, "--objective", "mobility", "--seed", seed, "--json").out for seed in (7, 7, 8)
    )
    assert first == again
    assert first != other


def test_optimise_along_a_family(cli):
    ran = cli(
        "optimise", "fanuc_s360", "--family", "second_link_horizontal", "--frequency", "8", "--json",
        "--start", "configuration_1",
    )  # fmt: skip
    found = ran.json()
    for optimum in found["optima"]:
        assert optimum["posture"]["q2"] == pytest.approx(-optimum["posture"]["q1"], abs=1e-15)
    assert found["objective"] <= found["start"]


@pytest.mark.parametrize(
    ("options", "unit"),
    [
        (("--objective", "stiffness"), "N/m"),
        (("--objective", "mobility"), "m²/rad²"),
        (
            ("--objective", "worst", "--frequency", "5", "--direction", "tool:+x", "--direction", "tool:+z"),
            "m/N",
        ),
        (
            (
                *("--objective", "weighted", "--frequency", "5"),
                *("--direction", "tool:+x=2", "--direction", "tool:+z=-1"),
            ),
            "m/N",
        ),
    ],
)
def test_every_objective(cli, options, unit):
    ran = cli("optimise", "six_link", "--hold", "-2,2", *options, "--starts", "1", "--json")
    found = ran.json()
    assert found["unit"] == unit
    assert type(found["objective"]) is float
    assert found["tool"] == pytest.approx([-2, 0, 2], abs=1e-9)  # the hold is kept to 1e-10
    assert ran.status == (0 if found["converged"] else 1)


def test_check(cli, card, urdf):
    sound = cli("check", card(), "--json")
    assert (sound.status, sound.err) == (0, "")
    assert set(sound.json()["checked"][0]) == {"path", "sound", "faults", "findings", "warnings"}
    assert sound.json()["checked"][0]["sound"] is True
    spoiled = urdf(('<mass value="2"/>', '<mass value="-2"/>'))
    ran = cli("check", spoiled, "--json")
    assert ran.status == 1
    (report,) = ran.json()["checked"]
    (fault,) = report["faults"]
    assert set(fault) == {"file", "key", "found", "allowed"}
    assert (fault["file"], fault["key"]) == (str(spoiled), "link.upper.inertial.mass")
    assert "-2" in fault["found"]

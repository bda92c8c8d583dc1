"""What is asked for: all faults at once, places listed, scenarios drawn, options that change no number."""

import numpy as np
import pytest
from click.testing import CliRunner

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.cli.rig import rig
from flexmodal.errors import InvalidInput, InvalidPosture, InvalidRequest
from flexmodal.rig import EFFECTS, Hide, draw_scenario, hide_places, simulate

SMALL = {"postures": 3, "points": 2, "references": 1, "trials": 2, "averages": 2, "record_length": 1.0}
LEAST = SMALL | {"postures": 1}
"""For what was hidden, where nothing is asked of what was measured."""


@pytest.fixture(scope="module")
def fanuc():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="module")
def spatial():
    return flexmodal.load("six_axis")


def keys(caught) -> set[str]:
    return {fault.key for fault in caught.value.faults}


def test_plan_and_hidden_effects_are_judged_together(fanuc):
    with pytest.raises(InvalidRequest) as caught:
        simulate(
            fanuc, postures=["configuration_9"], trials=0, axes="w", noise=-1.0, workers=0,
            references=["nowhere:+z"], hide=["servo_compliance@q9", "nonsense", "added_mass,mass"],
        )  # fmt: skip
    expected = {"noise", "workers", "trials", "axes", "references", "hide", "hide servo_compliance@q9"}
    assert expected < keys(caught)
    assert len(caught.value.faults) == 9  # two of "hide", and the posture


def test_one_kind_of_fault_keeps_its_class(fanuc):
    with pytest.raises(InvalidPosture):
        simulate(fanuc, postures=["configuration_9"], hide=["added_mass"])


def test_points_out_of_range_are_told_once(fanuc):
    """Places of sensors cannot be judged then, and are not."""
    with pytest.raises(InvalidRequest) as caught:
        simulate(fanuc, points=0, hide=["sensor_gain@location_1", "nonsense"])
    assert keys(caught) == {"points", "hide"}


def test_the_command_line_tells_everything_at_once_in_its_own_words(tmp_path):
    (tmp_path / "there").mkdir()
    asked = ["fanuc_s360", "--out", str(tmp_path / "there"), "--postures", "0", "--tip", "rubber",
             "--band", "5:1", "--peaks", "3,b", "--height", "1:2:3", "--hide", "servo_compliance@q9",
             "--hide", "added_mass,k", "--references", "two", "--parameter-error", "3",
             "--workers", "0"]  # fmt: skip
    run = CliRunner().invoke(rig, asked)
    assert isinstance(run.exception, InvalidInput)
    assert {fault.key for fault in run.exception.faults} == {
        "", "--postures", "--tip", "--band", "--peaks", "--height", "--hide servo_compliance@q9", "hide",
        "--references", "--parameter-error", "--workers",
    }  # fmt: skip
    assert {fault.file for fault in run.exception.faults} == {
        str(tmp_path / "there"), "command line", "command line --hide",
    }  # fmt: skip
    assert [entry.name for entry in tmp_path.iterdir()] == ["there"]


def test_an_unknown_robot_does_not_hide_the_rest(tmp_path):
    run = CliRunner().invoke(rig, ["nobody", "--out", str(tmp_path / "a" / "b"), "--band", "5:1"])
    assert isinstance(run.exception, InvalidInput)
    assert len(run.exception.faults) == 3


@pytest.mark.slow
def test_workers_change_not_a_bit(fanuc):
    """Each posture draws from streams of its own; a non-linear effect and one in the sensor go along."""
    hide = ["coulomb_friction", "sensor_gain"]
    one, two = (simulate(fanuc, **SMALL, hide=hide, seed=5, workers=workers) for workers in (1, 3))
    np.testing.assert_array_equal(one.campaign.frfs.value, two.campaign.frfs.value)
    assert one.truth == two.truth
    for first, second in zip(one.campaign.blows, two.campaign.blows, strict=True):
        np.testing.assert_array_equal(first.response, second.response)


def test_workers_tell_of_their_progress(fanuc):
    calls: list[int] = []
    simulate(fanuc, **SMALL, workers=2, advance=lambda: calls.append(1))
    assert len(calls) == 6


def test_without_time_records_the_frfs_are_the_same(fanuc, tmp_path):
    whole, frfs = (simulate(fanuc, **SMALL, time=time) for time in (True, False))
    assert frfs.campaign.blows == ()
    np.testing.assert_array_equal(whole.campaign.frfs.value, frfs.campaign.frfs.value)
    np.testing.assert_array_equal(whole.campaign.frfs.coherence, frfs.campaign.frfs.coherence)
    assert whole.campaign.frfs.flags == frfs.campaign.frfs.flags
    frfs.write(tmp_path / "test")
    names = {entry.name for entry in (tmp_path / "test").iterdir()}
    assert names == {"campaign.toml", "frf.uff", "robot"}
    back = read_campaign(tmp_path / "test")
    np.testing.assert_array_equal(back.frfs.value, frfs.campaign.frfs.value)
    assert back.trials == whole.campaign.trials


def test_no_time_on_the_command_line(tmp_path):
    out = tmp_path / "test"
    run = CliRunner().invoke(
        rig,
        ["fanuc_s360", "--out", str(out), "--postures", "1", "--points", "2", "--trials", "2",
         "--record-length", "0.5", "--no-time", "--workers", "2", "--hide", "added_mass", "--height", "3:30",
         "--json"],
    )  # fmt: skip
    assert run.exit_code == 0, run.output
    assert '"blows": 24' in run.stdout  # struck, though not kept: 2 points, 2 references, 2 trials of 3
    assert not (out / "time.uff").exists()


def test_places_are_those_the_rig_takes(fanuc, spatial):
    for robot in (fanuc, spatial):
        places = hide_places(robot, points=3)
        assert list(places) == list(EFFECTS)
        for effect in ("sensor_gain", "joint_coupling", "link_flexibility"):
            with pytest.raises(InvalidRequest) as caught:
                simulate(robot, points=3, hide=[f"{effect}@nowhere"])
            assert caught.value.faults[0].allowed.endswith(": " + ", ".join(places[effect]))
    assert hide_places(fanuc)["servo_compliance"] == ("q1", "q2", "q3")
    assert len(hide_places(spatial)["joint_coupling"]) == 15
    assert set(hide_places(spatial, points=2)["sensor_gain"]) < set(hide_places(spatial)["sensor_gain"])
    with pytest.raises(InvalidRequest, match="points: found 9"):
        hide_places(fanuc, points=9)


def test_a_height_in_a_range_is_drawn_from_the_seed(fanuc):
    hide = [Hide("time_delay", height=(3.0, 30.0))]
    found = []
    for seed in (*range(6), 5):
        result = simulate(fanuc, **LEAST, hide=hide, seed=seed, time=False)
        found.append(result.truth.effects[0].height)
    assert all(3 <= height <= 30 for height in found)
    assert max(found) > 2 * min(found)
    assert found[-1] == found[-2]


def test_a_height_out_of_reach_gives_way_within_the_range(fanuc):
    """A gain error makes |ln| 1.1 at most on one point of two; 1000 times a floor of 0.05 asks for more."""
    hide = [Hide("sensor_gain", "location_1", {"error": 0.2}, height=(3.0, 1000.0))]
    reached = [
        simulate(fanuc, **LEAST, noise=0.03, hide=hide, seed=seed, time=False).truth.effects[0]
        for seed in range(5)
    ]
    assert all(effect.height > 2.7 for effect in reached)
    most = EFFECTS["sensor_gain"].most({"error": 0.2})
    assert any(effect.severity == pytest.approx(most) for effect in reached)


@pytest.mark.parametrize("height", [(30.0, 3.0), (0.0, 3.0), (3.0, 2000.0), (float("nan"), 3.0)])
def test_heights_that_make_no_range(fanuc, height):
    with pytest.raises(InvalidRequest, match="times the noise floor"):
        simulate(fanuc, hide=[Hide("added_mass", height=height)])


def test_secrets_are_drawn_alike_from_a_seed_and_evenly_over_the_effects(spatial):
    drawn = [draw_scenario(spatial, seed, count=2) for seed in range(1000)]
    assert drawn[:50] == [draw_scenario(spatial, seed, count=2) for seed in range(50)]
    counts = {name: 0 for name, effect in EFFECTS.items() if effect.catalogued}
    for scenario in drawn:
        assert len({hide.effect for hide in scenario.hide}) == 2
        assert 0.02 <= scenario.parameter_error <= 0.08
        for hide in scenario.hide:
            counts[hide.effect] += 1
            assert hide.height == (3.0, 30.0)
    assert len(counts) == 14
    assert min(counts.values()) > 100  # 154 expected of each, standard deviation 11
    errors = [scenario.parameter_error for scenario in drawn]
    assert np.mean(errors) == pytest.approx(0.05, abs=0.0025)  # four standard errors


def test_a_secret_can_be_nothing_or_from_outside_the_catalogue(fanuc):
    assert draw_scenario(fanuc, 1, count=0).hide == ()
    outside = [name for name, effect in EFFECTS.items() if not effect.catalogued]
    assert draw_scenario(fanuc, 1, effects=outside).hide[0].effect in outside


def test_secrets_out_of_range_are_refused_all_at_once(bars):
    with pytest.raises(InvalidRequest) as caught:
        draw_scenario(
            bars(1),
            -1,
            count=9,
            effects=["joint_coupling", "nonsense"],
            heights=(3.0, 2.0),
            parameter_errors=(0.0, 3.0),
        )
    assert keys(caught) == {"effects", "seed", "count", "heights", "parameter_errors"}
    assert "joint_coupling" in str(caught.value)  # one joint has no pair


SOFT_LOOP = Hide("servo_compliance", "q2", {"proportional_gain": 2000.0, "rotor_inertia": 5.0})
"""The spring of q2 then hangs on a loop thirty times softer."""


def test_effects_that_ring_up_together_are_refused_by_name(fanuc):
    """A bare off-diagonal spring holds beside the joints' springs, and not where one hangs on a soft loop."""
    tied = Hide("joint_coupling", "q2+q3", {"coupling": 0.9})
    for alone in (SOFT_LOOP, tied):
        simulate(fanuc, **LEAST, hide=[alone], seed=1, time=False)
    for both in ([SOFT_LOOP, tied], [tied, SOFT_LOOP]):
        with pytest.raises(InvalidRequest, match=r"an arm that rings up with .*; allowed: weaker effects"):
            simulate(fanuc, **LEAST, hide=both, seed=1)


def test_effects_that_ring_up_together_are_drawn_again_where_places_are_open(fanuc):
    open_ = Hide("joint_coupling", parameters={"coupling": 0.9})
    alone, beside = (
        [
            simulate(fanuc, **LEAST, hide=hide, seed=seed, time=False).truth.effects[-1].where
            for seed in range(6)
        ]
        for hide in ([open_], [SOFT_LOOP, open_])
    )
    assert any("q2" in where for where in alone)
    assert all("q2" not in where for where in beside)

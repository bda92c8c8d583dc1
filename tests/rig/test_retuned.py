"""How high an effect stands once all else is fitted to it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

import flexmodal
from flexmodal.rig import Hide, ParameterError, Truth, simulate
from flexmodal.rig.believed import known_robot
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden import retuned
from flexmodal.rig.hidden.retuned import retuned_height, retuned_heights
from flexmodal.rig.hidden.severity import height, noise_floor, predicted, usable_lines

SMALL = {"postures": 2, "points": 2, "references": 1, "trials": 2, "averages": 2, "record_length": 1.0}
OFF = ParameterError.all(0.05)


@pytest.fixture(scope="module")
def robot():
    return flexmodal.load("fanuc_s360")


def hidden(robot, *effects, **more):
    """The stand with some effects, each five noise floors high, and the floor."""
    made = simulate(robot, **SMALL | more, hide=[Hide(*effect, height=5.0) for effect in effects], seed=4)
    return made, noise_floor(made.stand, Conduct(seed=4))


def test_a_gain_is_not_taken_up_and_a_mass_mostly_is(robot):
    """No parameter of a robot changes one sensor alone; a mass on a link is much like a heavier link."""
    effects = ("sensor_gain", "location_6"), ("added_mass", "link_3")
    made, floor = hidden(robot, *effects, points=4, references=2)
    gain, mass = (retuned_height(made.stand, made.hidden, k, floor, OFF) for k in (0, 1))
    alone = [height(made.stand, [one], floor) / floor.height for one in made.hidden]
    assert 0.8 * alone[0] < gain <= alone[0]
    assert mass < 0.3 * alone[1]


def test_it_is_what_a_general_least_squares_fit_leaves(robot):
    made, floor = hidden(robot, ("added_mass", "link_2"))
    target, usable = predicted(made.stand, made.hidden, floor), usable_lines(floor)
    names = [name for name in made.stand.true.factors if not name.startswith("mass_centre")]

    def off(change):
        own = {
            name: made.stand.true.factors[name] * np.exp(one) for name, one in zip(names, change, strict=True)
        }
        true = known_robot(made.robot, {**made.stand.true.factors, **own})
        left = np.log(target / predicted(replace(made.stand, true=true), [], floor))[usable]
        return np.concatenate([left.real / floor.height, left.imag / floor.height, change / 0.05])

    left = least_squares(off, np.zeros(len(names))).fun[: -len(names)]
    expected = np.sqrt(2 * np.mean(left**2))
    found = retuned_height(made.stand, made.hidden, 0, floor, OFF)
    assert found == pytest.approx(expected, rel=1e-3)
    assert found < 0.5 * height(made.stand, made.hidden, floor) / floor.height


def test_what_the_card_is_right_in_takes_nothing_up(robot):
    made, floor = hidden(robot, ("added_mass", "link_2"))
    alone = height(made.stand, made.hidden, floor) / floor.height
    found = retuned_height(made.stand, made.hidden, 0, floor, ParameterError.all(0.0))
    assert found == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize("other", [("time_delay", "location_6"), ("coulomb_friction", "q3")])
def test_of_a_spring_that_is_not_straight_re_tuning_takes_a_part(robot, other):
    made, floor = hidden(robot, ("nonlinear_stiffness", "q2"), other)
    alone = height(made.stand, made.hidden[:1], floor) / floor.height
    assert 0 < retuned_height(made.stand, made.hidden, 0, floor, OFF) < 1.5 * alone


def test_the_truth_tells_it_where_it_was_asked_for(robot, tmp_path):
    made, _ = hidden(robot, ("added_mass", "link_2"))
    assert "times_noise_floor_retuned" not in made.truth.table()["effect"][0]
    heights = retuned_heights(made.stand, made.hidden, Conduct(seed=4), OFF)
    told = replace(made.truth, effects=(replace(made.truth.effects[0], retuned=heights[0]),))
    assert told.table()["effect"][0]["times_noise_floor_retuned"] == heights[0]
    assert Truth.of_table(told.table()) == told
    assert retuned_heights(made.stand, made.hidden, Conduct(noise=0.0, scatter=0.0), OFF) == ()


def test_no_number_is_re_tuned_more_than_tenfold(robot, monkeypatch):
    """Far from where it is, what is hidden may have no model: a relaxation of infinite order."""
    made, floor = hidden(robot, ("added_mass", "link_2"))
    factors = []

    def steps(slopes, left, change, deviation, noise):
        return np.full(len(change), 1e3)

    def known(robot, given):
        factors.extend(given.values())
        return known_robot(robot, given)

    monkeypatch.setattr(retuned, "_step", steps)
    monkeypatch.setattr(retuned, "known_robot", known)
    start = dict(made.stand.true.factors)
    assert np.isfinite(retuned_height(made.stand, made.hidden, 0, floor, OFF))
    assert max(factors) < 10.001 * max(start.values())

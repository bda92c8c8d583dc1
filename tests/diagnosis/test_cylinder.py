"""Friction whose lever turns with the joint: that of a balancing cylinder's seal."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.effects.dry_friction import EFFECT, lever_of
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.identification import observe, predict
from flexmodal.rig import Hide
from flexmodal.rig.forms.further_joints import lever
from flexmodal.structure import robot_space

CYLINDER = {"force": 120.0, "presliding_stiffness": 4e7, "crank": 0.15, "distance": 0.4, "angle": 1.2}


@pytest.fixture(scope="module")
def tested():
    """Without noise or scatter."""
    robot = flexmodal.load("fanuc_s360")
    hide = [Hide("coulomb_friction", "q2", CYLINDER, form="cylinder")]
    return flexmodal.simulate(
        robot, hide=hide, postures=3, points=1, references=1, trials=2, noise=0.0, scatter=0.0,
        parameter_error=0.0, seed=6,
    )  # fmt: skip


def arms(postures):
    """Levers of the rig's cylinder [m]."""
    return np.array(
        [lever(CYLINDER["crank"], CYLINDER["distance"], CYLINDER["angle"] + one.q["q2"]) for one in postures]
    )


def in_mean(postures):
    """What the wider law has of the cylinder."""
    middle = CYLINDER["angle"] + float(np.mean([one.q["q2"] for one in postures]))
    return {
        "lever": 1.0,
        "lever_angle": (middle + np.pi) % (2 * np.pi) - np.pi,
        "lever_ratio": CYLINDER["crank"] / CYLINDER["distance"],
    }


def test_a_lever_turns_as_that_of_the_rig(tested):
    context = Context.of(flexmodal.load("fanuc_s360"), observe(tested.campaign))
    wanted = arms(context.postures)
    assert np.ptp(wanted) > 0.2 * np.abs(wanted).max()
    every, blank = np.arange(3), np.zeros((3, 2), dtype=int)
    still = Placement(context, "q2", in_mean(context.postures), every, 0 * every, blank, blank)
    found = lever_of(still)
    np.testing.assert_allclose(found, wanted / np.sqrt(np.mean(wanted**2)), rtol=1e-12)
    assert lever_of(replace(still, values={**still.values, "lever": 0.0})).tolist() == [1.0] * 3
    assert lever_of(replace(still, values={})).tolist() == [1.0] * 3
    dead = replace(still, where="q1", values={**still.values, "lever_angle": 0.0})
    stands = replace(context, postures=tuple(replace(one, q={}) for one in context.postures))
    assert lever_of(replace(dead, context=stands)).tolist() == [0.0] * 3


@pytest.mark.usefixtures("one_loop")
def test_a_seal_that_rubs_is_that_of_the_rig(tested):
    robot, seen = flexmodal.load("fanuc_s360"), observe(tested.campaign)
    root = Hypothesis(Context.of(robot, seen), robot_space(robot))
    typical = float(np.sqrt(np.mean(arms(root.context.postures) ** 2)))
    law = {
        "torque": CYLINDER["force"] * typical,
        "presliding_stiffness": CYLINDER["presliding_stiffness"] * typical**2,
        "exponent": 0.0,
        "stiction": 1e-3,
        "slow_torque": 1e-9,
        "bristle_time": 1e-12,
        "second_torque": 1e-4,
        "second_stiffness": 1e-3,
        "growing": 1e-7,
    }
    hypothesis = root.and_also(Placed(EFFECT.next_level.effect, "q2"))
    placed, none = hypothesis.placed[-1], np.zeros(len(root.space))

    def far(**more):
        x = hypothesis.start(placed, {**law, **more}, none)
        predicted = predict(TimeDomainModel(hypothesis), x, seen)
        return float(np.median(np.abs(np.log(predicted / seen.value))))

    turns, stays = far(**in_mean(root.context.postures)), far(lever=0.0)
    assert turns < 0.005
    assert stays > 10 * turns

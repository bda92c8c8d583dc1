"""Friction behind the joint's spring: a clamp that slips."""

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.effects.dry_friction import EFFECT
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.identification import observe, predict
from flexmodal.rig import Hide
from flexmodal.structure import robot_space

SOFTER, STICKING = 0.8, 3.0
"""Compliance of the clamp where it slips over the joint's, and what sticks over what stays."""


@pytest.mark.usefixtures("one_loop")
@pytest.mark.parametrize(("torque", "most"), [(200.0, 0.03), (2.0, 0.4)])
def test_a_clamp_that_slips_is_nearly_that_of_the_rig(torque, most):
    """In series k and (k₂ beside a slider σ, F): k₁ = k k₂/(k + k₂) beside one of limit F k/(k + k₂).

    The joint's damper, which is beside k alone, is smaller by the square of what of the stretch k has: right
    for a clamp that sticks, at 200 N·m, and too large for one that slips.
    """
    robot = flexmodal.load("fanuc_s360")
    hidden = {
        "torque": torque, "softer": SOFTER, "sticking": STICKING, "frequency": 2000.0, "damping_time": 1e-7,
    }  # fmt: skip
    tested = flexmodal.simulate(
        robot, hide=[Hide("coulomb_friction", "q2", hidden, form="clamped")], postures=2, points=1,
        references=1, trials=2, noise=0.0, scatter=0.0, parameter_error=0.0, seed=6,
    )  # fmt: skip
    seen = observe(tested.campaign)
    root = Hypothesis(Context.of(robot, seen), robot_space(robot))
    k = float(robot.joints["q2"].stiffness)
    stays = k / SOFTER
    slipping, sticking = (k * one / (k + one) for one in (stays, (1 + STICKING) * stays))
    law = {
        "torque": torque * k / (k + stays),
        "presliding_stiffness": sticking - slipping,
        "slips": 1 - slipping / k,
        "exponent": 0.0,
        "stiction": 1e-3,
        "slow_torque": 1e-9,
        "bristle_time": 1e-12,
        "second_torque": 1e-4,
        "second_stiffness": 1e-3,
        "growing": 1e-7,
        "lever": 0.0,
    }
    hypothesis = root.and_also(Placed(EFFECT.next_level.effect, "q2"))
    damped = root.space.coordinates({"damping.q2": float(robot.joints["q2"].damping) * (sticking / k) ** 2})

    def far(**more):
        x = hypothesis.start(hypothesis.placed[-1], {**law, **more}, damped)
        apart = predict(TimeDomainModel(hypothesis), x, seen) - seen.value
        return float(np.linalg.norm(apart) / np.linalg.norm(seen.value))

    slips = far()
    assert slips < most
    assert far(slips=1e-6) > 2.5 * slips
    assert torque > 100 or far(torque=1e4) > 2.5 * slips  # stuck

"""A spring behind a joint's own: a belt one of whose strands goes slack."""

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.effects.behind_spring import BEHIND
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.time_domain.model import TimeDomainModel
from flexmodal.identification import observe, predict
from flexmodal.rig import Hide
from flexmodal.structure import robot_space

SOFTER, TIME = 0.8, 6e-4


@pytest.mark.usefixtures("one_loop")
@pytest.mark.parametrize(("deflection", "most"), [(1.0, 1e-4), (2e-5, 5e-4)])
def test_a_belt_whose_strand_goes_slack_is_that_of_the_rig(deflection, most):
    """Of half the stiffness then; at 1 rad both strands stay tight."""
    robot = flexmodal.load("fanuc_s360")
    hidden = {"softer": SOFTER, "deflection": deflection, "frequency": 400.0, "damping_time": TIME}
    tested = flexmodal.simulate(
        robot, hide=[Hide("nonlinear_stiffness", "q2", hidden, form="strands")], postures=2, points=1,
        references=1, trials=2, noise=0.0, scatter=0.0, parameter_error=0.0, seed=6,
    )  # fmt: skip
    seen = observe(tested.campaign)
    root = Hypothesis(Context.of(robot, seen), robot_space(robot))
    law = {
        "behind_softer": SOFTER, "behind_time": TIME / 2, "behind_frequency": 400.0, "change": -0.5,
        "deflection": deflection, "softness": 0.01,
    }  # fmt: skip
    hypothesis = root.and_also(Placed(BEHIND, "q2"))

    def far(**more):
        x = hypothesis.start(hypothesis.placed[-1], {**law, **more}, np.zeros(len(root.space)))
        apart = predict(TimeDomainModel(hypothesis), x, seen) - seen.value
        return float(np.linalg.norm(apart) / np.linalg.norm(seen.value))

    assert far() < most
    assert far(behind_time=TIME) > 30 * far()
    assert far(behind_frequency=800.0) > 10 * far()
    assert deflection > 0.1 or far(change=0.0) > 0.5

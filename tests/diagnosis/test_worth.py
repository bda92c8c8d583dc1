"""Whether what makes an effect is there at all."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.structure import robot_space


@pytest.mark.parametrize(("together", "expected"), [(-1.0, Answer.YES), (0.0, Answer.NO)])
def test_a_damper_between_two_joints_is_a_coupling_however_little_its_spring_is_known(
    context, together, expected
):
    """A spring of 0.05 ± 0.04 with a time that is known to 80 %: their product is known, or it is not."""
    placed = Placed(catalogue()["joint_coupling"], "q1+q3")
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(placed)
    start = {"coupling": 0.05, "damping_time": 1e-2}
    x = hypothesis.start(placed, start, np.zeros(len(hypothesis.base)))
    spring, time, idler = (
        hypothesis.space.index[f"joint_coupling@q1+q3.{name}"]
        for name in ("coupling", "damping_time", "inertia")
    )
    covariance = np.zeros((len(x), len(x)))
    covariance[spring, spring], covariance[time, time], covariance[idler, idler] = 0.04**2, 0.8**2, 9.0
    covariance[spring, time] = covariance[time, spring] = together * 0.04 * 0.8
    data = FrfData.__new__(FrfData)
    data.covariance = lambda model: covariance
    assert data._is_there(Mock(spec=FittedFrfs, hypothesis=hypothesis, x=x)) is expected

"""What is told of an effect's parameters."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.outcome import Gaps, Step
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection.conclusion import Conclusion
from flexmodal.diagnosis.selection.described import as_found_last
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.structure import robot_space

MASS = ("added_mass", "link_2")


@pytest.fixture
def conclusion(context):
    """A mass of 2 kg ± 5 % and a coupling, fitted together."""
    hypothesis = Hypothesis(context, robot_space(context.robot))
    for name, where in (("joint_coupling", "q1+q3"), MASS):
        hypothesis = hypothesis.and_also(Placed(catalogue()[name], where))
    space = hypothesis.space
    x, k = np.zeros(len(space)), space.index["added_mass@link_2.mass"]
    x[k] = space.parameters[k].coordinate(2.0)
    covariance = np.zeros((len(x), len(x)))
    covariance[k, k] = 0.05**2
    after = Mock(spec=FittedFrfs, hypothesis=hypothesis, x=x)
    return Mock(spec=Conclusion, after=after, covariance=covariance)


def step(effect, where):
    gaps = Mock(spec=Gaps)
    return Step(effect, where, {"mass": 1.0}, {"mass": "kg"}, {"mass": 0.5}, 0.9, gaps, ())


def test_parameters_are_those_found_beside_what_came_after(conclusion):
    found = as_found_last(step(*MASS), conclusion)
    assert found.parameters["mass"] == pytest.approx(2.0)
    assert found.uncertainty["mass"] == pytest.approx(0.1, rel=1e-3)
    assert found.units["mass"] == "kg"
    assert (found.effect, found.where, found.confidence) == (*MASS, 0.9)


def test_what_the_last_model_has_not_stays_as_it_was_added(conclusion):
    left_out = step("added_mass", "link_3")
    assert as_found_last(left_out, conclusion) is left_out

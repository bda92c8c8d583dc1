"""A descent: how often it asks for the cost, and where it ends."""

import numpy as np
import pytest

from flexmodal.identification.descent import Normal, descend
from flexmodal.structure import Parameter, ParameterSpace

CURVED = np.array([[4.0, 1.0], [1.0, 3.0]])


def space():
    return ParameterSpace(tuple(Parameter(name, "", 0.0, 1e6, log=False) for name in ("a", "b")))


def normal(value, gradient):
    none = np.zeros((0, 2))
    return Normal(value, value, gradient, CURVED, none, np.zeros(0), None)


class Bowl:
    """A quadratic cost; how it rounds, and how steep it is beyond what its curvature says, are given."""

    def __init__(self, rounding=0.0, steeper=1.0):
        self.rounding, self.steeper, self.asked = rounding, steeper, []

    def cost(self, x):
        self.asked.append(x.copy())
        return 1.0 + self.steeper * float(x @ CURVED @ x) + self.rounding * len(self.asked)

    def equations(self, x):
        return normal(1.0 + self.steeper * float(x @ CURVED @ x), self.steeper * CURVED @ x)


def test_a_bowl_takes_a_step_for_each_look_at_its_cost():
    bowl = Bowl()
    found = descend(space(), bowl.equations, bowl.cost, np.array([0.3, -0.2]), most=20, settled=1e-9)
    assert found.converged
    np.testing.assert_allclose(found.x, 0.0, atol=1e-6)
    assert len(bowl.asked) == found.steps


@pytest.mark.parametrize("settled", [1e-3, 1e-6])
def test_where_only_rounding_is_left_no_shorter_steps_are_tried(settled):
    """Each look at the cost gives more than a step could take, so that none ever seems to lead down."""
    bowl = Bowl(rounding=settled)
    x = np.array([1.0, -1.0]) * np.sqrt(0.001 * settled)
    found = descend(space(), bowl.equations, bowl.cost, x, most=20, settled=settled)
    assert found.converged
    assert len(bowl.asked) == 1


def test_damping_that_was_needed_stays():
    """A valley three times as steep as its curvature says: little damping leads up on the other side.

    To find the damping and lose it after each step takes twenty looks.
    """
    bowl = Bowl(steeper=3.0)
    found = descend(space(), bowl.equations, bowl.cost, np.array([0.1, -0.1]), most=12, settled=1e-9)
    np.testing.assert_allclose(found.x, 0.0, atol=1e-3)
    assert len(bowl.asked) <= 15

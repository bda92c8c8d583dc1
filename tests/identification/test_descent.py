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


def test_what_hardly_matters_is_followed_to_the_minimum_if_that_is_asked_for():
    """Valleys of 30 000 and of 1: a step along the other is worth less than a millionth of the cost."""
    stiff = np.diag([3e4, 1.0])
    away = np.array([1e-4, 0.3])

    def cost(x):
        return 2e4 + float(x @ stiff @ x)

    def equations(x):
        none = np.zeros((0, 2))
        return Normal(cost(x), cost(x), 0.5 * stiff @ x, stiff, none, np.zeros(0), None)  # half of every step

    wide = ParameterSpace(tuple(Parameter(name, "", 0.0, 1e6, log=False) for name in ("a", "b")))
    rough = descend(wide, equations, cost, away, most=40, settled=1e-6)
    close = descend(wide, equations, cost, away, most=40, settled=1e-6, near=0.02)
    assert abs(rough.x[1]) > 0.05
    assert close.converged
    assert abs(close.x[1]) < 0.04
    assert close.steps > rough.steps

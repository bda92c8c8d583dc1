"""What a descent asks of the posture at hand, of an object in Python that answers for its problem.

The compiler puts functions of the same names in the place of these, which work on arrays:
`flexmodal.optimisation.compiled.held.hold_at` and those of `flexmodal.optimisation.compiled.judge`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations


def hold_at(at, values, error, constraint):
    """Go to a vector; the size of the hold's error there, which with its derivative is filled in."""
    return at.hold_at(values, error, constraint)


def cost_at(at):
    """The cost where it was gone to last; infinite where there is none."""
    return at.cost_at()


def slope_at(at, gradient):
    """Fill in the derivative of the cost taken last."""
    at.slope_at(gradient)


def limit_at(at, cost):
    """PERFECT or UNBOUNDED where a cost says so, else UNSETTLED."""
    return at.limit_at(cost)

"""Where descents end: on the hold, inside the limits, and at a local optimum in truth."""

import numpy as np
import pytest

from flexmodal.frf import PointDirection
from flexmodal.optimisation import (
    Hold,
    MobilityObjective,
    PostureProblem,
    ReceptanceObjective,
    StiffnessObjective,
)
from flexmodal.optimisation.objectives import Limit
from flexmodal.optimisation.search import descend

from .optimality import directions, gain_left

pytestmark = pytest.mark.usefixtures("types_unchecked")


def receptance(robot, frequency, axes="z", combine="weighted"):
    return ReceptanceObjective(
        directions(*(f"{robot.tool}:+{axis}" for axis in axes)), np.atleast_1d(float(frequency)), combine
    )


CASES = {
    "static": ("arm", (-3.5, 1.0), lambda r: receptance(r, 0)),
    "5 Hz": ("arm", (-2.0, 2.0), lambda r: receptance(r, 5)),
    "worst, static": ("arm", (0.0, 1.5), lambda r: receptance(r, 0, "xz", "worst")),
    "stiffness": ("arm", (0.0, 1.5), lambda r: StiffnessObjective(*directions("tool:+z"))),
    "mobility": ("arm", (0.0, 1.5), lambda r: MobilityObjective(*directions("tool:+z"))),
    "limits, static": ("tight", (2.0, 3.0), lambda r: receptance(r, 0)),
    "limits, 5 Hz": ("tight", (2.0, 3.0), lambda r: receptance(r, 5)),
    "limits, 20 Hz": ("tight", (3.0, 2.0), lambda r: receptance(r, 20)),
    "limits, stiffness": ("tight", (3.0, 2.0), lambda r: StiffnessObjective(*directions("tool:+z"))),
    "limits, mobility": ("tight", (-1.0, 4.0), lambda r: MobilityObjective(*directions("tool:+z"))),
    "limits, no hold": ("tight", None, lambda r: receptance(r, 5)),
    "fanuc": ("fanuc", (0.9, 0.8), lambda r: receptance(r, 20)),
    "ur5": ("ur5", (0.4, 0.2, 0.3), lambda r: receptance(r, 10)),
    "ur5, stiffness": ("ur5", (0.4, 0.2, 0.3), lambda r: StiffnessObjective(PointDirection("tool0", "z"))),
    "xarm7": ("xarm7", (0.4, 0.2, 0.3), lambda r: receptance(r, 10)),
    "xarm7, worst": ("xarm7", (0.4, 0.2, 0.3), lambda r: receptance(r, 10, "xyz", "worst")),
}


SLOW = "limits, no hold", "limits, static", "worst, static", "ur5, stiffness", "xarm7", "xarm7, worst"


@pytest.mark.some(3)
@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=[pytest.mark.slow] if case in SLOW else []) for case in CASES]
)
def test_every_end_is_a_local_optimum(request, case):
    name, target, build = CASES[case]
    robot = request.getfixturevalue(name)
    hold = None if target is None else Hold.at(robot, target)
    problem, generator = PostureProblem(robot, build(robot), hold), np.random.default_rng(51)
    ends = [end for end in (descend(problem, problem.random_vector(generator)) for _ in range(6)) if end]
    assert len(ends) >= 2
    for end in ends:
        assert np.all((problem.lower <= end.values) & (end.values <= problem.upper))
        assert np.linalg.norm(problem.held(end.values)[0]) <= 1e-9
        if end.limit is not Limit.NONE:
            continue  # perfect or unbounded: no gradient has to vanish
        assert end.converged
        # The search stops at 1e-7; differences of the cost add some 1e-9, and the curvature between the
        # limit and a joint within 1e-6 of it 1e-6 times a few.
        assert gain_left(problem, end.values) <= 2e-5


def test_limits_are_in_the_way_indeed(tight):
    """Else the cases above would not test much."""
    problem = PostureProblem(tight, receptance(tight, 5), Hold.at(tight, (2.0, 3.0)))
    generator = np.random.default_rng(51)
    for _ in range(4):
        end = descend(problem, problem.random_vector(generator))
        if end is not None:
            met = (end.values < problem.lower + 1e-6) | (end.values > problem.upper - 1e-6)
            assert 1 <= met.sum() <= 4


def test_never_uphill(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    generator = np.random.default_rng(52)
    for _ in range(4):
        start = problem.retract(problem.random_vector(generator))
        costs = [problem.cost_and_gradient(start)[0]]
        costs += [descend(problem, start, iterations=count).cost for count in (1, 2, 5, 15, 200)]
        assert costs == sorted(costs, reverse=True)


def test_giving_up_is_said(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    end = descend(problem, problem.vector(arm.posture("start_2")), iterations=3)
    assert (end.converged, end.iterations) == (False, 3)


def test_unreachable_start_is_none(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (7.0, 0.0)))
    assert descend(problem, np.full(6, 0.1)) is None


def test_every_joint_at_its_limit(tight):
    """A corner of the box: no step is left, and if it is the best corner that is an answer."""
    problem = PostureProblem(tight, MobilityObjective(*directions("tool:+x")))
    for corner in (problem.lower, problem.upper):
        end = descend(problem, corner)
        assert end.converged
        if end.limit is Limit.NONE:
            assert gain_left(problem, end.values) <= 2e-5


def test_starting_at_an_optimum_costs_nothing(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    first = descend(problem, problem.vector(arm.posture("start_2")))
    again = descend(problem, first.values)
    assert again.iterations == 0
    np.testing.assert_array_equal(again.values, first.values)

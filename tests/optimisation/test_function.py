"""A judge given as a function: the same as the objective that it is."""

from pathlib import Path

import numpy as np
import pytest

from flexmodal.errors import SingularResponse
from flexmodal.frf import PointDirection
from flexmodal.machining import critical_depth, depth_over, read_cut
from flexmodal.optimisation import (
    FunctionObjective,
    Hold,
    PostureProblem,
    ReceptanceObjective,
    StiffnessObjective,
    optimise,
)
from flexmodal.optimisation.objectives import Limit
from flexmodal.optimisation.problem import Evaluation

pytestmark = pytest.mark.usefixtures("types_unchecked")

Z = PointDirection("tool", "z")
CUT = Path(__file__).parents[2] / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml"


@pytest.mark.parametrize(
    "judge", [ReceptanceObjective((Z,), np.array([5.0])), StiffnessObjective(Z)], ids=["small", "large"]
)
def test_gradient(arm, judge):
    given = FunctionObjective(judge.value, judge.unit, judge.larger_is_better)
    problem, exact = PostureProblem(arm, given), PostureProblem(arm, judge)
    generator = np.random.default_rng(3)
    for _ in range(4):
        values = problem.random_vector(generator)
        cost, slope = problem.cost_and_gradient(values)
        expected, gradient = exact.cost_and_gradient(values)
        assert cost == pytest.approx(expected, abs=1e-12)
        # rounding of the cost over the step, 1e-12 / 1e-5, and a third derivative of some g³ times 1e-10
        np.testing.assert_allclose(slope, gradient, atol=1e-6 * (1 + np.linalg.norm(gradient)) ** 3)


def test_at_a_limit_the_difference_is_taken_inside(arm):
    judge = FunctionObjective(lambda posed: 2.0 + sum(posed.posture.values.values()) / 100)
    problem = PostureProblem(arm, judge)
    _, slope = problem.cost_and_gradient(problem.upper)
    expected = 0.01 / judge.value(problem.posed(problem.upper))
    np.testing.assert_allclose(slope, expected, rtol=1e-4)


def test_a_step_that_is_refused_costs_no_differences(arm):
    """One call for each place tried, and thirteen more for each that is taken."""
    judge, calls = ReceptanceObjective((Z,), np.array([5.0])), []

    def counted(posed):
        calls.append(posed)
        return judge.value(posed)

    problem = PostureProblem(arm, FunctionObjective(counted), Hold.at(arm, (-2.0, 2.0)))
    values = problem.retract(np.array([arm.postures["start_2"][name] for name in problem.names]))
    cost, gradient = PostureProblem(arm, judge).cost_and_gradient(values)
    assert problem.cost(values) == pytest.approx(cost, abs=1e-12)
    assert len(calls) == 1
    at, found = Evaluation(problem), np.empty(6)
    at.hold_at(values, np.empty(2), np.empty((2, 6)))
    assert at.cost_at() == problem.cost(values)
    assert len(calls) == 1 + 2
    at.slope_at(found)
    np.testing.assert_allclose(found, gradient, atol=1e-6 * (1 + np.linalg.norm(gradient)) ** 3)
    assert len(calls) == 3 + 13


def test_the_same_optimum(arm):
    judge = ReceptanceObjective((Z,), np.array([5.0]))
    hold = Hold.at(arm, (-2.0, 2.0))
    given = PostureProblem(arm, FunctionObjective(judge.value, "m/N"), hold)
    found = optimise(given, start="start_2", starts=1)
    exact = optimise(PostureProblem(arm, judge, hold), start="start_2", starts=1)
    assert found.best.objective == pytest.approx(exact.best.objective, rel=1e-9)


def test_zero_infinity_and_errors(arm):
    posed = arm.at("start_1")

    def fails(posed):
        raise SingularResponse("driven at a natural frequency")

    zero = FunctionObjective(lambda posed: 0.0)
    assert zero.limit(zero.cost_and_gradient(posed)[0], arm) is Limit.PERFECT
    boundless = FunctionObjective(lambda posed: np.inf, larger_is_better=True)
    assert boundless.limit(boundless.cost_and_gradient(posed)[0], arm) is Limit.PERFECT
    cost, slope = FunctionObjective(fails).cost_and_gradient(posed)
    assert cost == np.inf
    assert not np.any(slope)
    with pytest.raises(SingularResponse):
        FunctionObjective(fails).value(posed)


@pytest.mark.slow
def test_posture_by_depth_of_cut(fanuc):
    """On the held point of a named posture the search cuts deeper, by the full comparison too."""
    cut = read_cut(CUT)
    start = fanuc.posture("configuration_4")
    x, _, z = fanuc.at(start).position("tool")
    judge = FunctionObjective(depth_over(cut, speeds=6), "m", larger_is_better=True)
    problem = PostureProblem(fanuc, judge, Hold.at(fanuc, (float(x), float(z))))
    found = optimise(problem, start=start, starts=1)
    assert found.best.objective > found.start
    assert critical_depth(fanuc, found.best.posture, cut) > critical_depth(fanuc, start, cut)
    assert np.linalg.norm(problem.held(problem.vector(found.best.posture))[0]) < 1e-9

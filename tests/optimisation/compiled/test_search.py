"""Many descents at once: they go where a single one goes, and the optima are told apart."""

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest
from flexmodal.optimisation import (
    Hold,
    MobilityObjective,
    PostureProblem,
    ReceptanceObjective,
    StiffnessObjective,
)
from flexmodal.optimisation.compiled import arm_of, box_of, descents
from flexmodal.optimisation.compiled.held import hold_at
from flexmodal.optimisation.compiled.judge import cost_at, limit_at, slope_at
from flexmodal.optimisation.descent import PERFECT, SETTLED, UNBOUNDED, UNSETTLED, work_for
from flexmodal.optimisation.objectives import Limit
from flexmodal.optimisation.search import descend_from, random_starts, search_postures

from ..optimality import directions, gain_left

pytestmark = pytest.mark.usefixtures("types_unchecked", "descents_on_disk")


def receptance(robot, frequency, axes="z", combine="weighted", **more):
    return ReceptanceObjective(
        directions(*(f"{robot.tool}:+{axis}" for axis in axes)),
        np.atleast_1d(frequency).astype(float),
        combine,
        **more,
    )


CASES = {
    "static": ("arm", (-3.5, 1.0), lambda r: receptance(r, 0)),
    "5 Hz": ("arm", (-2.0, 2.0), lambda r: receptance(r, 5)),
    "band": ("arm", (-2.0, 2.0), lambda r: receptance(r, [4.0, 5.0, 6.0])),
    "worst of a band": ("arm", (0.0, 1.5), lambda r: receptance(r, [4.0, 5.0, 6.0], "xz", "worst")),
    "weighted": ("arm", (0.0, 1.5), lambda r: receptance(r, 3, "xz")),
    "motion across the force": (
        "arm",
        (0.0, 1.5),
        lambda r: receptance(r, 3, "xz", weights=(1.0, 0.2), toward=(0.1, 1.0)),
    ),
    "cutting force": (
        "arm",
        (0.0, 1.5),
        lambda r: receptance(r, [3, 6, 9], "xz", "force", weights=(2.0, 1.0), line_weights=(1.0, 0.5, 0.2)),
    ),
    "largest of harmonics": (
        "arm",
        (-2.0, 2.0),
        lambda r: receptance(r, [3, 6, 9], over="largest", line_weights=(1.0, 0.5, 0.2)),
    ),
    "stiffness": ("arm", (0.0, 1.5), lambda r: StiffnessObjective(*directions("tool:+z"))),
    "mobility": ("arm", (0.0, 1.5), lambda r: MobilityObjective(*directions("tool:+z"))),
    "limits, 5 Hz": ("tight", (2.0, 3.0), lambda r: receptance(r, 5)),
    "limits, stiffness": ("tight", (3.0, 2.0), lambda r: StiffnessObjective(*directions("tool:+z"))),
    "limits, mobility": ("tight", (-1.0, 4.0), lambda r: MobilityObjective(*directions("tool:+z"))),
    "limits, no hold": ("tight", None, lambda r: receptance(r, 5)),
    "fanuc": ("fanuc", (0.9, 0.8), lambda r: receptance(r, 20)),
    "ur5": ("ur5", (0.4, 0.2, 0.3), lambda r: receptance(r, 10)),
    "ur5, stiffness": ("ur5", (0.4, 0.2, 0.3), lambda r: StiffnessObjective(*directions("tool0:+z"))),
    "loss and coupling": ("lossy", (0.9, 0.8), lambda r: receptance(r, [7.0, 12.0, 50.0], "xz", "worst")),
    "loss, static": ("lossy", (0.9, 0.8), lambda r: receptance(r, 0)),
    "constant loss": ("always_lossy", (0.9, 0.8), lambda r: receptance(r, [8.0, 20.0])),
    "constant loss, stiffness": (
        "always_lossy",
        (0.9, 0.8),
        lambda r: StiffnessObjective(*directions("tool:+z")),
    ),
    "xarm7, worst": ("xarm7", (0.4, 0.2, 0.3), lambda r: receptance(r, 10, "xyz", "worst")),
}
ENDS = {Limit.PERFECT: PERFECT, Limit.UNBOUNDED: UNBOUNDED}


@pytest.fixture
def case(request):
    name, target, build = CASES[request.param]
    robot = request.getfixturevalue(name)
    return PostureProblem(robot, build(robot), None if target is None else Hold.at(robot, target))


@pytest.mark.parametrize("case", CASES, indirect=True)
def test_cost_and_gradient_are_the_objective_s(case):
    """And the hold's error and Jacobian are the problem's; as ordinary Python, without the compiler."""
    arm = arm_of(case)
    error, constraint = np.empty(case.held_components), np.empty((case.held_components, len(case.names)))
    found = np.empty(len(case.names))
    for values in random_starts(case, 5, np.random.default_rng(2)):
        size = hold_at(arm, values, error, constraint)
        cost = cost_at(arm)
        slope_at(arm, found)
        off, jacobian = case.held(values)
        expected, gradient = case.cost_and_gradient(values)
        assert size == pytest.approx(np.linalg.norm(off), abs=1e-12)
        np.testing.assert_allclose(constraint, jacobian, rtol=0, atol=1e-12)
        assert cost == pytest.approx(expected, abs=1e-11)
        # a stiffness measure near a singular posture loses digits on both sides
        np.testing.assert_allclose(found, gradient, rtol=1e-8, atol=1e-9 * np.max(np.abs(gradient)))
        limit = case.objective.limit(cost, case.robot)
        assert limit_at(arm, cost) == ENDS.get(limit, UNSETTLED)


@pytest.mark.parametrize("case", CASES, indirect=True)
def test_one_compilation_serves_every_problem(case, arm):
    """The compiler tells arrays apart by layout and by whether they are read-only; half a minute for each."""
    numba = pytest.importorskip("numba")
    usual = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    assert numba.typeof(arm_of(case)) == numba.typeof(arm_of(usual))
    assert numba.typeof(box_of(case)) == numba.typeof(box_of(usual))
    works = [numba.typeof(work_for(one.held_components, len(one.names))) for one in (case, usual)]
    assert works[0] == works[1]


@pytest.mark.some(3)
@pytest.mark.parametrize("case", [name for name in CASES if "limits" not in name], indirect=True)
def test_the_same_descent(case):
    """The first steps agree but for rounding, which grows on the way, and decides what is at a limit."""
    starts = random_starts(case, 12, np.random.default_rng(3))
    few, expected = (descend_from(case, starts, iterations=3, way=way) for way in ("compiled", "plain"))
    reached = expected.cost < np.inf
    np.testing.assert_array_equal(few.cost < np.inf, reached)
    np.testing.assert_allclose(few.cost[reached], expected.cost[reached], rtol=0, atol=1e-4)
    for cost, values in zip(few.cost[reached], few.values[reached], strict=True):
        assert case.cost_and_gradient(values)[0] == pytest.approx(cost, abs=1e-11)


@pytest.mark.some(4)
@pytest.mark.parametrize("case", CASES, indirect=True)
def test_every_end_is_a_local_optimum(case):
    found = search_postures(case, random_starts(case, 24, np.random.default_rng(4)), way="compiled")
    ends = found.ends
    assert found.settled == (len(found.cost) > 0)
    assert ends.reached >= 2
    assert found.hits.sum() <= ends.reached - ends.unbounded
    assert np.all(np.diff(found.cost) >= 0)
    for values, cost in zip(found.values[:4], found.cost[:4], strict=True):
        assert np.all((case.lower <= values) & (values <= case.upper))
        assert np.linalg.norm(case.held(values)[0]) <= 1e-9
        if case.objective.limit(cost, case.robot) is Limit.NONE:  # else a zero, all of it rounding
            assert case.cost_and_gradient(values)[0] == pytest.approx(cost, abs=1e-11)
            assert gain_left(case, values) <= 2e-5


@pytest.mark.parametrize(
    "case", ["5 Hz", "worst of a band", "stiffness", "ur5", "loss and coupling"], indirect=True
)
def test_plain_and_compiled_are_the_same(case):
    starts = random_starts(case, 3, np.random.default_rng(5))
    plain, compiled = (search_postures(case, starts, way=way, iterations=6) for way in ("plain", "compiled"))
    np.testing.assert_allclose(plain.ends.values, compiled.ends.values, rtol=0, atol=1e-8)
    np.testing.assert_array_equal(plain.ends.iterations, compiled.ends.iterations)


def test_threads_and_batches_change_nothing(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    starts = random_starts(problem, 150, np.random.default_rng(6))
    told = []
    one = search_postures(problem, starts, threads=1, way="compiled")
    two = search_postures(
        problem, starts, threads=2, way="compiled", progress=lambda done, best: told.append((done, best))
    )
    np.testing.assert_array_equal(one.ends.values, two.ends.values)
    assert [done for done, _ in told] == [128, 150]
    assert told[-1][1] == two.cost[0]


def test_interrupted_keeps_the_best(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    starts = random_starts(problem, 150, np.random.default_rng(6))

    def stop(done, best):
        raise KeyboardInterrupt

    found = search_postures(problem, starts, threads=1, way="compiled", progress=stop)
    assert found.ends.reached == 64
    assert len(found.cost) > 0


def test_whole_turns_are_one_posture(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    starts = random_starts(problem, 1, np.random.default_rng(7))
    turned = starts + np.where(starts > 0, -2 * np.pi, 2 * np.pi) * np.eye(6)[0]
    found = search_postures(problem, np.concatenate([starts, turned]))
    assert (len(found.cost), found.hits[0]) == (1, 2)


def test_nothing_reached_is_nothing_found(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (7.0, 0.0)))
    found = search_postures(problem, random_starts(problem, 4, np.random.default_rng(8)))
    assert (len(found.cost), found.ends.reached, found.settled) == (0, 0, False)


def test_bad_arguments_are_named_together(arm):
    problem = PostureProblem(arm, receptance(arm, 5))
    with pytest.raises(InvalidRequest) as caught:
        search_postures(problem, np.full((2, 5), np.nan), iterations=0, threads=True, way="fast")
    assert sorted(fault.key for fault in caught.value.faults) == ["iterations", "starts", "threads", "way"]


def test_all_searches_are_one_piece_of_code(arm):
    """One specialisation of one function: what it calls is inside it."""
    pytest.importorskip("numba")
    for hold, objective in (
        (Hold.at(arm, (-2.0, 2.0)), receptance(arm, 5)),
        (None, receptance(arm, 5, "xz", "worst")),
    ):
        problem = PostureProblem(arm, objective, hold)
        descend_from(problem, random_starts(problem, 2, np.random.default_rng(1)), way="compiled")
    assert len(descents().compiled.signatures) == 1


def test_good_starts_settle(arm):
    problem = PostureProblem(arm, receptance(arm, 5), Hold.at(arm, (-2.0, 2.0)))
    found = search_postures(problem, random_starts(problem, 200, np.random.default_rng(9)), way="compiled")
    assert np.all(found.ends.end == SETTLED)

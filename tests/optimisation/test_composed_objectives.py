"""Cutting forces, harmonics, combinations, samples, poles: values by definition, gradients by differences."""

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot
from flexmodal.optimisation import (
    CombinedObjective,
    FunctionObjective,
    Hold,
    MobilityObjective,
    Objective,
    PostureProblem,
    ReceptanceObjective,
    RobustObjective,
    SeparationObjective,
    StiffnessObjective,
    TunedObjective,
    optimise,
    sample_robots,
    tooth_passing,
)
from flexmodal.optimisation.objectives.combined import _WAYS
from flexmodal.optimisation.objectives.objective import COMBINE, OVER
from flexmodal.optimisation.objectives.robust import _JUDGED

from .optimality import difference
from .test_objectives import OBJECTIVES as SINGLE

BAND = np.linspace(3.0, 20.0, 6)


def along(robot, axes):
    return tuple(PointDirection(robot.tool, axis) for axis in axes)


def receptance(robot, frequency, axes="z", **rest):
    return ReceptanceObjective(along(robot, axes), np.atleast_1d(np.array(frequency, dtype=float)), **rest)


def passing(robot, **rest):
    return receptance(robot, tooth_passing(90.0, 4, 3), "xz", line_weights=(1.0, 0.5, 0.2), **rest)


OBJECTIVES = {
    "force": lambda r: receptance(r, 5, "xz", combine="force", weights=(1.0, -2.0)),
    "force over a band": lambda r: receptance(r, BAND, "xz", combine="force", over="largest"),
    "toward": lambda r: receptance(r, 5, "xz", weights=(1.0, 2.0), toward=(0.0, 1.0)),
    "harmonics, mean": lambda r: passing(r, weights=(1.0, 0.4), toward=(0.3, 1.0)),
    "harmonics, largest": lambda r: passing(r, combine="force", over="largest"),
    "worst, mean over a band": lambda r: receptance(r, BAND, "xz", combine="worst", over="mean"),
    "product": lambda r: CombinedObjective(
        (receptance(r, 5), StiffnessObjective(*along(r, "z")), MobilityObjective(*along(r, "x"))),
        (1.0, 0.5, 2.0),
    ),
    "sum": lambda r: CombinedObjective((receptance(r, 5), receptance(r, 12, "x")), (1.0, 3.0), "sum"),
    "worst of parts": lambda r: CombinedObjective(
        (receptance(r, 5), receptance(r, 12, "x")), (1.0, 3.0), "worst"
    ),
    "expected": lambda r: RobustObjective(receptance(r, 5), sample_robots(r, 4, seed=1)),
    "worst of a sample": lambda r: RobustObjective(receptance(r, 5), sample_robots(r, 4, seed=1), "worst"),
    "expected stiffness": lambda r: RobustObjective(
        StiffnessObjective(*along(r, "z")), sample_robots(r, 3, stiffness=0.2, seed=2)
    ),
    "worst stiffness": lambda r: RobustObjective(
        StiffnessObjective(*along(r, "z")), sample_robots(r, 3, stiffness=0.2, seed=2), "worst"
    ),
    "tuned, robust": lambda r: RobustObjective(
        TunedObjective(*along(r, "z"), (1.0, 40.0)), sample_robots(r, 2, seed=3)
    ),
    "robust product": lambda r: CombinedObjective(
        (RobustObjective(receptance(r, 5), sample_robots(r, 3, seed=1)), SeparationObjective(5.0))
    ),
    "away from a frequency": lambda r: SeparationObjective(5.0),
    "tuned": lambda r: TunedObjective(*along(r, "z"), (1.0, 40.0)),
    "force, mean": lambda r: receptance(r, BAND, "xz", combine="force"),
    "toward, largest": lambda r: receptance(
        r, BAND, "xz", weights=(1.0, 2.0), toward=(0.3, 1.0), over="largest"
    ),
    "weighted, largest": lambda r: receptance(r, BAND, "xz", weights=(1.0, 2.0), over="largest"),
    "worst, largest": lambda r: receptance(r, BAND, "xz", combine="worst"),
    "robust mobility": lambda r: RobustObjective(
        MobilityObjective(*along(r, "x")), sample_robots(r, 2, seed=4), "worst"
    ),
    "robust separation": lambda r: RobustObjective(
        SeparationObjective(5.0), sample_robots(r, 2, seed=5), "worst"
    ),
    "sample of a worst of sums": lambda r: RobustObjective(
        CombinedObjective(
            (
                CombinedObjective((receptance(r, 5), receptance(r, 12, "x")), (1.0, 3.0), "sum"),
                receptance(r, 8, "xz", combine="worst"),
            ),
            way="worst",
        ),
        sample_robots(r, 2, seed=6),
    ),
    "function": lambda r: FunctionObjective(receptance(r, 5).value, "m/N"),
    "product of products": lambda r: CombinedObjective(
        (
            CombinedObjective((receptance(r, 5), SeparationObjective(5.0))),
            RobustObjective(StiffnessObjective(*along(r, "z")), sample_robots(r, 2, seed=7)),
        ),
        (1.0, 2.0),
    ),
}
"""Everything that composes, in ways that a user might."""


def parts_of(judge):
    """An objective, and all that it is made of."""
    inner = getattr(judge, "parts", ()) or filter(None, [getattr(judge, "objective", None)])
    return [judge, *(part for one in inner for part in parts_of(one))]


def test_the_gradient_of_every_objective_is_tested(arm):
    """Whatever the package offers as an objective is among those of `test_gradient`, in all its variants."""
    offered = {
        kind
        for kind in vars(flexmodal.optimisation).values()
        if isinstance(kind, type)
        and hasattr(kind, "cost_and_gradient")
        and kind not in (Objective, PostureProblem)
    }
    assert len(offered) >= 7
    tested = [part for build in (*OBJECTIVES.values(), *SINGLE.values()) for part in parts_of(build(arm))]
    assert {type(part) for part in tested} == offered
    variants = {
        (part.combine, part.over, part.toward != part.weights)
        for part in tested
        if isinstance(part, ReceptanceObjective) and len(part.directions) > 1
    }
    across = {("weighted", over, True) for over in OVER}
    assert variants == {(way, over, False) for way in COMBINE for over in OVER} | across
    assert {part.way for part in tested if isinstance(part, CombinedObjective)} == set(_WAYS)
    assert {(part.judge, part.larger_is_better) for part in tested if isinstance(part, RobustObjective)} == {
        (judge, large) for judge in _JUDGED for large in (True, False)
    }
    held = {part.task for part in tested if isinstance(part, StiffnessObjective)}
    assert held == {"full", "position"}


@pytest.mark.some(3)
@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize(
    "name", ["six_link", *(pytest.param(name, marks=pytest.mark.slow) for name in ("fanuc_s360", "ur5"))]
)
def test_gradient(robots, name, objective):
    robot = robots[name]
    judge = OBJECTIVES[objective](robot)
    assert isinstance(judge, Objective)
    problem = PostureProblem(robot, judge)
    generator = np.random.default_rng(31)
    tried = 0
    while tried < 3:
        values = problem.random_vector(generator)
        _, gradient = problem.cost_and_gradient(values)
        size = float(np.linalg.norm(gradient))
        if size > 20:
            continue  # beside a zero or a pole of the measure, where differences say little
        tried += 1
        expected = difference(lambda v: np.array(problem.cost_and_gradient(v)[0]), values, 2e-4)
        # As in test_objectives; a maximum by power 40 has fifth derivatives of up to 40⁴ g⁵, 2.5e6 × 1e-15.
        # Poles are known to some 1e-13 of the largest, beside which the nearest is 1e-3: 1e-10 / 2e-4.
        assert np.max(np.abs(gradient - expected)) <= 2e-6 * (1 + size) ** 2


def test_poles_apart_from_one_another(fanuc):
    """Of the Fanuc, whose four modes vibrate throughout."""
    problem = PostureProblem(fanuc, SeparationObjective())
    generator = np.random.default_rng(3)
    for _ in range(4):
        values = problem.random_vector(generator)
        _, gradient = problem.cost_and_gradient(values)
        expected = difference(lambda v: np.array(problem.cost_and_gradient(v)[0]), values, 2e-4)
        assert np.max(np.abs(gradient - expected)) <= 2e-6 * (1 + np.linalg.norm(gradient)) ** 2
        poles = fanuc.modes(problem.posture(values)).pole
        gaps = [abs(a - b) for i, a in enumerate(poles) for b in poles[:i]]
        posed = problem.posed(values)
        assert problem.objective.value(posed) == pytest.approx(min(gaps) / (2 * np.pi), rel=1e-12)


def test_the_nearest_pole(arm):
    posed = arm.at("start_2")
    expected = np.min(np.abs(arm.modes("start_2").pole - 2j * np.pi * 5)) / (2 * np.pi)
    assert SeparationObjective(5.0).value(posed) == pytest.approx(expected, rel=1e-12)
    with pytest.raises(InvalidRequest, match="finite"):
        SeparationObjective(-1.0)


def alpha(robot, posed, axes, frequency):
    """α by the formula."""
    omega, system = 2 * np.pi * frequency, posed.system
    dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    rows = np.array([d.selector @ posed.jacobian(d.point) for d in along(robot, axes)])
    return rows @ np.linalg.inv(dynamic) @ rows.T


def test_values_by_definition(arm):
    posed = arm.at("start_2")
    f, n = np.array([1.0, -2.0]) / np.sqrt(5), np.array([0.3, 1.0]) / np.hypot(0.3, 1)
    matrix = alpha(arm, posed, "xz", 5.0)
    force = receptance(arm, 5, "xz", combine="force", weights=(1.0, -2.0))
    assert force.value(posed) == pytest.approx(np.linalg.norm(matrix @ f), rel=1e-12)
    normal = receptance(arm, 5, "xz", weights=(1.0, -2.0), toward=(0.3, 1.0))
    assert normal.value(posed) == pytest.approx(abs(n @ matrix @ f), rel=1e-12)
    lines = [(6.0, 1.0), (12.0, 0.5), (18.0, 0.2)]
    sizes = [share * abs(f @ alpha(arm, posed, "xz", line) @ f) for line, share in lines]
    for over, expected in (("mean", np.mean(sizes)), ("largest", max(sizes)), ("", np.mean(sizes))):
        found = passing(arm, weights=(1.0, -2.0), over=over)
        assert found.value(posed) == pytest.approx(expected, rel=1e-12)
    assert force.value(posed) <= receptance(arm, 5, "xz", combine="worst").value(posed)


def test_tooth_passing():
    np.testing.assert_allclose(tooth_passing(18000.0, 4), [1200.0])  # the thesis: four teeth at 300 Hz
    np.testing.assert_allclose(tooth_passing(90.0, 4, 3), [6.0, 12.0, 18.0])
    for bad in ((0.0, 4, 1), (90.0, 0, 1), (90.0, 4, 0), (np.nan, 4, 1), (np.inf, 4, 1)):
        with pytest.raises(InvalidRequest, match="spindle"):
            tooth_passing(*bad)


def test_combinations_by_definition(arm):
    posed = arm.at("start_2")
    parts = (receptance(arm, 5), receptance(arm, 12, "x"))
    a, b = (part.value(posed) for part in parts)
    assert CombinedObjective(parts, (1.0, 3.0), "sum").value(posed) == pytest.approx(a + 3 * b)
    assert CombinedObjective(parts, (1.0, 3.0), "worst").value(posed) == pytest.approx(max(a, 3 * b))
    assert CombinedObjective(parts, (1.0, 3.0)).value(posed) == pytest.approx(a**0.25 * b**0.75)
    stiff = StiffnessObjective(*along(arm, "z"))
    mixed = CombinedObjective((parts[0], stiff))
    assert mixed.value(posed) == pytest.approx(np.sqrt(a / stiff.value(posed)))
    assert (mixed.unit, CombinedObjective(parts).unit) == ("–", "m/N")
    for name, judge in OBJECTIVES.items():
        cost, value = judge(arm).cost_and_gradient(posed)[0], judge(arm).value(posed)
        sign = -1 if judge(arm).larger_is_better else 1
        # a smooth maximum of n values is off by ln(n)/40 at most, n ≤ 12
        assert sign * cost == pytest.approx(np.log(value), abs=np.log(12) / 40 + 1e-9), name


def test_samples(arm):
    sample = sample_robots(arm, 400, stiffness=0.1, damping={"q2": 0.5}, seed=4)
    factors = np.array([np.diag(robot.stiffness) / np.diag(arm.stiffness) for robot in sample])
    losses = np.array([np.diag(robot.damping) / np.diag(arm.damping) for robot in sample])
    # 400 draws: the standard deviation of a logarithm is known to 1/√800 = 3.5 %, times four for six joints
    np.testing.assert_allclose(np.log(factors).std(axis=0), 0.1, rtol=0.14)
    assert np.log(losses[:, 1]).std() == pytest.approx(0.5, rel=0.14)
    np.testing.assert_array_equal(np.delete(losses, 1, axis=1), 1.0)
    again = sample_robots(arm, 400, stiffness=0.1, damping={"q2": 0.5}, seed=4)
    np.testing.assert_array_equal(again[7].stiffness, sample[7].stiffness)
    posture = arm.posture("start_2")
    judge = receptance(arm, 5)
    values = [judge.value(PosedRobot(robot, posture)) for robot in sample[:5]]
    posed = arm.at(posture)
    assert RobustObjective(judge, sample[:5]).value(posed) == pytest.approx(np.mean(values))
    assert RobustObjective(judge, sample[:5], "worst").value(posed) == pytest.approx(max(values))
    stiff = StiffnessObjective(*along(arm, "z"))
    values = [stiff.value(PosedRobot(robot, posture)) for robot in sample[:5]]
    assert RobustObjective(stiff, sample[:5], "worst").value(posed) == pytest.approx(min(values))
    assert RobustObjective(stiff, sample[:5]).value(posed) == pytest.approx(1 / np.mean(1 / np.array(values)))


def test_a_certain_robot_is_its_own_sample(arm):
    judge, posed = receptance(arm, 5), arm.at("start_2")
    certain = RobustObjective(judge, sample_robots(arm, 3, stiffness=0.0, damping=0.0))
    assert certain.value(posed) == pytest.approx(judge.value(posed), rel=1e-14)
    np.testing.assert_allclose(
        certain.cost_and_gradient(posed)[1], judge.cost_and_gradient(posed)[1], rtol=1e-9
    )


@pytest.mark.usefixtures("types_unchecked")
@pytest.mark.slow
def test_the_robust_posture_is_the_better_one_over_the_sample(arm):
    """From the same starts: judged by the sample, the posture found by the sample wins."""
    sample, hold = sample_robots(arm, 6, stiffness=0.3, seed=5), Hold.at(arm, (-2.0, 2.0))
    judge = receptance(arm, 1.5)
    robust = RobustObjective(judge, sample, "worst")
    plain = optimise(PostureProblem(arm, judge, hold), start="start_2", starts=4)
    safe = optimise(PostureProblem(arm, robust, hold), start="start_2", starts=4)
    assert safe.best.objective <= robust.value(arm.at(plain.best.posture)) * (1 + 1e-9)


def test_bad_requests(arm, fanuc):
    z = along(arm, "z")
    part, stiff = receptance(arm, 5), StiffnessObjective(*z)
    for build, says in (
        (lambda: receptance(arm, 5, over="median"), "mean or largest"),
        (lambda: receptance(arm, 5, combine="force", toward=(1.0,)), "toward"),
        (lambda: receptance(arm, 5, toward=(1.0, 2.0)), "1 finite weights"),
        (lambda: receptance(arm, [5, 6], line_weights=(1.0,)), "2 finite numbers above 0"),
        (lambda: receptance(arm, [5, 6], line_weights=(1.0, 0.0)), "2 finite numbers above 0"),
        (lambda: CombinedObjective(()), "at least one"),
        (lambda: CombinedObjective((part,), (0.0,)), "above 0"),
        (lambda: CombinedObjective((part, stiff), way="sum"), "to be small in a sum"),
        (lambda: CombinedObjective((part, MobilityObjective(*z)), way="worst"), "one unit"),
        (lambda: CombinedObjective((part,), way="max"), "product, sum, worst"),
        (lambda: RobustObjective(part, ()), "at least one sample"),
        (lambda: RobustObjective(part, (arm,), "median"), "expected or worst"),
        (lambda: RobustObjective(part, (arm, fanuc)), "the same joints"),
        (lambda: sample_robots(arm, 0), "at least 1"),
        (lambda: sample_robots(arm, 1, stiffness=-0.1), "from 0 to 3"),
        (lambda: sample_robots(arm, 1, damping={"q9": 0.1}), "'q9'"),
    ):
        with pytest.raises(InvalidRequest, match=says):
            build()

"""No posture of a search, a path or a picture comes too near, and little is lost by the barrier."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import ObstacleCard
from flexmodal.errors import InCollision, InvalidRequest
from flexmodal.model.guess import guess_card
from flexmodal.optimisation import Clearance, Hold, PostureProblem, ReceptanceObjective, optimise
from flexmodal.optimisation.clearance import Apart

TABLE = ObstacleCard(box=(1.6, 1.6, 0.05), xyz=(0.0, 0.0, -0.03))
FIXTURE = ObstacleCard(box=(0.2, 0.3, 0.25), xyz=(0.45, 0.3, 0.125))


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    robot = flexmodal.load(guess_card("ur5", tmp_path_factory.mktemp("ur5")).write())
    return replace(robot, obstacles={"table": TABLE, "fixture": FIXTURE})


@pytest.fixture(scope="module")
def problem(arm):
    judge = ReceptanceObjective("tool:+z", 20.0)
    return PostureProblem(arm, judge, Hold.at(arm, (0.5, 0.1, 0.2)), clearance=Clearance.of(arm))


@pytest.fixture(scope="module")
def outcome(problem):
    return optimise(problem, starts=3, seed=0)


def test_every_optimum_is_clear_and_holds(problem, outcome):
    scene = problem.clearance.scene
    for optimum in outcome.optima:
        for posture in (optimum.posture, *optimum.equals):
            posed = problem.robot.at(posture)
            assert scene.nearest(posed)[0] >= problem.clearance.distance
            assert np.linalg.norm(problem.hold.error(posed)) < 1e-9
    assert outcome.nearest[0] >= problem.clearance.distance


@pytest.mark.slow
def test_without_it_the_elbow_is_in_the_table(problem):
    loose = optimise(replace(problem, clearance=None), starts=16, seed=0, way="plain")
    distance, names = problem.clearance.scene.nearest(problem.robot.at(loose.best.posture))
    assert distance < 0
    assert "table" in names
    assert loose.nearest is None


def test_the_barrier_and_its_gradient(problem):
    generator, compared = np.random.default_rng(3), 0
    wide = replace(problem.clearance, reach=0.2, weight=1.0)
    near = replace(problem, clearance=wide)
    for _ in range(400):
        values = near.random_vector(generator)
        try:
            cost, gradient = near.cost_and_gradient(values)
        except InCollision:
            assert wide.scene.nearest(near.posed(values))[0] <= wide.distance
            continue
        bare = replace(near, clearance=None).cost_and_gradient(values)[0]
        assert cost >= bare
        if cost - bare < 0.1:
            continue
        step = 1e-5 * generator.normal(size=len(values))
        try:
            slope = near.cost_and_gradient(values + step)[0] - near.cost_and_gradient(values - step)[0]
        except InCollision:
            continue
        compared += abs(slope / 2 - gradient @ step) < 1e-3 * np.linalg.norm(gradient) * np.linalg.norm(step)
    assert compared > 5


def test_moving_apart_is_a_sum_of_squares(problem):
    apart = Apart(problem.clearance, 0.5)
    posed = problem.robot.at("middle")
    cost, _ = apart.cost_and_gradient(posed)
    wanted = 0.01 + 0.5 * 0.05
    missing = np.maximum(wanted - problem.clearance.scene.distances(posed), 0) / 0.05
    assert cost == pytest.approx(0.5 * np.sum(missing**2))


def test_a_target_inside_the_fixture_has_no_answer(arm):
    buried = PostureProblem(
        arm,
        ReceptanceObjective("tool:+z", 20.0),
        Hold.at(arm, (0.45, 0.3, 0.12)),
        clearance=Clearance.of(arm),
    )
    with pytest.raises(InCollision, match="clear of everything"):
        optimise(buried, starts=2, seed=0)


def test_little_is_lost_by_the_barrier(problem, outcome):
    """Going on from the optimum with a tenth of the barrier's reach gains next to nothing."""
    closer = replace(problem, clearance=replace(problem.clearance, reach=0.005))
    again = optimise(closer, start=outcome.best.posture, starts=1)
    assert again.best.objective == pytest.approx(outcome.best.objective, rel=0.02)


def test_family_and_null_space(arm, problem):
    with pytest.raises(InvalidRequest, match="null-space"):
        optimise(problem, start="bent", method="null-space")
    with pytest.raises(InvalidRequest, match="serial chain"):
        optimise(problem, way="compiled")


def test_no_shapes_are_told(arm):
    with pytest.raises(InvalidRequest, match="no two shapes that could meet"):
        Clearance.of(flexmodal.load("six_axis"))


@pytest.mark.slow
def test_a_path_keeps_clear(arm):
    from flexmodal.optimisation.path import PathProblem, line, plan_path

    toolpath = line((0.5, -0.1, 0.2), (0.5, 0.1, 0.2), 5, 0.1)
    clearance = Clearance.of(arm)
    judged = PathProblem.along(arm, toolpath, 20.0, clearance=clearance)
    found = plan_path(judged, nodes=20)
    for values in found.postures:
        assert clearance.scene.nearest(judged.at[0].posed(values))[0] >= clearance.distance
    assert found.nearest[0] <= clearance.scene.nearest(judged.at[0].posed(found.postures[0]))[0]


@pytest.mark.slow
def test_self_motion_is_not_drawn_through_the_table(problem, outcome):
    from flexmodal.optimisation.pictures.plot import _value

    vector = problem.vector(outcome.best.posture)
    assert np.isfinite(_value(problem, vector))
    loose = optimise(replace(problem, clearance=None), starts=16, seed=0, way="plain")
    assert np.isnan(_value(problem, problem.vector(loose.best.posture)))

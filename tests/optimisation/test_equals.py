"""Equal optima are one, angles lie within a turn, and a start is compared where it holds the target."""

import numpy as np
import pytest
from scipy.optimize import minimize

import flexmodal
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, optimise
from flexmodal.optimisation.search import nearest_held, within_a_turn


@pytest.fixture(scope="module")
def arm():
    return flexmodal.load("six_axis")


@pytest.fixture(scope="module")
def problem(arm):
    return PostureProblem(arm, ReceptanceObjective("tool:+z", 20.0), Hold.at(arm, (0.8, 0.1, 0.9)))


@pytest.fixture(scope="module")
def found(problem):
    return optimise(problem, start={"q2": 0.3}, starts=48, seed=2, way="plain")


def test_no_two_optima_have_one_value(found):
    values = np.array([one.objective for one in found.optima])
    assert np.all(np.diff(np.log(values)) > 1e-6)
    assert any(one.equals for one in found.optima)  # the wrist turned over


def test_equals_are_as_good_and_hold(problem, found):
    for optimum in found.optima:
        for posture in optimum.equals:
            value = problem.objective.value(problem.robot.at(posture))
            assert value == pytest.approx(optimum.objective, rel=1e-5)
            assert np.linalg.norm(problem.hold.error(problem.robot.at(posture))) < 1e-9


def test_an_idle_joint_makes_one_optimum(tmp_path):
    """A wrist about the direction of the force, its mass on its axis, moves nothing that counts."""
    inertial = (
        '<inertial><origin xyz="{0} 0 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" '
    )
    inertial += 'iyz="0" izz="0.1"/></inertial>'
    names = ["upper", "fore", "spin"]
    links = "".join(f'<link name="{n}">{inertial.format(0.0 if n == "spin" else 0.5)}</link>' for n in names)
    joints = ""
    for name, parent, child, axis, x in (
        ("q1", "base", "upper", "0 -1 0", 0), ("q2", "upper", "fore", "0 -1 0", 1),
        ("q3", "fore", "spin", "1 0 0", 1),
    ):  # fmt: skip
        joints += (
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{x} 0 0"/><axis xyz="{axis}"/>'
            '<limit lower="-3.1" upper="3.1" effort="1" velocity="1"/></joint>'
        )
    path = tmp_path / "idle.urdf"
    path.write_text(f'<robot name="idle"><link name="base"/>{links}{joints}</robot>')
    robot = flexmodal.load(path, stiffness=1e4, damping=5.0, tool="spin")
    free = PostureProblem(robot, ReceptanceObjective("spin:+z", 3.0), Hold.at(robot, (1.2, 0.0, 0.5)))
    outcome = optimise(free, starts=9, seed=0, way="plain")
    assert len(outcome.optima) == 2  # elbow up and down
    assert sum(len(one.equals) + 1 for one in outcome.optima) > 2
    assert "more starts" not in outcome.verdict


def test_angles_lie_within_half_a_turn_of_the_start(problem, found):
    start = problem.vector(found.compared.held)
    for optimum in found.optima:
        values = problem.vector(optimum.posture)
        turned = within_a_turn(problem, values, start)
        assert np.array_equal(values, turned)
    far = np.array([0, 0, 0, 3.4, 0, 0])
    assert within_a_turn(problem, far)[3] == pytest.approx(3.4 - 2 * np.pi)


def test_a_start_elsewhere_is_brought_to_the_target(problem, found):
    compared = found.compared
    given = problem.robot.at(compared.given)
    assert compared.away == pytest.approx(np.linalg.norm(given.position("tool") - (0.8, 0.1, 0.9)))
    assert not compared.is_held
    assert np.linalg.norm(problem.hold.error(problem.robot.at(compared.held))) < 1e-9
    assert found.start == pytest.approx(problem.objective.value(problem.robot.at(compared.held)))


def test_it_is_the_nearest_that_another_solver_finds(problem):
    start = np.array([0.0, 0.3, 0.0, 0.0, 0.0, 0.0])
    ours = nearest_held(problem, start)
    constraint = {"type": "eq", "fun": lambda q: problem.held(np.clip(q, problem.lower, problem.upper))[0]}
    bounds = list(zip(problem.lower, problem.upper, strict=True))
    theirs = minimize(
        lambda q: np.sum((q - start) ** 2), ours, constraints=constraint, bounds=bounds, tol=1e-12
    )
    assert np.linalg.norm(ours - start) <= np.linalg.norm(theirs.x - start) * (1 + 1e-4)


def test_a_start_that_holds_is_itself(problem, found):
    again = optimise(problem, start=found.best.posture, starts=1, way="plain")
    assert again.compared.is_held
    assert again.start == pytest.approx(again.compared.objective)


def test_what_was_found_once_is_not_called_converged(problem):
    alone = optimise(problem, starts=3, seed=1, way="plain")
    if alone.best.hits == 1:
        assert "converged" not in alone.verdict
        assert "more starts" in alone.verdict

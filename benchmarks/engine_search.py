"""The posture search against scipy's SLSQP with finite differences, on the six-link arm held at a point.

Part of `make bench`; by itself, `python benchmarks/engine_search.py [ROUNDS]` prints its rows.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pinocchio as pin
from engine_harness import interleaved
from scipy.optimize import minimize

import flexmodal
from flexmodal import Hold, PointDirection, PostureProblem, ReceptanceObjective
from flexmodal.optimisation.search import descend, random_starts, search_postures

HERTZ, TARGET = 5.0, (-2.0, 2.0)
OURS, THEIRS, BEFORE = 256, 64, 16
"""Starts of the compiled search, of SLSQP, and of the descents in Python."""

Function = Callable[[np.ndarray], float]
Vector = Callable[[np.ndarray], np.ndarray]


def problem() -> PostureProblem:
    """The task."""
    robot = flexmodal.load("six_link")
    objective = ReceptanceObjective((PointDirection("tool", "z"),), np.array([HERTZ]))
    return PostureProblem(robot, objective, Hold.at(robot, TARGET))


def package(task: PostureProblem) -> tuple[Function, Vector]:
    """Cost and constraint as a user of the package writes them."""
    robot, hold = task.robot, task.hold
    assert hold is not None

    def cost(q: np.ndarray) -> float:
        value = robot.at(dict(zip(task.names, q.tolist(), strict=True))).frf([HERTZ], response="tool:+z")
        return float(np.log(abs(value.value[0, 0, 0])))

    def error(q: np.ndarray) -> np.ndarray:
        position = robot.at(dict(zip(task.names, q.tolist(), strict=True))).position("tool")
        return np.asarray(hold.rows @ position - hold.target)

    return cost, error


def by_hand(task: PostureProblem) -> tuple[Function, Vector]:
    """The same with nothing but the calls of Pinocchio and numpy that it takes."""
    robot, hold = task.robot, task.hold
    assert hold is not None
    model, frame = robot.pinocchio, robot.frame_of("tool")
    data, omega = model.createData(), 2 * np.pi * HERTZ
    rest, world = robot.stiffness + 1j * omega * robot.damping, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def cost(q: np.ndarray) -> float:
        mass = pin.crba(model, data, q)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacement(model, data, frame)
        row = pin.getFrameJacobian(model, data, frame, world)[2]
        return float(np.log(abs(row @ np.linalg.solve(rest - omega**2 * mass, row))))

    def error(q: np.ndarray) -> np.ndarray:
        pin.forwardKinematics(model, data, q)
        pin.updateFramePlacement(model, data, frame)
        return np.asarray(hold.rows @ data.oMf[frame].translation - hold.target)

    return cost, error


def slsqp(task: PostureProblem, functions: tuple[Function, Vector], starts: np.ndarray) -> float:
    """Best cost on the hold, scipy's defaults."""
    cost, error = functions
    slack = 1e-6  # the package refuses postures outside the limits, where differences may step
    bounds = list(zip(task.lower + slack, task.upper - slack, strict=True))
    ends = [
        minimize(cost, start, method="SLSQP", bounds=bounds, constraints={"type": "eq", "fun": error})
        for start in starts
    ]
    return min(float(end.fun) for end in ends if np.linalg.norm(error(end.x)) <= 1e-4)


def variants(task: PostureProblem) -> dict[str, tuple[Callable[[], float], int]]:
    """What is timed: best cost of each, and as how many runs it counts."""
    starts = random_starts(task, OURS, np.random.default_rng(0))

    def ours() -> float:
        return float(search_postures(task, starts, threads=1, way="compiled").cost[0])

    def before() -> float:
        ends = [descend(task, start) for start in starts[:BEFORE]]
        return min(end.cost for end in ends if end is not None)

    return {
        "ours": (ours, 1),
        "package": (lambda: slsqp(task, package(task), starts[:THEIRS]), 1),
        "by hand": (lambda: slsqp(task, by_hand(task), starts[:THEIRS]), 1),
        "descents in Python": (before, 1),
    }


def main() -> None:
    found = variants(problem())
    best = {name: call() for name, (call, _) in found.items()}
    run = interleaved(found, int(sys.argv[1]) if len(sys.argv) > 1 else 5)
    for name in found:
        print(
            f"{name}: {1e3 * run.median(name):.1f} ms, {run.longer(name, 'ours')} times as long as ours, "
            f"|receptance| {np.exp(best[name]):.6e} m/N",
            flush=True,
        )


if __name__ == "__main__":
    main()

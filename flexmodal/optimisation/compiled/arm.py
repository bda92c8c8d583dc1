"""A posture problem as plain arrays, where it can be one."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.model import Robot
from flexmodal.model.batch.chain import chain_of, places_of, turn_of
from flexmodal.model.batch.springs import springs_of
from flexmodal.model.receptance_source import ModelReceptances
from flexmodal.optimisation.compiled.arrays import (
    AXIS,
    FORCE,
    LARGEST,
    MOBILITY,
    ORIENTATION,
    PAIR,
    POSITION,
    RECEPTANCE,
    STIFFNESS,
    Arm,
    Held,
    Judge,
    places_for,
    scratch_for,
)
from flexmodal.optimisation.descent import Box
from flexmodal.optimisation.hold import FixedOrientation, Hold
from flexmodal.optimisation.objectives import (
    BLIND,
    LEVER,
    SHARPNESS,
    MobilityObjective,
    Objective,
    ReceptanceObjective,
    StiffnessObjective,
)
from flexmodal.optimisation.problem import PostureProblem


def arm_of(problem: PostureProblem) -> Arm | None:
    """The arrays of a problem; none where the robot branches or the objective is of another kind."""
    if problem.clearance is not None:  # shapes are asked of Pinocchio
        return None
    chain = chain_of(problem.robot)
    judge = judge_of(problem.robot, problem.objective)
    if chain is None or judge is None:
        return None
    joints = len(chain.mass)
    return Arm(
        chain=chain.arrays,
        hold=_alike(held_of(problem.robot, problem.hold)),
        columns=problem.columns.astype(np.int64),
        judge=_alike(judge),
        places=places_for(joints),
        room=scratch_for(joints, judge),
    )


def box_of(problem: PostureProblem) -> Box:
    """The limits of the commanded joints."""
    box: Box = _alike(Box(problem.lower, problem.upper))
    return box


def _alike(arrays: Any) -> Any:
    """The same with arrays of its own: the search is compiled anew for each that is read-only or strided."""
    own = (np.array(value, order="C") if isinstance(value, np.ndarray) else value for value in arrays)
    return arrays._make(own)


def held_of(robot: Robot, hold: Hold | None) -> Held:
    """What is held: a position, and the orientation or an axis if they are.

    Args:
        robot: whose point.
        hold: what is held, if anything.
    """
    if hold is None:
        return Held(-1, np.zeros(3), POSITION, np.eye(3), np.zeros((0, 6)), np.zeros(3), np.eye(3))
    places = places_of(robot, ((hold.point, np.zeros(6)),))
    kind, turned = POSITION, np.zeros((0, 3))
    own, orientation = turn_of(robot, hold.point), np.eye(3)
    if isinstance(hold.orientation, FixedOrientation):
        kind, turned, orientation = ORIENTATION, np.eye(3), hold.orientation.rotation
    elif hold.orientation is not None:
        kind = AXIS
        turned = np.cross(hold.orientation.target, hold.orientation.across)
        own = np.tile((own @ hold.orientation.axis)[:, None], (1, 3))
        orientation = np.tile(hold.orientation.target[:, None], (1, 3))
    rows = np.zeros((len(hold.rows) + len(turned), 6))
    rows[: len(hold.rows), :3], rows[len(hold.rows) :, 3:] = hold.rows, turned
    return Held(
        joint=int(places.joint[0]),
        offset=places.offset[0],
        kind=kind,
        own=np.ascontiguousarray(own),
        rows=rows,
        target=hold.rows.T @ hold.target,  # the rows are orthonormal
        orientation=np.ascontiguousarray(orientation),
    )


def judge_of(robot: Robot, objective: Objective) -> Judge | None:
    """What is judged; none where the objective is of another kind.

    Args:
        robot: the robot.
        objective: what it is judged by.
    """
    if isinstance(objective, ReceptanceObjective):
        return _receptance(robot, objective)
    if isinstance(objective, StiffnessObjective):
        rows = robot.task if objective.task == "full" else robot.task[: 2 if robot.is_planar else 3]
        along = rows @ objective.direction.selector
        if not np.any(along):
            return None  # the objective itself says what is wrong
        goal = -float(np.log(np.max(robot.stiffness) / LEVER**2))
        return _judge(
            robot, STIFFNESS, [objective.direction], goal=goal, bounded=False, task=rows, along=along
        )
    if isinstance(objective, MobilityObjective):
        return _judge(robot, MOBILITY, [objective.direction], goal=2 * float(np.log(LEVER**2)))
    return None


def _receptance(robot: Robot, objective: ReceptanceObjective) -> Judge | None:
    """Force and motion along the same weights make one row of all directions; else they are kept apart.

    The largest singular value itself, without the smooth maximum, is left to the objective.
    """
    if not isinstance(objective.source, ModelReceptances):
        return None
    worst = objective.combine == "worst" and len(objective.directions) > 1
    largest = objective.over == "largest"
    if worst and not largest:
        return None
    force, toward = np.array(objective.weights), np.array(objective.toward)
    judge = _judge(
        robot,
        RECEPTANCE,
        list(objective.directions),
        goal=float(np.log(BLIND)),
        omega=2 * np.pi * np.asarray(objective.frequency, dtype=float),
        power=float(SHARPNESS) if largest and (worst or len(objective.frequency) > 1) else 1.0,
        lines=np.array(objective.line_weights, dtype=float),
    )
    if objective.combine != "force" and not worst and np.array_equal(force, toward):
        return judge._replace(selector=judge.selector * force[:, None])
    measure = LARGEST if worst else FORCE if objective.combine == "force" else PAIR
    rows = np.arange(len(objective.directions))
    return judge._replace(row=rows, measure=measure, force=force, toward=toward)


def _judge(robot: Robot, kind: int, directions: list[Any], **given: Any) -> Judge:
    places = places_of(robot, tuple((d.point, d.selector) for d in directions))
    defaults: dict[str, Any] = {
        "omega": np.zeros(0),
        "power": 1.0,
        "lines": np.zeros(0),
        "task": np.zeros((0, 6)),
        "along": np.zeros(0),
        "bounded": True,
    }
    values: dict[str, Any] = {**defaults, **given}
    matrices, lag = springs_of(robot, values["omega"] / (2 * np.pi))
    return Judge(
        kind=kind,
        joint=places.joint,
        offset=places.offset,
        selector=places.selector,
        row=np.zeros(len(directions), dtype=np.int64),
        pick=robot.flexible_index.astype(np.int64),
        measure=PAIR,
        force=np.ones(1),
        toward=np.ones(1),
        matrices=matrices,
        lag=lag,
        **values,
    )

"""A posture problem as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool

from flexmodal.model import Robot
from flexmodal.model.batch_chain import Chain, chain_of, places_of
from flexmodal.optimisation.compiled.arrays import (
    MOBILITY,
    POSITION,
    RECEPTANCE,
    STIFFNESS,
    Box,
    Held,
    Judge,
)
from flexmodal.optimisation.hold import Hold
from flexmodal.optimisation.objective import (
    _LEVER,
    _SHARPNESS,
    BLIND,
    MobilityObjective,
    Objective,
    ReceptanceObjective,
    StiffnessObjective,
)
from flexmodal.optimisation.problem import PostureProblem


@dataclass(frozen=True, eq=False)
class Plan:
    """All that a compiled search needs to know."""

    chain: Chain
    hold: Held
    box: Box
    judge: Judge
    turning: Bool[np.ndarray, " commanded"]
    """Whether a commanded joint turns: whole turns are the same posture then."""


def plan_of(problem: PostureProblem) -> Plan | None:
    """The arrays of a problem; none where the robot branches or the objective is of another kind."""
    chain = chain_of(problem.robot)
    judge = judge_of(problem.robot, problem.objective)
    if chain is None or judge is None:
        return None
    return Plan(
        chain=chain,
        hold=held_of(problem.robot, problem.hold),
        box=Box(problem.columns.astype(np.int64), problem.lower, problem.upper),
        judge=judge,
        turning=np.array([joint.type != "prismatic" for joint in problem.robot.commanded.values()]),
    )


def held_of(robot: Robot, hold: Hold | None) -> Held:
    """What is held, a position only."""
    if hold is None:
        return Held(-1, np.zeros(3), POSITION, np.eye(3), np.zeros((0, 6)), np.zeros(3), np.eye(3))
    places = places_of(robot, ((hold.point, np.zeros(6)),))
    return Held(
        joint=int(places.joint[0]),
        offset=places.offset[0],
        kind=POSITION,
        own=np.eye(3),
        rows=np.hstack([hold.rows, np.zeros_like(hold.rows)]),
        target=hold.rows.T @ hold.target,  # the rows are orthonormal
        orientation=np.eye(3),
    )


def judge_of(robot: Robot, objective: Objective) -> Judge | None:
    """What is judged; none where the objective is of another kind."""
    if isinstance(objective, ReceptanceObjective):
        return _receptance(robot, objective)
    if isinstance(objective, StiffnessObjective):
        rows = robot.task if objective.task == "full" else robot.task[: 2 if robot.is_planar else 3]
        along = rows @ objective.direction.selector
        if not np.any(along):
            return None  # the objective itself says what is wrong
        goal = -float(np.log(np.max(robot.stiffness) / _LEVER**2))
        return _judge(
            robot, STIFFNESS, [objective.direction], goal=goal, bounded=False, task=rows, along=along
        )
    if isinstance(objective, MobilityObjective):
        return _judge(robot, MOBILITY, [objective.direction], goal=2 * float(np.log(_LEVER**2)))
    return None


def _receptance(robot: Robot, objective: ReceptanceObjective) -> Judge:
    """Weights make one row of all directions; the worst direction keeps them apart."""
    apart = objective.combine == "worst" and len(objective.directions) > 1
    sharp = objective.combine == "worst" and (apart or len(objective.frequency) > 1)
    judge = _judge(
        robot,
        RECEPTANCE,
        list(objective.directions),
        goal=float(np.log(BLIND)),
        omega=2 * np.pi * np.asarray(objective.frequency, dtype=float),
        power=float(_SHARPNESS) if sharp else 1.0,
    )
    if apart:
        return judge._replace(row=np.arange(len(objective.directions)))
    return judge._replace(selector=judge.selector * np.array(objective.weights)[:, None])


def _judge(robot: Robot, kind: int, directions: list[Any], **given: Any) -> Judge:
    places = places_of(robot, tuple((d.point, d.selector) for d in directions))
    defaults: dict[str, Any] = {
        "omega": np.zeros(0),
        "power": 1.0,
        "task": np.zeros((0, 6)),
        "along": np.zeros(0),
        "bounded": True,
    }
    return Judge(
        kind=kind,
        joint=places.joint,
        offset=places.offset,
        selector=places.selector,
        row=np.zeros(len(directions), dtype=np.int64),
        pick=robot.flexible_index.astype(np.int64),
        matrices=np.array([robot.stiffness, robot.damping, np.zeros_like(robot.damping)]),
        **{**defaults, **given},
    )

"""From an atlas to an optimum: the local search begun at the best postures that the atlas has."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from flexmodal.atlas.atlas import Atlas
from flexmodal.atlas.best import best, within
from flexmodal.atlas.near import Spot
from flexmodal.atlas.plan import robot_digest
from flexmodal.atlas.task import Task
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest
from flexmodal.model import Robot
from flexmodal.optimisation import Outcome, PostureProblem, optimise


def check_robot(atlas: Atlas, robot: Robot) -> None:
    """Refuse a robot that is not the atlas's.

    Raises:
        InvalidRequest: a number of it is another.
    """
    if atlas.facts["robot_digest"] != robot_digest(robot):
        found = f"{robot.name}, which is not what {atlas.path} was computed with"
        raise InvalidRequest(Fault("call", "robot", found, f"{atlas.facts['robot']} with the same numbers"))


def search_from(
    atlas: Atlas,
    problem: PostureProblem,
    task: Task,
    *,
    count: int = 5,
    radius: float = math.inf,
    advance: Callable[[], None] = lambda: None,
) -> tuple[Outcome, Sequence[Spot]]:
    """Search from each of the best postures of an atlas, and keep the best end.

    Args:
        atlas: of the same robot.
        problem: what is judged and held.
        task: how the starts are chosen.
        count: how many starts at most.
        radius: how far the tool of a start may be from where it is held [m].
        advance: called after each start.

    Raises:
        InvalidRequest: another robot, or a task that the atlas has nothing for.
        FlexmodalError: no posture of the atlas is near, or no start came to the target.
    """
    check_robot(atlas, problem.robot)
    hold = problem.hold
    where = None if hold is None else within(hold.rows, hold.target, radius)
    starts = best(atlas, task, count=count, where=where)
    kept: Outcome | None = None
    trouble: FlexmodalError | None = None
    for start in starts:
        try:
            found = optimise(problem, start=start.posture, starts=1)
        except InvalidRequest:
            raise
        except FlexmodalError as error:
            trouble = error
        else:
            if kept is None or _is_better(found, kept):
                kept = found
        advance()
    if kept is None:
        raise trouble or FlexmodalError("no start came to the target")
    return kept, starts


def _is_better(one: Outcome, other: Outcome) -> bool:
    sign = -1.0 if one.problem.objective.larger_is_better else 1.0
    return bool(np.sign(sign * (one.best.objective - other.best.objective)) < 0)

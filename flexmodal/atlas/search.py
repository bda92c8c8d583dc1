"""Searches begun at the best postures that an atlas has, and searches spread over many workers."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from flexmodal.atlas.atlas import Atlas
from flexmodal.atlas.best import best, within
from flexmodal.atlas.near import Spot
from flexmodal.atlas.plan import robot_digest
from flexmodal.atlas.spread import PATIENCE, spread
from flexmodal.atlas.task import Task
from flexmodal.errors import Fault, FlexmodalError, InvalidInput, InvalidRequest
from flexmodal.model import Pose, Posture, Robot
from flexmodal.optimisation import Optimum, Outcome, PostureProblem, optimise

EACH = 16
"""Starts of a piece of a search that is spread."""
EQUAL = 1e-6
"""Relative difference of two optima that are one value."""
_SAME = 1e-3
"""Difference of every joint below which two postures are one [rad, m]."""


def check_robot(atlas: Atlas, robot: Robot) -> None:
    """Refuse a robot that is not the atlas's.

    Args:
        atlas: the atlas.
        robot: to compare with the one it was computed with.

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


@dataclass(frozen=True)
class _Searcher:
    """Some starts of a search, wherever it is called.

    A piece whose starts came to nothing says so, as others may have come to something.
    """

    job: bytes
    start: Posture | None

    def __call__(self, piece: tuple[int, int, int]) -> Outcome | FlexmodalError:
        number, seed, starts = piece
        given = self.start if number == 0 else None
        try:
            return optimise(_problem(self.job), start=given, starts=starts, seed=seed)
        except InvalidInput:
            raise
        except FlexmodalError as error:
            return error


@lru_cache(maxsize=4)
def _problem(job: bytes) -> PostureProblem:
    problem: PostureProblem = pickle.loads(job)
    return problem


def search_spread(
    problem: PostureProblem,
    starts: int,
    *,
    start: Pose | None = None,
    seed: int = 0,
    scheduler: str | None = None,
    workers: int | None = None,
    patience: float = PATIENCE,
    advance: Callable[[], None] = lambda: None,
) -> Outcome:
    """Search from many starts in pieces of `EACH`, on this machine's cores or on a cluster.

    For objectives that take their time, such as robust ones over many robots. What comes out hangs on the
    seed and the number of starts, not on who searched.

    Args:
        problem: robot, objective and hold.
        starts: how many in all.
        start: a posture to compare with and to start from as well.
        seed: of the random starts.
        scheduler: address of a Dask scheduler; this machine if none.
        workers: processes here; as many as cores if none.
        patience: how long a cluster may be without any worker [s].
        advance: called after each piece.

    Raises:
        InvalidRequest: a number of starts or workers below 1, no scheduler at the address.
        InvalidPosture: a bad start.
        FlexmodalError: what `optimise` raises, where it does so in every piece.
    """
    if starts < 1:
        raise InvalidRequest(Fault("call", "starts", str(starts), "at least 1"))
    given = None if start is None else problem.robot.posture(start)
    count = -(-starts // EACH)
    seeds = np.random.SeedSequence(seed).generate_state(count).tolist()
    sizes = [min(EACH, starts - number * EACH) for number in range(count)]
    pieces = zip(range(count), seeds, sizes, strict=True)
    work = _Searcher(pickle.dumps(problem), given)
    found: dict[int, Outcome | FlexmodalError] = {}
    spread_out = spread(work, pieces, scheduler=scheduler, workers=workers, patience=patience)
    for (number, _, _), outcome in spread_out:
        found[number] = outcome
        advance()
    ends = [found[number] for number in range(count)]
    outcomes = [one for one in ends if isinstance(one, Outcome)]
    if not outcomes:
        (trouble, *_) = [one for one in ends if isinstance(one, FlexmodalError)]
        raise trouble
    return gathered(problem, outcomes, tried=starts)


def gathered(problem: PostureProblem, outcomes: Sequence[Outcome], *, tried: int) -> Outcome:
    """One outcome of several for the same problem: optima of equal value as one, best first.

    Args:
        problem: for which all of them are.
        outcomes: at least one; only the first may have been given a start.
        tried: starts in all.
    """
    sign = -1.0 if problem.objective.larger_is_better else 1.0
    every = sorted(
        (one for outcome in outcomes for one in outcome.optima), key=lambda one: sign * one.objective
    )
    kept: list[Optimum] = []
    for one in every:
        if kept and math.isclose(kept[-1].objective, one.objective, rel_tol=EQUAL):
            kept[-1] = _joined(kept[-1], one)
        else:
            kept.append(one)
    best_of = min(outcomes, key=lambda outcome: sign * outcome.best.objective)
    return replace(
        outcomes[0],
        problem=problem,
        optima=tuple(kept),
        converged=best_of.converged,
        starts=sum(one.starts for one in outcomes),
        unbounded=sum(one.unbounded for one in outcomes),
        tried=tried,
        interrupted=any(one.interrupted for one in outcomes),
    )


def _joined(one: Optimum, other: Optimum) -> Optimum:
    """Two optima of one value; postures that are the same are named once."""
    postures = [one.posture, *one.equals]
    for posture in (other.posture, *other.equals):
        away = [max(abs(posture.values[n] - known.values[n]) for n in posture.values) for known in postures]
        if min(away) > _SAME:
            postures.append(posture)
    return replace(one, hits=one.hits + other.hits, equals=tuple(postures[1:]))


def _is_better(one: Outcome, other: Outcome) -> bool:
    sign = -1.0 if one.problem.objective.larger_is_better else 1.0
    return bool(np.sign(sign * (one.best.objective - other.best.objective)) < 0)

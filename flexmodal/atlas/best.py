"""The best postures of an atlas for a task."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.atlas.atlas import Atlas
from flexmodal.atlas.near import Spot
from flexmodal.atlas.task import Task
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest

if TYPE_CHECKING:
    import xarray

Candidate = tuple[float, tuple[float, ...], tuple[float, ...]]
"""Cost, values of the joints, place of the tool."""
Where = Callable[[Float[np.ndarray, "posture 3"]], Bool[np.ndarray, " posture"]]
"""Says of places of the tool [m] whether they count."""
APART = 0.1
"""Distance between two of the best postures, in parts of the joints' ranges, below which they are one."""
MOST_BEST = 1000
_CANDIDATES = 50
"""Postures kept for each of the best while looking, so that enough stand apart in the end."""


@dataclass(frozen=True, eq=False)
class Scanned:
    """Some postures of an atlas, judged."""

    value: Float[np.ndarray, " posture"]
    tool: Float[np.ndarray, "posture 3"]
    joints: Float[np.ndarray, "posture commanded"]
    inside: Bool[np.ndarray, " posture"]
    """Within what was struck, where receptances are predicted; else everywhere."""


def scan(atlas: Atlas, task: Task, advance: Callable[[], None] = lambda: None) -> Iterator[Scanned]:
    """Judge every posture that is there, chunk by chunk.

    Args:
        atlas: to look in.
        task: what is asked of a posture.
        advance: called after each chunk.

    Raises:
        InvalidRequest: a task that this atlas has nothing for.
        FlexmodalError: a chunk is spoilt.
    """
    judge = task.judge(atlas.dataset, atlas.quantity)
    struck = ["beyond"] if atlas.source is not None else []
    for number in atlas.standing:
        _, region = atlas.layout.region(number)
        part = dict(zip(atlas.dims, region, strict=True))
        with atlas.reading():
            some = atlas.dataset[[judge.variable, "tool", *atlas.along, *struck]].isel(part)
            value = np.asarray(judge.value(some)).ravel()
            tool = some["tool"].values.reshape(-1, 3)
            inside = some["beyond"].values.ravel() == 0 if struck else np.ones(len(value), bool)
        yield Scanned(value, tool, _joint_values(atlas, some, len(value)), inside)
        advance()


def best(
    atlas: Atlas,
    task: Task,
    *,
    count: int = 5,
    where: Where | None = None,
    advance: Callable[[], None] = lambda: None,
) -> list[Spot]:
    """The best postures for a task, each some way apart from those before it, best first.

    Args:
        atlas: to look in.
        task: what is asked of a posture.
        count: how many at most.
        where: which places of the tool count; all if none.
        advance: called after each chunk.

    Raises:
        InvalidRequest: a task that this atlas has nothing for; a count out of range.
        FlexmodalError: no posture counts, or a chunk is spoilt.
    """
    if not 1 <= count <= MOST_BEST:
        raise InvalidRequest(Fault("call", "count", str(count), f"1 to {MOST_BEST}"))
    sign = -1.0 if task.larger(atlas.quantity) else 1.0
    most = count * _CANDIDATES
    kept: list[Candidate] = []
    for some in scan(atlas, task, advance):
        counts = np.isfinite(some.value) if where is None else np.isfinite(some.value) & where(some.tool)
        places = np.flatnonzero(counts)
        places = places[np.argsort(sign * some.value[places], kind="stable")][:most]
        found = zip(sign * some.value[places], some.joints[places], some.tool[places], strict=True)
        new = [(float(value), tuple(joints.tolist()), tuple(tool.tolist())) for value, joints, tool in found]
        kept = heapq.nsmallest(most, [*kept, *new])
    if not kept:
        there = "" if where is None else " near that place"
        raise FlexmodalError(f"{atlas.path}: no posture{there} has a finite value for this task")
    return _apart(atlas, kept, sign, count)


def within(rows: Float[np.ndarray, "held 3"], target: Float[np.ndarray, " held"], radius: float) -> Where:
    """Places of the tool near a target.

    Args:
        rows: unit vectors along which it is looked at.
        target: coordinates along them [m].
        radius: how far from there [m].

    Raises:
        InvalidRequest: a radius that is none.
    """
    if not radius > 0:
        raise InvalidRequest(Fault("call", "radius", f"{radius:g}", "a length above 0 [m]"))
    return lambda tool: np.linalg.norm(tool @ rows.T - target, axis=1) <= radius


def _apart(atlas: Atlas, kept: list[Candidate], sign: float, count: int) -> list[Spot]:
    span = np.array([atlas.span[name] for name in atlas.joints])
    found: list[Spot] = []
    for value, joints, tool in kept:
        others = [np.array(list(one.posture.values())) for one in found]
        if all(np.linalg.norm((np.array(joints) - other) / span) > APART for other in others):
            posture = dict(zip(atlas.joints, joints, strict=True))
            found.append(Spot(posture, (tool[0], tool[1], tool[2]), sign * value))
        if len(found) == count:
            break
    return found


def _joint_values(atlas: Atlas, some: xarray.Dataset, count: int) -> np.ndarray:
    shape = tuple(some.sizes[name] for name in atlas.dims)
    out = np.empty((count, len(atlas.joints)))
    for column, name in enumerate(atlas.joints):
        values = some[name].values
        if name in atlas.dims:
            values = values.reshape([-1 if one == name else 1 for one in atlas.dims])
        out[:, column] = np.broadcast_to(values, shape).ravel()
    return out

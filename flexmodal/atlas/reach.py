"""How far predicted numbers of an atlas may be off, and how far a posture is from what was struck."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from flexmodal.atlas.atlas import Atlas
from flexmodal.atlas.near import Spot, nearest
from flexmodal.atlas.task import Task


@dataclass(frozen=True)
class Reach:
    """Of one posture."""

    low: float
    """End of the 95 % band of the task's value [m/N; m of depths]."""
    high: float
    remote: float
    """Distance from what was struck over that between these, 1 or more."""
    beyond: int
    """Joints outside the range that was struck."""


def reach(atlas: Atlas, task: Task, spot: Spot) -> Reach | None:
    """How far a posture that was found may be off; None in an atlas of the robot itself.

    Args:
        atlas: in which it was found.
        task: by which.
        spot: the posture.

    Raises:
        InvalidRequest: a task that this atlas has nothing for.
        FlexmodalError: its chunk is spoilt.
    """
    if atlas.source is None:
        return None
    judge = task.judge(atlas.dataset, atlas.quantity)
    found = nearest(atlas, spot.posture)[1]
    if atlas.quantity == "depth":
        ends = [replace(judge, variable=f"{end}_{judge.variable}").value(found) for end in ("low", "high")]
    else:
        size, width = (found[name].isel(judge.fixed).isel({judge.along: judge.part}) for name in _ARRAYS)
        ends = [np.max(np.abs(size.values) * np.exp(side * width.values)) for side in (-1, 1)]
    remote, beyond = float(found["remote"]), float(found["beyond"])
    return Reach(float(ends[0]), float(ends[1]), remote, 0 if math.isnan(beyond) else round(beyond))


_ARRAYS = ("receptance", "log_size")

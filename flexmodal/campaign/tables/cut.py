"""A continuous record with several blows cut into blows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flexmodal.campaign.blow import Blow

PART = 0.2
"""Of the largest pulse, that a pulse has to reach to be a blow of its own."""
BEFORE = 0.02
"""Part of the length that is kept before a pulse."""

APART = 0.1
"""Part of a record that pulses are apart that are blows of their own and no rebounds."""
KEPT = 0.95
"""Of the least distance between pulses, that a blow may be long."""


def several(record: Blow) -> tuple[int, float] | None:
    """How many blows a record seems to hold, and how long each may be [s]; None for one.

    Args:
        record: as it was read.
    """
    force = np.abs(record.force - np.median(record.force))
    above = np.flatnonzero(force >= PART * float(force.max()))
    if not above.size:
        return None
    first = [int(above[0])]
    for line in above.tolist():
        if line - first[-1] > APART * len(force):
            first.append(line)
    if len(first) < 2:
        return None
    least = min(np.diff([*first, len(force)]).tolist())
    return len(first), float(f"{KEPT * least * record.step:.2g}")


def cut(record: Blow, length: float) -> Iterator[Blow]:
    """The blows of a record, each so long, the pulse after two per cent of it.

    A pulse within the length of the one before belongs to that, a rebound; what begins before the record or
    ends after it is left out.

    Args:
        record: with several pulses.
        length: of each blow [s].
    """
    count = max(round(length / record.step), 2)
    lead = int(BEFORE * count)
    force = np.abs(record.force - np.median(record.force))
    place, number = 0, record.sequence
    most = float(force.max())
    while place < len(force):
        above = np.flatnonzero(force[place:] >= PART * most)
        if not above.size:
            return
        first = place + int(above[0])
        start = first - lead
        if start >= 0 and start + count <= len(force):
            part = slice(start, start + count)
            yield replace(
                record,
                sequence=number,
                time=record.time[:count] - record.time[0],
                force=record.force[part],
                response=record.response[:, part],
            )
            number += 1
        place = first + count - lead

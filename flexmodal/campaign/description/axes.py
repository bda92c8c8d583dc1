"""Axes of a point: what is allowed, what is wrong with given ones, what is odd about sound ones."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from flexmodal.campaign.description.tested import CampaignPoint
from flexmodal.text.words import shown

LENGTH = 1e-3
"""By how much a row's length may be off 1; rows of four digits are."""
SQUARE = math.radians(1.0)
"""Angle between two rows off the right one from which it is worth a word [rad]."""
AXES = (
    '"link" for the axes of its link, or three rows of three numbers, each of length 1, for directions 1, 2, '
    "3; none for the axes of the world"
)
FRAME_OF_ROWS = '"world" or "link": what the rows of axes are fixed to'
FRAME = f"{FRAME_OF_ROWS}; none without rows"


def axes_fault(given: object) -> str | None:
    """What keeps something from being three unit vectors, in words; None where nothing does.

    Args:
        given: what stands in a file, or in memory.
    """
    if not isinstance(given, Sequence) or isinstance(given, str):
        return shown(given)
    if len(given) != 3:
        return f"{len(given)} rows" if len(given) != 1 else "1 row"
    wrong = [said for number, row in enumerate(given, start=1) if (said := _row_fault(number, row))]
    return ", ".join(wrong) or None


def _row_fault(number: int, row: object) -> str | None:
    if not isinstance(row, Sequence) or isinstance(row, str) or len(row) != 3:
        return f"row {number}: {shown(row)}"
    odd = [part for part in row if isinstance(part, bool) or not isinstance(part, int | float)]
    if odd:
        return f"row {number} with {shown(odd[0])}"
    length = math.hypot(*row)
    if not abs(length - 1) <= LENGTH:
        return f"row {number} of length {length:.6g}"
    return None


def odd_axes(points: Iterable[CampaignPoint]) -> list[str]:
    """Sentences on axes that are sound and yet may not be meant: aslant, or left-handed.

    Args:
        points: of a campaign.
    """
    found = []
    for point in points:
        if point.axes is None:
            continue
        rows = point.rows()
        off = np.abs(np.pi / 2 - np.arccos(np.clip(rows @ np.roll(rows, -1, axis=0).T, -1, 1)).diagonal())
        if off.max() > SQUARE:
            first = int(np.argmax(off))
            pair = f"{first + 1} and {(first + 1) % 3 + 1}"
            found.append(
                f"point {point.name}: directions {pair} are {90 - math.degrees(off[first]):.3g}° apart, "
                "not square to each other"
            )
        elif np.linalg.det(rows) < 0:
            found.append(
                f"point {point.name}: directions 1, 2, 3 are left-handed; is the sense of one wrong?"
            )
    return found

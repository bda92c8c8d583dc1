"""The frequency axis: finite, not negative, ascending, in hertz."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from flexmodal.errors import Fault, InvalidFrequencies

MOST_LINES = 10_000_000
"""More lines than this are a slip of the keyboard (160 MB for one FRF)."""

MOST_HERTZ = 1e12
"""Higher frequencies mean nothing here, and their squares and fourth powers leave the range of numbers."""

LEAST_HERTZ = 1e-9
"""Lower frequencies but 0 mean nothing either."""

MOST_VALUES = 20_000_000
"""Values of an FRF, lines times responses times references (320 MB); JSON takes several times that."""


def check_values(lines: int, responses: int, references: int) -> None:
    """Complain about an FRF before it is allocated.

    Args:
        lines: of its axis.
        responses: how many.
        references: how many.

    Raises:
        InvalidFrequencies: it would hold more than `MOST_VALUES`.
    """
    if lines * responses * references > MOST_VALUES:
        found = f"{lines} lines × {responses} responses × {references} references"
        allowed = f"at most {MOST_VALUES:,} values: fewer lines, or fewer directions at a time"
        raise InvalidFrequencies(Fault("call", "frequencies", found, allowed))


def frequency_axis(values: ArrayLike | float, *, source: str = "call") -> Float[np.ndarray, " line"]:
    """Check a frequency axis and return it as a read-only array.

    Args:
        values: one frequency or an ascending sequence of them [Hz].
        source: where the values came from, for the error.

    Raises:
        InvalidFrequencies: empty, not numbers, not finite, negative, or not strictly ascending.
    """
    try:
        given = np.asarray(values)
        if np.iscomplexobj(given):
            raise TypeError
        axis = np.atleast_1d(np.array(given, dtype=float))
    except (TypeError, ValueError, OverflowError):
        raise _fault(source, "something that is not a number") from None
    if axis.ndim != 1 or axis.size == 0:
        raise _fault(source, "no frequencies" if axis.size == 0 else f"an array of shape {axis.shape}")
    if not np.all(np.isfinite(axis)):
        raise _fault(source, f"{axis[~np.isfinite(axis)][0]} Hz")
    if axis.max() > MOST_HERTZ:
        raise _fault(source, f"{axis.max():g} Hz, more than {MOST_HERTZ:g} Hz")
    if axis.min() < 0:
        raise _fault(source, f"a negative frequency, {axis.min():g} Hz")
    if axis.size > 1 and np.min(np.diff(axis)) <= 0:
        place = int(np.argmin(np.diff(axis)))
        raise _fault(source, f"{axis[place]:g} Hz followed by {axis[place + 1]:g} Hz")
    axis.flags.writeable = False
    return axis


def stepped_axis(start: float, stop: float, step: float, *, source: str) -> Float[np.ndarray, " line"]:
    """Frequencies from `start` to `stop` inclusive, `step` apart [Hz].

    Args:
        start: first line [Hz].
        stop: last line, included where a step ends there [Hz].
        step: spacing [Hz].
        source: where the numbers came from, for the error.

    Raises:
        InvalidFrequencies: reversed or endless, or more than `MOST_LINES` lines.
    """
    if not np.all(np.isfinite([start, stop, step])) or start < 0:
        raise _fault(source, f"{start:g}:{stop:g}:{step:g}")
    if stop < start:
        raise _fault(source, f"a reversed range, {start:g} to {stop:g} Hz")
    if step <= 0:
        raise _fault(source, f"a step of {step:g} Hz")
    lines = (stop - start) / step + 1
    if lines > MOST_LINES:
        raise _fault(source, f"a range of {lines:.3g} lines, more than {MOST_LINES:,}")
    return frequency_axis(start + step * np.arange(int(np.floor(lines + 1e-9))), source=source)


def _fault(source: str, found: str) -> InvalidFrequencies:
    return InvalidFrequencies(
        Fault(source, "frequencies", found, "finite frequencies ≥ 0 Hz in ascending order, at least one")
    )

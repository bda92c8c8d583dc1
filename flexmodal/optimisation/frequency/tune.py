"""The operating frequency that vibrates least at a posture, with all the minima there are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.frf.axis import LEAST_HERTZ, MOST_HERTZ
from flexmodal.model import PosedRobot
from flexmodal.optimisation.frequency.partial_fractions import (
    LogarithmicSlope,
    direction_rows,
    logarithmic_slope,
)
from flexmodal.optimisation.frequency.roots import roots
from flexmodal.optimisation.frequency.sampled import stationary
from flexmodal.text.shown import Shown, several

_PIECES = 64
"""Intervals that a band is cut into before they are halved as needed."""

Band = tuple[float, float]


@dataclass(frozen=True)
class Extremum:
    """A frequency at which |receptance| is least or greatest among its neighbours."""

    frequency: float
    """[Hz]."""
    receptance: float
    """|α| there [m/N]; infinite at an undamped pole."""


@dataclass(frozen=True, eq=False, repr=False)
class Tuning(Shown):
    """Every minimum and maximum of |receptance| inside a band, and the best frequency of the band."""

    posed: PosedRobot
    response: PointDirection
    reference: PointDirection
    band: Band
    """[Hz]."""
    minima: tuple[Extremum, ...]
    """Ascending in frequency; complete, by bounds on the slope between them, where `proved`."""
    maxima: tuple[Extremum, ...]
    ends: tuple[Extremum, Extremum]
    """The two ends of the band."""
    proved: bool = True
    """False with causal hysteresis: the receptance is no rational function then, and its minima are those
    that a fine grid shows."""

    def _facts(self) -> Mapping[str, object]:
        return {
            "best at [Hz]": float(self.best.frequency),
            "receptance": float(self.best.receptance),
            "minima at [Hz]": several(f"{one.frequency:.4g}" for one in self.minima) or "none",
        }

    @property
    def best(self) -> Extremum:
        """Where in the band |receptance| is least, ends included."""
        return min((*self.minima, *self.ends), key=lambda place: place.receptance)

    @property
    def verdict(self) -> str:
        """What to think of it, and what to do next."""
        note = (
            "" if self.proved else "; looked for on a fine grid, since hysteresis leaves no rational function"
        )
        if self.best not in self.ends:
            return f"the least of {len(self.minima)} minima in the band{note}"
        where = "lower" if self.best is self.ends[0] else "upper"
        count = f"{len(self.minima)} minima inside it" if self.minima else "there is no minimum inside it"
        return f"at the {where} end of the band ({count}): a wider band may do better{note}"


def tune(
    posed: PosedRobot,
    band: Band,
    *,
    response: str | PointDirection | None = None,
    reference: str | PointDirection | None = None,
) -> Tuning:
    """Find the frequency of a band at which |receptance| is least.

    Poles and antiresonances make |receptance|² a rational function of the frequency; the roots of its slope
    are all found, each between its own bounds. Loss factors keep it so, unless the card has a
    `loss_frequency`: then the slope is still exact, but its roots are those between neighbouring lines of a
    fine grid.

    Args:
        posed: the robot in its posture.
        band: lowest and highest frequency [Hz], 0 allowed.
        response: such as "tool:+z"; the tool along z if none.
        reference: the same for the force; as `response` if none.

    Raises:
        InvalidRequest: a band that is no band, or a direction in which nothing gives way.
        InvalidPoint: a bad direction.
        InvalidSystem: the mass matrix is not positive definite.
        InaccurateModes: stiffness and damping range over too many decades for a double.

    >>> import flexmodal
    >>> found = flexmodal.tune(flexmodal.load("six_axis").at("work"), (5.0, 30.0))
    >>> round(found.best.frequency, 2)
    20.72
    """
    low, high = band
    if not (0 <= low < high <= MOST_HERTZ and high >= LEAST_HERTZ):
        allowed = f"0 ≤ low < high, high from {LEAST_HERTZ:g} to {MOST_HERTZ:g} Hz"
        raise InvalidRequest(Fault("call", "band", f"{low:g} to {high:g} Hz", allowed))
    (out,) = posed.directions(response)
    (into,) = posed.directions(out if reference is None else reference)
    loss = posed.system.hysteresis
    proved = loss is None or loss.frequency is None
    if proved:
        frequency, rising, sharp = _stationary(logarithmic_slope(posed, out, into), low, high)
    else:
        frequency, rising = stationary(posed.system, direction_rows(posed, out, into), low, high)
        sharp = np.zeros(0)
    size = _sizes(posed, out, into, np.r_[low, frequency, high], sharp)
    found = [Extremum(float(f), float(a)) for f, a in zip(frequency, size[1:-1], strict=True)]
    return Tuning(
        posed,
        out,
        into,
        band,
        tuple(item for item, least in zip(found, rising, strict=True) if least),
        tuple(item for item, least in zip(found, rising, strict=True) if not least),
        (Extremum(low, float(size[0])), Extremum(high, float(size[-1]))),
        proved,
    )


def _stationary(
    slope: LogarithmicSlope, low: float, high: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies inside a band where |α| is stationary, and which are minima.

    Third, the frequencies of all undamped poles [Hz].
    """
    first, last = slope.place(np.array([low, high]))
    undamped = slope.width == 0
    inside = undamped & (slope.centre > first) & (slope.centre < last)
    spaced = np.geomspace(max(first, 1e-12 * last), last, _PIECES + 1)[1:-1]
    edges = np.unique(np.r_[first, spaced, slope.centre[inside], last])
    smooth, rising = roots(slope, edges)
    places = np.r_[smooth, slope.centre[inside]]
    least = np.r_[rising, slope.weight[inside] > 0]
    order = np.argsort(places)
    sharp = slope.centre[undamped & (slope.weight < 0) & (slope.centre >= 0)]
    return slope.frequency(places[order]), least[order], slope.frequency(sharp)


def _sizes(
    posed: PosedRobot,
    response: PointDirection,
    reference: PointDirection,
    frequency: np.ndarray,
    sharp: np.ndarray,
) -> np.ndarray:
    """|α| at some frequencies; infinite at an undamped pole."""
    size = np.full(len(frequency), np.inf)
    gap = np.abs(frequency[:, None] - sharp).min(axis=1, initial=np.inf)
    finite = gap > 1e-9 * frequency
    lines, back = np.unique(frequency[finite], return_inverse=True)
    values = posed.frf(lines, response=response, reference=reference).value[:, 0, 0]
    size[finite] = np.abs(values)[back]
    return size

"""Measured FRFs as the fits take them: checked once, read-only ever after."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf.axis import frequency_axis
from flexmodal.frf.form import POWER, Form, check_form, convert

FEWEST_LINES = 5
"""A mode has four real numbers in one FRF; fewer lines than this say nothing about it."""

MOST_REFERENCES = 4
"""Of more the matrices of a poly-reference fit grow too large to be worth their time."""

LARGEST = 1e100
"""Values beyond, or below its inverse, overflow or vanish when they are squared and multiplied."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Some FRFs on one frequency axis, with what is known of their noise.

    To hold one is proof that the axis ascends, every value is finite and no FRF is zero throughout. A
    line at 0 Hz is left out: in a mobility or inertance it says nothing about modes.

    Raises:
        InvalidRequest: shapes that differ, values that are not finite, a variance that is not positive,
            fewer than five lines; all faults at once.
        InvalidFrequencies: the axis does not ascend.
    """

    frequency: Float[np.ndarray, " line"]
    """Ascending [Hz]."""
    value: Complex[np.ndarray, "line frf"]
    """In SI units of `form`."""
    form: Form = "receptance"
    variance: Float[np.ndarray, "line frf"] | None = None
    """E|noise|² of each value, real and imaginary part together; None where it is not known."""
    labels: tuple[str, ...] = ()
    """What each FRF is called; numbered where none are given."""
    ends: tuple[tuple[str, str], ...] = ()
    """Response and reference of each FRF, where they are known: FRFs of several references are then a
    matrix."""

    def __post_init__(self) -> None:
        frequency = frequency_axis(self.frequency)
        value = np.array(self.value, dtype=complex)
        variance = None if self.variance is None else np.array(self.variance, dtype=float)
        check_form(self.form)
        faults = _faults(frequency, value, variance, self.labels)
        if self.ends and (len(self.ends) != value.shape[-1] or len(set(self.ends)) != len(self.ends)):
            faults.append(Fault("call", "ends", f"{len(self.ends)}", "one pair for each FRF, no two alike"))
        if faults:
            raise InvalidRequest(faults)
        keep = frequency > 0
        labels = self.labels or tuple(f"FRF {place + 1}" for place in range(value.shape[1]))
        parts = {"frequency": frequency[keep], "value": value[keep], "labels": tuple(labels)}
        parts["variance"] = None if variance is None else variance[keep]
        parts["ends"] = tuple(self.ends)
        for name, part in parts.items():
            if isinstance(part, np.ndarray):
                part.flags.writeable = False
            object.__setattr__(self, name, part)

    @property
    def omega(self) -> Float[np.ndarray, " line"]:
        """Angular frequency [rad/s]."""
        return 2 * np.pi * self.frequency

    @property
    def spacing(self) -> float:
        """Median distance between neighbouring lines [Hz]."""
        return float(np.median(np.diff(self.frequency)))

    @property
    def matrix(self) -> Int[np.ndarray, "response reference"] | None:
        """Number of each FRF by response and reference, of the two sides the one with fewer as references.

        By reciprocity either side may stand for it. None where the FRFs do not fill such a matrix, or one
        side has one place only, or both have more than four.
        """
        rows, columns = (
            (list(dict.fromkeys(side)) for side in zip(*self.ends, strict=True)) if self.ends else ((), ())
        )
        places = {ends: frf for frf, ends in enumerate(self.ends)}
        if not 2 <= min(len(rows), len(columns)) <= MOST_REFERENCES or len(places) != len(rows) * len(
            columns
        ):
            return None
        found = np.array([[places[row, column] for column in columns] for row in rows])
        return found if len(rows) >= len(columns) else found.T

    def within(self, low: float, high: float) -> Measured:
        """The lines from `low` to `high` [Hz], both included.

        Args:
            low: first line [Hz].
            high: last line [Hz].

        Raises:
            InvalidRequest: fewer than five lines lie in the band.
        """
        keep = (self.frequency >= low) & (self.frequency <= high)
        if np.count_nonzero(keep) < FEWEST_LINES:
            found = f"{np.count_nonzero(keep)} lines from {low:g} to {high:g} Hz"
            raise InvalidRequest(Fault("call", "band", found, f"at least {FEWEST_LINES} lines"))
        variance = None if self.variance is None else self.variance[keep]
        return replace(self, frequency=self.frequency[keep], value=self.value[keep], variance=variance)

    def only(self, frf: int) -> Measured:
        """One of the FRFs."""
        variance = None if self.variance is None else self.variance[:, [frf]]
        ends = self.ends[frf : frf + 1]
        return replace(
            self, value=self.value[:, [frf]], variance=variance, labels=(self.labels[frf],), ends=ends
        )

    def to(self, form: Form) -> Measured:
        """The same FRFs as receptance, mobility or inertance."""
        if form == self.form:
            return self
        value = convert(self.value, self.frequency, self.form, form)
        variance = self.variance
        if variance is not None:
            variance = variance * (np.abs(self.omega) ** (2 * (POWER[form] - POWER[self.form])))[:, None]
        return replace(self, value=value, variance=variance, form=form)


def _faults(
    frequency: np.ndarray, value: np.ndarray, variance: np.ndarray | None, labels: tuple[str, ...]
) -> list[Fault]:
    faults = []
    if np.count_nonzero(frequency > 0) < FEWEST_LINES:
        found = f"{np.count_nonzero(frequency > 0)} lines above 0 Hz"
        faults.append(Fault("call", "frequency", found, f"at least {FEWEST_LINES}"))
    if value.ndim != 2 or len(value) != len(frequency) or value.shape[1] == 0:
        allowed = f"{len(frequency)} lines by at least one FRF"
        return [*faults, Fault("call", "value", f"shape {value.shape}", allowed)]
    if labels and len(labels) != value.shape[1]:
        faults.append(Fault("call", "labels", f"{len(labels)}", f"{value.shape[1]}, one for each FRF"))
    bad = ~np.isfinite(value[frequency > 0])
    if bad.any():
        line, frf = np.argwhere(bad)[0]
        where = f"{frequency[frequency > 0][line]:g} Hz of FRF {frf + 1}"
        faults.append(
            Fault("call", "value", f"{np.count_nonzero(bad)} not finite, first at {where}", "numbers")
        )
    elif np.max(np.abs(value[frequency > 0]), initial=0.0) > LARGEST:
        faults.append(Fault("call", "value", "a size above 1e100", "sizes that can be squared"))
    elif not np.all(np.any(value[frequency > 0] != 0, axis=0)):
        frf = int(np.argmin(np.any(value[frequency > 0] != 0, axis=0)))
        faults.append(Fault("call", "value", f"FRF {frf + 1} zero throughout", "a response"))
    elif np.min(np.max(np.abs(value[frequency > 0]), axis=0)) < 1 / LARGEST:
        faults.append(
            Fault("call", "value", "an FRF that nowhere reaches 1e-100", "sizes that can be squared")
        )
    if variance is not None:
        if variance.shape != value.shape:
            faults.append(Fault("call", "variance", f"shape {variance.shape}", f"shape {value.shape}"))
        elif not np.all(np.isfinite(variance[frequency > 0]) & (variance[frequency > 0] > 0)):
            faults.append(Fault("call", "variance", "an entry that is not above 0", "finite, positive"))
    return faults

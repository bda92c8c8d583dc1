"""What every FRF of a passive linear structure obeys: checks that need no model."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf.form import Form, convert


@dataclass(frozen=True, eq=False)
class DrivePointCheck:
    """Whether an FRF can be that of a point hit and measured in one place and direction."""

    active: Float[np.ndarray, " bad"]
    """Frequencies where energy would come out of the structure: Re of the mobility below the noise [Hz]."""
    share: float
    """Part of the lines that are active."""
    resonance: Float[np.ndarray, " peak"]
    """[Hz]."""
    antiresonance: Float[np.ndarray, " dip"]
    """[Hz]."""
    unparted: tuple[tuple[float, float], ...]
    """Neighbouring resonances with no antiresonance between them [Hz]."""

    @property
    def is_sound(self) -> bool:
        """No active line and every two resonances parted."""
        return self.share == 0 and not self.unparted

    @property
    def verdict(self) -> str:
        """One sentence."""
        if self.is_sound:
            return "a drive point: no energy comes out, and antiresonances part the resonances"
        says = []
        if self.share > 0:
            low, high = self.active.min(), self.active.max()
            says.append(
                f"energy comes out on {100 * self.share:.2g} % of the lines, {low:.4g} to {high:.4g} Hz"
            )
        for low, high in self.unparted:
            says.append(f"no antiresonance between {low:.4g} and {high:.4g} Hz")
        return "; ".join(says) + ": look at the direction, the phase or the place of sensor and hammer"


def check_drive_point(
    frequency: Float[np.ndarray, " line"],
    value: Complex[np.ndarray, " line"],
    form: Form,
    *,
    noise: float = 0.0,
    prominence: float = 3.0,
) -> DrivePointCheck:
    """Check the sign and the pattern of a drive-point FRF.

    The power that a force puts in is ½|F|² Re Y, so Re of the mobility is never negative, Im of the
    receptance never positive and Im of the inertance never negative; and between every two resonances
    there is an antiresonance.

    Args:
        frequency: ascending [Hz].
        value: the FRF.
        form: receptance, mobility or inertance.
        noise: standard deviation of the values; three of them may stick out below zero.
        prominence: least height of a resonance and depth of an antiresonance [dB].

    Raises:
        InvalidRequest: values not finite.
        InvalidFrequencies: lines that do not ascend.
    """
    axis, response = _above_zero(frequency, value)
    mobility = convert(response, axis, form, "mobility")
    turn = np.abs(mobility) / np.where(np.abs(response) > 0, np.abs(response), 1)
    rounding = 1e-9 * np.abs(mobility)
    bad = mobility.real < -(3 * noise * turn + rounding)
    level = 20 * np.log10(np.maximum(np.abs(mobility), np.finfo(float).tiny))
    peaks = _extrema(level, prominence)[0]
    resonance, dip = axis[peaks], antiresonances(axis, response, prominence=prominence)
    # A zero between two resonances gives back the half turn that the phase lost; a mere minimum does not.
    unparted = tuple(
        (float(axis[a]), float(axis[b]))
        for a, b in pairwise(peaks)
        if (mobility[a] * np.conj(mobility[b])).real < 0
    )
    return DrivePointCheck(axis[bad], float(np.mean(bad)), resonance, dip, unparted)


def antiresonances(
    frequency: Float[np.ndarray, " line"], value: Complex[np.ndarray, " line"], *, prominence: float = 3.0
) -> Float[np.ndarray, " dip"]:
    """Frequencies of the dips of |H| that are at least `prominence` dB deep on both sides [Hz].

    Between the lines a dip is placed by the zero of the complex parabola through three lines: the root
    nearest to the lowest line, its real part. That is exact where H is smooth and the zero lightly damped.

    Args:
        frequency: of the lines [Hz].
        value: one FRF.
        prominence: how deep a dip has to be on both sides [dB].

    Raises:
        InvalidRequest: values not finite, or fewer than five lines above 0 Hz.
    """
    axis, response = _above_zero(frequency, value)
    level = 20 * np.log10(np.maximum(np.abs(response), np.finfo(float).tiny))
    found = []
    for line in _extrema(level, prominence)[1]:
        part = slice(line - 1, line + 2)
        size = np.max(np.abs(response[part]))
        roots = np.roots(np.polyfit(axis[part] - axis[line], response[part] / size, 2))
        reach = max(axis[line + 1] - axis[line], axis[line] - axis[line - 1])
        near = roots[np.abs(roots.real) <= reach]
        shift = near[np.argmin(np.abs(near))].real if len(near) else 0.0
        found.append(axis[line] + shift)
    return np.array(found, dtype=float)


def reciprocity(
    value: Complex[np.ndarray, " line"], mirrored: Complex[np.ndarray, " line"]
) -> Float[np.ndarray, " line"]:
    """|H_uv − H_vu| relative to their mean size, line by line: 0 for a linear structure that is not spinning.

    Args:
        value: H_uv.
        mirrored: H_vu, on the same lines.

    Raises:
        InvalidRequest: different lengths or values not finite.
    """
    one, other = np.asarray(value), np.asarray(mirrored)
    if one.shape != other.shape:
        raise InvalidRequest(Fault("call", "FRFs", f"{one.shape} and {other.shape}", "the same lines"))
    if not (np.all(np.isfinite(one)) and np.all(np.isfinite(other))):
        raise InvalidRequest(Fault("call", "FRFs", "a value that is not finite", "finite numbers"))
    mean = (np.abs(one) + np.abs(other)) / 2
    return np.divide(np.abs(one - other), mean, out=np.zeros(len(mean)), where=mean > 0)


def _above_zero(frequency: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    axis, response = np.asarray(frequency, dtype=float), np.asarray(value, dtype=complex)
    if axis.shape != response.shape or axis.ndim != 1 or np.count_nonzero(axis > 0) < 5:
        found = f"{axis.shape} frequencies for {response.shape} values"
        raise InvalidRequest(Fault("call", "FRF", found, "one value a line, five lines above 0 Hz at least"))
    if not np.all(np.isfinite(response[axis > 0])):
        raise InvalidRequest(Fault("call", "FRF", "a value that is not finite", "finite numbers"))
    return axis[axis > 0], response[axis > 0]


def _extrema(level: np.ndarray, prominence: float) -> tuple[np.ndarray, np.ndarray]:
    """Lines of the peaks and of the dips that stand out by so many decibels: each in its turn."""
    peaks: list[int] = []
    dips: list[int] = []
    high = low = 0
    rising: bool | None = None
    for line in range(1, len(level)):
        if level[line] > level[high]:
            high = line
        if level[line] < level[low]:
            low = line
        if rising is not False and level[high] - level[line] >= prominence:
            if high > 0:
                peaks.append(high)
            rising, low = False, line
        elif rising is not True and level[line] - level[low] >= prominence:
            if low > 0:
                dips.append(low)
            rising, high = True, line
    return np.array(peaks, dtype=int), np.array(dips, dtype=int)

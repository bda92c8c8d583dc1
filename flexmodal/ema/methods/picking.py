"""Peak picking: the height and the half-power points of a mobility's peak.

Of a viscously damped mode the mobility is 1/√2 of its peak at two frequencies with f₁f₂ = f_n² and
f₂ − f₁ = 2ζf_n, exactly; the height is |A′|/(2ζω_n). Neighbours and residuals are taken for part of
the mode: quick, robust, and biased where modes are close.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.noise import with_variance
from flexmodal.ema.methods.peak import Peak
from flexmodal.ema.methods.residue import from_multiplier, hidden_by_noise
from flexmodal.ema.mode import ModeEstimate


@dataclass(frozen=True, eq=False)
class _Reading:
    """Linear maps to a parabola over the top and a straight line on each flank.

    The parabola is that of 1/|Y|², the lines are those of √(h²/|Y|² − 1) with h the height: for one mode
    both are what they are called but for terms of the order of ζ.
    """

    top: Float[np.ndarray, "3 line"]
    flanks: tuple[Float[np.ndarray, "2 line"] | None, Float[np.ndarray, "2 line"] | None]
    peak: Peak
    origin: float

    def read(self, size: Float[np.ndarray, "*batch line"]) -> Float[np.ndarray, "*batch 3"]:
        """Natural frequency [Hz], damping ratio and height, of many sets of amplitudes."""
        with np.errstate(divide="ignore", invalid="ignore"):  # what cannot be read is refused by `pick_peak`
            return self._read(size)

    def _read(self, size: np.ndarray) -> np.ndarray:
        flat, slope, bend = np.moveaxis(size**-2 @ self.top.T, -1, 0)
        apex = -slope / (2 * bend)
        lowest = flat + slope * apex / 2
        height = np.where(lowest > 0, lowest, np.nan) ** -0.5
        away = np.sqrt(np.maximum((height[..., None] / size) ** 2 - 1, 0.0))  # 1 at half power
        crossing = []
        for flank in self.flanks:
            if flank is not None:
                start, rise = np.moveaxis(away @ flank.T, -1, 0)
                crossing.append((1 - start) / rise + self.origin)
        top = apex + self.origin
        if len(crossing) == 2:
            natural = np.sqrt(crossing[0] * crossing[1])
            width = crossing[1] - crossing[0]
        else:
            natural, width = top, 2 * np.abs(crossing[0] - top)
        if self.peak.holds_frequency:
            natural = np.full_like(natural, self.peak.frequency)
        damping = width / (2 * natural)
        if self.peak.damping is not None:
            damping = np.full_like(damping, self.peak.damping)
        return np.stack([natural, damping, height], axis=-1)


def pick_peak(measured: Measured, peak: Peak) -> ModeEstimate | str:
    """Read one peak of one FRF.

    Args:
        measured: one FRF.
        peak: where to look.

    Returns:
        The mode, or a sentence on why the peak cannot be read.
    """
    mobility = with_variance(measured).to("mobility")
    inside = (mobility.frequency >= peak.low) & (mobility.frequency <= peak.high)
    if np.count_nonzero(inside) < 4:
        return f"{np.count_nonzero(inside)} lines in the peak's band, fewer than 4"
    axis, value = mobility.frequency[inside], mobility.value[inside, 0]
    variance = np.asarray(mobility.variance)[inside, 0]
    size = np.maximum(np.abs(value), 1e-9 * np.max(np.abs(value)))
    near = np.abs(axis - peak.frequency) <= max(peak.width, mobility.spacing)
    summit = int(np.argmax(np.where(near, size, -1.0)))
    if summit in (0, len(axis) - 1):
        return "this FRF has no peak there"
    reading = _prepare(axis, size, summit, peak)
    if isinstance(reading, str):
        return reading
    natural, damping, height = (float(number) for number in reading.read(size))
    if not (
        np.isfinite([natural, damping, height]).all() and 0 < damping < 0.9 and height > 0 and natural > 0
    ):
        return "the peak has no half-power points that can be read"
    # Slopes by central differences; each reading is smooth in the amplitudes once its lines are chosen.
    step = 1e-6 * height
    shifted = size + step * np.stack([np.eye(len(size)), -np.eye(len(size))])
    slopes = (reading.read(shifted[0]) - reading.read(shifted[1])) / (2 * step)
    basis = np.vander(np.array([natural - reading.origin]), 3, increasing=True)[0]
    at_peak = complex(basis @ (reading.top @ value))
    jacobian = np.stack(
        [2 * np.pi * slopes[:, 0], slopes[:, 1], _log_multiplier(slopes, natural, damping, height)]
    )
    covariance = np.zeros((4, 4))
    covariance[:3, :3] = (jacobian * variance / 2) @ jacobian.T
    covariance[3, 3] = np.sum((basis @ reading.top) ** 2 * variance / 2) / height**2
    multiplier = 4 * np.pi * natural * damping * height * np.exp(1j * np.angle(at_peak))
    one_sided = any(flank is None for flank in reading.flanks)
    remarks = ("only one half-power point stands clear of the neighbours",) if one_sided else ()
    freedom = float(max(2 * int(np.count_nonzero(inside)) - 7, 1))
    mode = from_multiplier(2 * np.pi * natural, damping, multiplier, covariance, freedom, "peaks", remarks)
    return hidden_by_noise(mode) or mode


def _log_multiplier(slopes: np.ndarray, natural: float, damping: float, height: float) -> np.ndarray:
    """Slopes of ln|A′| = ln f_n + ln ζ + ln height + constant."""
    return slopes[:, 0] / natural + slopes[:, 1] / damping + slopes[:, 2] / height


def _prepare(axis: np.ndarray, size: np.ndarray, summit: int, peak: Peak) -> _Reading | str:
    """Choose the lines of the top and the flanks."""
    height, origin = size[summit], float(axis[summit])
    top = _stretch(size, summit, 0.9 * height)
    if len(top) < 3:
        top = np.arange(summit - 1, summit + 2)
    flanks = [_flank(axis, size, summit, step) for step in (-1, 1)]
    if flanks[0] is None and flanks[1] is None:
        return "the peak does not fall to half power on either side"
    maps = [None if lines is None else _fit(axis - origin, lines, 1, len(size)) for lines in flanks]
    return _Reading(_fit(axis - origin, top, 2, len(size)), (maps[0], maps[1]), peak, origin)


def _stretch(size: np.ndarray, summit: int, least: float) -> np.ndarray:
    """The lines round the summit that do not fall below `least`."""
    low = high = summit
    while low > 0 and size[low - 1] >= least:
        low -= 1
    while high < len(size) - 1 and size[high + 1] >= least:
        high += 1
    return np.arange(low, high + 1)


def _flank(axis: np.ndarray, size: np.ndarray, summit: int, step: int) -> np.ndarray | None:
    """Lines about one half-power point: those from 0.6 to 0.8 of the height, or the two beside it."""
    height = size[summit]
    here = summit
    while 0 <= here + step < len(size) and size[here + step] > height / np.sqrt(2):
        here += step
    if not 0 <= here + step < len(size):
        return None
    lines = [here, here + step]
    for where, towards in ((here, -step), (here + step, step)):
        probe = where + towards
        while 0 <= probe < len(size) and probe != summit and 0.6 * height <= size[probe] <= 0.8 * height:
            lines.append(probe)
            probe += towards
    return np.sort(np.array(lines))


def _fit(axis: np.ndarray, lines: np.ndarray, degree: int, count: int) -> np.ndarray:
    """The map from all amplitudes to the coefficients of a least squares polynomial over some lines."""
    matrix = np.zeros((degree + 1, count))
    matrix[:, lines] = np.linalg.pinv(np.vander(axis[lines], degree + 1, increasing=True))
    return matrix

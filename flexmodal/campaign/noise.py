"""How noisy each line of a record is: the floor that everything later is judged against.

From repeats: the noise of two records of the same FRF is independent, so half the squared difference is the
variance of one. From coherence: H1 is a least-squares fit of one number to n blows, whose residual variance
gives

    E|ΔH|² = |H|² (1 − γ²) / (γ² (n − 1)),

without bias where the noise is in the response (regression with n − 1 degrees of freedom; for large n the
random error of Bendat and Piersol, Random Data, table 9.6).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign.records import FrfRecords
from flexmodal.errors import Fault, InvalidRequest

SMOOTH = 9
"""Lines to either side over which a variance is averaged."""
LARGEST = 1e100
"""Values beyond overflow when they are squared and multiplied."""
ZERO = 10.0
"""What |ln| counts as where a line is exactly zero."""


def record_variance(
    frfs: FrfRecords, *, relative: bool = False, smooth: int = SMOOTH
) -> Float[np.ndarray, "record line"]:
    """Variance E|ΔH|² of each line of each record: from repeats, else from coherence and averages.

    Args:
        frfs: records; their `trials` say what repeats what and how many blows were averaged.
        relative: divide by |H|²; a line that is zero has an infinite one.
        smooth: lines to either side to average over; 0 leaves the estimates as rough as they are.

    Returns:
        In the squared unit of the records, or without unit.

    Raises:
        InvalidRequest: records with neither a repeat nor coherence over two averages or more, or values too
            large to be squared.
    """
    if np.max(np.abs(frfs.value), initial=0.0) > LARGEST:
        allowed = f"sizes up to {LARGEST:g}, which can be squared"
        raise InvalidRequest(Fault("frfs", "value", f"a size above {LARGEST:g}", allowed))
    variance = np.full(frfs.value.shape, np.nan)
    repeated, counts = np.zeros(frfs.value.shape), np.zeros(len(frfs))
    for one, other in frfs.repeats():
        half = 0.5 * np.abs(frfs.value[one] - frfs.value[other]) ** 2
        repeated[[one, other]] += half
        counts[[one, other]] += 1
    some = counts > 0
    variance[some] = repeated[some] / counts[some][:, None]
    for row in np.flatnonzero(~some).tolist():
        variance[row] = _from_coherence(frfs, row)
    variance = _smoothed(variance, smooth)
    if not relative:
        return variance
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(frfs.value == 0, np.inf, variance / np.abs(frfs.value) ** 2)


def noise_floor(frfs: FrfRecords, band: tuple[float, float]) -> float:
    """The gap that the noise of one record alone makes: root mean square of |ln(true H / measured H)|.

    Over lines inside the band with coherence 0.8 or more, each weighted by its coherence; all lines where
    there is no coherence (file format, section 3).

    Lines whose coherence reaches 0.8 by chance are those whose noise adds to |H|, the more so the fewer the
    averages: measured against its own |H| their noise looks small. So each line is judged by what it says
    together with its neighbours, see `expected_gap_square`. In tests the floor of 2 to 10 averages is within
    12 % of the gap of the true FRF, where lines judged alone would put it up to 30 % too low.

    Args:
        frfs: the records.
        band: [Hz].

    Raises:
        InvalidRequest: no line is left, or nothing says how noisy the records are.
    """
    inside = (frfs.frequency >= band[0]) & (frfs.frequency <= band[1])
    weight = frfs.weight[:, inside]
    if not weight.sum() > 0:
        found = f"no coherent line from {band[0]:g} to {band[1]:g} Hz"
        raise InvalidRequest(Fault("call", "band", found, "a band with lines in it"))
    squared = expected_gap_square(frfs.value, record_variance(frfs))[:, inside]
    return float(np.sqrt((weight * squared).sum() / weight.sum()))


def expected_gap_square(
    value: Complex[np.ndarray, "record line"], variance: Float[np.ndarray, "record line"]
) -> Float[np.ndarray, "record line"]:
    """E|ln(H / value)|² of the true FRF H, given what was measured.

    Before the measurement H is taken for circular normal with the power S that the lines around show beyond
    their noise; after it, for normal about k·value with the variance k·V, k = S/(S + V). With
    u = V/(k|value|²) then

        E|ln(H/value)|² = ln²k + ln k · E₁(1/u) + E|ln(1 + z)|²,   z circular normal of variance u.

    An expectation given the data holds for whichever lines are picked by them. Where noise is small, k is 1
    and the first two terms are 0.

    Args:
        value: the records.
        variance: E|ΔH|² of each line.
    """
    from scipy.special import exp1

    power = np.abs(value) ** 2
    prior = np.maximum(_smoothed(power, SMOOTH) - variance, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        kept = np.clip(np.where(variance > 0, prior / (prior + variance), 1.0), np.exp(-ZERO), 1.0)
        relative = np.where(variance > 0, variance / (kept * power), 0.0)
        pulled = exp1(np.where(relative > 0, 1 / relative, np.inf))
    found = np.log(kept) ** 2 + np.log(kept) * np.where(np.isfinite(pulled), pulled, 0.0)
    found = np.maximum(found + expected_log_square(relative), 0.0)
    return np.where(power == 0, ZERO**2, np.minimum(found, ZERO**2))


def expected_log_square(variance: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """E|ln(1 + z)|² for circular complex normal z of this variance, phase wrapped to (−π, π].

    Equal to the variance where it is small. Integrated in polar coordinates around z = 0, once, and
    interpolated.
    """
    grid, table = _log_square_table()
    clipped = np.clip(variance, grid[0], grid[-1])
    found = np.exp(np.interp(np.log(clipped), np.log(grid), np.log(table)))
    found = np.where(variance < grid[0], variance, found)
    return np.where(np.isinf(variance), ZERO**2, found)


@cache
def _log_square_table() -> tuple[np.ndarray, np.ndarray]:
    """Variances, and E|ln(1 + z)|² at each."""
    grid = np.logspace(-6, 4, 101)
    nodes, weights = np.polynomial.laguerre.laggauss(48)  # |z|²/variance is exponentially distributed
    angle = (np.arange(128) + 0.5) * 2 * np.pi / 128
    z = np.sqrt(grid[:, None, None] * nodes[None, :, None]) * np.exp(1j * angle)
    return grid, (np.abs(np.log(1 + z)) ** 2).mean(axis=2) @ weights


def _from_coherence(frfs: FrfRecords, row: int) -> Float[np.ndarray, " line"]:
    """Variance of a record from its coherence, where that says anything."""
    trial = next((t for t in frfs.trials if t.id == int(frfs.trial[row])), None)
    averages = 1 if trial is None else trial.averages
    coherence = None if frfs.coherence is None else frfs.coherence[row]
    if coherence is None or averages < 2 or np.all(coherence == 1):
        where = f"posture {int(frfs.posture[row])}, trial {int(frfs.trial[row])}, record {row}"
        allowed = "a trial that repeats it, or coherence over two averages or more"
        raise InvalidRequest(Fault("frfs", where, "nothing that says how noisy it is", allowed))
    kept = np.maximum(coherence, 1e-12)
    return np.abs(frfs.value[row]) ** 2 * (1 - coherence) / (kept * (averages - 1))


def _smoothed(values: Float[np.ndarray, "record line"], reach: int) -> Float[np.ndarray, "record line"]:
    """Mean over `reach` lines to either side, over fewer at the ends."""
    if reach <= 0:
        return values
    lines = values.shape[1]
    total = np.concatenate([np.zeros((len(values), 1)), np.cumsum(values, axis=1)], axis=1)
    first = np.maximum(np.arange(lines) - reach, 0)
    last = np.minimum(np.arange(lines) + reach + 1, lines)
    return np.maximum(total[:, last] - total[:, first], 0.0) / (last - first)

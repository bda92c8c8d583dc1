"""A linear plant under a hammer: exact, whatever the step.

A haversine is itself the output of a linear system (a constant and an oscillation), so that the state during
the pulse is the exponential of a slightly larger matrix, and afterwards that of A alone; no force is held or
interpolated between grid points. Once the pulse is over, a filtered sample is a fixed row times the state:
Σ_j w_j C A_h^(…) s, and the record follows from powers of exp(A·interval).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.rig.analyser import Analyser
from flexmodal.rig.blow import Strike

_BLOCK = 64
"""Samples of free decay worked out at once."""


@dataclass(frozen=True, eq=False)
class Outputs:
    """What is measured: acceleration = by_state · s + by_force · f, one row a channel."""

    by_state: Float[np.ndarray, "channel state"]
    by_force: Float[np.ndarray, "blow channel"]
    """The direct share of each blow's force: row M⁻¹ rowᵀ [1/kg]."""
    delay: Float[np.ndarray, " channel"]
    """[s]"""


def pulse_states(
    a: Float[np.ndarray, "state state"],
    column: Float[np.ndarray, "blow state"],
    strikes: list[Strike],
    step: float,
) -> tuple[int, Float[np.ndarray, "blow grid state"]]:
    """States on the grid from the first point with any motion to one where every pulse is over.

    Returns:
        Number of the grid point before the first contact, and the states from there on.
    """
    from scipy.linalg import expm

    start = np.array([s.start for s in strikes])
    end = start + np.array([s.duration for s in strikes])
    origin = int(np.floor(start.min() / step))
    last = int(np.ceil(end.max() / step)) + 1
    n = len(a)
    wide = np.zeros((len(strikes), n + 3, n + 3))  # s, then P/2 and the oscillation P/2 cos, P/2 sin
    wide[:, :n, :n] = a
    wide[:, :n, n], wide[:, :n, n + 1] = column, -column
    turning = 2 * np.pi / (end - start)
    wide[:, n + 1, n + 2], wide[:, n + 2, n + 1] = -turning, turning
    first = np.floor(start / step).astype(int) + 1  # first grid point inside the pulse
    done = np.ceil(end / step).astype(int)  # first grid point after it
    entry = expm(wide * (first * step - start)[:, None, None])
    whole = expm(wide * step)
    leave = expm(wide * (end - (done - 1) * step)[:, None, None])
    rest = expm(a[None] * (done * step - end)[:, None, None])
    free = expm(a * step)
    states = np.zeros((len(strikes), last - origin + 1, n))
    now = np.zeros((len(strikes), n + 3))
    peak = np.array([s.peak for s in strikes]) / 2
    for grid in range(origin + 1, last + 1):
        fresh = grid == first
        now[fresh] = 0.0
        now[fresh, n] = now[fresh, n + 1] = peak[fresh]
        moved = np.zeros_like(now)
        moved[fresh] = _each(entry[fresh], now[fresh])
        ending, inside, after = grid == done, (grid > first) & (grid < done), grid > done
        moved[inside] = _each(whole[inside], now[inside])
        moved[after, :n] = now[after, :n] @ free.T
        left = _each(leave[ending], now[ending])[:, :n]
        moved[ending, :n] = _each(rest[ending], left)
        now = moved
        states[:, grid - origin] = now[:, :n]
    return origin, states


def _each(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("bij,bj->bi", matrices, vectors)


def records(
    a: Float[np.ndarray, "state state"],
    column: Float[np.ndarray, "blow state"],
    outputs: Outputs,
    strikes: list[Strike],
    analyser: Analyser,
) -> Float[np.ndarray, "blow channel sample"]:
    """Sampled accelerations of a linear plant under each of several blows [m/s²]."""
    from scipy.linalg import expm

    step, fold = analyser.step, analyser.oversampling
    origin, states = pulse_states(a, column, strikes, step)
    filters = [analyser.weights(float(delay)) for delay in outputs.delay]
    longest = max(map(len, filters))
    over = origin + states.shape[1] - 1  # from here on nobody strikes
    tail = min(-(-(over + longest - analyser.reach) // fold), analyser.samples)
    grid = tail * fold + analyser.reach + 1
    free = expm(a * step)
    decay = _powers(free, max(grid - over - 1, 0), states[:, -1])
    path = np.concatenate([states, decay], axis=1)
    fine = path @ outputs.by_state.T  # blow, grid, channel
    times = (origin + np.arange(path.shape[1])) * step
    force = np.array([s.force(times) for s in strikes])
    fine += force[:, :, None] * outputs.by_force[:, None, :]
    fine = np.pad(np.swapaxes(fine, 1, 2), [(0, 0), (0, 0), (origin, 0)])[..., :grid]
    out = np.zeros((len(strikes), len(filters), analyser.samples))
    for channel, weights in enumerate(filters):
        out[:, channel, :tail] = analyser.sampled(fine[:, channel], weights, 0, tail)
        if tail < analyser.samples:
            begin = tail * fold + analyser.reach - len(weights) + 1
            row = _filtered(outputs.by_state[channel], free, weights)
            out[:, channel, tail:] = _decay(row, expm(a / analyser.rate), path[:, begin - origin], analyser.samples - tail)
    return out


def _powers(free: np.ndarray, count: int, start: np.ndarray) -> np.ndarray:
    """States free s, free² s, … by doubling."""
    path = np.zeros((len(start), count, start.shape[1]))
    if count == 0:
        return path
    path[:, 0] = start @ free.T
    have, power = 1, free
    while have < count:
        more = min(have, count - have)
        path[:, have : have + more] = path[:, :more] @ power.T
        have, power = have + more, power @ power
    return path


def _filtered(row: np.ndarray, free: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Row that turns the state at the start of the filter's span into the filtered sample."""
    total, moved = np.zeros_like(row), row
    for weight in weights[::-1]:
        total = total + weight * moved
        moved = moved @ free
    return total


def _decay(row: np.ndarray, across: np.ndarray, state: np.ndarray, count: int) -> np.ndarray:
    """row · s, row · A_i s, row · A_i² s, … for every blow."""
    rows = np.zeros((min(_BLOCK, count), len(row)))
    rows[0] = row
    for number in range(1, len(rows)):
        rows[number] = rows[number - 1] @ across
    jump = np.linalg.matrix_power(across, len(rows))
    out = np.zeros((len(state), count))
    for start in range(0, count, len(rows)):
        out[:, start : start + len(rows)] = (state @ rows.T)[:, : count - start]
        state = state @ jump.T
    return out

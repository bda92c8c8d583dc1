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
from flexmodal.rig.integration.exponential import exponential, polynomial

_BLOCK = 64
"""Samples of free decay worked out at once."""


@dataclass(frozen=True, eq=False)
class Outputs:
    """What is measured: acceleration = by_state · s + by_force · f, one row a channel, for each blow."""

    by_state: Float[np.ndarray, "blow channel state"]
    by_force: Float[np.ndarray, "blow channel"]
    """The direct share of each blow's force: row M⁻¹ rowᵀ [1/kg]."""
    delay: Float[np.ndarray, " blow"]
    """Of the sensor that measures a blow [s]."""


def pulse_states(
    a: Float[np.ndarray, "state state"],
    column: Float[np.ndarray, "blow state"],
    strikes: list[Strike],
    step: float,
) -> tuple[int, Float[np.ndarray, "blow grid state"]]:
    """States on the grid from the first point with any motion to one where every pulse is over.

    Args:
        a: state matrix.
        column: input vector of each blow.
        strikes: the blows.
        step: of the grid [s].

    Returns:
        Number of the grid point before the first contact, and the states from there on.
    """
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
    entry = exponential(wide * (first * step - start)[:, None, None])
    whole = exponential(wide * step)
    leave = exponential(wide * (end - (done - 1) * step)[:, None, None])
    rest = exponential(a[None] * (done * step - end)[:, None, None])
    free = exponential(a * step)
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
    """Sampled accelerations of a linear plant under each of several blows [m/s²].

    Args:
        a: state matrix.
        column: input vector of each blow.
        outputs: rows that are recorded.
        strikes: the blows.
        analyser: filter and samples.
    """
    step, fold = analyser.step, analyser.oversampling
    origin, states = pulse_states(a, column, strikes, step)
    filters = {float(delay): analyser.weights(float(delay)) for delay in np.unique(outputs.delay)}
    longest = max(map(len, filters.values()))
    over = origin + states.shape[1] - 1  # from here on nobody strikes
    tail = min(-(-(over + longest - analyser.reach) // fold), analyser.samples)
    grid = tail * fold + analyser.reach + 1
    free = exponential(a * step)
    path = np.concatenate([states, _powers(free, max(grid - over - 1, 0), states[:, -1])], axis=1)
    times = (origin + np.arange(path.shape[1])) * step
    force = np.array([s.force(times) for s in strikes])
    fine = outputs.by_state @ np.swapaxes(path, 1, 2) + outputs.by_force[:, :, None] * force[:, None, :]
    fine = np.pad(fine, [(0, 0), (0, 0), (origin, 0)])[..., :grid]
    across = exponential(a / analyser.rate)
    out = np.zeros((*fine.shape[:2], analyser.samples))
    for delay, weights in filters.items():
        mine = outputs.delay == delay
        out[mine, :, :tail] = analyser.sampled(fine[mine], weights, 0, tail)
        if tail < analyser.samples:
            begin = tail * fold + analyser.reach - len(weights) + 1
            rows = outputs.by_state[mine] @ polynomial(weights[::-1], free)
            out[mine, :, tail:] = _decay(rows, across, path[mine, begin - origin], analyser.samples - tail)
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


def _decay(rows: np.ndarray, across: np.ndarray, state: np.ndarray, count: int) -> np.ndarray:
    """Rows · s, rows · A_i s, rows · A_i² s, … for every blow, [blow, channel, sample]."""
    powers = [np.eye(len(across))]
    for _ in range(min(_BLOCK, count)):
        powers.append(powers[-1] @ across)
    block = np.array(powers[:-1])  # later samples of a block by its first state
    width, jump = len(block), powers[-1]
    flat = block.reshape(-1, len(across))
    out = np.zeros((*rows.shape[:2], count))
    for start in range(0, count, width):
        there = (state @ flat.T).reshape(len(state), width, -1)
        out[:, :, start : start + width] = np.einsum("bcj,bkj->bck", rows, there)[:, :, : count - start]
        state = state @ jump.T
    return out

"""Stability lobes from the mean directional matrix: the zero-order solution of Altintas and Budak (1995).

Chatter at ω and depth a needs `1 = a (1 − exp(−iωT)) μ(ω)` for an eigenvalue μ of Φ W₀. With μ = |μ| exp(iβ)
the depth is real where `ωT = π + 2β + 2πk`, and is then `1 / (2 Re μ)`; k counts the whole waves between two
teeth. For one spindle speed every such frequency is found on every branch; the smallest depth is the limit.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.branches import Branches, branches
from flexmodal.machining.stability.lobes import Lobes
from flexmodal.machining.tip_receptance import TipReceptance

_POLISH = 12
_CANDIDATES = 3
"""Crossings polished at each speed; the interpolated ones rank the rest well enough."""


def zero_order(tip: TipReceptance, cut: Cut, speed: Float[np.ndarray, " speed"]) -> Lobes:
    """Stability limit at each spindle speed.

    Args:
        tip: receptance of the tip in the frame of the cut.
        cut: the cut.
        speed: ascending [rev/min].

    Raises:
        SingularResponse: a mode that the tip sees has no damping.
    """
    found = branches(tip, cut)
    period = 60 / (cut.cutter.teeth * speed)
    chosen = [_crossings(found, float(one)) for one in period]
    place = np.repeat(np.arange(len(speed)), [len(cells) for cells, *_ in chosen])
    cell, lobe, part = (np.concatenate([one[k] for one in chosen]) for k in range(3))
    if not len(place):
        return _lowest(cut, speed, place, np.zeros(0), np.zeros(0), place)
    frequency, depth = _polish(found, cell.astype(int), lobe, part, period[place])
    return _lowest(cut, speed, place, frequency, depth, lobe.astype(int))


def _crossings(found: Branches, period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells where ωT − π − 2β passes a multiple of 2π, which one, and where in the cell; the lowest few."""
    begin = 2 * np.pi * found.low * period - np.pi - 2 * np.angle(found.at_low)
    step = 2 * np.pi * (found.high - found.low) * period - 2 * found.turn
    low, high = np.minimum(begin, begin + step), np.maximum(begin, begin + step)
    first = np.ceil(low / (2 * np.pi))
    count = np.maximum(np.floor(high / (2 * np.pi)) - first + 1, 0).astype(int)
    count[np.maximum(found.at_low.real, found.at_high.real) <= 0] = 0
    # A slow spindle passes many multiples in one cell; μ hardly moves there: the first and the last will do.
    once, again = np.flatnonzero(count > 0), np.flatnonzero(count > 1)
    cell = np.concatenate([once, again])
    lobe = np.concatenate([first[once], first[again] + count[again] - 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.clip(np.nan_to_num((2 * np.pi * lobe - begin[cell]) / step[cell]), 0, 1)
    value = found.at_low[cell] * (found.at_high[cell] / found.at_low[cell]) ** part
    good = np.flatnonzero(value.real > 0)
    lowest = good[np.argsort(-value.real[good])[:_CANDIDATES]]
    return cell[lowest], lobe[lowest], part[lowest]


def _polish(
    found: Branches, cell: np.ndarray, lobe: np.ndarray, part: np.ndarray, period: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies where the phase is exact, by bracketed secant steps (Illinois), and the depths there."""

    def error(frequency: np.ndarray, value: np.ndarray) -> np.ndarray:
        turned = np.angle(found.at_low[cell]) + np.angle(value / found.at_low[cell])
        return 2 * np.pi * (frequency * period - lobe) - np.pi - 2 * turned

    low, high = found.low[cell], found.high[cell]
    at_low, at_high = error(low, found.at_low[cell]), error(high, found.at_high[cell])
    frequency = low + part * (high - low)
    value = found.follow(cell, frequency)
    for _ in range(_POLISH):
        here = error(frequency, value)
        above = np.sign(here) == np.sign(at_high)
        low, at_low = np.where(above, low, frequency), np.where(above, at_low / 2, here)
        high, at_high = np.where(above, frequency, high), np.where(above, here, at_high / 2)
        gap = at_high - at_low
        step = np.divide(at_low, gap, out=np.full_like(gap, -0.5), where=gap != 0)
        frequency = np.clip(low - step * (high - low), low, high)
        value = found.follow(cell, frequency)
    depth = np.full(len(cell), np.inf)
    np.divide(0.5, value.real, out=depth, where=value.real > 0)
    return frequency, depth


def _lowest(
    cut: Cut, speed: np.ndarray, place: np.ndarray, frequency: np.ndarray, depth: np.ndarray, lobe: np.ndarray
) -> Lobes:
    """Of the candidates at each speed the one with the least depth."""
    limit, chatter = np.full(len(speed), np.inf), np.full(len(speed), np.nan)
    number = np.full(len(speed), -1)
    for one in np.argsort(-depth, kind="stable"):
        if np.isfinite(depth[one]):
            limit[place[one]], chatter[place[one]], number[place[one]] = (
                depth[one], frequency[one], lobe[one],
            )  # fmt: skip
    return Lobes(cut, "zero-order", speed, limit, chatter, number, np.zeros(len(speed), dtype=bool))

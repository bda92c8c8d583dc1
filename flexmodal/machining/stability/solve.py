"""Stability lobes by a method's name, with the speeds crowded where the limit bends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.branches import branches, eigenvalues
from flexmodal.machining.stability.lobes import Lobes, joined, speed_axis
from flexmodal.machining.stability.multi_frequency import multi_frequency
from flexmodal.machining.stability.semi_discretisation import semi_discretisation
from flexmodal.machining.stability.zero_order import zero_order
from flexmodal.machining.tip import ModelTip
from flexmodal.machining.tip_receptance import TipReceptance

METHODS = ("zero-order", "multi-frequency", "semi-discretisation")
SPEEDS = {"zero-order": 300, "multi-frequency": 120, "semi-discretisation": 60}
"""How many speeds are looked at if nobody says."""

_FINER = np.array([0.2, 0.4, 0.6, 0.8])
_ROUNDS = 2
_JUMP = 0.2
"""Change of the logarithm of the depth from one speed to the next that wants more of them between."""
_MOST_SPEEDS = 100_000


def stability_lobes(
    tip: TipReceptance,
    cut: Cut,
    *,
    method: str = "zero-order",
    speeds: int | Float[np.ndarray, " speed"] | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Lobes:
    """The stability limit of a cut over spindle speed.

    Args:
        tip: receptance of the tip in the frame of the cut.
        cut: the cut.
        method: "zero-order" (quick, the mean of the interrupted cut), "multi-frequency" (the interrupted cut,
            from a receptance) or "semi-discretisation" (the interrupted cut, from a second-order system).
        speeds: how many over the cut's range, or which, ascending [rev/min]. Of a number the zero-order
            solution takes more where the limit peaks and dips.
        advance: called after each speed.

    Raises:
        InvalidRequest: no such method, or one that this tip does not allow; bad speeds.
        InvalidFrequencies: a measured receptance does not reach far enough.
        SingularResponse: a mode that the tip sees has no damping.
    """
    if method not in METHODS:
        raise InvalidRequest(Fault("call", "method", repr(method), ", ".join(METHODS)))
    axis = _axis(cut, SPEEDS[method] if speeds is None else speeds)
    if method == "zero-order":
        found = zero_order(tip, cut, axis)
        return found if isinstance(speeds, np.ndarray) else _sharpened(tip, cut, found)
    parts = []
    for one in axis:
        here = np.array([one])
        if method == "multi-frequency":
            parts.append(multi_frequency(tip, cut, here))
        elif isinstance(tip, ModelTip):
            parts.append(semi_discretisation(tip, cut, here))
        else:
            allowed = "a second-order system; with a measured receptance use multi-frequency"
            raise InvalidRequest(Fault("call", "method", "semi-discretisation of a table", allowed))
        advance()
    return joined(parts)


def unconditional_depth(tip: TipReceptance, cut: Cut) -> tuple[float, float]:
    """Depth that is stable at every spindle speed, in range or not [m], and where it is limited [Hz].

    The smallest of `limiting_depth` over frequency, found between the lines of a grid that follows the
    eigenvalues; infinite, and not a number, where nothing limits it.

    Args:
        tip: how the tip gives way.
        cut: the cut.
    """
    from scipy.optimize import minimize_scalar

    found = branches(tip, cut)
    if not len(found.low) or max(found.at_low.real.max(), found.at_high.real.max()) <= 0:
        return np.inf, np.nan
    which = int(np.argmax(np.maximum(found.at_low.real, found.at_high.real)))
    at_low = bool(found.at_low.real[which] >= found.at_high.real[which])
    top = float(found.low[which] if at_low else found.high[which])
    ends = np.unique(np.concatenate([found.low, found.high]))
    place = int(np.searchsorted(ends, top))
    bounds = (float(ends[max(place - 1, 0)]), float(ends[min(place + 1, len(ends) - 1)]))

    def negative(frequency: float) -> float:
        return -float(np.max(eigenvalues(tip, found.directional, np.array([frequency])).real))

    refined = minimize_scalar(negative, bounds=bounds, method="bounded", options={"xatol": 1e-10 * top})
    best = min((refined.fun, float(refined.x)), (negative(top), top))
    return float(-0.5 / best[0]), best[1]


def _axis(cut: Cut, speeds: int | np.ndarray) -> Float[np.ndarray, " speed"]:
    if isinstance(speeds, np.ndarray):
        fine = speeds.ndim == 1 and len(speeds) and np.all(np.isfinite(speeds)) and np.all(speeds > 0)
        if not fine or np.any(np.diff(speeds) <= 0):
            raise InvalidRequest(Fault("call", "speeds", "an array", "ascending numbers above 0 [rev/min]"))
        return speeds.astype(float)
    if isinstance(speeds, bool) or not 2 <= speeds <= _MOST_SPEEDS:
        raise InvalidRequest(
            Fault("call", "speeds", repr(speeds), f"a whole number from 2 to {_MOST_SPEEDS:,}")
        )
    return speed_axis(cut, int(speeds))


def _sharpened(tip: TipReceptance, cut: Cut, found: Lobes) -> Lobes:
    """Rounds of finer speeds about each peak and dip, and where the limit jumps."""
    for _ in range(_ROUNDS):
        with np.errstate(invalid="ignore"):
            rise = np.nan_to_num(np.diff(np.log(np.maximum(found.depth, 1e-300))))
        bends = np.flatnonzero(rise[:-1] * rise[1:] < 0) + 1
        jumps = np.flatnonzero(np.abs(rise) > _JUMP)
        cells = np.unique(np.concatenate([bends - 1, bends, jumps]))
        if not len(cells):
            break
        width = found.speed[cells + 1] - found.speed[cells]
        finer = (found.speed[cells][:, None] + width[:, None] * _FINER).ravel()
        found = joined([found, zero_order(tip, cut, np.unique(finer))])
    return replace(found, method="zero-order")

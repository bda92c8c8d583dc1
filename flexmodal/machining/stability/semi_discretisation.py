"""Floquet multipliers of the regenerative cut by first-order semi-discretisation.

Insperger and Stépán, International Journal for Numerical Methods in Engineering 61 (2004) 117, and Insperger,
International Journal of Machine Tools and Manufacture 50 (2010) 658. The tooth period is cut into intervals.
In each, W(t) is replaced by its mean and the deflection one tooth ago by a straight line, and the rest is
solved exactly by a matrix exponential. Unlike the zero-order solution it keeps the interrupted cut: period
doubling, low immersion, helix. It needs the second-order system and not only a receptance.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.machining.cut import Cut
from flexmodal.machining.stability.directional import at, chip_axes, helix_lag, window_mean
from flexmodal.machining.stability.first_loss import first_loss, searches
from flexmodal.machining.stability.lobes import Lobes, unfolded
from flexmodal.machining.tip import ModelTip

_FEWEST, _MOST = 60, 900
_PER_CYCLE = 24
"""Intervals for each period of the fastest mode."""
_IN_CUT = 20
"""Intervals in the part of the period in which a tooth cuts."""
_GAUSS = ((-0.7745966692414834, 5 / 18), (0.0, 8 / 18), (0.7745966692414834, 5 / 18))


def multipliers(
    tip: ModelTip, cut: Cut, spindle_speed: float, depth: float, *, intervals: int | None = None
) -> Complex[np.ndarray, " multiplier"]:
    """Floquet multipliers over a tooth period, the largest first: the cut is stable where all are below 1.

    Args:
        tip: the tip as a second-order system, without a measured receptance.
        cut: the cut.
        spindle_speed: [rev/min].
        depth: axial depth of cut [m].
        intervals: of a tooth period; if none, 24 for each period of the fastest
            mode, 20 for the part in which a tooth cuts, 60 at least.

    Raises:
        InvalidRequest: the tip holds a measured receptance, or the intervals are not 2 to 900.
    """
    period = cut.tooth_period(spindle_speed)
    count = _intervals(tip, cut, period) if intervals is None else intervals
    if tip.added is not None:
        allowed = "a model alone; with a measured receptance use multi-frequency"
        raise InvalidRequest(Fault("call", "method", "semi-discretisation of a measured receptance", allowed))
    if not 2 <= count <= _MOST:
        allowed = f"2 to {_MOST}; at slow speeds use zero-order or multi-frequency"
        raise InvalidRequest(Fault("call", "intervals", f"{count} at {spindle_speed:g} rev/min", allowed))
    step, delayed = _steps(tip, cut, depth, period, count)
    values = np.linalg.eigvals(_monodromy(tip, step, delayed, chip_axes(cut)))
    return values[np.argsort(-np.abs(values))]


def semi_discretisation(
    tip: ModelTip, cut: Cut, speed: Float[np.ndarray, " speed"], *, intervals: int | None = None
) -> Lobes:
    """Stability limit at each spindle speed; the zero-order solution says where to begin.

    Args:
        tip: how the tip gives way.
        cut: the cut.
        speed: spindle speeds [rev/min].
        intervals: steps of a tooth period.

    Raises:
        InvalidRequest: see `multipliers`.
        SingularResponse: a mode that the tip sees has no damping.
    """
    depth, chatter = np.full(len(speed), np.inf), np.full(len(speed), np.nan)
    lobe, flip = np.full(len(speed), -1), np.zeros(len(speed), dtype=bool)
    for place, (one, search) in enumerate(zip(speed.tolist(), searches(tip, cut, speed), strict=True)):

        def unstable(tried: float, one: float = one) -> bool:
            return bool(np.abs(multipliers(tip, cut, one, tried, intervals=intervals)[0]) > 1)

        depth[place] = first_loss(unstable, search)
        if np.isfinite(depth[place]):
            largest = multipliers(tip, cut, one, float(depth[place]), intervals=intervals)[0]
            period, turn = cut.tooth_period(one), abs(float(np.angle(largest)))
            base = turn / (2 * np.pi * period)
            chatter[place], lobe[place], flip[place] = unfolded(base, period, search.near)
    return Lobes(cut, "semi-discretisation", speed, depth, chatter, lobe, flip)


def _intervals(tip: ModelTip, cut: Cut, period: float) -> int:
    fastest = float(np.max(np.abs(tip.poles))) / (2 * np.pi)
    part = (cut.engagement.exit - cut.engagement.entry) * cut.cutter.teeth / (2 * np.pi)
    return max(_FEWEST, int(np.ceil(_PER_CYCLE * fastest * period)), int(np.ceil(_IN_CUT / part)))


def _steps(
    tip: ModelTip, cut: Cut, depth: float, period: float, count: int
) -> tuple[Float[np.ndarray, "step state state"], Float[np.ndarray, "step state two axis"]]:
    """What a step makes of the state, and of the delayed deflection at its two ends."""
    from scipy.linalg import expm

    mass, axes, dof = tip.system.mass, chip_axes(cut), tip.system.dof
    inverse = np.linalg.inv(mass)
    force = inverse @ tip.rows.T @ (depth * _step_means(cut, depth, count)[:, :, :axes])  # per deflection
    size, width = 2 * dof, period / count
    whole = np.zeros((count, size + 2 * axes, size + 2 * axes))
    whole[:, :dof, dof:size] = np.eye(dof)
    whole[:, dof:size, :dof] = -inverse @ tip.system.stiffness + force @ tip.rows[:axes]
    whole[:, dof:size, dof:size] = -inverse @ tip.system.damping
    whole[:, dof:size, size : size + axes] = -force
    whole[:, size : size + axes, size + axes :] = np.eye(axes) / width
    solved = expm(whole * width)
    at_start, ramp = solved[:, :size, size : size + axes], solved[:, :size, size + axes :]
    return solved[:, :size, :size], np.stack([at_start - ramp, ramp], axis=2)


def _step_means(cut: Cut, depth: float, count: int) -> Float[np.ndarray, "step 3 3"]:
    """W averaged over each interval: exactly, or with a helix by three points of Gauss and Legendre."""
    width = 2 * np.pi / (cut.cutter.teeth * count)
    start = width * np.arange(count)
    if helix_lag(cut, depth) == 0:
        return window_mean(cut, start, width)
    parts = [weight * at(cut, start + width * (1 + point) / 2, depth) for point, weight in _GAUSS]
    return np.sum(parts, axis=0)


def _monodromy(tip: ModelTip, step: np.ndarray, delayed: np.ndarray, axes: int) -> np.ndarray:
    """State and the deflections of the last tooth period, one period on."""
    count, size = len(step), step.shape[1]
    whole = size + count * axes
    state = np.eye(size, whole)
    seen = [np.eye(axes, whole, size + (lag - 1) * axes) for lag in range(count, 0, -1)]  # the oldest first
    see = np.hstack([tip.rows[:axes], np.zeros_like(tip.rows[:axes])])
    for one, (turn, past) in enumerate(zip(step, delayed, strict=True)):
        seen.append(see @ state)
        state = turn @ state + past[:, 0] @ seen[one] + past[:, 1] @ seen[one + 1]
    return np.vstack([state, *seen[: count - 1 : -1]])

"""Pictures of stability lobes, and of postures compared by depth of cut."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmodal.machining.depth import Comparison, PostureDepth
from flexmodal.machining.forced import ForcedSweep
from flexmodal.machining.stability.lobes import LINEAR_RATIO, Lobes
from flexmodal.report.figure import PALETTE, SOFT, WIDE, drawing, log_axis, look, new_figure, short

_DEEP = 40
"""Depths that differ by more than this are drawn on a logarithmic axis."""
_MOST = 7
_HIGHEST = 20.0
"""Depths beyond this many times the middle one are drawn as if there were no limit: a peak, not a scale."""


@drawing
def draw_lobes(
    curves: Mapping[str, Lobes],
    *,
    title: str = "",
    coupling: float | None = None,
    depth: float | None = None,
    forced: ForcedSweep | None = None,
) -> Any:
    """Stable depth of cut over spindle speed, chatter frequency below it, and the error of the wall.

    Args:
        curves: lobes by what the legend calls them; the stable region of the first is shaded.
        title: heading of the picture.
        coupling: depth at which mode coupling begins [m].
        depth: depth of cut meant to be taken [m].
        forced: vibration of a stable cut at that depth, for a third panel.

    Returns:
        A matplotlib figure.
    """
    walls = forced is not None and np.any(np.isfinite(forced.surface_error))
    figure = new_figure(WIDE, 7.4 if walls else 5.8)
    heights = [2.2, 1, 1] if walls else [2.2, 1]
    upper, middle, *rest = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    shown = list(curves.items())[:_MOST]
    for place, (name, lobes) in enumerate(shown):
        _curve(upper, middle, lobes, name, place)
    _shade(upper, shown[0][1], [level for level in (coupling, depth) if level is not None])
    _level(upper, coupling, "mode coupling", (0, (5, 2)))
    _level(upper, depth, "intended depth", (0, (1, 2)))
    upper.set_ylabel("Axial depth of cut [mm]")
    upper.set_title(title)
    upper.legend(loc="upper left")
    middle.set_ylabel("Chatter frequency [Hz]")
    _frequency_scale(middle, [lobes for _, lobes in shown])
    if walls and forced is not None:
        _errors(rest[0], forced, shown[0][1])
    bottom = rest[0] if walls else middle
    bottom.set_xlabel("Spindle speed [rev/min]")
    _speed_scale(bottom, shown[0][1].speed)
    return figure


@drawing
def draw_comparison(found: Comparison) -> Any:
    """Critical depth of each posture above, and the lobes of the best and the worst below."""
    figure = new_figure(WIDE, 7.0)
    upper, lower = figure.subplots(2, 1)
    _depths(upper, found)
    _extremes(lower, found)
    upper.set_title(f"{found.robot.name}: {found.cut.title}")
    for axes in (upper, lower):
        axes.set_ylabel("Axial depth of cut [mm]")
    return figure


def _depths(axes: Any, found: Comparison) -> None:
    """Critical depth and mode coupling by posture, or by the family's parameter."""
    depth = 1e3 * np.array([one.critical_depth for one in found.postures])
    coupled = 1e3 * np.array([one.coupling.depth for one in found.postures])
    family = found.family is not None
    place = np.array([one.parameter if family else k for k, one in enumerate(found.postures)], dtype=float)
    style: dict[str, Any] = {"markersize": 5, "linewidth": 1.6 if family else 0}
    axes.plot(place, _finite(depth), "o-", color=PALETTE[0], label="critical depth", **style)
    if np.any(np.isfinite(coupled)):
        axes.plot(place, _finite(coupled), "s--", color=PALETTE[1], label="mode coupling", **style)
    both = np.concatenate([depth, coupled])
    both = both[np.isfinite(both) & (both > 0)]
    if len(both) and both.max() > _DEEP / 4 * both.min():
        log_axis(axes.yaxis)
        axes.set_ylim(both.min() / 1.5, 4 * both.max())  # room for the legend
    else:
        axes.set_ylim(0, 1.35 * both.max() if len(both) else 1)
    if family:
        card = found.robot.families[found.family or ""]
        prismatic = found.robot.moving[card.parameter].is_prismatic
        label = f"{card.parameter} of family {found.family} [{'m' if prismatic else 'rad'}]"
        axes.set_xlabel(label)
    else:
        axes.set_xticks(place, [_short(one) for one in found.postures], rotation=20, ha="right")
    axes.legend(loc="upper left", ncols=2)


def _extremes(axes: Any, found: Comparison) -> None:
    """Lobes of the posture with the greatest critical depth, and with the least."""
    order = sorted(range(len(found.postures)), key=lambda k: -found.postures[k].critical_depth)
    for number, (which, word) in enumerate(((order[0], "best"), (order[-1], "worst"))):
        one = found.postures[which]
        name = f"{word}: {_short(one)}"
        axes.plot(one.lobes.speed, _finite(1e3 * one.lobes.depth), label=name, **look(number))
    log_axis(axes.yaxis)
    axes.set_xlabel("Spindle speed [rev/min]")
    _speed_scale(axes, found.postures[0].lobes.speed)
    axes.legend(loc="upper left")


def _curve(upper: Any, middle: Any, lobes: Lobes, name: str, place: int) -> None:
    style = look(place)
    upper.plot(lobes.speed, _finite(1e3 * lobes.depth), label=name or "stability limit", **style)
    jump = np.flatnonzero(np.abs(np.diff(lobes.chatter_frequency)) > 0.02 * lobes.chatter_frequency[1:]) + 1
    speed = np.insert(lobes.speed, jump, lobes.speed[jump])
    middle.plot(speed, np.insert(lobes.chatter_frequency, jump, np.nan), **style)
    if np.any(lobes.flip):
        mark: dict[str, Any] = {
            "marker": "v",
            "markersize": 4,
            "linestyle": "none",
            "markerfacecolor": "none",
        }
        middle.plot(
            lobes.speed[lobes.flip], lobes.chatter_frequency[lobes.flip], color=style["color"],
            label="period doubling", **mark,
        )  # fmt: skip
        middle.legend(loc="upper left")


def _shade(axes: Any, lobes: Lobes, levels: list[float]) -> None:
    depth = 1e3 * lobes.depth
    known = depth[np.isfinite(depth)]
    if not len(known):
        axes.text(0.5, 0.5, "no limit found", transform=axes.transAxes, ha="center")
        return
    low, top = float(known.min()), float(min(known.max(), _HIGHEST * np.median(known)))
    if known.max() > _DEEP * low:
        log_axis(axes.yaxis)
        bottom = min([low, *(1e3 * level for level in levels)]) / 2
        top = float(known.max()) * 1.6
    else:
        bottom, top = 0.0, 1.15 * top
    filled = np.where(np.isfinite(depth), depth, 10 * top)
    axes.fill_between(lobes.speed, bottom, filled, color=PALETTE[5], alpha=0.22, linewidth=0, label="stable")
    axes.set_ylim(bottom, top)


def _level(axes: Any, depth: float | None, name: str, style: Any) -> None:
    if depth is not None and np.isfinite(depth):
        axes.axhline(
            1e3 * depth, color=SOFT, linewidth=1.2, linestyle=style, label=f"{name}, {1e3 * depth:.3g} mm"
        )


def _errors(axes: Any, forced: ForcedSweep, lobes: Lobes) -> None:
    error = 1e6 * forced.dynamic_error
    unstable = np.interp(forced.speed, lobes.speed, np.nan_to_num(lobes.depth, posinf=1e9)) < forced.depth
    axes.plot(forced.speed, np.where(unstable, np.nan, error), color=PALETTE[2], label="stable")
    if np.any(unstable):
        shown = np.where(unstable, error, np.nan)
        axes.plot(forced.speed, shown, color=SOFT, linewidth=1, linestyle=":", label="chatter, not valid")
    axes.axhline(0, color=SOFT, linewidth=0.8)
    axes.margins(y=0.3)  # room for the legend
    axes.set_ylabel("Surface error [µm]")
    mean = 1e6 * np.median(forced.static[:, 1])
    heading = f"at {1e3 * forced.depth:.3g} mm, the mean deflection of {abs(mean):.3g} µm left out"
    axes.legend(title=heading, ncols=2, loc="lower right")


def _finite(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, np.nan)


def _speed_scale(axes: Any, speed: np.ndarray) -> None:
    if len(speed) > 1:
        axes.set_xlim(speed[0], speed[-1])
        if speed[-1] / speed[0] > LINEAR_RATIO:
            log_axis(axes.xaxis)


def _frequency_scale(axes: Any, shown: list[Lobes]) -> None:
    every = np.concatenate([lobes.chatter_frequency for lobes in shown])
    every = every[np.isfinite(every) & (every > 0)]
    if len(every) and every.max() > 30 * every.min():
        log_axis(axes.yaxis)


def _short(one: PostureDepth) -> str:
    if one.posture.name:
        return short(one.posture.name, 30)
    if one.parameter is not None:
        return f"{one.parameter:.4g}"
    return short(str(one.posture), 40)

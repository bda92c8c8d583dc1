"""Results as rows of tables for people."""

from __future__ import annotations

import math

import numpy as np

from flexmodal.machining.depth import Comparison, PostureDepth

NUMBERS = ("", "value", "unit")
BEST = ("spindle speed [rev/min]", "stable depth [mm]")
POSTURES = (
    "posture", "critical depth [mm]", "at [rev/min]", "chatter [Hz]", "best depth [mm]", "at [rev/min]",
    "mode coupling [mm]",
)  # fmt: skip


def numbers(found: PostureDepth) -> list[list[str]]:
    """Rows under `NUMBERS`."""
    lobes = found.lobes
    rows = [
        ["critical depth over the range of speeds", millimetres(found.critical_depth), "mm"],
        ["  at", f"{lobes.critical_speed:.0f}" if math.isfinite(found.critical_depth) else "–", "rev/min"],
        ["  chatter frequency", hertz(chatter(found)), "Hz"],
        ["depth stable at any speed at all", millimetres(found.unconditional[0]), "mm"],
        ["mode coupling begins at", millimetres(found.coupling.depth), "mm"],
        ["  at a frequency of", hertz(found.coupling.frequency), "Hz"],
    ]
    if found.forced is not None:
        rows.append(["intended depth", millimetres(found.forced.depth), "mm"])
        rows.append(["  stable at", stable_part(found), "of the range"])
        for name, metres in (
            ("  error of the wall, size", found.forced.surface_error),
            ("  without the mean deflection", found.forced.dynamic_error),
        ):
            size = 1e6 * np.abs(metres)
            if np.all(np.isfinite(size)):
                rows.append([name, f"{size.min():.3g} to {size.max():.3g}", "µm"])
    return rows


def best_rows(found: PostureDepth) -> list[list[str]]:
    """Rows under `BEST`."""
    return [[f"{speed:.0f}", millimetres(depth)] for speed, depth in found.lobes.best()]


def posture_rows(found: Comparison) -> list[list[str]]:
    """Rows under `POSTURES`."""
    rows = []
    for one in found.postures:
        best = int(np.argmax(one.lobes.depth))
        rows.append(
            [
                _name(one), millimetres(one.critical_depth), f"{one.lobes.critical_speed:.0f}",
                hertz(chatter(one)), millimetres(float(one.lobes.depth[best])),
                f"{one.lobes.speed[best]:.0f}", millimetres(one.coupling.depth),
            ]
        )  # fmt: skip
    return rows


def stable_part(found: PostureDepth) -> str:
    """How much of the range of speeds is stable at the intended depth."""
    depth = found.lobes.cut.engagement.depth or 0.0
    stable, speed = found.lobes.depth > depth, found.lobes.speed
    width = np.diff(speed, prepend=speed[0], append=speed[-1])
    share = (width[:-1] + width[1:]) / 2
    return f"{100 * np.sum(share[stable]) / np.sum(share):.0f} %" if np.sum(share) else str(bool(stable[0]))


def millimetres(depth: float) -> str:
    """A depth for people."""
    return f"{1e3 * depth:.4g}" if math.isfinite(depth) else "no limit"


def hertz(frequency: float) -> str:
    """A frequency for people."""
    return f"{frequency:.4g}" if math.isfinite(frequency) else "–"


def chatter(found: PostureDepth) -> float:
    """Frequency of the chatter at the critical depth [Hz]."""
    return float(found.lobes.chatter_frequency[np.argmin(found.lobes.depth)])


def _name(one: PostureDepth) -> str:
    return one.posture.name or (str(one.posture) if one.parameter is None else f"{one.parameter:.4f}")

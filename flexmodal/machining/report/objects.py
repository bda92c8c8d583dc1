"""Results as JSON objects."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from flexmodal.machining.depth import Comparison, PostureDepth
from flexmodal.machining.report.rows import chatter
from flexmodal.report.parts import finite


def lobes_object(robot: str, found: PostureDepth) -> dict[str, Any]:
    """What `flexmodal lobes --json` prints for one posture; null where there is no limit."""
    lobes = found.lobes
    return {
        "robot": robot,
        "posture": dict(found.posture.values),
        "cut": lobes.cut.title,
        "method": lobes.method,
        **_judged(found),
        "best": [{"spindle_speed": speed, "depth": finite(depth)} for speed, depth in lobes.best()],
        "spindle_speed": lobes.speed.tolist(),
        "depth": [finite(value) for value in lobes.depth],
        "chatter_frequency": [finite(value) for value in lobes.chatter_frequency],
        "lobe": [int(value) if value >= 0 else None for value in lobes.lobe],
        "period_doubling": [bool(value) for value in lobes.flip],
        "forced": _forced(found),
    }


def comparison_object(found: Comparison) -> dict[str, Any]:
    """What `flexmodal lobes --json` prints for several postures."""
    return {
        "robot": found.robot.name,
        "cut": found.cut.title,
        "method": found.postures[0].lobes.method,
        "family": found.family,
        "postures": [
            {
                "posture": dict(one.posture.values),
                "name": one.posture.name or None,
                "parameter": one.parameter,
            }
            | _judged(one)
            for one in found.postures
        ],
        "best": found.best,
        "gain": finite(found.gain),
    }


def _judged(found: PostureDepth) -> dict[str, Any]:
    best = int(np.argmax(found.lobes.depth))
    limited = math.isfinite(found.critical_depth)
    return {
        "critical_depth": finite(found.critical_depth),
        "critical_speed": found.lobes.critical_speed if limited else None,
        "critical_frequency": finite(chatter(found)),
        "best_depth": finite(float(found.lobes.depth[best])),
        "best_speed": float(found.lobes.speed[best]),
        "unconditional_depth": finite(found.unconditional[0]),
        "mode_coupling": None
        if not math.isfinite(found.coupling.depth)
        else {"depth": found.coupling.depth, "frequency": found.coupling.frequency},
    }


def _forced(found: PostureDepth) -> dict[str, Any] | None:
    forced = found.forced
    if forced is None:
        return None
    return {
        "depth": forced.depth,
        "stable": [bool(value) for value in found.lobes.depth > forced.depth],
        "surface_error": [finite(value) for value in forced.surface_error],
        "dynamic_error": [finite(value) for value in forced.dynamic_error],
        "static": forced.static.tolist(),
        "peak": forced.peak.tolist(),
    }

"""The stage on which arms stand: from where they are seen, grid, ground and axes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from flexmodal.model import Robot
from flexmodal_viewer import marks
from flexmodal_viewer.scene import Scene, View

_ROUND_THE_CORNER = math.radians(28)
"""How far the camera stands ahead of a view square from the side."""
_FROM_ABOVE = math.radians(20)


def view_of(robot: Robot, tool: Iterable[float]) -> View:
    """A planar arm square on, x to the right; a spatial one from its side, a little ahead and above.

    Args:
        robot: seen from where.
        tool: position of its end-effector [m].
    """
    if robot.is_planar:
        normal = robot.task[2, 3:]
        across = int(np.argmax(np.abs(normal)))
        look = np.abs(np.eye(3)[across]) * (1 if across == 1 else -1)
        return View(
            (float(look[0]), float(look[1]), float(look[2])), flat=bool(np.max(np.abs(normal)) > 1 - 1e-9)
        )
    x, y, _ = tool
    angle = (math.atan2(y, x) if math.hypot(x, y) > 1e-3 else 0.0) + math.pi / 2 + _ROUND_THE_CORNER
    level = math.cos(_FROM_ABOVE)
    return View((level * math.cos(angle), level * math.sin(angle), -math.sin(_FROM_ABOVE)), flat=False)


def set_stage(scene: Scene) -> Scene:
    """Add grid, ground and axes that suit what is there already."""
    corners = scene.corners
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = float(np.max(high - low))
    if scene.view.flat:
        across = int(np.argmax(np.abs(scene.view.look)))
        behind = float((high if scene.view.look[across] > 0 else low)[across])
        drawn, step = marks.grid(low, high, across, behind, 0.0)
    else:
        drawn, step = marks.grid(low, high, 2, None, float(low[2]))
        # Planar arms have the names of the axes on the edges of their grid.
        triad = marks.axes(np.array([0.0, 0.0, low[2]]), 0.16 * size)
        drawn = drawn.beside(triad)
    note = f"Grid {step:g} m. World frame at the root link: x forward, z up."
    return replace(
        scene,
        nodes={**scene.nodes, **drawn.nodes},
        items=(*scene.items, *drawn.items),
        labels=(*scene.labels, *drawn.labels),
        caption=replace(scene.caption, notes=(*scene.caption.notes, note)),
    )

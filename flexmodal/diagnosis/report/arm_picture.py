"""The arm from the side, with the places marked that the verdict names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.disagreement.compare import excess
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.report.figure import INK, NARROW, NOISE, PALETTE, PAPER, SOFT, drawing, new_figure, short

FOUND, POINT, LINK, GHOST = PALETTE[1], PALETTE[2], SOFT, NOISE

Plane = Float[np.ndarray, "2 3"]
Placed = Mapping[str, Float[np.ndarray, "4 4"]]


@drawing
def draw_arm(diagnosis: Diagnosis) -> Any:
    """Draw the posture that disagrees most, the others behind it, with places marked and named."""
    context, seen = diagnosis.model.context, diagnosis.frfs
    robot, worst = context.robot, 0
    if seen is not None:
        above = excess(seen, diagnosis.predicted["before"]).sum(axis=1)
        worst = int(np.argmax(np.bincount(seen.posture, above, len(seen.postures))))
    placed = [link_placements(robot, dict(p.q)) for p in context.postures]
    plane = _plane(robot, placed[worst])
    figure = new_figure(NARROW, _height([plane @ place[:3, 3] for one in placed for place in one.values()]))
    axes = figure.subplots()
    for number, one in enumerate(placed):
        if number != worst:
            _sticks(axes, robot, one, plane, GHOST, 2.0)
    _ground(axes, robot, placed[worst], plane)
    _sticks(axes, robot, placed[worst], plane, LINK, 6.0)
    _joints(axes, robot, placed[worst], plane)
    _points(axes, diagnosis, placed[worst], plane)
    for number, where in enumerate(dict.fromkeys(where for _, where in diagnosis.verdict.effects)):
        _mark(axes, diagnosis, placed[worst], plane, where, number)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.1, 0.2)
    axes.set_axis_off()
    name = context.postures[worst].name
    axes.set_title(f"In {short(name, 30)}; other postures grey", fontsize=10, pad=16)
    return figure


def _height(spots: list[np.ndarray]) -> float:
    """Height of the picture that the arm fills [in]."""
    width, height = np.ptp(np.array(spots), axis=0) + 1e-6
    return float(np.clip(NARROW * 1.25 * height / width, 0.4 * NARROW, NARROW)) + 0.4


def _plane(robot: Robot, placed: Placed) -> Plane:
    """Axes of the picture: the plane of a planar chain, or the upright one it reaches in."""
    if robot.is_planar:
        return robot.task[:2, :3]
    ends = np.array([place[:3, 3] for place in placed.values()])
    reach = ends[int(np.argmax(np.linalg.norm(ends[:, :2], axis=1)))][:2]
    size = float(np.linalg.norm(reach))
    level = np.array([*(reach / size), 0.0]) if size > 1e-6 else np.array([1.0, 0.0, 0.0])
    return np.array([level, [0.0, 0.0, 1.0]])


def _ends(robot: Robot, placed: Placed, link: str) -> list[np.ndarray]:
    """World origins of what a link carries."""
    return [placed[joint.child][:3, 3] for joint in robot.urdf.joints if joint.parent == link]


def _sticks(axes: Any, robot: Robot, placed: Placed, plane: Plane, colour: str, width: float) -> None:
    for link, place in placed.items():
        for end in _ends(robot, placed, link):
            line = plane @ np.array([place[:3, 3], end]).T
            axes.plot(*line, color=colour, linewidth=width, solid_capstyle="round", zorder=2)


def _ground(axes: Any, robot: Robot, placed: Placed, plane: Plane) -> None:
    x, y = plane @ placed[robot.urdf.root][:3, 3]
    size = 0.12 * _extent(placed)
    axes.plot([x - size, x + size], [y - 0.25 * size] * 2, color=LINK, linewidth=2, zorder=1)
    for step in np.linspace(-size, 0.8 * size, 7):
        axes.plot(
            [x + step, x + step + 0.2 * size], [y - 0.55 * size, y - 0.25 * size], color=LINK, linewidth=1
        )


def _joints(axes: Any, robot: Robot, placed: Placed, plane: Plane) -> None:
    for name in robot.joints:
        x, y = plane @ placed[robot.urdf.joint_by_name[name].child][:3, 3]
        axes.plot(x, y, "o", markersize=8, markerfacecolor=PAPER, markeredgecolor=LINK, zorder=4)


def _points(axes: Any, diagnosis: Diagnosis, placed: Placed, plane: Plane) -> None:
    used = {number for number, _ in diagnosis.model.context.responses}
    for point in diagnosis.model.context.points:
        if point.id in used and point.link in placed:
            place = placed[point.link] @ np.array([*point.xyz, 1.0])
            x, y = plane @ place[:3]
            axes.plot(x, y, "D", markersize=5, color=POINT, zorder=5)
            axes.annotate(
                short(point.name, 24), (x, y), xytext=(3, -7), textcoords="offset points", fontsize=8,
                color=INK, zorder=6, rotation=-40, rotation_mode="anchor",
                va="top",  # aslant, so that names of points side by side do not run into each other
            )  # fmt: skip


def _mark(axes: Any, diagnosis: Diagnosis, placed: Placed, plane: Plane, where: str, rank: int = 0) -> None:
    """A ring, or a thick line along a link, with the name of the place; that of the next stands higher."""
    robot = diagnosis.model.context.robot
    points = {point.name: point for point in diagnosis.model.context.points}
    spots: list[np.ndarray] = []
    if where in placed:
        start = placed[where][:3, 3]
        ends = _ends(robot, placed, where)
        end = max(ends, key=lambda one: float(np.linalg.norm(one - start))) if ends else start
        axes.plot(
            *(plane @ np.array([start, end]).T), color=FOUND, linewidth=9, alpha=0.9, solid_capstyle="butt",
            zorder=3,
        )  # fmt: skip
        spots.append((start + end) / 2)
    elif where == "base":
        spots.append(placed[robot.urdf.root][:3, 3])
    elif where in points:
        point = points[where]
        spots.append((placed[point.link] @ np.array([*point.xyz, 1.0]))[:3])
    else:
        for name in robot.joints:
            if where in ("joints", name) or name in where.split("+"):
                spots.append(placed[robot.urdf.joint_by_name[name].child][:3, 3])
    if where == "sensor":
        spots = [(placed[p.link] @ np.array([*p.xyz, 1.0]))[:3] for p in points.values() if p.link in placed]
    for number, spot in enumerate(spots):
        x, y = plane @ spot
        if where not in placed:
            axes.plot(
                x, y, "o", markersize=20, markerfacecolor="none", markeredgecolor=FOUND, markeredgewidth=3
            )
        if number == 0:
            axes.annotate(
                short(where, 30), (x, y), xytext=(16, 22 + 15 * rank), textcoords="offset points",
                fontsize=11, fontweight="bold", color=INK,
                arrowprops={"arrowstyle": "-", "color": FOUND}, zorder=6,
            )  # fmt: skip


def _extent(placed: Placed) -> float:
    ends = np.array([place[:3, 3] for place in placed.values()])
    return max(float(np.ptp(ends, axis=0).max()), 1e-3)

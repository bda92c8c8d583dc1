"""Where the sensor sits and where the hammer strikes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.errors import Fault, InvalidInput, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import Robot
from flexmodal.rig.plant.chain import reach
from flexmodal.structure.arm import moved_bodies

AXES = "xyz"


def choose_points(robot: Robot, count: int | None) -> tuple[CampaignPoint, ...]:
    """The card's points on moving links, or the far ends of the links; evenly chosen, the outermost kept.

    Args:
        robot: which.
        count: how many; all of them if None.

    Raises:
        InvalidRequest: not so many, or no point at all.
    """
    moved = moved_bodies(robot)
    found = [(name, point.link, point.xyz) for name, point in robot.points.items()]
    if not found:
        for link in moved:
            end = reach(robot, link)
            if np.linalg.norm(end) > 1e-3:
                found.append((f"{link}_end", link, (float(end[0]), float(end[1]), float(end[2]))))
    if not found:
        allowed = "a card with points, or links of some length"
        raise InvalidRequest(Fault(robot.name, "points", "no point to measure at", allowed))
    total = len(found)
    if count is None:
        count = total
    if not 1 <= count <= total:
        names = ", ".join(name for name, *_ in found)
        raise InvalidRequest(Fault("call", "points", str(count), f"1 to {total}: {names}"))
    outer = _outermost(robot, [(link, xyz) for _, link, xyz in found])
    order = [outer, *(k for k in range(total) if k != outer)]
    picked = sorted({order[k] for k in np.linspace(0, total - 1, count).round().astype(int)})
    return tuple(CampaignPoint(n, *found[k]) for n, k in enumerate(picked, start=1))


def _depth(robot: Robot, link: str) -> int:
    parent = {joint.child: joint for joint in robot.urdf.joints}
    depth = 0
    while link in parent:
        depth += parent[link].name in robot.joints
        link = parent[link].parent
    return depth


def _outermost(robot: Robot, places: Sequence[tuple[str, tuple[float, float, float]]]) -> int:
    """The place that most joints move, the farthest out on its link."""
    return max(
        range(len(places)), key=lambda k: (_depth(robot, places[k][0]), float(np.linalg.norm(places[k][1])))
    )


def choose_references(
    robot: Robot, points: tuple[CampaignPoint, ...], wanted: int | Sequence[str], axes: tuple[int, ...]
) -> tuple[tuple[int, int], ...]:
    """Hammer positions, as point id and direction ±1 ±2 ±3.

    Args:
        robot: the robot.
        points: where it may be struck.
        wanted: how many, or which as "name:+z"; a number takes the outermost point first, then one halfway.
        axes: directions that the sensor measures.

    Raises:
        InvalidRequest: more than there are, unknown ones, or one of them twice.
    """
    if not isinstance(wanted, int):
        return _named_references(points, wanted)
    outer = _outermost(robot, [(point.link, point.xyz) for point in points])
    inner = sorted(range(len(points)), key=lambda k: _depth(robot, points[k].link), reverse=True)
    halfway = [inner[len(inner) // 2], *(k for k in inner if k != inner[len(inner) // 2])]
    order = [outer, *(k for k in halfway if k != outer)]
    upright = sorted(axes, reverse=True)
    pairs = [(points[order[(k + turn) % len(order)]].id, upright[(k + turn) % len(upright)])
             for turn in range(len(upright)) for k in range(len(order))]  # fmt: skip
    everything = list(dict.fromkeys([*pairs, *((p.id, axis) for p in points for axis in upright)]))
    if wanted > len(everything):
        allowed = f"1 to {len(everything)} with these points and axes"
        raise InvalidRequest(Fault("call", "references", str(wanted), allowed))
    return tuple(everything[:wanted])


def _named_references(
    points: tuple[CampaignPoint, ...], wanted: Sequence[str]
) -> tuple[tuple[int, int], ...]:
    ids = {point.name: point.id for point in points}
    faults: list[Fault] = []
    found = []
    for text in wanted:
        try:
            direction = PointDirection.parse(text)
        except InvalidInput as error:
            faults += error.faults
            continue
        if direction.point not in ids or direction.is_rotation:
            allowed = f"NAME:±x, ±y or ±z with one of {', '.join(ids)}"
            faults.append(Fault("call", "references", repr(text), allowed))
            continue
        found.append((ids[direction.point], direction.sign * (AXES.index(direction.axis) + 1)))
    if len(set(found)) < len(found):
        faults.append(Fault("call", "references", "one of them twice", "different ones"))
    if faults:
        raise InvalidRequest(faults)
    return tuple(found)

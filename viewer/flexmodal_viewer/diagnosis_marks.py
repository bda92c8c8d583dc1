"""Where a diagnosis looked and what it found, on the links of the arm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm, along
from flexmodal_viewer.palette import JOINT, TARGET
from flexmodal_viewer.scene import Item, Label
from flexmodal_viewer.shapes import Cylinder, Sphere

_POINT, _SPOT, _LINK = 0.014, 0.05, 0.035
"""Radii of a point, of a place that is marked and along a link, as parts of the reach."""
_CLEAR = 0.5

Spot = tuple[str, Float[np.ndarray, "3"]]
"""A link, and a place in its frame [m]."""


def points_on(arm: Arm, points: Sequence[CampaignPoint]) -> marks.Drawn:
    """A ball and a name at each point of a campaign, moving with its link; those on other links left out.

    Args:
        arm: whose links carry them.
        points: of the campaign.
    """
    drawn = marks.Drawn({}, [], [])
    for point in points:
        if point.link not in arm.index:
            continue
        path = f"{arm.node('arm', point.link)}/tested_{point.id}"
        place = marks.at(np.array(point.xyz, dtype=float))
        drawn.items.append(Item(path, Sphere(_POINT * arm.reach), JOINT, place, on_top=True))
        drawn.labels.append(Label(point.name, f"{path}/<object>"))
    return drawn


def mark_of(arm: Arm, points: Sequence[CampaignPoint], number: int, where: str, text: str) -> marks.Drawn:
    """What marks a place that a diagnosis names: a tube along a link, a ball about anything else.

    Args:
        arm: whose links carry it.
        points: of the campaign, some of which may be meant.
        number: of the mark, in its paths.
        where: a link, a joint, several with + between them, "joints", "base", a point, or "sensor".
        text: its label.
    """
    robot, drawn = arm.robot, marks.Drawn({}, [], [])
    if where in arm.index:
        spots = [_tube(arm, number, where)]
    else:
        ball = Sphere(_SPOT * arm.reach)
        spots = [
            Item(
                f"{arm.node('arm', link)}/mark_{number}_{k}", ball, TARGET, marks.at(xyz), _CLEAR, on_top=True
            )
            for k, (link, xyz) in enumerate(_spots(robot, points, where))
            if link in arm.index
        ]
    drawn.items.extend(spots)
    if spots:
        drawn.labels.append(Label(text, f"{spots[0].path}/<object>", "mark"))
    return drawn


def _tube(arm: Arm, number: int, link: str) -> Item:
    """Along a link, from where it begins to the farthest of what it carries."""
    ends = [np.array(joint.xyz) for joint in arm.robot.urdf.joints if joint.parent == link]
    end = max(ends, key=lambda one: float(np.linalg.norm(one)), default=np.zeros(3))
    length = float(np.linalg.norm(end))
    path = f"{arm.node('arm', link)}/mark_{number}_0"
    if length < 1e-6:
        return Item(path, Sphere(_SPOT * arm.reach), TARGET, opacity=_CLEAR, on_top=True)
    place = along(end / length)
    place[:3, 3] = end / 2
    return Item(path, Cylinder(_LINK * arm.reach, length), TARGET, place, _CLEAR, on_top=True)


def _spots(robot: Robot, points: Sequence[CampaignPoint], where: str) -> list[Spot]:
    if where == "base":
        return [(robot.urdf.root, np.zeros(3))]
    named = [point for point in points if where in (point.name, "sensor")]
    if named:
        return [(point.link, np.array(point.xyz, dtype=float)) for point in named]
    joints = [name for name in robot.moving if where in ("joints", name) or name in where.split("+")]
    return [(robot.moving[name].child, np.zeros(3)) for name in joints]

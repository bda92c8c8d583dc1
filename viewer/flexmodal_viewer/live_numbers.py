"""What a page needs to put a robot in postures itself: its chain, its springs, its points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.model.batch.chain import Chain, joints_of, parents_of, places_of, turn_of
from flexmodal.model.placements import link_placements
from flexmodal_viewer.scene import Matrix


def is_live(robot: Robot) -> bool:
    """Whether the page can move it: every joint turns about an axis or slides along one, branching or not."""
    return joints_of(robot) is not None


def live_numbers(
    robot: Robot, points: Sequence[str] = (), measured: Mapping[str, CampaignPoint] | None = None
) -> dict[str, Any] | None:
    """The robot in numbers, ready for JSON, every one with all its digits; None with joints of another kind.

    Args:
        robot: whose joints are to be moved on the page.
        points: that can be pushed at besides the tool and the points of the card.
        measured: points of a campaign, which count before those of the card.
    """
    chain = joints_of(robot)
    if chain is None:
        return None
    names = list(robot.moving)
    hysteresis = robot.hysteresis
    links = _links(robot, chain)
    named = _points(robot, points)
    order = [link.name for link in robot.urdf.links]
    for name, point in (measured or {}).items():
        if point.link in order:
            named[name] = _on(links[order.index(point.link)], point)
    return {
        "name": robot.name,
        "joints": [_joint(robot, chain, number) for number in range(len(names))],
        "flexible": robot.flexible_index.tolist(),
        "commanded": [names.index(name) for name in robot.commanded],
        "stiffness": robot.stiffness.ravel().tolist(),
        "damping": robot.damping.ravel().tolist(),
        "hysteresis": None
        if hysteresis is None
        else {
            "stiffness": hysteresis.stiffness.tolist(),
            "loss": hysteresis.loss_factor.tolist(),
            "frequency": hysteresis.frequency,
        },
        "points": named,
        "tool": robot.tool,
        "links": links,
        "postures": [[name, dict(values)] for name, values in robot.postures.items()],
        "planar": robot.is_planar,
    }


def _joint(robot: Robot, chain: Chain, number: int) -> dict[str, Any]:
    name, joint = list(robot.moving.items())[number]
    bounded = np.isfinite([joint.lower, joint.upper])
    return {
        "name": name,
        "parent": parents_of(robot)[number],
        "turns": bool(chain.turns[number]),
        "axis": chain.axis[number].tolist(),
        "rotation": chain.rotation[number].ravel().tolist(),
        "offset": chain.offset[number].tolist(),
        "mass": float(chain.mass[number]),
        "centre": chain.centre[number].tolist(),
        "inertia": chain.inertia[number].ravel().tolist(),
        "rotor": float(chain.rotor[number]),
        "lower": float(joint.lower) if bounded[0] else -np.pi,
        "upper": float(joint.upper) if bounded[1] else np.pi,
        "pseudo": name in robot.pseudo_joints,
    }


def _points(robot: Robot, more: Sequence[str]) -> dict[str, Any]:
    """Named points and links that can be pushed at, by name: joint that carries them, offset, turn."""
    names = dict.fromkeys(["tool", robot.tool, *robot.points, *more])
    places = places_of(robot, tuple((name, np.zeros(6)) for name in names))
    return {
        name: {
            "joint": int(places.joint[row]),
            "offset": places.offset[row].tolist(),
            "turn": turn_of(robot, name).ravel().tolist(),
        }
        for row, name in enumerate(names)
    }


def _on(link: Mapping[str, Any], point: CampaignPoint) -> dict[str, Any]:
    """A point of a link, in the frame of the joint that carries it, with its own axes if it has any."""
    place = np.array(link["place"]).reshape(4, 4).T
    turn, offset = place[:3, :3], place[:3, :3] @ np.array(point.xyz) + place[:3, 3]
    found = {"joint": link["joint"], "offset": offset.tolist(), "turn": turn.ravel().tolist()}
    found["tested"] = True  # a point of the campaign, which Python's robot does not know by this name
    if point.own_axes:
        turning = point.frame == "link"
        rows = point.rows() @ turn.T if turning else point.rows()
        found["axes"] = {"rows": rows.tolist(), "turning": turning, "says": point.axes_text()}
    return found


def _links(robot: Robot, chain: Chain) -> list[dict[str, Any]]:
    """Each link in the order of the URDF: the joint that carries it, and its place in that joint's frame."""
    order = {joint.child: number for number, joint in enumerate(robot.moving.values())}
    above = {joint.child: joint.parent for joint in robot.urdf.joints}
    placed = link_placements(robot, {})
    carried = _joint_frames(chain, parents_of(robot))
    found = []
    for link in robot.urdf.links:
        at: str | None = link.name
        while at is not None and at not in order:
            at = above.get(at)
        joint = -1 if at is None else order[at]
        place = placed[link.name] if joint < 0 else np.linalg.inv(carried[joint]) @ placed[link.name]
        found.append({"joint": joint, "place": place.T.ravel().tolist()})
    return found


def _joint_frames(chain: Chain, parents: Sequence[int]) -> list[Matrix]:
    """Frames of the joints in the world with all of them at 0."""
    found: list[Matrix] = []
    for parent, rotation, offset in zip(parents, chain.rotation, chain.offset, strict=True):
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = rotation, offset
        found.append((np.eye(4) if parent < 0 else found[parent]) @ step)
    return found

"""What hangs on what in a URDF, which way a link points, and which links can bend."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from jaxtyping import Float

from flexmodal.cards import Urdf, UrdfJoint
from flexmodal.model import Robot
from flexmodal.structure.arm import moved_bodies

SHORTEST = 0.05
"""Links shorter than this are blocks, not beams [m]."""


def children(urdf: Urdf, link: str) -> tuple[UrdfJoint, ...]:
    """Joints whose parent is that link.

    Args:
        urdf: the tree.
        link: which.
    """
    return tuple(joint for joint in urdf.joints if joint.parent == link)


def rigid_with(urdf: Urdf, link: str, flexible: Collection[str]) -> tuple[str, ...]:
    """The link and the links beyond it that no flexible joint parts from it.

    Args:
        urdf: the tree.
        link: where to begin.
        flexible: names of the joints that part links.
    """
    found = [link]
    for member in found:
        found += [joint.child for joint in children(urdf, member) if joint.name not in flexible]
    return tuple(found)


def commanded_joints(robot: Robot) -> tuple[str, ...]:
    """Flexible joints that are no pseudo-joints."""
    return tuple(name for name, joint in robot.joints.items() if not joint.pseudo)


def reach(robot: Robot, link: str) -> Float[np.ndarray, "3"]:
    """From the origin of a link to its far end, in its frame [m].

    The far end is where the farthest joint on it sits; where there is none, its farthest named point, or
    twice its mass centre.

    Args:
        robot: which.
        link: which of its links.
    """
    ends = [np.asarray(joint.xyz, dtype=float) for joint in children(robot.urdf, link)]
    if not ends:
        ends = [np.array(point.xyz, dtype=float) for point in robot.points.values() if point.link == link]
    ends.append(2 * np.asarray(robot.urdf.link_by_name[link].com, dtype=float) * (0.0 if ends else 1.0))
    return max(ends, key=lambda end: float(np.linalg.norm(end)))


def heading(robot: Robot, link: str) -> Float[np.ndarray, "3"]:
    """Unit vector from the origin of a link to its far end, in its frame; x where they are one.

    Args:
        robot: which.
        link: which of its links.
    """
    end = reach(robot, link)
    length = float(np.linalg.norm(end))
    return end / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])


def slender_links(robot: Robot) -> tuple[str, ...]:
    """Links long enough to bend that carry something beyond themselves or have mass along them."""
    return tuple(
        link for link in moved_bodies(robot) if float(np.linalg.norm(reach(robot, link))) >= SHORTEST
    )

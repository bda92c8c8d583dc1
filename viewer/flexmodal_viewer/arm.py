"""An arm: one node for each link, the parts of the link under it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal_viewer.palette import PLAIN, Colour
from flexmodal_viewer.scene import Item, Matrix
from flexmodal_viewer.shapes import Cylinder, Mesh, Shape, Sphere
from flexmodal_viewer.thinner import FEW_FACES, thinned
from flexmodal_viewer.visuals import Looks, Visual, read_looks

Paint = Callable[[Colour], Colour]
"""From the colour a part has by itself to the one it is drawn in."""


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot ready to be drawn, in as many postures as wanted."""

    robot: Robot

    @cached_property
    def reach(self) -> float:
        """Length of the chain from the first moving joint to the tool, stretched out [m]."""
        above = {joint.child: joint for joint in self.robot.urdf.joints}
        link, length, reach = self.robot.tool, 0.0, 0.0
        while link in above:
            joint = above[link]
            if joint.movable:
                reach = length  # of what this joint carries
            length += float(np.linalg.norm(joint.xyz))
            link = joint.parent
        return reach or length or 1.0

    @cached_property
    def looks(self) -> Looks:
        """Visual geometry; sticks where the URDF shows nothing at all."""
        found = read_looks(self.robot.urdf)
        if found.visuals:
            return Looks(thinned(found.visuals), found.notes)
        note = "The URDF has no visual geometry that can be shown; the arm is drawn as sticks."
        return Looks(tuple(self._sticks()), (*found.notes, note))

    @cached_property
    def rough(self) -> tuple[Shape, ...]:
        """Shapes of the visuals with few triangles, for an arm that is translucent or moves in software."""
        return tuple(visual.shape for visual in thinned(self.looks.visuals, FEW_FACES))

    def _sticks(self) -> list[Visual]:
        radius = 0.015 * self.reach
        sticks = []
        for joint in self.robot.urdf.joints:
            sticks.append(Visual(joint.child, Sphere(1.6 * radius), np.eye(4), PLAIN))
            length = float(np.linalg.norm(joint.xyz))
            if length > 0:
                place = along(joint.xyz / length)
                place[:3, 3] = joint.xyz / 2
                sticks.append(Visual(joint.parent, Cylinder(radius, length), place, PLAIN))
        return sticks

    @cached_property
    def index(self) -> Mapping[str, int]:
        """Number of each link in paths."""
        return {link.name: number for number, link in enumerate(self.robot.urdf.links)}

    def node(self, group: str, link: str) -> str:
        """Path of a link in one of the drawn postures.

        Args:
            group: the drawn posture.
            link: of the URDF.
        """
        return f"{group}/link_{self.index[link]}"

    def nodes(self, group: str, values: Mapping[str, float]) -> dict[str, Matrix]:
        """Nodes of all links with the joints at these values.

        Args:
            group: the drawn posture.
            values: of the joints [rad, m].
        """
        placed = link_placements(self.robot, values)
        return {self.node(group, link): placed[link] for link in self.index}

    def items(
        self, group: str, paint: Paint, *, opacity: float = 1.0, skip: frozenset[str] = frozenset()
    ) -> list[Item]:
        """The parts of all links but those to skip.

        Args:
            group: the drawn posture.
            paint: the colour of a part, of its own.
            opacity: 1 for solid.
            skip: links that are left out.
        """
        items = []
        for number, visual in enumerate(self.looks.visuals):
            if visual.link in skip:
                continue
            path = f"{self.node(group, visual.link)}/part_{number}"
            flat, colour, few = isinstance(visual.shape, Mesh), paint(visual.colour), self.rough[number]
            shape = few if opacity < 1 else visual.shape
            other = few if shape is not few else None
            items.append(Item(path, shape, colour, visual.place, opacity, flat=flat, rough=other))
        return items

    def still_links(self) -> frozenset[str]:
        """Links that no joint moves."""
        parent = {joint.child: joint for joint in self.robot.urdf.joints}

        def moves(link: str) -> bool:
            while link in parent:
                if parent[link].movable:
                    return True
                link = parent[link].parent
            return False

        return frozenset(link for link in self.index if not moves(link))

    def carrier(self, point: str) -> tuple[str, Matrix]:
        """The link that carries a named point or frame, and the point's place in it."""
        place = np.eye(4)
        if point in self.robot.points:
            card = self.robot.points[point]
            place[:3, 3] = card.xyz
            return card.link, place
        return point, place


def along(direction: Float[np.ndarray, "3"]) -> Matrix:
    """A placement at the origin whose z axis points along a unit vector."""
    helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
    across = np.cross(helper, direction)
    across /= np.linalg.norm(across)
    place = np.eye(4)
    place[:3, :3] = np.array([across, np.cross(direction, across), direction]).T
    return place

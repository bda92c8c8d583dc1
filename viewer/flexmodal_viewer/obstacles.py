"""What the arm may run into, as its card describes it: where it stands or on the link that carries it."""

from __future__ import annotations

import numpy as np

from flexmodal.cards import ObstacleCard
from flexmodal.cards.urdf.link import rotation
from flexmodal.model.placements import link_placements
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.marks import Drawn
from flexmodal_viewer.meshfile import load_mesh
from flexmodal_viewer.palette import OBSTACLE
from flexmodal_viewer.scene import Item, Label, Matrix, Swatch
from flexmodal_viewer.shapes import Box, Cylinder, Mesh, Shape, Sphere

LEGEND = Swatch("obstacles", OBSTACLE, "clear")
_CLEAR = 0.5
_FRAMED = 1.2
"""The camera need not have in the picture what is so many times larger than the reach of the arm."""


def obstacles(arm: Arm, group: str) -> tuple[Drawn, tuple[str, ...]]:
    """The obstacles of the arm's card.

    Args:
        arm: whose.
        group: the drawn posture whose links carry those that a link carries.

    Returns:
        What is drawn, and a sentence for each obstacle that cannot be shown.
    """
    root = link_placements(arm.robot, {})[arm.robot.urdf.root]
    drawn, notes = Drawn({}, [], []), []
    for number, (name, obstacle) in enumerate(arm.robot.obstacles.items()):
        shapes = _shapes(obstacle)
        if isinstance(shapes, str):
            notes.append(f"Obstacle {name} is not shown: {shapes}.")
            continue
        carrier = arm.node(group, obstacle.link) if obstacle.link else "around"
        place = _place(obstacle) if obstacle.link else root @ _place(obstacle)
        for part, shape in enumerate(shapes):
            path = f"{carrier}/obstacle_{number}_{part}"
            framed = bool(np.ptp(shape.corners, axis=0).max() < _FRAMED * arm.reach)
            flat = isinstance(shape, Mesh)
            drawn.items.append(Item(path, shape, OBSTACLE, place, _CLEAR, flat=flat, framed=framed))
        drawn.labels.append(Label(name, f"{carrier}/obstacle_{number}_0/<object>", "mark"))
    return drawn, tuple(notes)


def _place(obstacle: ObstacleCard) -> Matrix:
    place = np.eye(4)
    place[:3, :3] = rotation(np.array(obstacle.rpy))
    place[:3, 3] = obstacle.xyz
    return place


def _shapes(obstacle: ObstacleCard) -> list[Shape] | str:
    """Its solids in its own frame, or why there are none."""
    if obstacle.box is not None:
        return [Box(obstacle.box)]
    if obstacle.sphere is not None:
        return [Sphere(obstacle.sphere)]
    if obstacle.cylinder is not None:
        return [Cylinder(*obstacle.cylinder)]
    assert obstacle.mesh is not None  # one of the four, or the card would not have been read
    parts = load_mesh(obstacle.mesh)
    if isinstance(parts, str):
        return f"mesh {obstacle.mesh.name[:80]}, {parts}"
    return [Mesh(mesh.vertices * obstacle.scale, mesh.faces) for mesh, _ in parts]

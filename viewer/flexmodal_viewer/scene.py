"""What a page shows, as data: things at places, motions, labels, a view, and words beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal_viewer.palette import Colour
from flexmodal_viewer.shapes import IDENTITY, Shape

Matrix = Float[np.ndarray, "4 4"]


@dataclass(frozen=True, eq=False)
class Item:
    """A shape in the tree of the scene."""

    path: str
    """Such as "optimised/link_2/part_0". Never made of names from a file."""
    shape: Shape
    colour: Colour
    place: Matrix = field(default_factory=lambda: IDENTITY)
    """In the frame of the node above it."""
    opacity: float = 1.0
    on_top: bool = False
    """Whether nothing hides it."""
    flat: bool = False
    """Whether it is shaded facet by facet, as meshes without normals should be."""
    framed: bool = True
    """Whether the camera makes sure it is in the picture."""
    rough: Shape | None = None
    """Drawn instead while a picture that is made in software moves."""


@dataclass(frozen=True)
class Label:
    """A short text that follows a node."""

    text: str
    path: str
    kind: str = "point"
    """point, mark, axis, or tick; with below or beside, on which side of its place it stands."""


@dataclass(frozen=True)
class Swatch:
    """A line of the legend."""

    text: str
    colour: Colour
    kind: str = "solid"
    """solid, own (colours of its own), clear, arrow, cross or dot."""


@dataclass(frozen=True)
class Table:
    """Some values under a heading."""

    heading: str
    columns: tuple[str, ...]
    """Headings of the columns, the first of them over the names; empty for none."""
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Caption:
    """Words beside the picture, plain text throughout."""

    title: str
    subtitle: str = ""
    legend: tuple[Swatch, ...] = ()
    tables: tuple[Table, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Motion:
    """One cycle of a vibration, repeated."""

    name: str
    """On its button."""
    tracks: Mapping[str, Float[np.ndarray, "frame 4 4"]]
    """Placements of nodes over one cycle; the last frame leads back to the first."""
    extreme: float
    """Phase at which the tool is farthest out, as a part of the cycle."""
    shows: tuple[str, ...] = ()
    """Nodes that are only seen with this motion or another that shows them."""
    poses: Mapping[str, Matrix] = field(default_factory=dict)
    """Nodes that stand elsewhere for this motion, such as the ghost at its extreme."""
    legend: tuple[Swatch, ...] = ()
    table: Table | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class View:
    """Where the camera looks from."""

    look: tuple[float, float, float]
    """Direction from the camera to the scene."""
    flat: bool
    """Whether the scene is seen square on, its grid standing behind it."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything on a page."""

    caption: Caption
    view: View
    nodes: Mapping[str, Matrix]
    """Nodes that carry items, by path; those not named stand at the origin."""
    items: tuple[Item, ...]
    labels: tuple[Label, ...] = ()
    motions: tuple[Motion, ...] = ()
    rest: str = ""
    """Name of the button that stops all motion; without it a motion is always chosen."""
    live: Mapping[str, Any] | None = None
    """What the page needs to put the robot in postures itself; without it the scene is as it was drawn."""

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """Points the camera must have in the picture, motions at their widest included [m]."""
        return np.concatenate(
            [
                _moved(place @ item.place, item.shape.corners)
                for item in self.items
                if item.framed
                for place in self._places(item.path)
            ]
        )

    def _places(self, path: str) -> list[Matrix]:
        node = path.rsplit("/", 1)[0]
        places = [self.nodes.get(node, IDENTITY)]
        for motion in self.motions:
            if node in motion.poses:
                places.append(motion.poses[node])
            if node in motion.tracks:
                places += list(motion.tracks[node][::4])
        return places


def _moved(place: Matrix, points: Float[np.ndarray, "point 3"]) -> Float[np.ndarray, "point 3"]:
    return points @ place[:3, :3].T + place[:3, 3]

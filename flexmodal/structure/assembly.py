"""Putting a structure together, term by term, each with the parameters it is proportional to.

Motions first (`add_coordinates`, `move_root`, `hinge`), then bodies and springs. A term named after
parameters on a logarithmic scale is its own derivative along them; whatever else a term depends on is
differentiated by rebuilding.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.structure.arm import Arm, Arms, Body, beyond, carried, crossed, plane_normal
from flexmodal.structure.coordinates import Coordinates
from flexmodal.structure.rank_one import Size, rank_one, scaled
from flexmodal.structure.structure import Structure, changed

KINDS = ("mass", "damping", "stiffness", "loss")

_KEPT = 256
"""Motions of points that an assembly keeps at most."""


class Assembly:
    """A structure in the making."""

    def __init__(self, arm: Arm | Arms) -> None:
        self.arm = arm
        self.robot = arm.robot
        self.placed = arm.placed
        self.normal = plane_normal(arm.robot)
        self.coordinates = Coordinates(arm.robot.joints)
        self.owner = ""
        """Whose coordinates are added and asked for."""
        self.stretch: dict[str, np.ndarray] = {}
        """Rows of what stretches a joint's spring where that is not the joint's own coordinate."""
        self.loss_factor: float = 0.0
        """η of the hysteretic springs."""
        self._maps = dict(arm.maps)
        self._moved: dict[tuple[object, ...], np.ndarray] = {}
        """Motions of points asked for so far; forgotten when anything moves otherwise."""
        self._outer: dict[str, list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = {}
        """Of each link its cuts: where, towards which end, and the motion of the link's origin beyond."""
        self._terms: list[tuple[str, np.ndarray, tuple[str, ...]]] = []

    def alike(self) -> Assembly:
        """Another with the same coordinates and motions and nothing on them yet."""
        other = copy.copy(self)
        other._terms = []
        other.stretch = dict(self.stretch)
        other.coordinates = Coordinates(self.coordinates)
        return other

    def owned(self, owner: str) -> Assembly:
        """The same structure, as one who puts something on it calls its coordinates."""
        other = copy.copy(self)
        other.owner = owner
        return other

    @property
    def terms(self) -> tuple[tuple[str, np.ndarray, tuple[str, ...]], ...]:
        """Every mass, spring and damper so far: kind, matrix, the parameters it is proportional to."""
        return tuple(self._terms)

    # motions

    def add_coordinates(self, names: Sequence[str]) -> slice:
        """New coordinates at the end; returns their place."""
        return self.coordinates.add(names, self.owner)

    def number(self, coordinate: str) -> int:
        """Place of one coordinate."""
        return self.coordinates.number(coordinate, self.owner)

    def row(self, coordinate: str) -> Float[np.ndarray, " dof"]:
        """The row that picks one coordinate."""
        picked = np.zeros(len(self.coordinates))
        picked[self.number(coordinate)] = 1.0
        return picked

    def stretch_of(self, joint: str) -> Float[np.ndarray, "*posture dof"]:
        """The row of what stretches a joint's spring."""
        return self._padded(self.stretch[joint]) if joint in self.stretch else self.row(joint)

    def origin(self, link: str) -> Float[np.ndarray, "*posture 3"]:
        """Where the frame of a link stands in the world [m]."""
        return self.placed[link][..., :3, 3]

    def axes(self, link: str) -> Float[np.ndarray, "*posture 3 3"]:
        """Axes of a link in the world."""
        return self.placed[link][..., :3, :3]

    def motion(
        self, link: str, place: Float[np.ndarray, "3"], section: Float[np.ndarray, "3"] | None = None
    ) -> Float[np.ndarray, "*posture 6 dof"]:
        """Motion of a point of a link, with the hinges in that link that lie before it.

        Args:
            link: which.
            place: in its frame [m].
            section: the place along the link that the point belongs to, if not its own.
        """
        key = (link, place.tobytes(), None if section is None else section.tobytes(), len(self.coordinates))
        if len(self._moved) >= _KEPT:
            self._moved.clear()
        if key not in self._moved:
            self._moved[key] = self._motion(link, place, section)
        return self._moved[key]

    def _motion(self, link: str, place: np.ndarray, section: np.ndarray | None) -> np.ndarray:
        where, moved = place if section is None else section, self._padded(self._maps[link])
        for cut, way, turned in self._outer.get(link, []):
            if (where - cut) @ way > 0:
                moved = moved + self._padded(turned)
        return carried(moved, self.axes(link) @ place)

    def move_pivot(self, joint: str, shift: Float[np.ndarray, "*posture 3"]) -> None:
        """Let a revolute joint turn what it carries about another place, `shift` [m] away in the world.

        Args:
            joint: which; revolute.
            shift: from its place to the other, world axes [m].
        """
        self._moved.clear()
        column, child = self.number(joint), self.robot.urdf.joint_by_name[joint].child
        less = crossed(self.axes(child) @ self.robot.urdf.joint_by_name[joint].axis, shift)
        for link in beyond(self.robot.urdf, child):
            moved = self._maps[link].copy()
            moved[..., :3, column] -= less
            self._maps[link] = moved

    def move_root(self, columns: slice, motion: Float[np.ndarray, "6 added"]) -> None:
        """Let the root link move, and everything with it; see `move_link` for the arguments."""
        self.move_link(self.robot.urdf.root, columns, motion)

    def move_link(self, link: str, columns: slice, motion: Float[np.ndarray, "*posture 6 added"]) -> None:
        """Let a link move, and all it carries, by coordinates already added.

        Args:
            link: which; its own motion by other coordinates stays.
            columns: the coordinates.
            motion: of its origin, linear rows first, world axes.
        """
        self._moved.clear()
        start = self.origin(link)
        for member in beyond(self.robot.urdf, link):
            wide = self._padded(self._maps[member]).copy()
            wide[..., columns] += carried(motion, self.origin(member) - start)
            self._maps[member] = wide

    def hinge(
        self,
        link: str,
        cut: Float[np.ndarray, "3"],
        way: Float[np.ndarray, "3"],
        column: int,
        motion: Float[np.ndarray, "*posture 6"],
    ) -> None:
        """A cut inside a link: what lies beyond it turns or slides by a coordinate already added.

        Args:
            link: which.
            cut: where, in its frame [m].
            way: unit vector towards its far end; points of the link beyond `cut` along it move.
            column: the coordinate.
            motion: of what lies there, at the cut, in the world: how it slides, then how it turns.
        """
        self._moved.clear()
        pivot = self.origin(link) + self.axes(link) @ cut
        still = np.zeros((*pivot.shape[:-1], 6, len(self.coordinates)))
        for member in beyond(self.robot.urdf, link):
            moved = np.array(still if member == link else self._padded(self._maps[member]))
            moved[..., column] += carried(motion[..., None], self.origin(member) - pivot)[..., 0]
            if member == link:
                self._outer.setdefault(link, []).append((np.asarray(cut), np.asarray(way), moved))
            else:
                self._maps[member] = moved

    # masses and springs

    def add_body(
        self, link: str, body: Body, *, mass: str = "", inertia: str = "", section: np.ndarray | None = None
    ) -> None:
        """A body fixed to a link.

        Args:
            link: which.
            body: in the frame of that link.
            mass: parameter that its mass, and its inertia with it, is proportional to.
            inertia: parameter that its inertia about the mass centre is proportional to besides.
            section: see `motion`.
        """
        motion = self.motion(link, body.centre, section)
        axes = self.axes(link)
        tags = (mass,) if mass else ()
        shift, turn = motion[..., :3, :], motion[..., 3:, :]
        if np.any(body.mass):
            self._add("mass", scaled(np.swapaxes(shift, -1, -2) @ shift, body.mass), tags)
        if body.inertia.any():
            along = np.swapaxes(axes, -1, -2) @ turn  # the turning in the frame of the link
            turned = np.swapaxes(along, -1, -2) @ body.inertia @ along
            self._add("mass", turned, (*tags, inertia) if inertia else tags)

    def add_inertia(self, row: np.ndarray, inertia: Size, *names: str) -> None:
        """An inertia that moves along `row` [kg, kg·m²].

        Args:
            row: over the coordinates; those added later are 0 in it.
            inertia: its size, the same in every posture or one for each.
            *names: parameters that it is proportional to.
        """
        self._add("mass", rank_one(row, row, inertia), names)

    def add_spring(self, row: np.ndarray, stiffness: Size, *names: str) -> None:
        """A spring along `row` [N/m, N·m/rad]; see `add_inertia` for the arguments."""
        self._add("stiffness", rank_one(row, row, stiffness), names)

    def add_damper(self, row: np.ndarray, damping: Size, *names: str) -> None:
        """A damper along `row` [N·s/m, N·m·s/rad]; see `add_inertia` for the arguments."""
        self._add("damping", rank_one(row, row, damping), names)

    def add_loss(self, row: np.ndarray, stiffness: Size, *names: str) -> None:
        """Make springs along `row` hysteretic by `loss_factor`; see `add_inertia` for the arguments."""
        self._add("loss", rank_one(row, row, stiffness), names)

    def add_coupling(self, one: np.ndarray, other: np.ndarray, stiffness: Size, *names: str) -> None:
        """An off-diagonal stiffness between two rows [N·m/rad]; see `add_inertia` for the arguments."""
        self._add("stiffness", rank_one(one, other, stiffness) + rank_one(other, one, stiffness), names)

    def add_together(self, kind: str, rows: np.ndarray, sizes: np.ndarray, *names: str) -> None:
        """Inertias, dampers or springs along several rows.

        Args:
            kind: "mass", "damping" or "stiffness".
            rows: [*posture row dof] over the coordinates; those added later are 0 in them.
            sizes: [row] of each, or [*posture row]; units as in `add_inertia`, `add_damper` and `add_spring`.
            *names: parameters that all are proportional to.
        """
        self._add(kind, np.swapaxes(rows, -1, -2) @ (sizes[..., :, None] * rows), names)

    def _add(self, kind: str, matrix: np.ndarray, names: tuple[str, ...]) -> None:
        self._terms.append((kind, matrix, names))

    def summed(self) -> dict[str, Float[np.ndarray, "*posture dof dof"]]:
        """Sum of all terms by kind."""
        n = len(self.coordinates)
        total: dict[str, np.ndarray] = {kind: np.zeros((n, n)) for kind in KINDS}
        for kind, matrix, _ in self._terms:
            total[kind] = total[kind] + self.full(matrix)
        return total

    def full(self, matrix: np.ndarray) -> Float[np.ndarray, "*posture dof dof"]:
        """A matrix from before the last coordinates were added, with zeros for these."""
        missing = len(self.coordinates) - matrix.shape[-1]
        if not missing:
            return matrix
        return np.pad(matrix, [(0, 0)] * (matrix.ndim - 2) + [(0, missing)] * 2)

    def close(
        self, response: Float[np.ndarray, "response dof"], reference: Float[np.ndarray, "reference dof"]
    ) -> Structure:
        """The structure, once everything is added, with the rows that are measured and struck.

        Args:
            response: rows that are measured.
            reference: rows that are struck.
        """
        n = len(self.coordinates)
        total = {kind: np.zeros((n, n)) for kind in KINDS}
        slopes: dict[str, dict[str, np.ndarray]] = {}
        for kind, matrix, names in self._terms:
            size = len(matrix)
            total[kind][:size, :size] += matrix
            for name in names:
                slot = slopes.setdefault(name, {}).setdefault(kind, np.zeros((n, n)))
                slot[:size, :size] += matrix
        changes = {name: changed(slot) for name, slot in slopes.items()}
        return Structure(
            tuple(self.coordinates), total["mass"], total["damping"], total["stiffness"], total["loss"],
            self._padded(response), self._padded(reference), changes, self.loss_factor,
        )  # fmt: skip

    def rows(
        self, places: Sequence[tuple[str, np.ndarray, np.ndarray]]
    ) -> Float[np.ndarray, "*posture place dof"]:
        """Rows of points: link, place in its frame [m], direction in the world, perhaps in each posture."""
        if not places:
            return np.zeros((*self.placed[self.robot.urdf.root].shape[:-2], 0, len(self.coordinates)))
        seen = [way[..., None, :] @ self.motion(link, place)[..., :3, :] for link, place, way in places]
        return np.stack([one[..., 0, :] for one in seen], axis=-2)

    def _padded(self, rows: np.ndarray) -> np.ndarray:
        missing = len(self.coordinates) - rows.shape[-1]
        if not missing:
            return rows
        return np.concatenate([rows, np.zeros((*rows.shape[:-1], missing))], axis=-1)

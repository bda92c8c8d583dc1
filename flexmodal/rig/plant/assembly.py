"""Putting a plant together: rigid links on flexible joints, and whatever the effects add to them.

Everything that moves is described by motion maps: six rows (linear, angular, world axes) over the
coordinates. The mass matrix is the sum over bodies of Gᵀ I G, so that a link, a section of a beam, a payload
and a sensor are all put in alike. With nothing added it is the joint-space mass matrix that Pinocchio gives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.model import PosedRobot
from flexmodal.model.placements import link_placements
from flexmodal.rig.plant.chain import children
from flexmodal.rig.plant.flexure import Flexure
from flexmodal.rig.plant.plant import Branch, Feedback, NonlinearElement, Plant
from flexmodal.structure.arm import beyond, carried, plane_normal


@dataclass(frozen=True, eq=False)
class _Bending:
    """One way in which a link gives: it bends in a plane, or twists."""

    flexure: Flexure
    axis: np.ndarray
    """Along the link, in its frame."""
    side: np.ndarray
    """The way it deflects, in its frame; 0 where it only turns."""
    turned: np.ndarray
    """The axis about which it turns, in its frame."""
    columns: slice


class PlantAssembly:
    """A plant in the making. Effects add to it, motions first; `plant` closes it."""

    def __init__(self, posed: PosedRobot) -> None:
        robot = posed.robot
        self.robot = robot
        self.posture = posed.posture
        self.placed = link_placements(robot, posed.posture.values)
        self.normal = plane_normal(robot)
        self.coordinates: list[str] = list(robot.joints)
        self._maps = self._rigid_maps()
        self._bending: dict[str, list[_Bending]] = {}
        self._bodies: list[tuple[str, np.ndarray, float, np.ndarray]] = []
        self._mass: list[tuple[np.ndarray, float]] = []
        self._springs: list[tuple[np.ndarray, float, float]] = []
        self._coupling: list[tuple[int, int, float]] = []
        self.branches: list[Branch] = []
        self.feedbacks: list[Feedback] = []
        self.elements: list[NonlinearElement] = []
        self.elongation: dict[str, np.ndarray] = {}
        """Joints whose spring something else stretches than the joint on a locked motor, and what."""

    def _rigid_maps(self) -> dict[str, np.ndarray]:
        maps = {link.name: np.zeros((6, len(self.coordinates))) for link in self.robot.urdf.links}
        for column, name in enumerate(self.coordinates):
            joint = self.robot.urdf.joint_by_name[name]
            axis = self.placed[joint.child][:3, :3] @ joint.axis
            pivot = self.placed[joint.child][:3, 3]
            for link in beyond(self.robot.urdf, joint.child):
                if joint.is_prismatic:
                    maps[link][:3, column] = axis
                else:
                    maps[link][:3, column] = np.cross(axis, self.placed[link][:3, 3] - pivot)
                    maps[link][3:, column] = axis
        return maps

    # what effects ask

    def row(self, coordinate: str) -> Float[np.ndarray, " dof"]:
        """The row that picks one coordinate."""
        picked = np.zeros(len(self.coordinates))
        picked[self.coordinates.index(coordinate)] = 1.0
        return picked

    def stretch(self, joint: str) -> Float[np.ndarray, " dof"]:
        """The row of what stretches a joint's spring."""
        return self._padded(self.elongation.get(joint, self.row(joint)))

    def origin(self, link: str) -> Float[np.ndarray, "3"]:
        """Where the frame of a link stands in the world [m]."""
        return self.placed[link][:3, 3]

    def orientation(self, link: str) -> Float[np.ndarray, "3 3"]:
        """Axes of a link in the world."""
        return self.placed[link][:3, :3]

    def motion(self, link: str, place: Float[np.ndarray, "3"]) -> Float[np.ndarray, "6 dof"]:
        """Motion of a point of a link, the bending of that link included.

        Args:
            link: which.
            place: in its frame [m].
        """
        moved = carried(self._padded(self._maps[link]), self.orientation(link) @ place)
        for bending in self._bending.get(link, []):
            moved[:, bending.columns] += self._bent(link, bending, place)
        return moved

    def _bent(self, link: str, bending: _Bending, place: np.ndarray) -> np.ndarray:
        """Motion of a point of a bending link by its own coordinates: a deflection and a turn."""
        along = float(np.clip(bending.axis @ place, 0.0, bending.flexure.length))
        deflection, slope = bending.flexure.shape(along)
        motion = np.vstack([np.outer(bending.side, deflection), np.outer(bending.turned, slope)])
        motion = carried(motion, place - along * bending.axis)
        axes = self.orientation(link)
        return np.vstack([axes @ motion[:3], axes @ motion[3:]])

    # what effects add

    def add_coordinates(self, names: list[str]) -> slice:
        """New coordinates at the end; returns their place."""
        start = len(self.coordinates)
        self.coordinates += names
        return slice(start, len(self.coordinates))

    def add_root_motion(self, columns: slice, motion: Float[np.ndarray, "6 added"]) -> None:
        """Let the root link move, and every link with it, by coordinates already added.

        Args:
            columns: where the coordinates stand.
            motion: of the root link, linear rows first, world axes.
        """
        self.add_link_motion(self.robot.urdf.root, columns, motion)

    def add_link_motion(self, link: str, columns: slice, motion: Float[np.ndarray, "6 added"]) -> None:
        """Let a link move, and all it carries, by coordinates already added.

        Args:
            link: which.
            columns: where the coordinates stand.
            motion: of its origin, linear rows first, world axes.
        """
        start = self.origin(link)
        for further in beyond(self.robot.urdf, link):
            self._widen(further)[:, columns] += carried(motion, self.origin(further) - start)

    def add_flexure(
        self, link: str, flexure: Flexure, axis: np.ndarray, side: np.ndarray | None, loss: float
    ) -> None:
        """Let a link bend in one plane or twist; everything beyond it is carried along.

        Args:
            link: which.
            flexure: clamped at the origin of the link's frame.
            axis: unit vector along the link, in that frame.
            side: unit vector of its deflection, in that frame; None for a twist about the axis.
            loss: its damping, as a multiple of its stiffness [s].
        """
        planes = self._bending.setdefault(link, [])
        count = len(flexure.condensed_stiffness)
        columns = self.add_coordinates([f"{link} bending {len(planes) + 1}.{k + 1}" for k in range(count)])
        turned = axis if side is None else np.cross(axis, side)
        bending = _Bending(flexure, axis, np.zeros(3) if side is None else side, turned, columns)
        planes.append(bending)
        for joint in children(self.robot.urdf, link):
            place = np.asarray(joint.xyz)  # from where a joint that slides has carried its child away
            swept = self._bent(link, bending, place)
            held = self.origin(link) + self.orientation(link) @ place
            for further in beyond(self.robot.urdf, joint.child):
                lever = self.origin(further) - held
                self._widen(further)[:, columns] += carried(swept, lever)
        values, vectors = np.linalg.eigh(flexure.condensed_stiffness)
        for value, vector in zip(values, vectors.T, strict=True):
            row = np.zeros(len(self.coordinates))
            row[columns] = vector
            self.add_spring(row, float(value), loss * float(value))

    def add_body(self, link: str, place: np.ndarray, mass: float, inertia: np.ndarray | None = None) -> None:
        """A body fixed to a link: mass centre and moments about it in the link's frame [m, kg, kg·m²].

        Args:
            link: which.
            place: mass centre in its frame [m].
            mass: [kg].
            inertia: about the mass centre [kg·m²]; none for a point mass.
        """
        self._bodies.append((link, np.asarray(place), mass, np.zeros((3, 3)) if inertia is None else inertia))

    def add_inertia(self, row: np.ndarray, inertia: float) -> None:
        """An inertia that moves along `row` [kg, kg·m²].

        Args:
            row: over the coordinates.
            inertia: [kg, kg·m²].
        """
        self._mass.append((row, inertia))

    def add_spring(self, row: np.ndarray, stiffness: float, damping: float = 0.0) -> None:
        """A spring and a damper side by side along `row`.

        Args:
            row: over the coordinates.
            stiffness: [N/m, N·m/rad].
            damping: [N·s/m, N·m·s/rad].
        """
        self._springs.append((row, stiffness, damping))

    def add_on_springs(
        self, names: list[str], rows: np.ndarray, mass: float, frequency: float, damping_ratio: float
    ) -> None:
        """A mass that moves by `rows` and, on equal springs along them, by coordinates of its own.

        Args:
            names: of these coordinates.
            rows: over the coordinates there were, one for each.
            mass: [kg].
            frequency: where what carries it is held still [Hz].
            damping_ratio: likewise.
        """
        self.add_coordinates(names)
        omega = 2 * np.pi * frequency
        for name, row in zip(names, rows, strict=True):
            own = self.row(name)
            self.add_inertia(self._padded(row) + own, mass)
            self.add_spring(own, mass * omega**2, 2 * damping_ratio * mass * omega)

    def add_relaxation(
        self,
        row: Float[np.ndarray, " dof"],
        strengths: Float[np.ndarray, " element"],
        times: Float[np.ndarray, " element"],
    ) -> None:
        """Maxwell elements side by side along a row; none that has no strength.

        Args:
            row: what stretches them.
            strengths: of their springs [N·m/rad, N/m].
            times: in which they relax [s].
        """
        self.branches += [
            Branch(row, float(strength), float(time))
            for strength, time in zip(strengths, times, strict=True)
            if strength > 0
        ]

    def add_coupling(self, one: str, other: str, stiffness: float) -> None:
        """An off-diagonal stiffness between two coordinates [N·m/rad].

        Args:
            one: a coordinate.
            other: another.
            stiffness: [N·m/rad].
        """
        self._coupling.append((self.coordinates.index(one), self.coordinates.index(other), stiffness))

    # closing

    def plant(self) -> Plant:
        """The plant, once everything is added."""
        n = len(self.coordinates)
        mass, damping, stiffness = np.zeros((3, n, n))
        for link, place, weight, inertia in self._bodies:
            motion, axes = self.motion(link, place), self.orientation(link)
            mass += weight * motion[:3].T @ motion[:3]
            mass += motion[3:].T @ (axes @ inertia @ axes.T) @ motion[3:]
        for row, weight in self._mass:
            mass += weight * np.outer(self._padded(row), self._padded(row))
        for row, spring, damper in self._springs:
            stiffness += spring * np.outer(self._padded(row), self._padded(row))
            damping += damper * np.outer(self._padded(row), self._padded(row))
        for one, other, spring in self._coupling:
            stiffness[one, other] += spring
            stiffness[other, one] += spring
        branches = tuple(Branch(self._padded(b.row), b.stiffness, b.time) for b in self.branches)
        feedbacks = tuple(
            replace(f, sensed=self._padded(f.sensed), driven=self._padded(f.driven)) for f in self.feedbacks
        )
        elements = tuple(NonlinearElement(self._padded(e.row), e.kind, e.parameters) for e in self.elements)
        hung = (branches, feedbacks, elements)
        names = tuple(self.coordinates)
        return Plant(names, mass, damping, stiffness, *hung, self.motion, self.orientation)

    def _padded(self, rows: np.ndarray) -> np.ndarray:
        missing = len(self.coordinates) - rows.shape[-1]
        if not missing:
            return rows
        return np.concatenate([rows, np.zeros((*rows.shape[:-1], missing))], axis=-1)

    def _widen(self, link: str) -> np.ndarray:
        self._maps[link] = self._padded(self._maps[link])
        return self._maps[link]

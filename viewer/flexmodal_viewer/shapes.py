"""Solids and lines, each able to say how three.js writes it and how far it extends.

The dictionaries are those of three.js's JSON object format, which meshcat's `set_object` takes. They are
written here, not by meshcat's Python classes: those name objects by time and network card, so that no two
pages of one scene would be equal and each would tell on whose computer it was made.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from jaxtyping import Float, Int

IDENTITY: Float[np.ndarray, "4 4"] = np.eye(4)
IDENTITY.flags.writeable = False

# Cylinders of three.js stand along y, those of URDF along z.
_UPRIGHT: Float[np.ndarray, "4 4"] = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


class Arrays(Protocol):
    """Where the numbers of meshes go, each array once."""

    def add(self, array: np.ndarray) -> dict[str, str]:
        """Store an array and return a reference to it."""
        ...


class Shape(Protocol):
    """Something that can be drawn."""

    @property
    def kind(self) -> str:
        """Type of the three.js object that carries the geometry."""
        ...

    @property
    def turn(self) -> Float[np.ndarray, "4 4"]:
        """From the axes of three.js to those of URDF."""
        ...

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """Points whose convex hull contains it, along the axes of URDF [m]."""
        ...

    def geometry(self, arrays: Arrays) -> dict[str, Any]:
        """The geometry in the format of three.js, without its uuid."""
        ...


def _box_corners(half: Float[np.ndarray, "3"]) -> Float[np.ndarray, "8 3"]:
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    return signs * half


@dataclass(frozen=True)
class Box:
    """A box about its origin."""

    size: tuple[float, float, float]
    kind = "Mesh"
    turn = IDENTITY

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """Its eight corners."""
        return _box_corners(np.array(self.size) / 2)

    def geometry(self, arrays: Arrays) -> dict[str, Any]:
        """A BoxGeometry."""
        width, height, depth = self.size
        return {"type": "BoxGeometry", "width": width, "height": height, "depth": depth}


@dataclass(frozen=True)
class Cylinder:
    """A cylinder, or with `top` a cone, about its origin and along z."""

    radius: float
    length: float
    top: float | None = None
    kind = "Mesh"
    turn = _UPRIGHT

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """Corners of the box around it."""
        return _box_corners(np.array([self.radius, self.radius, self.length / 2]))

    def geometry(self, arrays: Arrays) -> dict[str, Any]:
        """A CylinderGeometry."""
        return {
            "type": "CylinderGeometry",
            "radiusTop": self.radius if self.top is None else self.top,
            "radiusBottom": self.radius,
            "height": self.length,
            "radialSegments": 40,
        }


@dataclass(frozen=True)
class Sphere:
    """A sphere about its origin."""

    radius: float
    kind = "Mesh"
    turn = IDENTITY

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """Corners of the box around it."""
        return _box_corners(np.full(3, self.radius))

    def geometry(self, arrays: Arrays) -> dict[str, Any]:
        """A SphereGeometry."""
        return {"type": "SphereGeometry", "radius": self.radius, "widthSegments": 24, "heightSegments": 16}


@dataclass(frozen=True)
class Ring:
    """A ring, or part of one, about z; an arc begins on x."""

    radius: float
    tube: float
    arc: float = 2 * np.pi
    kind = "Mesh"
    turn = IDENTITY

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """Corners of the box around it."""
        outer = self.radius + self.tube
        return _box_corners(np.array([outer, outer, self.tube]))

    def geometry(self, arrays: Arrays) -> dict[str, Any]:
        """A TorusGeometry."""
        return {
            "type": "TorusGeometry",
            "radius": self.radius,
            "tube": self.tube,
            "radialSegments": 6,
            "tubularSegments": 32,
            "arc": self.arc,
        }


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles. Geometry only: whatever picture or text came with them is left behind."""

    vertices: Float[np.ndarray, "vertex 3"]
    faces: Int[np.ndarray, "face 3"]
    kind = "Mesh"
    turn = IDENTITY

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """Corners of the box around it."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        return (low + high) / 2 + _box_corners((high - low) / 2)

    def geometry(self, arrays: Arrays) -> dict[str, Any]:
        """A BufferGeometry."""
        index = "<u2" if len(self.vertices) < 1 << 16 else "<u4"
        return {
            "type": "BufferGeometry",
            "data": {
                "attributes": {"position": _packed(arrays, self.vertices)},
                "index": _attribute(arrays, self.faces.astype(index), 1),
            },
        }


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines, each between two points."""

    ends: Float[np.ndarray, "line 2 3"]
    kind = "LineSegments"
    turn = IDENTITY

    @property
    def corners(self) -> Float[np.ndarray, "corner 3"]:
        """The ends themselves."""
        return self.ends.reshape(-1, 3)

    def geometry(self, arrays: Arrays) -> dict[str, Any]:
        """A BufferGeometry."""
        position = _attribute(arrays, self.ends.reshape(-1, 3).astype("<f4"), 3)
        return {"type": "BufferGeometry", "data": {"attributes": {"position": position}}}


def _attribute(arrays: Arrays, values: np.ndarray, size: int) -> dict[str, Any]:
    name = {"<f4": "Float32Array", "<u2": "Uint16Array", "<u4": "Uint32Array"}[values.dtype.str]
    return {"itemSize": size, "type": name, "normalized": False, "array": arrays.add(values)}


def _packed(arrays: Arrays, vertices: Float[np.ndarray, "vertex 3"]) -> dict[str, Any]:
    """Places as whole numbers of 16 bits between the least and the largest, which the page turns back [m]."""
    low = vertices.min(axis=0)
    step = (vertices.max(axis=0) - low) / 65535
    counts = np.rint((vertices - low) / np.where(step > 0, step, 1.0)).astype("<u2")
    packed = {"low": [float(f"{value:.7g}") for value in low], "step": [float(f"{one:.7g}") for one in step]}
    return {"itemSize": 3, "type": "Float32Array", "normalized": False, "array": arrays.add(counts), **packed}

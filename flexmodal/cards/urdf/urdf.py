"""A URDF as flexmodal uses it: links, joints, and the text that Pinocchio gets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Float

from flexmodal.text.frozen import FrozenDict

MOVABLE = ("revolute", "continuous", "prismatic")
"""Joint types that have one degree of freedom."""
FIXED = "fixed"


@dataclass(frozen=True, eq=False)
class UrdfLink:
    """A rigid body."""

    name: str
    mass: float | None
    """[kg], 0 or more; None without an <inertial>."""
    com: Float[np.ndarray, "3"]
    """Mass centre in the frame of the link [m]; zero without an <inertial>."""
    inertia: Float[np.ndarray, "3 3"] | None
    """About the mass centre, along the axes of the link [kg·m²]; None without an <inertial>."""
    meshes: tuple[str, ...]
    """Mesh files of its visuals, as addressed in the URDF."""


@dataclass(frozen=True, eq=False)
class UrdfJoint:
    """A connection of two links."""

    name: str
    type: str
    """One of `MOVABLE`, or `FIXED`."""
    parent: str
    child: str
    axis: Float[np.ndarray, "3"]
    """Unit vector in the frame of the joint; x for a fixed joint, where it means nothing."""
    xyz: Float[np.ndarray, "3"]
    """Origin in the frame of the parent link [m]."""
    rpy: Float[np.ndarray, "3"]
    """Orientation in the frame of the parent link: roll, pitch, yaw [rad]."""
    lower: float
    """[rad], or [m] for a prismatic joint; minus infinity for a continuous or fixed joint."""
    upper: float
    """[rad], or [m] for a prismatic joint; infinity for a continuous or fixed joint."""
    velocity: float | None
    """Speed limit [rad/s], or [m/s] for a prismatic joint; None where none is given."""

    @property
    def is_prismatic(self) -> bool:
        """Whether its value is a length [m] rather than an angle [rad]."""
        return self.type == "prismatic"

    @property
    def movable(self) -> bool:
        """Whether it has a degree of freedom."""
        return self.type in MOVABLE


@dataclass(frozen=True, eq=False)
class Urdf:
    """A sound URDF: one tree, finite numbers, physical inertias. Masses may still be missing."""

    path: Path
    """The file, absolute."""
    text: str
    """Its content as XML without declaration, for parsers that take a string."""
    name: str
    root: str
    """The link that is no joint's child."""
    links: tuple[UrdfLink, ...]
    """In the order of the file."""
    joints: tuple[UrdfJoint, ...]
    """In the order of the file."""
    warnings: tuple[str, ...]
    """Sentences about what is odd but does no harm to the dynamics, such as missing mesh files."""

    @property
    def movable_joints(self) -> tuple[str, ...]:
        """Names of the joints that have a degree of freedom, in the order of the file."""
        return tuple(joint.name for joint in self.joints if joint.movable)

    @cached_property
    def link_by_name(self) -> Mapping[str, UrdfLink]:
        """The links by their names."""
        return FrozenDict({link.name: link for link in self.links})

    @cached_property
    def joint_by_name(self) -> Mapping[str, UrdfJoint]:
        """The joints by their names."""
        return FrozenDict({joint.name: joint for joint in self.joints})

    @cached_property
    def beyond(self) -> Mapping[str, tuple[str, ...]]:
        """Every link and all it carries, by its name."""
        found = {}
        for link in self.links:
            carried = [link.name]
            for member in carried:
                carried += [joint.child for joint in self.joints if joint.parent == member]
            found[link.name] = tuple(carried)
        return FrozenDict(found)

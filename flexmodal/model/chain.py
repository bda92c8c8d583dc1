"""A chain of bodies from the URDF with the flexibility of its joints from the card, in no posture yet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.cards import (
    CouplingCard,
    FamilyCard,
    FrozenDict,
    JointCard,
    ObstacleCard,
    PointCard,
    Urdf,
    UrdfJoint,
    stiffness_matrix,
)
from flexmodal.errors import Fault, InvalidPoint, InvalidPosture, InvalidRequest
from flexmodal.modal import Hysteresis
from flexmodal.model.build import pinocchio, point_frame
from flexmodal.model.planar import task_rows
from flexmodal.model.posture import Pose, Posture, check_posture
from flexmodal.text.shown import Shown, several
from flexmodal.text.words import strange

TOOL = "tool"
"""What the end-effector may be called on every robot, whatever its link is called."""


@dataclass(frozen=True, eq=False, repr=False)
class FlexibleChain(Shown):
    """What is known of a robot before it is put in a posture; `Robot` is the one there is.

    The motor side is locked: joint stiffness and damping sit between a motor that stands still and its link.
    """

    name: str
    title: str
    urdf: Urdf
    tool: str
    joints: Mapping[str, JointCard]
    """The flexible joints, in the order of the URDF's chain."""
    points: Mapping[str, PointCard]
    postures: Mapping[str, Mapping[str, float]]
    families: Mapping[str, FamilyCard]
    moving: Mapping[str, UrdfJoint]
    """Every joint that moves, flexible or rigid, in the order of Pinocchio's velocity vector."""
    pinocchio: Any = field(repr=False)
    """The Pinocchio model; private to this room."""
    couplings: Mapping[str, CouplingCard] = field(default_factory=FrozenDict)
    """Off-diagonal stiffness, by `jointA+jointB`."""
    loss_frequency: float | None = None
    """Where joints with a loss factor have their stiffness [Hz]; None for K (1 + iη) at every frequency."""
    tolerance: Mapping[str, float] = field(default_factory=FrozenDict)
    """Relative standard deviation of masses and inertias, by kind."""
    obstacles: Mapping[str, ObstacleCard] = field(default_factory=FrozenDict)
    """What the arm may run into, or carries."""
    srdf: Path | None = None
    """Says which links may touch."""
    path: Path | None = None
    """The card, or the URDF, that it was loaded from."""

    def _facts(self) -> Mapping[str, object]:
        return {
            "": self.name,
            "joints": several(f"({n})" if n in self.pseudo_joints else n for n in self.moving),
            "tool": self.tool,
            "points": several(self.points, 4) or "none",
            "postures": several(self.postures, 4) or "none",
        }

    @property
    def pseudo_joints(self) -> tuple[str, ...]:
        """Joints that stand for the bending of a link: never commanded, at rest at 0."""
        return tuple(name for name, joint in self.joints.items() if joint.pseudo)

    @cached_property
    def commanded(self) -> Mapping[str, UrdfJoint]:
        """The joints that a posture sets."""
        pseudo = self.pseudo_joints
        return FrozenDict({name: joint for name, joint in self.moving.items() if name not in pseudo})

    @cached_property
    def flexible_index(self) -> np.ndarray:
        """Where the flexible joints stand in the velocity vector."""
        order = list(self.moving)
        return _fixed(np.array([order.index(name) for name in self.joints]))

    @cached_property
    def stiffness(self) -> Float[np.ndarray, "joint joint"]:
        """K over the flexible joints, couplings off the diagonal [N·m/rad, N/m]."""
        return _fixed(stiffness_matrix(self.joints, self.couplings))

    @cached_property
    def damping(self) -> Float[np.ndarray, "joint joint"]:
        """B over the flexible joints [N·m·s/rad, N·s/m]."""
        return _fixed(np.diag([float(joint.damping) for joint in self.joints.values()]))

    @cached_property
    def hysteresis(self) -> Hysteresis | None:
        """The loss of the joints' springs; None where no joint has a loss factor."""
        loss = np.array([float(joint.loss_factor) for joint in self.joints.values()])
        if not loss.any():
            return None
        stiffness = np.array([float(joint.stiffness) for joint in self.joints.values()])
        return Hysteresis(stiffness, loss, self.loss_frequency)

    @cached_property
    def task(self) -> Float[np.ndarray, "task 6"]:
        """Rows of a six-row Jacobian that the stiffness measure takes: three of a planar chain, or six."""
        return _fixed(task_rows(self.pinocchio))

    @property
    def is_planar(self) -> bool:
        """Whether the chain moves in one plane only."""
        return len(self.task) == 3

    @cached_property
    def _frames(self) -> Mapping[str, int]:
        """Pinocchio's frames by what a user calls them: the named points, then the links.

        "tool" is the end-effector, unless a point or a link has that name itself.
        """
        names = dict.fromkeys([*self.points, *(link.name for link in self.urdf.links)])
        frames = {name: point_frame(self.pinocchio, name, named=name in self.points) for name in names}
        return frames | {TOOL: frames.get(TOOL, frames[self.tool])}

    def frame_of(self, point: str, *, source: str = "call") -> int:
        """Pinocchio's frame of a named point or a URDF link.

        Args:
            point: a named point or a link of the URDF.
            source: where the name came from, for the error.

        Raises:
            InvalidPoint: the robot has no such point or link.
        """
        if point not in self._frames:
            found = strange(point, self._frames)
            raise InvalidPoint(Fault(source, "point", found, f"one of {', '.join(self._frames)}"))
        return self._frames[point]

    def posture(self, pose: Pose, *, source: str = "call") -> Posture:
        """Look up or check a posture.

        Args:
            pose: its name, its values by joint [rad, m], a checked posture, or an array in the order of
                Pinocchio's joints: of the commanded ones, of all that move (pseudo-joints at 0), or a
                configuration of Pinocchio's.
            source: where it came from, for the error.

        Raises:
            InvalidPosture: unknown name, unknown joints, bad values, outside the limits.
        """
        if isinstance(pose, Posture):
            return check_posture(pose.values, self.commanded, self.pseudo_joints, name=pose.name)
        if isinstance(pose, str):
            if pose not in self.postures:
                found = strange(pose, self.postures)
                names = ", ".join(self.postures) or "none (the robot has no named postures)"
                raise InvalidPosture(Fault(source, "posture", found, f"a named posture: {names}; or values"))
            name, values = pose, self.postures[pose]
        elif isinstance(pose, Mapping):
            name, values = "", pose
        else:
            name, values = "", self._by_name(pose, source)
        return check_posture(values, self.commanded, self.pseudo_joints, name=name, source=source)

    def _by_name(self, given: Sequence[float | int] | np.ndarray, source: str) -> dict[str, float]:
        """Values by joint of an array in Pinocchio's order."""
        model = self.pinocchio
        try:
            values = np.array(given, dtype=float)
        except (TypeError, ValueError):
            values = np.zeros((0, 0))
        if values.shape == (model.nq,) and model.nq != model.nv:  # continuous joints by cosine and sine
            pin = pinocchio()
            values = np.array(pin.difference(model, pin.neutral(model), values))
        if values.shape == (len(self.commanded),):
            return dict(zip(self.commanded, values.tolist(), strict=True))
        if values.shape != (len(self.moving),):
            found = f"an array of shape {np.shape(given)}"
            allowed = f"{len(self.commanded)} values, of {', '.join(self.commanded)}"
            raise InvalidPosture(Fault(source, "posture", found, allowed))
        by_name = dict(zip(self.moving, values.tolist(), strict=True))
        return {name: value for name, value in by_name.items() if name in self.commanded or value != 0}

    def family(self, name: str, *, source: str = "call") -> FamilyCard:
        """A one-parameter family of postures of the card.

        Args:
            name: of the family.
            source: where the name came from, for the error.

        Raises:
            InvalidRequest: the card has no such family.
        """
        if name not in self.families:
            names = ", ".join(self.families) or "none (the card has no families)"
            raise InvalidRequest(Fault(source, "family", repr(name), names))
        return self.families[name]


def _fixed(array: np.ndarray) -> np.ndarray:
    """The same array, read-only: everything posed from the robot shares it."""
    array.flags.writeable = False
    return array

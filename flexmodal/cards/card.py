"""The robot card: what a URDF cannot say, as frozen dataclasses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from flexmodal.text.frozen import FrozenDict


@dataclass(frozen=True)
class JointCard:
    """A flexible joint.

    `rotor_inertia`, `loss_factor`, `lower`, `upper` and `scale` are optional. The last three belong to the
    identification: they are relative to the values of this card, so that one set serves stiffness and
    damping alike.
    """

    stiffness: float
    """[N·m/rad], or [N/m] for a prismatic joint; above 0."""
    damping: float
    """[N·m·s/rad], or [N·s/m] for a prismatic joint; 0 or more."""
    pseudo: bool = False
    """Whether it stands for a flexible link: never commanded, rests at 0."""
    rotor_inertia: float = 0.0
    """Inertia of the motor, reflected to the joint [kg·m²], or [kg] for a prismatic joint; 0 or more."""
    lower: float | None = None
    """The identification keeps a parameter above `lower` times its value here; between 0 and 1."""
    upper: float | None = None
    """The identification keeps a parameter below `upper` times its value here; above 1."""
    scale: float | None = None
    """Relative standard deviation of the values here, the trust put in them; above 0."""
    loss_factor: float = 0.0
    """η of a spring that loses energy by hysteresis, beside the damping; see `RobotCard.loss_frequency`."""


@dataclass(frozen=True)
class CouplingCard:
    """A mechanism that ties two flexible joints."""

    joints: tuple[str, str]
    stiffness: float
    """Off-diagonal entry of the stiffness matrix [N·m/rad], of either sign."""


@dataclass(frozen=True)
class PointCard:
    """A place where a hammer hits or a sensor sits."""

    link: str
    """The URDF link that carries it."""
    xyz: tuple[float, float, float]
    """Its place in the frame of that link [m]."""


@dataclass(frozen=True)
class FamilyCard:
    """A one-parameter family of postures."""

    parameter: str
    """The joint that is swept."""
    start: float
    """Where the sweep begins [rad, or m]; the key `from`."""
    stop: float
    """Where it ends [rad, or m], above `start`; the key `to`."""
    follow: Mapping[str, float]
    """Joints that move with it: joint = factor times parameter."""


@dataclass(frozen=True)
class ObstacleCard:
    """Something that the arm may run into, or that it carries; of one of four shapes."""

    box: tuple[float, float, float] | None = None
    """Lengths along x, y and z [m]."""
    sphere: float | None = None
    """Radius [m]."""
    cylinder: tuple[float, float] | None = None
    """Radius and length along z [m]."""
    mesh: Path | None = None
    """An existing file, absolute; its convex hull is taken."""
    scale: float = 1.0
    """Of the mesh: metres for each of its units."""
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Place of its middle, or of the origin of its mesh, in the frame of the link [m]."""
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw about the axes of the link [rad]."""
    link: str = ""
    """The URDF link that carries it; the one that stands in the world if empty."""


@dataclass(frozen=True)
class RobotCard:
    """One `robot.toml`, sound in itself; `check_consistency` says whether it belongs to its URDF."""

    name: str
    title: str
    urdf: Path
    """The URDF, an existing file, absolute."""
    tool: str
    """URDF link of the end-effector."""
    source: str
    """Where the numbers come from."""
    joints: Mapping[str, JointCard]
    """The flexible joints, at least one, in the order of the file."""
    points: Mapping[str, PointCard]
    postures: Mapping[str, Mapping[str, float]]
    """Angles of commanded joints [rad, or m]; a joint left out is 0."""
    families: Mapping[str, FamilyCard]
    path: Path
    """The card itself, absolute."""
    couplings: Mapping[str, CouplingCard] = field(default_factory=FrozenDict)
    """By the names of the joints, `jointA+jointB`."""
    loss_frequency: float | None = None
    """Where the stiffness of joints with a loss factor is what the card says [Hz]: such a spring is stiffer
    at higher frequencies, as causality asks. None for K (1 + iη) whatever the frequency."""

    tolerance: Mapping[str, float] = field(default_factory=FrozenDict)
    """Relative standard deviation of masses (`mass`) and inertias (`inertia`) of links, where known."""
    obstacles: Mapping[str, ObstacleCard] = field(default_factory=FrozenDict)
    srdf: Path | None = None
    """An SRDF that says which links may touch, an existing file, absolute."""

    @property
    def pseudo_joints(self) -> tuple[str, ...]:
        """Names of the joints that stand for a flexible link."""
        return tuple(name for name, joint in self.joints.items() if joint.pseudo)

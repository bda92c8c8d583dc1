"""The robot as the tester believes it to be, and as it truly is: a few per cent off everywhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from flexmodal.model import Robot
from flexmodal.rig.plant.chain import reach, rigid_with
from flexmodal.structure.arm import moved_bodies

MOST = 2.5
"""A parameter is at most this many standard deviations off."""
BASE_MASS = 2.0
"""Mass of a base that the URDF gives none, over that of the arm."""
BASE_GYRATION = 0.2
"""Its radius of gyration over the length of the stretched arm."""


@dataclass(frozen=True, eq=False)
class Body:
    """Mass properties of a link."""

    mass: float
    """[kg]"""
    com: Float[np.ndarray, "3"]
    """In the frame of the link [m]."""
    inertia: Float[np.ndarray, "3 3"]
    """About the mass centre [kg·m²]."""


@dataclass(frozen=True)
class ParameterError:
    """Standard deviations of the logarithm of each kind of parameter, true over believed."""

    stiffness: float = 0.05
    damping: float = 0.05
    mass: float = 0.05
    """Of a link's mass; its inertia goes with it."""
    inertia: float = 0.05
    """Of the moments of inertia, beside what the mass does."""
    mass_centre: float = 0.0
    """Of its distance from the origin of the link's frame."""

    @classmethod
    def all(cls, size: float) -> ParameterError:
        """The same for all but the mass centres, which stay where the card has them."""
        return cls(size, size, size, size)


@dataclass(frozen=True, eq=False)
class TrueRobot:
    """What the hammer really meets."""

    stiffness: Mapping[str, float]
    """By flexible joint [N·m/rad]."""
    damping: Mapping[str, float]
    """By flexible joint [N·m·s/rad]."""
    rotor: Mapping[str, float]
    """Reflected inertia of a locked motor's card entry [kg·m²]."""
    bodies: Mapping[str, Body]
    """By link."""
    factors: Mapping[str, float] = field(default_factory=dict)
    """True over believed, by parameter name, such as "stiffness.q1"."""


def true_robot(robot: Robot, error: ParameterError, random: np.random.Generator) -> TrueRobot:
    """Draw the true robot around the believed one.

    Args:
        robot: as the card says.
        error: how far the card is off.
        random: where it is drawn from.
    """

    def drawn(kind: str, name: str) -> float:
        size = getattr(error, kind)
        return float(np.exp(size * float(np.clip(random.standard_normal(), -MOST, MOST))))

    return _made(robot, drawn)


def known_robot(robot: Robot, factors: Mapping[str, float]) -> TrueRobot:
    """The true robot of a campaign that was simulated before.

    Args:
        robot: as the card says.
        factors: true over believed, by parameter name; 1 for those that are not among them.
    """
    return _made(robot, lambda kind, name: float(factors.get(f"{kind}.{name}", 1.0)))


def _made(robot: Robot, drawn: Callable[[str, str], float]) -> TrueRobot:
    factors: dict[str, float] = {}

    def factor(kind: str, name: str) -> float:
        factors[f"{kind}.{name}"] = drawn(kind, name)
        return factors[f"{kind}.{name}"]

    stiffness = {n: j.stiffness * factor("stiffness", n) for n, j in robot.joints.items()}
    damping = {n: j.damping * factor("damping", n) for n, j in robot.joints.items()}
    moved = moved_bodies(robot)
    bodies = {}
    for name, body in believed_bodies(robot).items():
        if name not in moved:
            bodies[name] = body
            continue
        mass = factor("mass", name)
        inertia = factor("inertia", name)
        centre = factor("mass_centre", name)
        bodies[name] = Body(body.mass * mass, body.com * centre, body.inertia * mass * inertia)
    rotor = {name: joint.rotor_inertia for name, joint in robot.joints.items()}
    return TrueRobot(stiffness, damping, rotor, bodies, factors)


def believed_bodies(robot: Robot) -> dict[str, Body]:
    """Mass properties of every link that has any, a base included that the URDF may have left out."""
    bodies = {
        link.name: Body(
            link.mass,
            np.asarray(link.com),
            np.zeros((3, 3)) if link.inertia is None else np.asarray(link.inertia),
        )
        for link in robot.urdf.links
        if link.mass
    }
    base = base_body(robot)
    if base is not None:
        bodies[robot.urdf.root] = base
    return bodies


def base_body(robot: Robot) -> Body | None:
    """The base that a tester would write down where the URDF gives none; None where it gives one."""
    fixed = rigid_with(robot.urdf, robot.urdf.root, tuple(robot.joints))
    if any(robot.urdf.link_by_name[name].mass for name in fixed):
        return None
    arm = moved_bodies(robot)
    mass = BASE_MASS * sum(robot.urdf.link_by_name[name].mass or 0.0 for name in arm)
    length = sum(float(np.linalg.norm(reach(robot, name))) for name in arm)
    return Body(mass, np.zeros(3), mass * (BASE_GYRATION * length) ** 2 * np.eye(3))

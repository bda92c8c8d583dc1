"""What joints and their bearings carry of the robot's weight, as believed, in each posture."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.bearing import frame_of, ways
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement, positive, signed
from flexmodal.structure import Parameter
from flexmodal.structure.arm import beyond, bodies_of
from flexmodal.structure.assembly import Assembly

LOADED, TOOTH, MESH = "loaded", "tooth_radius", "tooth_angle"
"""Of a bearing that is stiffer the more it carries: the most that it carries over what presses it anyway; how
far off the tooth is that holds up the weight beyond, and where it stands."""
MUCH, NEAR = 10.0, 0.1
"""Load and radius [m] from which fits start, at some angles."""
ANGLES = 6


@lru_cache(maxsize=16)
def moments(context: Context) -> Mapping[str, Float[np.ndarray, " posture"]]:
    """By how much each joint raises the robot's mass, which is what it holds over gravity [kg·m, kg].

    Args:
        context: whose postures.
    """
    assembly = Assembly(context.stacked)
    bodies = bodies_of(context.robot.urdf).items()
    raised = np.sum(
        [body.mass * assembly.motion(link, body.centre)[..., 2, :] for link, body in bodies], axis=0
    )
    return {joint: raised[..., assembly.number(joint)] for joint in context.robot.joints}


@lru_cache(maxsize=16)
def carried(context: Context) -> Mapping[str, Float[np.ndarray, " posture"]]:
    """What each joint holds against the weight, over the most that any does.

    Args:
        context: whose postures.
    """
    found = {joint: np.abs(one) for joint, one in moments(context).items()}
    most = max(float(one.max()) for one in found.values())
    return {joint: one / most if most > 0 else one for joint, one in found.items()}


def loaded() -> tuple[Parameter, ...]:
    """Of a bearing that is stiffer under load, not at all unless the data ask for it."""
    return (
        signed(LOADED, "of the preload", 5.0, 0.0, 1e3),
        positive(TOOTH, "m", NEAR, 0.7, 0.01, 2.0),
        signed(MESH, "rad", 2.0, -3.2, 3.2),
    )


def loaded_starts() -> list[dict[str, float]]:
    """With little preload, the tooth anywhere about the joint."""
    angles = (np.arange(ANGLES) * 2 * np.pi / ANGLES - np.pi).tolist()
    return [{LOADED: MUCH, TOOTH: NEAR, MESH: angle} for angle in angles]


def stiffer(placement: Placement, joint: str) -> float | Float[np.ndarray, " system"]:
    """Stiffness of a bearing over that under the largest load, in each system.

    That of balls goes with the cube root of what they carry (Gargiulo, Machine Design 52, 1980, 107): here
    the weight beyond the joint, and the force of the tooth that holds it up.

    Args:
        placement: of the effect.
        joint: whose bearing; 1 where the law knows of no load.
    """
    by = placement.values.get(LOADED, 0.0)
    if not by:
        return 1.0
    load = _load(placement, joint)
    most = max(float(load.max()), 1e-12)
    return np.asarray((((1 + by * load / most) / (1 + by)) ** (1 / 3))[placement.posture])


def _load(placement: Placement, joint: str) -> Float[np.ndarray, " posture"]:
    """Over gravity [kg]."""
    context, urdf = placement.context, placement.context.robot.urdf
    described, bodies = urdf.joint_by_name[joint], bodies_of(urdf)
    mass = sum(bodies[link].mass for link in beyond(urdf, described.child) if link in bodies)
    first, second = (way.vector for way in ways(context, joint) if way.kind == "radial")
    tooth = -np.sin(placement[MESH]) * first + np.cos(placement[MESH]) * second
    tooth = Assembly(context.stacked).axes(described.parent) @ (frame_of(context, joint) @ tooth)
    pushed = (moments(context)[joint] / placement[TOOTH])[:, None] * tooth
    return np.asarray(np.linalg.norm(pushed - mass * np.array([0.0, 0.0, 1.0]), axis=-1))

"""The foundation gives: the root link tilts and moves on springs."""

from __future__ import annotations

import numpy as np

from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, divided, positive
from flexmodal.rig.plant.assembly import PlantAssembly


def base_directions(normal: np.ndarray | None) -> tuple[list[str], np.ndarray]:
    """Names and motions [6, coordinate] of a base: three of a planar chain, six of a spatial one."""
    if normal is None:
        return [f"base {name}" for name in ("x", "y", "z", "rx", "ry", "rz")], np.eye(6)
    level = np.cross(normal, np.array([0.0, 0.0, 1.0]))
    if np.linalg.norm(level) < 1e-9:
        level = np.array([1.0, 0.0, 0.0])
    level /= np.linalg.norm(level)
    up = np.cross(level, normal)
    motion = np.zeros((6, 3))
    motion[:3, 0], motion[:3, 1], motion[3:, 2] = level, up, normal
    return ["base along", "base up", "base tilt"], motion


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A base that would tilt at 8 to 30 Hz and shift at 15 to 60 Hz under the whole, stretched arm."""
    mass = stand.mass
    inertia = sum(
        float(np.trace(body.inertia)) / 2 + body.mass * _distance(stand, link) ** 2
        for link, body in stand.true.bodies.items()
    )
    return {
        "translation_stiffness": float(mass * (2 * np.pi * random.uniform(15, 60)) ** 2),
        "tilt_stiffness": float(inertia * (2 * np.pi * random.uniform(8, 30)) ** 2),
        "damping_ratio": float(random.uniform(0.02, 0.06)),
        "vertical_over_horizontal": float(random.uniform(1.0, 2.0)),
    }


def _distance(stand: Stand, link: str) -> float:
    """Length of the chain from the base to a link, as if stretched out."""
    total, joints = 0.0, {joint.child: joint for joint in stand.robot.urdf.joints}
    while link in joints:
        total += float(np.linalg.norm(joints[link].xyz))
        link = joints[link].parent
    return total


def base_coordinates(assembly: PlantAssembly, site: Site) -> None:
    """Let the root move along `base_directions`.

    Args:
        assembly: the plant in the making.
        site: the base.
    """
    names, motion = base_directions(assembly.normal)
    columns = assembly.add_coordinates(names)
    assembly.add_root_motion(columns, motion)


def _act(assembly: PlantAssembly, site: Site) -> None:
    names, motion = base_directions(assembly.normal)
    mass = site.stand.mass
    shift = site["translation_stiffness"]
    period = np.sqrt(mass / shift)  # sets the damping: 2 ζ √(k m) = 2 ζ k √(m/k)
    for name, direction in zip(names, motion.T, strict=True):
        if np.any(direction[3:]):
            twist = 1.0 if assembly.normal is not None or abs(direction[5]) < 0.5 else 2.0
            stiffness = twist * site["tilt_stiffness"]
        else:
            stiffness = shift * (site["vertical_over_horizontal"] if abs(direction[2]) > 0.5 else 1.0)
        assembly.add_spring(assembly.row(name), stiffness, 2 * site["damping_ratio"] * stiffness * period)


def _scaled(parameters: Parameters, s: float) -> dict[str, float]:
    return divided("translation_stiffness", "tilt_stiffness")(parameters, s)


EFFECT = Effect(
    name="base_flexibility",
    says="the foundation tilts and shifts",
    units={
        "translation_stiffness": "N/m",
        "tilt_stiffness": "N·m/rad",
        "damping_ratio": "",
        "vertical_over_horizontal": "",
    },
    places=lambda robot, points: ("base",),
    place_is="the base",
    draw=_draw,
    scaled=_scaled,
    check=positive("translation_stiffness", "tilt_stiffness", "vertical_over_horizontal"),
    shape=base_coordinates,
    act=_act,
)

"""The bearing of a joint gives: what it carries tilts and shifts on springs across the axis, and along it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, damping_time, divided, positive
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import commanded_joints


def turning_joints(robot: Robot, points: Sequence[CampaignPoint]) -> tuple[str, ...]:
    """Flexible joints that turn.

    Args:
        robot: whose.
        points: where motion is measured.
    """
    joints = robot.urdf.joint_by_name
    return tuple(name for name in commanded_joints(robot) if not joints[name].is_prismatic)


def draw_springs(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A tilt two to eight times as stiff as the joint, shifts as of rows on a ring of 5 to 15 cm.

    Args:
        stand: what is looked at.
        where: the joint.
        random: source of numbers.
    """
    tilt = float(random.uniform(2.0, 8.0) * stand.true.stiffness[where])
    radial = tilt / float(random.uniform(0.05, 0.15)) ** 2
    return {
        "tilt_stiffness": tilt,
        "radial_stiffness": radial,
        "axial_stiffness": radial * float(random.uniform(0.5, 2.0)),
        "damping_time": damping_time(random),
    }


def frame(assembly: PlantAssembly, joint: str) -> np.ndarray:
    """Axes in the world, as columns: two across the joint's axis, fixed to the carrying link, and the axis.

    Args:
        assembly: the plant in the making.
        joint: which.
    """
    described, still = assembly.robot.urdf.joint_by_name[joint], link_placements(assembly.robot, {})
    mount = still[described.parent][:3, :3].T @ still[described.child][:3, :3]
    axis = np.asarray(described.axis) / np.linalg.norm(described.axis)
    side = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = side - (side @ axis) * axis
    first /= np.linalg.norm(first)
    local = np.column_stack([first, np.cross(axis, first), axis])
    return np.asarray(assembly.orientation(described.parent) @ mount @ local)


def shape(assembly: PlantAssembly, site: Site) -> None:
    """New coordinates: shifts along the frame's three axes, tilts about the first two; in a plane two shifts.

    Args:
        assembly: the plant in the making.
        site: the joint.
    """
    axes, count = frame(assembly, site.where), 5 if assembly.normal is None else 2
    columns = assembly.add_coordinates([f"{site.where} bearing {k + 1}" for k in range(count)])
    motion = np.zeros((6, 5))
    motion[:3, :3], motion[3:, 3:] = axes, axes[:, :2]
    child = assembly.robot.urdf.joint_by_name[site.where].child
    assembly.add_link_motion(child, columns, motion[:, :count])


def rows(assembly: PlantAssembly, site: Site) -> np.ndarray:
    """Rows of three shifts and two tilts; 0 of those that a chain in a plane cannot make.

    Args:
        assembly: the plant in the making.
        site: the joint.
    """
    found = np.zeros((5, len(assembly.coordinates)))
    for k in range(5 if assembly.normal is None else 2):
        found[k] = assembly.row(f"{site.where} bearing {k + 1}")
    return found


def _act(assembly: PlantAssembly, site: Site) -> None:
    spring = [site["radial_stiffness"]] * 2 + [site["axial_stiffness"]] + [site["tilt_stiffness"]] * 2
    for row, stiffness in zip(rows(assembly, site), spring, strict=True):
        assembly.add_spring(row, stiffness, stiffness * site["damping_time"])


def check(parameters: Parameters) -> str | None:
    """What is wrong with parameters, if anything.

    Args:
        parameters: to check.
    """
    if not 0 <= parameters["damping_time"] <= 0.1:
        return f"damping_time = {parameters['damping_time']:g}, where 0 to 0.1 is allowed"
    return positive(*(name for name in parameters if name.endswith("stiffness")))(parameters)


EFFECT = Effect(
    name="bearing_flexibility",
    says="the bearing of a joint tilts and shifts",
    units={
        "tilt_stiffness": "N·m/rad",
        "radial_stiffness": "N/m",
        "axial_stiffness": "N/m",
        "damping_time": "damping over stiffness, s",
    },
    places=turning_joints,
    place_is="a flexible joint that turns",
    draw=draw_springs,
    scaled=divided("tilt_stiffness", "radial_stiffness", "axial_stiffness"),
    check=check,
    shape=shape,
    act=_act,
)

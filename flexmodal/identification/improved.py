"""The identified robot as a card with its URDF, which loads like any other; never over the old one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from flexmodal.cards import FrozenDict, PointCard, RobotCard
from flexmodal.cards.write import UrdfDraft, write_robot
from flexmodal.errors import Fault, OutputExists
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.model.written import card_of
from flexmodal.structure.arm import Body, bodies_of, moved_bodies
from flexmodal.structure.robot_terms import scaled
from flexmodal.structure.shape import outwards

_NOTHING = Body(0.0, np.zeros(3), np.zeros((3, 3)))


def write_improved(
    robot: Robot,
    values: Mapping[str, float],
    folder: Path,
    *,
    source: str,
    home: Path | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a robot with other numbers.

    Args:
        robot: the one they were found for.
        values: by name, as `robot_space` has them; what is missing stays.
        folder: gets `robot.toml` and the URDF; made if it is not there.
        source: where the numbers come from, for the card.
        home: where the folder will stand in the end, for the addresses of meshes.
        overwrite: replace files that stand there.

    Returns:
        Path of the card.

    Raises:
        OutputExists: a file is there, or the folder is the one that the URDF came from.
        NotWritten: the disk is full, or the folder may not be written.
    """
    refuse_own(robot, folder)
    folder.mkdir(parents=True, exist_ok=True)
    shifts = _shifts(robot, values)
    card = _with_values(card_of(robot, folder, source=source), values, shifts)
    return write_robot(card, _urdf(robot, values, shifts), home=home, overwrite=overwrite)


def refuse_own(robot: Robot, folder: Path) -> None:
    """Complain about a folder that holds the robot's own URDF.

    Args:
        robot: whose URDF it may be.
        folder: of the output.

    Raises:
        OutputExists: it does.
    """
    if robot.urdf.path.parent.resolve() == folder.resolve():
        raise OutputExists(Fault(str(folder), "", "the folder of the card's own URDF", "another folder"))


def _with_values(card: RobotCard, values: Mapping[str, float], shifts: Mapping[str, np.ndarray]) -> RobotCard:
    joints = {
        name: replace(
            joint,
            stiffness=float(values.get(f"stiffness.{name}", joint.stiffness)),
            damping=float(values.get(f"damping.{name}", joint.damping)),
        )
        for name, joint in card.joints.items()
    }
    points = {
        name: PointCard(point.link, _shifted(point.xyz, shifts.get(point.link)))
        for name, point in card.points.items()
    }
    obstacles = {
        name: replace(obstacle, xyz=_shifted(obstacle.xyz, shifts.get(obstacle.link)))
        for name, obstacle in card.obstacles.items()
    }
    return replace(
        card, joints=FrozenDict(joints), points=FrozenDict(points), obstacles=FrozenDict(obstacles)
    )


def _shifted(
    xyz: tuple[float, float, float], shift: Float[np.ndarray, "3"] | None
) -> tuple[float, float, float]:
    """A place in the frame of a link that moves by `shift` [m], in that frame; as it is if it does not."""
    if shift is None:
        return xyz
    x, y, z = (np.array(xyz) - shift).tolist()
    return x, y, z


def _urdf(robot: Robot, values: Mapping[str, float], shifts: Mapping[str, np.ndarray]) -> UrdfDraft:
    """The URDF with new masses and pivots; moments grow with the mass and with the factor of their own."""
    draft = UrdfDraft(robot.urdf)
    old, moved = bodies_of(robot.urdf), moved_bodies(robot)
    bodies = dict(old)
    for link in moved:
        factor = float(values.get(f"mass_centre.{link}", 1.0))
        bodies[link] = scaled(old[link], link, values)
        bodies[link] = replace(bodies[link], centre=bodies[link].centre * factor)
    if load := float(values.get(f"payload.{robot.tool}", 0.0)):
        bodies[robot.tool] = _loaded(bodies.get(robot.tool, _NOTHING), load)
    for link, shift in shifts.items():
        if link in bodies:
            bodies[link] = replace(bodies[link], centre=bodies[link].centre - shift)
        draft.shift_shapes(link, -shift)
        draft.shift_joints(link, -shift)
    for name in robot.joints:
        if out := float(values.get(f"position.{name}", 0.0)):
            draft.change_joint(name, xyz=draft.joints[name].xyz + out * outwards(robot, name))
    for link, body in bodies.items():
        if not _same(body, old.get(link, _NOTHING)):
            draft.set_body(link, float(body.mass), body.centre, body.inertia)
    return draft


def _same(one: Body, other: Body) -> bool:
    kept = np.array_equal(one.centre, other.centre) and np.array_equal(one.inertia, other.inertia)
    return kept and one.mass == other.mass


def _shifts(robot: Robot, values: Mapping[str, float]) -> dict[str, Float[np.ndarray, "3"]]:
    """How far the frame of each link behind a moved pseudo-joint moves, in that frame [m]."""
    placed, found = link_placements(robot, {}), {}
    for name in robot.joints:
        if out := float(values.get(f"position.{name}", 0.0)):
            joint = robot.urdf.joint_by_name[name]
            turn = placed[joint.child][:3, :3].T @ placed[joint.parent][:3, :3]
            found[joint.child] = out * (turn @ outwards(robot, name))
    return found


def _loaded(body: Body, load: float) -> Body:
    """A body with a point mass at the origin of its frame: μ d² about the common centre, μ = m M/(m + M)."""
    mass, away = body.mass + load, body.centre
    reduced = body.mass * load / mass
    more = reduced * (away @ away * np.eye(3) - np.outer(away, away))
    return Body(mass, away * (body.mass / mass), body.inertia + more)

"""A card for any URDF: points, stiffness and damping by rule of thumb, each marked as guessed."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexmodal.cards import (
    FrozenDict,
    JointCard,
    PointCard,
    RobotCard,
    Urdf,
    find,
    find_tool,
    gripper_joints,
    read_urdf,
)
from flexmodal.cards.write import UrdfDraft, write_robot
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.files import whole_folder
from flexmodal.model.load import load
from flexmodal.model.posture import Posture, middle
from flexmodal.model.robot import Robot
from flexmodal.model.written import card_of
from flexmodal.text.words import listing, safe_name

STIFFNESS_PER_TORQUE = 250.0
"""Stiffness of a joint over its largest torque [1/rad]: strain-wave gears of sizes 14 to 32 have some 200 to
350 times their limit for repeated peaks."""

DAMPING_RATIO = 0.03
"""Of each joint by itself; arms in hammer tests show 1 to 6 %."""

TRUST = 1.0
"""Relative standard deviation of what is guessed here: a factor of two or three either way."""

_GRAVITY, _RESERVE = 9.81, 3.0
"""Torque of a joint without a limit of effort: so many times what its arm weighs stretched out."""

_SLIDE = 2e7
"""Stiffness of a prismatic joint [N/m], of the size of a ball screw."""

_BENT = math.radians(30.0)
_MOST_EFFORT = 1e5


@dataclass(frozen=True)
class GuessedCard:
    """A card that was made up, the URDF it is of, and what is to be said about both."""

    card: RobotCard
    urdf: Urdf
    notes: tuple[str, ...]

    def write(self, *, overwrite: bool = False) -> Path:
        """Write card and URDF, both or neither; the path of the card.

        A folder that does not exist yet appears with both of them in it.

        Raises:
            OutputExists: one of them exists.
        """
        folder, draft = self.card.path.parent, UrdfDraft(self.urdf)
        if folder.is_dir():
            return write_robot(self.card, draft, notes=self.notes, overwrite=overwrite)
        folder.parent.mkdir(parents=True, exist_ok=True)
        with whole_folder(folder) as scratch:
            made = replace(self.card, path=scratch / self.card.path.name, urdf=scratch / self.card.urdf.name)
            write_robot(made, draft, notes=self.notes, home=folder)
        return self.card.path


def guess_card(
    reference: str | Path, folder: Path, *, tool: str | None = None, fixed: Sequence[str] = ()
) -> GuessedCard:
    """Make a card for a bare URDF.

    Args:
        reference: path of a URDF, or the name of an example arm.
        folder: where card and URDF are to stand.
        tool: link of the end-effector; found by its name if none is given.
        fixed: joints that stay at 0, such as those of a gripper.

    Raises:
        InvalidRequest: a card already, or an end-effector that cannot be told from other links.
        RobotNotFound, InvalidUrdf: there is no such URDF, or it is not sound.
    """
    path = find(str(reference))
    if path.suffix != ".urdf":
        raise InvalidRequest(
            Fault(str(reference), "", "a robot that has a card", "a URDF, or an example arm")
        )
    urdf = read_urdf(path, fixed=(*gripper_joints(path), *fixed))
    if tool is None:
        found = find_tool(urdf)
        if not found.sure:
            names = listing([found.link, *found.others])
            asked = f"--tool FRAME, one of {names} or another link"
            raise InvalidRequest(Fault(str(path), "tool", "several links that it may be", asked))
        tool = found.link
    robot = load(path, stiffness=1.0, tool=tool, fixed=fixed)
    return GuessedCard(_card(robot, folder, path), urdf, _notes(path))


def _notes(path: Path) -> tuple[str, ...]:
    return (
        f"Made from {path.name}. GUESSED: all stiffness, damping, points and postures; none is measured.",
        f"Stiffness: {STIFFNESS_PER_TORQUE:g} times the effort limit of the URDF, as strain-wave gears have; "
        f"without a limit, of {_RESERVE:g} times the torque that holds the arm stretched out. May be "
        "wrong by a factor of three.",
        f"Damping: {100 * DAMPING_RATIO:g} % of critical for each joint by itself, the others locked.",
        f"scale = {TRUST:g} tells flexmodal identify how little these numbers are to be trusted; take it "
        "away from those that you know.",
        "Points: at the mass centre of each moving link. Put in their place where your hammer hits.",
    )


def _card(robot: Robot, folder: Path, path: Path) -> RobotCard:
    source = (
        f"guessed from {path.name} by rule of thumb: stiffness from the effort limits, damping "
        f"{100 * DAMPING_RATIO:g} % of critical; nothing was measured"
    )
    rest = middle(robot.commanded)
    postures = {"middle": rest.values, "bent": _bent(robot, rest)}
    card = card_of(robot, folder, name=safe_name(robot.name), source=source)
    return replace(
        card,
        title=f"{robot.name} (guessed card)",
        urdf=Path(os.path.abspath(folder)) / f"{safe_name(robot.name)}.urdf",
        joints=FrozenDict(_joints(robot, rest)),
        points=FrozenDict(_points(robot)),
        postures=FrozenDict({name: FrozenDict(values) for name, values in postures.items()}),
    )


def _joints(robot: Robot, rest: Posture) -> dict[str, JointCard]:
    inertia = np.diag(robot.at(rest).system.mass)
    torque = _torques(robot)
    joints = {}
    for place, (name, joint) in enumerate(robot.moving.items()):
        stiffness = _SLIDE if joint.is_prismatic else STIFFNESS_PER_TORQUE * torque[place]
        damping = 2 * DAMPING_RATIO * math.sqrt(stiffness * inertia[place])
        joints[name] = JointCard(_short(stiffness), _short(damping), scale=TRUST)
    return joints


def _torques(robot: Robot) -> np.ndarray:
    """Largest torque of each joint: the limit of its effort, or from the weight that it may carry."""
    limits = np.array(robot.pinocchio.effortLimit, dtype=float)
    return np.array(
        [
            limit if 0 < limit < _MOST_EFFORT else _RESERVE * _weight(robot, joint.child)
            for limit, joint in zip(limits, robot.moving.values(), strict=True)
        ]
    )


def _weight(robot: Robot, link: str) -> float:
    """Torque that holds everything from a link on, stretched out [N·m]; never less than 0.1."""
    joints, total = robot.urdf.joints, 0.0
    stack = [(link, 0.0)]
    while stack:
        name, away = stack.pop()
        body = robot.urdf.link_by_name[name]
        total += _GRAVITY * (body.mass or 0.0) * (away + float(np.linalg.norm(body.com)))
        stack += [(one.child, away + float(np.linalg.norm(one.xyz))) for one in joints if one.parent == name]
    return max(total, 0.1)


def _points(robot: Robot) -> dict[str, PointCard]:
    points = {}
    for joint in robot.moving.values():
        body = robot.urdf.link_by_name[joint.child]
        if body.mass:
            x, y, z = (round(float(value), 4) for value in body.com)
            points[f"on_{safe_name(joint.child)}"] = PointCard(joint.child, (x, y, z))
    return points


def _bent(robot: Robot, rest: Posture) -> dict[str, float]:
    """Every turning joint 30° from the middle, towards where there is room."""
    values = {}
    for name, joint in robot.commanded.items():
        value = rest.values[name]
        if joint.is_prismatic:
            values[name] = value
            continue
        up, down = joint.upper - value, value - joint.lower
        step = min(_BENT, up) if up >= min(_BENT, down) else -min(_BENT, down)
        values[name] = round(value + step, 6) if min(up, down) > 1e-3 else value
    return values


def _short(value: float) -> float:
    """Three digits: more would look as if they were known."""
    return float(f"{value:.3g}")

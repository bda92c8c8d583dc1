"""One robot in one posture: as it stands, how it bends under a force, how its modes swing."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.frf.form import unit
from flexmodal.modal import Modes
from flexmodal.model import PosedRobot, Posture, Robot
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.motion import Deflection, forced, mode_shapes
from flexmodal_viewer.obstacles import LEGEND as OBSTACLES
from flexmodal_viewer.obstacles import obstacles
from flexmodal_viewer.palette import EXTREME, FORCE, PLAIN, POINT, START, shade
from flexmodal_viewer.scene import Caption, Motion, Scene, Swatch, Table
from flexmodal_viewer.stage import set_stage, view_of
from flexmodal_viewer.units import degrees, joint_value, plain, quantity

CLEAR = 0.36
"""Opacity of what is only there to compare with."""
_GHOSTS = (
    Swatch("at rest", START, "clear"),
    Swatch("arm, moving", PLAIN, "own"),
    Swatch("extreme", EXTREME, "clear"),
)


def robot_scene(
    robot: Robot,
    posture: Posture,
    *,
    modes: bool = False,
    response: str | PointDirection | None = None,
    frequency: float | None = None,
) -> Scene:
    """Draw a robot.

    Args:
        robot: what to draw.
        posture: how it stands.
        modes: add a motion for each mode shape.
        response: point and direction of the force; the tool along z if none.
        frequency: add the motion under a harmonic force at this frequency [Hz].

    Raises:
        InvalidPoint, InvalidFrequencies, InvalidPosture: bad arguments.
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    arm = Arm(robot)
    posed = robot.at(posture)
    (direction,) = posed.directions(response) if not isinstance(response, list | tuple) else (None,)
    if direction is None:
        raise InvalidRequest(Fault("call", "response", "several", "one point and direction"))
    motions = _motions(arm, posed, direction, frequency, modes=modes)
    drawn = marks.Drawn(arm.nodes("arm", posture.values), arm.items("arm", lambda own: own), [])
    legend: list[Swatch] = []
    if motions:
        drawn = drawn.beside(_ghosts(arm, posture))
        legend += _GHOSTS
    if frequency is not None or response is not None:
        drawn = drawn.beside(marks.force(direction, posed.position(direction.point), 0.16 * arm.reach))
        kind = "moment" if direction.is_rotation else "force"
        legend.append(Swatch(f"{kind} {direction}", FORCE, "arrow"))
    if robot.points:
        drawn = drawn.beside(marks.points(arm, "arm", 0.012 * arm.reach))
        legend.append(Swatch("measurement points", POINT, "dot"))
    around, hidden = obstacles(arm, "arm")
    drawn = drawn.beside(around)
    legend += [OBSTACLES] if around.items else []
    caption = Caption(
        robot.title or robot.name,
        _subtitle(robot, posture),
        tuple(legend),
        _tables(robot, posture),
        (*arm.looks.notes, *hidden),
    )
    view = view_of(robot, posed.position(robot.tool))
    return set_stage(Scene(caption, view, drawn.nodes, tuple(drawn.items), tuple(drawn.labels), motions))


def _motions(
    arm: Arm, posed: PosedRobot, direction: PointDirection, frequency: float | None, *, modes: bool
) -> tuple[Motion, ...]:
    """Under a force of this frequency, and in each mode."""
    found = []
    if frequency is not None:
        found.append(_forced_motion(arm, forced(posed, direction, frequency), direction, frequency))
    if modes:
        solved = posed.modes()
        shapes = mode_shapes(posed, solved)
        found += [_mode_motion(arm, solved, number, shape) for number, shape in enumerate(shapes)]
    return tuple(found)


def _ghosts(arm: Arm, posture: Posture) -> marks.Drawn:
    still = arm.still_links()
    rest = arm.items("rest", lambda own: shade(START, own), opacity=CLEAR, skip=still)
    extreme = arm.items("extreme", lambda own: shade(EXTREME, own), opacity=CLEAR + 0.1, skip=still)
    nodes = arm.nodes("rest", posture.values) | arm.nodes("extreme", posture.values)
    return marks.Drawn(nodes, rest + extreme, [])


def _subtitle(robot: Robot, posture: Posture) -> str:
    return f"{robot.name}, posture {posture.name}" if posture.name else robot.name


def _tables(robot: Robot, posture: Posture) -> tuple[Table, ...]:
    rows = [
        (name, joint_value(value, slides=robot.moving[name].is_prismatic))
        for name, value in posture.values.items()
    ]
    rows += [(name, "0.0° (pseudo-joint)") for name in robot.pseudo_joints]
    tool = robot.at(posture).position(robot.tool)
    place = [
        (axis, f"{plain(round(float(value), 4) + 0.0)} m") for axis, value in zip("xyz", tool, strict=True)
    ]
    return Table("Posture", (), tuple(rows)), Table("End-effector", (), tuple(place))


def _scaled(arm: Arm, deflection: Deflection) -> tuple[float, dict[str, Any]]:
    """Scale, and what every motion of a single arm has."""
    scale = deflection.scale(arm.reach)
    extreme = arm.nodes("extreme", deflection.values(deflection.extreme, scale))
    return scale, {
        "tracks": deflection.tracks(arm, ("arm",), scale),
        "extreme": deflection.extreme / (2 * np.pi),
        "shows": ("extreme",),
        "poses": extreme,
    }


def _forced_motion(arm: Arm, deflection: Deflection, direction: PointDirection, frequency: float) -> Motion:
    scale, common = _scaled(arm, deflection)
    value = complex(deflection.posed.rows([direction])[0] @ deflection.amplitude)
    over = "N·m" if direction.is_rotation else "N"
    size = unit("receptance", response_rotates=direction.is_rotation, reference_rotates=direction.is_rotation)
    rows = (
        ("force", f"{direction}"),
        ("frequency", f"{plain(frequency)} Hz"),
        (
            "receptance |α|",
            quantity(abs(value), size),
        ),
        ("phase", degrees(float(np.angle(value)), 1)),
        ("tool, farthest", quantity(deflection.farthest(), "m") + f" per {over}"),
        ("drawn larger by", f"× {plain(scale)}"),
    )
    notes = () if np.any(deflection.amplitude) else ("This force moves nothing in this posture.",)
    return Motion(
        f"{plain(frequency)} Hz",
        legend=(),
        table=Table("Deflection under a harmonic force", (), rows),
        notes=(
            *notes,
            f"Drawn as for a force of {plain(scale)} {over}; the vibration itself is slowed down.",
        ),
        **common,
    )


def _mode_motion(arm: Arm, modes: Modes, number: int, deflection: Deflection) -> Motion:
    _, common = _scaled(arm, deflection)
    frequency, ratio = (
        plain(float(modes.frequency[number])),
        plain(100 * float(modes.damping_ratio[number]), 3),
    )
    rows = [("natural frequency", f"{frequency} Hz"), ("damping ratio", f"{ratio} %")]
    rows += [
        (f"share of {name}", f"{abs(value):.2f} at {degrees(float(np.angle(value)), 0)}")
        for name, value in zip(arm.robot.joints, deflection.amplitude, strict=True)
    ]
    notes = ["A mode has a shape and no size: it is drawn as large as can be seen well."]
    if modes.overdamped[number]:
        notes.append("Overdamped: it creeps back without swinging; the swing only shows the shape.")
    table = Table(f"Mode {number + 1}", (), tuple(rows))
    name = f"{number + 1}: {frequency} Hz, {ratio} %"
    return Motion(name, table=table, notes=tuple(notes), **common)

"""What is held, as options of several commands."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from flexmodal.cli.options import SOURCE, Command, number
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.model import Robot
    from flexmodal.optimisation import Hold

_OPTIONS = (
    click.option(
        "--orientation",
        metavar="ROLL,PITCH,YAW|ANGLE",
        help="Hold the tool's orientation too: about x, y, z of the world; the tool's angle in a plane.",
    ),
    click.option(
        "--axis", metavar="X,Y,Z", help="Hold the tool's axis along this direction, free to turn about it."
    ),
    click.option(
        "--tool-axis", metavar="AXIS", default="", help="Which: x, y, z, -x, …; z, or x in a plane, if none."
    ),
)


def orientation_options(command: Command) -> Command:
    """How the tool is turned."""
    for decorate in reversed(_OPTIONS):
        command = decorate(command)
    return command


def hold_of(
    arm: Robot, target: str | None, orientation: str | None, axis: str | None, tool_axis: str
) -> Hold | None:
    """The hold that `--hold` and the options of `orientation_options` describe.

    Args:
        arm: the robot.
        target: text of --hold, coordinates of the place [m]; None where nothing is held.
        orientation: text of --orientation; None if not given.
        axis: text of --axis, a direction of the world; None if not given.
        tool_axis: text of --tool-axis; empty if not given.
    """
    if target is None:
        given = {"--orientation": orientation, "--axis": axis, "--tool-axis": tool_axis or None}
        alone = [name for name, text in given.items() if text is not None]
        if alone:
            raise InvalidRequest(Fault(SOURCE, " and ".join(alone), "given without --hold", "--hold X,Y,Z"))
        return None
    what = "coordinates X,Z or X,Y,Z [m]"
    place = tuple(number(part, "--hold", what) for part in target.split(","))
    return at(arm, place, orientation, axis, tool_axis)


def at(
    arm: Robot, place: tuple[float, ...], orientation: str | None, axis: str | None, tool_axis: str
) -> Hold:
    """A hold at a place, turned as the texts of the options say.

    Args:
        arm: the robot.
        place: X, Z or X, Y, Z of the tool in the world [m].
        orientation: text of --orientation; None if not given.
        axis: text of --axis, a direction of the world; None if not given.
        tool_axis: text of --tool-axis; empty if not given.
    """
    from flexmodal.optimisation import Hold

    return Hold.at(
        arm,
        place,
        orientation=None if orientation is None else [_angle(part) for part in orientation.split(",")],
        axis=None if axis is None else [number(part, "--axis", "a component") for part in axis.split(",")],
        tool_axis=tool_axis,
    )


def _angle(text: str) -> float:
    """Read an angle in rad, or in degrees if it says deg."""
    value = number(text.removesuffix("deg"), "--orientation", "an angle in rad, or like 50deg")
    return math.radians(value) if text.endswith("deg") else value

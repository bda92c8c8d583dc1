"""What several commands take: the robot, its flexibility, a posture, frequencies; and how they are read."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidFrequencies, InvalidPosture, InvalidRequest

if TYPE_CHECKING:
    import numpy as np

    from flexmodal.frf import PointDirection
    from flexmodal.model import PosedRobot, Posture, Robot

SOURCE = "command line"

SMALLEST, LARGEST = 1e-100, 1e100
"""Sizes between which a number is taken: beyond them its square or cube is no finite number."""

_LEAST_HERTZ = 1e-9
MOST_STARTS = 100_000
"""Of a search: more is a slip of the keyboard."""

Command = TypeVar("Command", bound=Callable[..., Any])


@dataclass(frozen=True)
class RobotOptions:
    """ROBOT and what a bare URDF needs beside it, as they were given."""

    robot: str
    stiffness: str | None
    damping: str | None
    tool: str | None
    fix: str | None

    def load(self) -> Robot:
        """The robot they describe; of a folder that `identify`, `diagnose` or `rig` wrote, the one in it."""
        from flexmodal.model import load

        inside = Path(self.robot) / "robot" / "robot.toml"
        with suppress(OSError):  # a name too long to be one
            if inside.is_file():
                return replace(self, robot=str(inside)).load()
        self._say_tool()
        return load(
            self.robot,
            stiffness=per_joint(self.stiffness, "--stiffness"),
            damping=per_joint(self.damping, "--damping"),
            tool=self.tool,
            fixed=[name.strip() for name in self.fix.split(",")] if self.fix else (),
        )

    def _say_tool(self) -> None:
        """Say which link of a bare URDF is taken for the end-effector where others may be meant."""
        from flexmodal.cards import find, find_tool, gripper_joints, read_urdf

        path = find(self.robot)
        if self.tool is not None or path.suffix != ".urdf":
            return
        fixed = [name.strip() for name in self.fix.split(",")] if self.fix else []
        found = find_tool(read_urdf(path, fixed=(*gripper_joints(path), *fixed)))
        if not found.sure:
            others = f"--tool FRAME names another: {', '.join(found.others)}"
            say(f"note: the end-effector is {found.link}, {found.how}; {others}", err=True)


def robot_options(command: Command) -> Command:
    """ROBOT and what a bare URDF needs beside it, given to the command as one `RobotOptions`."""

    @wraps(command)
    def gathered(**given: Any) -> Any:
        own = {field.name: given.pop(field.name) for field in fields(RobotOptions)}
        return command(robot=RobotOptions(**own), **given)

    wrapped: Any = gathered
    for decorate in (
        click.option(
            "--fix", metavar="JOINT,…", help="For a bare URDF: joints that stay at 0, as a gripper's."
        ),
        click.option(
            "--tool",
            metavar="FRAME",
            help="URDF link that is the end-effector, called tool everywhere; that of the card, or found.",
        ),
        click.option(
            "--damping", metavar="VALUE", help="For a bare URDF: one number or joint=number,… [N·m·s/rad]."
        ),
        click.option(
            "--stiffness", metavar="VALUE", help="For a bare URDF: one number or joint=number,… [N·m/rad]."
        ),
        click.argument("robot"),
    ):
        wrapped = decorate(wrapped)
    return wrapped


json_option = click.option("--json", "as_json", is_flag=True, help="One JSON object on standard output.")
force_option = click.option("--force", is_flag=True, help="Replace the output file if it exists.")
quiet_option = click.option("--quiet", is_flag=True, help="No progress bar.")
trust_option = click.option(
    "--trust",
    multiple=True,
    metavar="GROUP=FACTOR",
    help="How far the card may be off: relative standard deviation of a kind (mass=0.1) or of a parameter "
    "(mass.link_2=0.1); may be repeated.",
)
poor_option = click.option(
    "--poor-card",
    is_flag=True,
    help="Little is known: stiffness and damping within a decade, masses within 40 %; --trust goes before.",
)


class _PostureText(click.types.StringParamType):
    """A text; where it is missing, what it may be."""

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None) -> str:
        return "A named posture, which flexmodal robots lists for each card, or values: q1=50deg,q2=-0.8"


posture_option = click.option(
    "--posture",
    type=_PostureText(),
    required=True,
    metavar="POSTURE",
    help="A named posture, or q1=50deg,q2=-0.8.",
)


def per_joint(text: str | None, option: str) -> float | dict[str, float] | None:
    """Read "5e5" or "q1=5e5,q2=2e4".

    Args:
        text: what was given, if anything.
        option: whose value it is, for the error.
    """
    if text is None:
        return None
    if "=" not in text:
        return number(text, option)
    return {name: number(value, f"{option} {name}") for name, value in _pairs(text, option).items()}


def trust_of(texts: Sequence[str]) -> dict[str, float]:
    """Read every "mass=0.1" of `trust_option`; several may stand in one text, separated by commas."""
    found: dict[str, float] = {}
    for part in (part.strip() for text in texts for part in text.split(",")):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not name:
            raise InvalidRequest(Fault(SOURCE, "--trust", repr(part), "GROUP=FACTOR, such as mass=0.1"))
        found[name] = number(value, f"--trust {name}", "a relative standard deviation")
    return found


def number(text: str, key: str, what: str = "a number") -> float:
    """A finite number whose square and cube are finite too, or InvalidRequest.

    Args:
        text: what was given.
        key: whose value it is, for the error.
        what: what may stand there, for the error.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if value != 0 and not SMALLEST <= abs(value) <= LARGEST:
        allowed = f"{what}, finite, 0 or of a size from {SMALLEST:g} to {LARGEST:g}"
        raise InvalidRequest(Fault(SOURCE, key, repr(text), allowed))
    return value


def hertz(ctx: click.Context, param: click.Parameter, text: str | None) -> float | None:
    """Callback of an option, a frequency whose sign is still to be judged; see click for the arguments."""
    return None if text is None else number(text, "--frequency", "a frequency in Hz")


def _pairs(text: str, key: str) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not name or not value:
            raise InvalidRequest(Fault(SOURCE, key, repr(part), "name=value, separated by commas"))
        if name in pairs:
            raise InvalidRequest(Fault(SOURCE, key, f"{name} twice", "each joint once"))
        pairs[name] = value
    return pairs


def posture_of(robot: Robot, text: str, option: str = "--posture") -> Posture:
    """Read a posture's name or "q1=50deg,q2=-0.8".

    Args:
        robot: whose posture.
        text: what was given.
        option: whose value it is, for the error.
    """
    if "=" not in text:
        return robot.posture(text, source=f"{SOURCE} {option}")
    values: dict[str, float] = {}
    faults = []
    degrees = set()
    for name, value in _pairs(text, option).items():
        if value.endswith("deg"):
            degrees.add(name)
        try:
            plain = float(value.removesuffix("deg"))
        except ValueError:
            faults.append(Fault(f"{SOURCE} {option}", name, repr(value), "a number in rad, or like 50deg"))
            continue
        values[name] = math.radians(plain) if name in degrees else plain
    if faults:
        raise InvalidPosture(faults)
    return replace(robot.posture(values, source=f"{SOURCE} {option}"), degrees=frozenset(degrees))


def is_typed_in_radians(text: str | None) -> bool:
    """Whether a posture was typed as values and none of them in degrees: answers are given likewise."""
    return text is not None and "=" in text and "deg" not in text


def say_motionless(posed: PosedRobot, directions: Sequence[str | PointDirection]) -> None:
    """Say of which directions the answer is zero because the arm cannot move that way.

    Args:
        posed: the robot in its posture.
        directions: of an answer.
    """
    still = posed.motionless(posed.directions(directions or None))
    if not still:
        return
    why = "a planar arm moves in its plane only" if posed.robot.is_planar else "in this posture"
    names = ", ".join(dict.fromkeys(map(str, still)))
    say(f"note: no flexible joint moves {names} ({why}): the receptance there is zero", err=True)


def frequencies_of(text: str) -> np.ndarray:
    """Read "1:200:0.25" (both ends included), "5" or "1,5,20" [Hz]."""
    from flexmodal.frf.axis import frequency_axis, stepped_axis

    source = f"{SOURCE} --frequencies"
    try:
        if ":" in text:
            start, stop, step = (float(part) for part in text.split(":"))
        else:
            values = [float(part) for part in text.split(",") if part.strip()]
    except ValueError:
        allowed = "START:STOP:STEP, or frequencies separated by commas [Hz]"
        raise InvalidFrequencies(Fault(source, "", repr(text), allowed)) from None
    if ":" in text:
        return stepped_axis(start, stop, step, source=source)
    return frequency_axis(values, source=source)


def band_of(text: str) -> tuple[float, float]:
    """Read "LOW:HIGH" [Hz]."""
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low, high = math.nan, math.nan
    if not (0 <= low < high and _LEAST_HERTZ <= high <= LARGEST):
        allowed = f"LOW:HIGH in Hz, 0 ≤ LOW < HIGH, HIGH from {_LEAST_HERTZ:g}"
        raise InvalidRequest(Fault(SOURCE, "--band", repr(text), allowed))
    return low, high


def refuse_existing(
    out: Path | None, force: bool, endings: tuple[str, ...], *, option: str = "--out"
) -> None:
    """Complain about an output file before the work starts, not after.

    Args:
        out: the file, if one was asked for.
        force: whether it may be replaced.
        endings: those allowed.
        option: which option named it, for the error.
    """
    from flexmodal.errors import OutputExists

    if out is None:
        return
    if out.suffix.lower() not in endings:
        raise InvalidRequest(Fault(SOURCE, option, repr(str(out)), f"a file ending in {', '.join(endings)}"))
    if out.is_dir():
        raise OutputExists(Fault(str(out), "", "a folder", "the name of a file"))
    if out.exists() and not force:
        raise OutputExists(Fault(str(out), "", "an existing file", "a new name, or --force"))
    if not out.parent.is_dir():
        raise OutputExists(Fault(str(out), "", "no such folder", "a file in an existing folder"))

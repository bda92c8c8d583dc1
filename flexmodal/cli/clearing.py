"""What the arm keeps away from, as options of several commands, and what is said about it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import SOURCE, Command, number
from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.model import Robot
    from flexmodal.optimisation import Clearance

_OPTIONS = (
    click.option(
        "--clearance",
        metavar="METRES",
        help="Keep so far from obstacles of the card and from itself; 0.01 where the card has obstacles.",
    ),
    click.option("--no-collisions", is_flag=True, help="Check none, whatever the card has."),
)


def clearance_options(command: Command) -> Command:
    """`--clearance` and `--no-collisions`."""
    for decorate in reversed(_OPTIONS):
        command = decorate(command)
    return command


def clearance_of(arm: Robot, clearance: str | None, no_collisions: bool) -> Clearance | None:
    """The clearance that the options of `clearance_options` ask for, or that the card does.

    Args:
        arm: the robot, whose card may have obstacles.
        clearance: text of --clearance [m]; None where it is not given.
        no_collisions: whether nothing is to be checked.
    """
    from flexmodal.optimisation import Clearance
    from flexmodal.optimisation.clearance import DISTANCE

    if no_collisions:
        if clearance is not None:
            raise InvalidRequest(Fault(SOURCE, "--clearance", "with --no-collisions", "one of them"))
        return None
    if clearance is None and not arm.obstacles and arm.srdf is None:
        return None
    distance = DISTANCE if clearance is None else number(clearance, "--clearance", "a distance in m")
    return Clearance.of(arm, distance)


def clearance_json(kept: Clearance | None, nearest: tuple[float, tuple[str, str]] | None) -> dict[str, Any]:
    """What was checked, and what came nearest [m].

    Args:
        kept: what was kept clear of; None where nothing was checked.
        nearest: how near anything came [m], and what to what; None where nothing was checked.
    """
    if kept is None or nearest is None:
        return {"checked": False}
    return {
        "checked": True,
        "asked": kept.distance,
        "distance": nearest[0],
        "between": list(nearest[1]),
        "pairs": len(kept.scene.pairs),
        "left_out": [list(pair) for pair in kept.scene.left_out],
    }


def say_clearance(kept: Clearance | None, nearest: tuple[float, tuple[str, str]] | None) -> None:
    """Say what was checked, or that nothing was.

    Args:
        kept: what was kept clear of; None where nothing was checked.
        nearest: how near anything came [m], and what to what; None where nothing was checked.
    """
    if kept is None or nearest is None:
        say("collisions: none checked; obstacles go into the card, --clearance METRES asks for a distance")
        return
    distance, (one, other) = nearest
    around = f"{', '.join(kept.scene.obstacles)} and itself" if kept.scene.obstacles else "itself"
    said = f"collisions: {len(kept.scene.pairs)} pairs checked against {around}"
    say(f"{said}; nearest {one} to {other}, {1e3 * distance:.1f} mm ({1e3 * kept.distance:g} mm asked)")
    if kept.scene.left_out:
        pairs = "; ".join(f"{a} and {b}" for a, b in kept.scene.left_out)
        say(f"collisions: left out, as near as that in nearly every posture: {pairs}")

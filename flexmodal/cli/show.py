"""`flexmodal show`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.measured import campaign_at, card_of, of_postures, refuse_export
from flexmodal.cli.options import (
    SOURCE,
    RobotOptions,
    force_option,
    hertz,
    posture_of,
    refuse_existing,
    robot_options,
)
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.campaign import Campaign
    from flexmodal.ema.shapes import FittedShapes
    from flexmodal.model import Posture, Robot

_MOST_CARDS = 3
"""Curves that a reader can tell apart beside the arm's own and the measured ones."""


@click.command()
@robot_options
@click.option("--posture", metavar="POSTURE", help="A named posture or q1=50deg,…; the card's first if none.")
@click.option("--modes", is_flag=True, help="Animate the mode shapes.")
@click.option("--response", metavar="POINT:AXIS", help="Point and direction of the force, tool:+z if none.")
@click.option("--frequency", callback=hertz, metavar="HZ", help="Animate the deflection at this frequency.")
@click.option("--workspace", is_flag=True, help="Open with a map of the receptance over all places.")
@click.option(
    "--campaign",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Show how the robot was tested, and the shapes of the modes fitted to that.",
)
@click.option(
    "--compare",
    multiple=True,
    metavar="OTHER",
    help="Another card, or a campaign with FRFs, on the same axes; may be repeated.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Write one self-contained page instead (.html), a picture (.png) or a film (.gif, .mp4).",
)
@click.option("--port", type=click.IntRange(0, 65535), help="Port on 127.0.0.1; a free one if none.")
@click.option("--host", metavar="ADDRESS", help="Another address of this computer; others can reach it.")
@force_option
def show(
    robot: RobotOptions,
    posture: str | None,
    modes: bool,
    response: str | None,
    frequency: float | None,
    workspace: bool,
    campaign: Path | None,
    compare: tuple[str, ...],
    out: Path | None,
    port: int | None,
    host: str | None,
    force: bool,
) -> None:
    """Show the robot, its modes or its deflection in the browser, or write it as a page.

    ROBOT may also be the folder of a campaign, which says itself what robot it is of.
    """
    from flexmodal.campaign import is_campaign
    from flexmodal.cli.viewing import PAGES, announce, viewer

    refuse_existing(out, force, PAGES)
    deliver: dict[str, Any] = {"out": out, "port": port, "overwrite": force}
    deliver["announce"] = announce
    if host is not None:
        deliver["host"] = host
    if campaign is not None or is_campaign(robot.robot):
        given = {"modes": modes, "response": response, "frequency": frequency}
        _refuse_beside(**given, workspace=workspace, compare=compare)
        measured = _campaign(Path(robot.robot) if campaign is None else campaign, posture)
        refuse_export(measured)
        arm = (robot if campaign is not None else replace(robot, robot=card_of(measured))).load()
        viewer("show_campaign")(arm, measured, shapes=_shapes(measured), **deliver)
        return
    arm = robot.load()
    where = _first_posture(arm) if posture is None else posture_of(arm, posture)
    beside = _compared(robot, compare)
    swing = {"modes": modes, "response": response, "frequency": frequency}
    viewer("show_robot")(arm, where, workspace=workspace, **swing, **beside, **deliver)


def _compared(robot: RobotOptions, given: tuple[str, ...]) -> dict[str, Any]:
    """Models by name, and at most one campaign, to stand on the same axes."""
    from flexmodal.campaign import is_campaign

    folders = [one for one in given if is_campaign(one)]
    cards = [one for one in given if one not in folders]
    faults = [
        Fault(SOURCE, "--compare", repr(one), "one campaign; each other that is compared is a card")
        for one in folders[1:]
    ]
    if len(cards) > _MOST_CARDS:
        faults.append(Fault(SOURCE, "--compare", f"{len(cards)} cards", f"at most {_MOST_CARDS}"))
    if faults:
        raise InvalidRequest(faults)
    others: dict[str, Any] = {}
    for one in cards:
        other = replace(robot, robot=one).load()
        name = other.name if other.name not in others else one
        others[name] = other
    return {"others": others, "measured": campaign_at(folders[0]) if folders else None}


def _first_posture(arm: Robot) -> Posture:
    """The card's first; of a robot without one, as near to 0 as the limits of its joints allow."""
    from flexmodal.model.posture import middle

    return arm.posture(next(iter(arm.postures))) if arm.postures else middle(arm.commanded)


def _refuse_beside(**given: object) -> None:
    faults = [
        Fault(SOURCE, f"--{name}", "given", "nothing beside a campaign, whose postures and shapes are shown")
        for name, value in given.items()
        if value
    ]
    if faults:
        raise InvalidRequest(faults)


def _campaign(folder: Path, posture: str | None) -> Campaign:
    """The campaign, or one posture of it by name or number."""
    measured = campaign_at(folder)
    return measured if posture is None else of_postures(measured, [posture])


def _shapes(measured: Campaign) -> tuple[FittedShapes, ...]:
    """Shapes of the modes that a fit of each posture finds by itself; none without FRFs."""
    from flexmodal.ema import Choices, fit
    from flexmodal.ema.shapes import fitted_shapes

    if measured.frfs is None and not measured.blows:
        return ()
    return fitted_shapes(fit(measured, per="posture", choices=Choices(vary=False)))

"""`flexmodal campaign new`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import click

from flexmodal.cli.options import RobotOptions, force_option, robot_options
from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidRequest

Thing = TypeVar("Thing")


@click.group()
def campaign() -> None:
    """Write a campaign folder to fill in."""


@campaign.command()
@robot_options
@click.option(
    "--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="A new folder for it."
)
@click.option("--title", metavar="TEXT", help="Of the test.")
@click.option("--points", metavar="NAME,…", help="Points of the card; all of them if none.")
@click.option("--postures", metavar="NAME,…", help="Postures of the card; all of them if none.")
@force_option
def new(
    robot: RobotOptions,
    out: Path,
    title: str | None,
    points: str | None,
    postures: str | None,
    force: bool,
) -> None:
    """A campaign.toml with the robot's postures and points, every line explained; data go beside it."""
    from flexmodal.campaign.new import new_campaign_toml
    from flexmodal.files import whole_folder

    arm = robot.load()
    q = _chosen(arm.postures, postures, "--postures") or {"zero": {name: 0.0 for name in arm.commanded}}
    places = _chosen(arm.points, points, "--points")
    if not places:
        found = f"{arm.name}, whose card has no points"
        raise InvalidRequest(Fault("command line", "ROBOT", found, "a card with points; card new writes one"))
    text = new_campaign_toml(
        title or f"{arm.title}: hammer test",
        robot.robot if not Path(robot.robot).exists() else str(Path(robot.robot).resolve()),
        {name: {joint: values.get(joint, 0.0) for joint in arm.commanded} for name, values in q.items()},
        {name: (point.link, point.xyz) for name, point in places.items()},
    )
    with whole_folder(out, own=("campaign.toml",), overwrite=force) as scratch:
        (scratch / "campaign.toml").write_text(text, encoding="utf-8")
    say(f"wrote {out / 'campaign.toml'}: {len(q)} postures, {len(places)} points; fill it in, put frf.uff or")
    say("time.uff beside it, or a table with a map: flexmodal import TABLE --draft map.toml")


def _chosen(given: Mapping[str, Thing], names: str | None, option: str) -> dict[str, Thing]:
    """Those asked for, in that order."""
    if names is None:
        return dict(given)
    wanted = [name.strip() for name in names.split(",") if name.strip()]
    faults = [
        Fault("command line", option, repr(name), f"one of {', '.join(given)}")
        for name in wanted
        if name not in given
    ]
    if faults:
        raise InvalidRequest(faults)
    return {name: given[name] for name in wanted}

"""`flexmodal show`."""

from __future__ import annotations

from pathlib import Path

import click

from flexmodal.cli.options import force_option, hertz, load_robot, posture_of, refuse_existing, robot_options


@click.command()
@robot_options
@click.option("--posture", metavar="POSTURE", help="A named posture or q1=50deg,…; the card's first if none.")
@click.option("--modes", is_flag=True, help="Animate the mode shapes.")
@click.option("--response", metavar="POINT:AXIS", help="Point and direction of the force, tool:+z if none.")
@click.option("--frequency", callback=hertz, metavar="HZ", help="Animate the deflection at this frequency.")
@click.option("--out", type=click.Path(path_type=Path), help="Write one self-contained page instead.")
@click.option("--port", type=click.IntRange(0, 65535), help="Port on 127.0.0.1; a free one if none.")
@force_option
def show(
    robot: str,
    stiffness: str | None,
    damping: str | None,
    tool: str | None,
    fix: str | None,
    posture: str | None,
    modes: bool,
    response: str | None,
    frequency: float | None,
    out: Path | None,
    port: int | None,
    force: bool,
) -> None:
    """Show the robot, its modes or its deflection in the browser, or write it as a page."""
    from flexmodal.cli.viewing import viewer

    refuse_existing(out, force, (".html",))
    arm = load_robot(robot, stiffness, damping, tool, fix)
    where = arm.posture(next(iter(arm.postures), {})) if posture is None else posture_of(arm, posture)
    viewer("show_robot")(
        arm,
        where,
        modes=modes,
        response=response,
        frequency=frequency,
        out=out,
        port=port,
        overwrite=force,
        announce=lambda text: click.echo(text, err=True),
    )

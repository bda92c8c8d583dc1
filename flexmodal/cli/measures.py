"""`flexmodal measures`."""

from __future__ import annotations

import click

from flexmodal.cli.options import (
    RobotOptions,
    hertz,
    json_option,
    posture_of,
    posture_option,
    robot_options,
    say_motionless,
)
from flexmodal.cli.printing import print_json, print_table


@click.command()
@robot_options
@posture_option
@click.option("--direction", metavar="POINT:AXIS", help="Such as tool:+z (the default).")
@click.option("--frequency", callback=hertz, metavar="HZ", help="For the dynamic receptance.")
@click.option(
    "--task",
    type=click.Choice(["full", "position"]),
    default="full",
    show_default=True,
    help="Whether the stiffness measure holds the rotations too.",
)
@json_option
def measures(
    robot: RobotOptions,
    posture: str,
    direction: str | None,
    frequency: float | None,
    task: str,
    as_json: bool,
) -> None:
    """Stiffness, mobility, static and dynamic receptance along one direction."""
    from flexmodal.frf import PointDirection

    arm = robot.load()
    where = posture_of(arm, posture)
    found = arm.measures(where, direction=direction, frequency=frequency, task=task)
    say_motionless(arm.at(where), [] if direction is None else [direction])
    dynamic = found.receptance
    if as_json:
        print_json(
            {
                "stiffness": found.stiffness,
                "mobility": found.mobility,
                "static_receptance": found.static_receptance,
                "receptance": None if dynamic is None else [dynamic.real, dynamic.imag],
                "tool": list(found.tool),
            }
        )
        return
    turning = direction is not None and PointDirection.parse(direction).is_rotation
    units = ("N·m/rad", "rad²/rad²", "rad/(N·m)") if turning else ("N/m", "m²/rad²", "m/N")
    rows = [
        ["stiffness measure", f"{found.stiffness:.5g}", units[0]],
        ["mobility measure", f"{found.mobility:.5g}", units[1]],
        ["static receptance", f"{found.static_receptance:.5g}", units[2]],
    ]
    if dynamic is not None:
        rows.append([f"|receptance| at {found.frequency:g} Hz", f"{abs(dynamic):.5g}", units[2]])
    rows.append([f"{arm.tool} at", "  ".join(f"{value:.4f}" for value in found.tool), "m"])
    print_table(f"{arm.name} at {where}, {direction or arm.tool + ':+z'}", ["measure", "value", "unit"], rows)

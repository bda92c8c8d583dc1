"""`flexmodal robots`."""

from __future__ import annotations

import click

from flexmodal.cli.options import json_option
from flexmodal.cli.printing import print_json, print_table, say


@click.command()
@json_option
def robots(as_json: bool) -> None:
    """List the cards that ship, with their joints, points and postures."""
    from flexmodal.cards import example_arms
    from flexmodal.model import robots as shipped_robots

    loaded = shipped_robots()
    if as_json:
        listed = [
            {
                "name": robot.name,
                "title": robot.title,
                "joints": list(robot.moving),
                "pseudo_joints": list(robot.pseudo_joints),
                "points": list(robot.points),
                "postures": list(robot.postures),
                "families": list(robot.families),
                "tool": robot.tool,
            }
            for robot in loaded
        ]
        print_json({"robots": listed})
        return
    rows = [
        [
            robot.name,
            " ".join(f"({name})" if name in robot.pseudo_joints else name for name in robot.moving),
            str(len(robot.points)),
            str(len(robot.postures)),
            ", ".join(robot.families) or "–",
            robot.tool,
        ]
        for robot in loaded
    ]
    columns = ["card", "joints, (pseudo-joints)", "points", "postures", "families", "tool"]
    print_table("Cards", columns, rows)
    for robot in loaded:
        say(f"{robot.name}: {robot.title}")
        say(f"  points    {', '.join(robot.points) or '–'}")
        say(f"  postures  {', '.join(robot.postures) or '–'}")
    arms = example_arms()
    if arms:
        say(f"\nExample arms (bare URDFs, give --stiffness and --damping): {', '.join(arms)}")
    else:
        say("\nMore arms by name, as bare URDFs: pip install 'flexmodal[arms]'")

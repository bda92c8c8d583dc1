"""`flexmodal card new`."""

from __future__ import annotations

from pathlib import Path

import click

from flexmodal.cli.options import force_option, json_option
from flexmodal.cli.printing import print_json, print_table, say


@click.group()
def card() -> None:
    """Write a robot card."""


@card.command()
@click.argument("arm")
@click.option(
    "--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="Folder of card and URDF."
)
@click.option(
    "--tool", metavar="FRAME", help="URDF link that is the end-effector; found by its name if none."
)
@click.option("--fix", metavar="JOINT,…", help="Joints that stay at 0, as a gripper's.")
@force_option
@json_option
def new(arm: str, out: Path, tool: str | None, fix: str | None, force: bool, as_json: bool) -> None:
    """Write a card for a bare URDF, its stiffness, damping and points guessed by rule of thumb.

    ARM is a path to a .urdf or the name of an example arm. The card says of each number that it is guessed.
    """
    from flexmodal.model.guess import guess_card

    fixed = [name.strip() for name in fix.split(",")] if fix else []
    guessed = guess_card(arm, out, tool=tool, fixed=fixed)
    path = guessed.write(overwrite=force)
    joints = guessed.card.joints
    if as_json:
        print_json(
            {
                "card": str(path),
                "urdf": str(guessed.card.urdf),
                "tool": guessed.card.tool,
                "guessed": True,
                "joints": {
                    name: {"stiffness": joint.stiffness, "damping": joint.damping}
                    for name, joint in joints.items()
                },
                "points": list(guessed.card.points),
                "postures": list(guessed.card.postures),
            }
        )
        return
    rows = [[name, f"{joint.stiffness:g}", f"{joint.damping:g}"] for name, joint in joints.items()]
    columns = ["joint", "stiffness, guessed [N·m/rad]", "damping, guessed [N·m·s/rad]"]
    print_table(f"{path}: {guessed.card.title}", columns, rows)
    say(f"end-effector {guessed.card.tool}; points {', '.join(guessed.card.points)}")
    say(f"next: flexmodal modes {out} --posture middle")

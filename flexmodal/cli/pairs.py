"""Options of commands whose answer is between points and directions: frf and export."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])


def pair_options(command: Command) -> Command:
    """`--response`, `--reference` and `--form`, given to the command as `response`, `reference`, `form`."""
    wrapped: Any = command
    for decorate in (
        click.option(
            "--form",
            type=click.Choice(["receptance", "mobility", "inertance"]),
            default="receptance",
            show_default=True,
            help="Displacement, velocity or acceleration over force.",
        ),
        click.option(
            "--reference", multiple=True, metavar="POINT:AXIS", help="Of the force; as --response if none."
        ),
        click.option(
            "--response",
            multiple=True,
            metavar="POINT:AXIS",
            help="Such as tool:+z, the default; may be repeated.",
        ),
    ):
        wrapped = decorate(wrapped)
    return wrapped

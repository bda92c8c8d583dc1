"""How wide what a command prints may be."""

from __future__ import annotations

import os
import shutil
import sys

import click

WIDTH = "flexmodal.width"
"""Where a command's context keeps what `--width` said."""

NARROWEST, WIDEST = 40, 1000
"""Columns that `--width` may ask for."""

_OFF_TERMINAL = 200


def width_asked() -> int | None:
    """What `--width` says, if anything."""
    context = click.get_current_context(silent=True)
    asked = None if context is None else context.find_root().meta.get(WIDTH)
    return None if asked is None else int(asked)


def width_of_output() -> int:
    """Columns there are: of `--width`, else of COLUMNS, else of the terminal; 200 where there is none."""
    asked = width_asked()
    if asked is not None:
        return asked
    named = os.environ.get("COLUMNS", "")
    if named.isdigit() and len(named) < 6:
        return max(NARROWEST, int(named))
    if sys.stdout.isatty():
        return max(NARROWEST, shutil.get_terminal_size((80, 24)).columns)
    return _OFF_TERMINAL

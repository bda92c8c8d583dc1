"""Results on standard output: one JSON object, or tables for people."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any
from unicodedata import category

import click

from flexmodal.errors import FlexmodalError

_STAGE = "{desc}{percentage:3.0f} % {bar} {elapsed}, {remaining} left"


def print_json(result: dict[str, Any]) -> None:
    """One JSON object in ASCII, refusing NaN and infinity rather than writing what no reader accepts."""
    try:
        text = json.dumps(result, allow_nan=False)
    except ValueError:
        raise FlexmodalError("the result is not finite: its numbers are too large or too small") from None
    click.echo(text)


def say(text: str = "", *, err: bool = False) -> None:
    """Print a text, without what would steer the terminal: names and titles come from other people's files.

    Args:
        text: may have several lines.
        err: on standard error.
    """
    click.echo(plain(text), err=err)


def plain(text: str) -> str:
    """A text whose control characters are ?, but for the ends of its lines."""
    return "".join(sign if sign in "\n\t" or category(sign)[0] != "C" else "?" for sign in text)


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A table, its numbers aligned right.

    Args:
        title: above the table.
        columns: their headings.
        rows: cells as texts.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(plain(title)), title_justify="left", box=box.SIMPLE_HEAD)
    for place, column in enumerate(columns):
        table.add_column(Text(plain(column)), justify="left" if place == 0 else "right")
    for row in rows:
        table.add_row(*(Text(plain(cell)) for cell in row))
    width = None if sys.stdout.isatty() else 200
    console = Console(width=width, highlight=False)
    with console.capture() as told:  # rich itself would leave with 1 where a pipe closes early
        console.print(table)
    sys.stdout.write(told.get())


@contextmanager
def progress(total: int, label: str, *, quiet: bool) -> Iterator[Callable[[], None]]:
    """A bar with the time left on a terminal; nothing elsewhere.

    Args:
        total: how many steps.
        label: beside the bar.
        quiet: whether to show none.
    """
    with noted_progress(total, label, quiet=quiet) as (advance, _):
        yield advance


@contextmanager
def noted_progress(
    total: int, label: str, *, quiet: bool
) -> Iterator[tuple[Callable[[], None], Callable[[str], None]]]:
    """The same, with a second function that puts a note beside the bar."""
    from tqdm import tqdm

    hidden = quiet or not sys.stderr.isatty()
    with tqdm(total=total, desc=label, file=sys.stderr, disable=hidden, leave=False) as bar:
        yield lambda: bar.update(1) and None, bar.set_postfix_str


@contextmanager
def stages(*, quiet: bool) -> Iterator[Callable[[str, float], None]]:
    """A bar for work in stages told of by name, with the time left of each; nothing off a terminal."""
    from tqdm import tqdm

    if quiet or not sys.stderr.isatty():
        yield lambda doing, part: None
        return
    now = ""
    with tqdm(total=1.0, file=sys.stderr, leave=False, bar_format=_STAGE) as bar:

        def advance(doing: str, part: float) -> None:
            nonlocal now
            if doing != now:
                now = doing
                bar.reset(1.0)
                bar.set_description(doing)
            bar.n = min(part, 1.0)
            bar.refresh()

        yield advance


def degrees(value: float, *, prismatic: bool = False) -> str:
    """A joint value for people: degrees, or metres for a prismatic joint.

    Args:
        value: of the joint [rad, m].
        prismatic: whether it is a length.
    """
    import math

    return f"{value:.4f} m" if prismatic else f"{math.degrees(value):.2f}°"

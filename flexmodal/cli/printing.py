"""Results on standard output: one JSON object, or tables for people."""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any
from unicodedata import category

import click

from flexmodal.cli.waiting import aside, shown_bar
from flexmodal.cli.width import width_asked, width_of_output
from flexmodal.errors import FlexmodalError

_STAGE = "{desc}{percentage:3.0f} % {bar} {elapsed}, {remaining} left"


def print_json(result: dict[str, Any]) -> None:
    """One JSON object in ASCII, refusing NaN and infinity rather than writing what no reader accepts."""
    try:
        text = json.dumps(result, allow_nan=False)
    except ValueError:
        raise FlexmodalError("the result is not finite: its numbers are too large or too small") from None
    with aside():
        click.echo(text)


def say(text: str = "", *, err: bool = False) -> None:
    """Print a text, without what would steer the terminal: names and titles come from other people's files.

    Args:
        text: may have several lines.
        err: on standard error.
    """
    wrapped = _wrapped(plain(text), sys.stderr if err else sys.stdout)
    with aside():
        click.echo(wrapped, err=err)


def _wrapped(text: str, stream: Any) -> str:
    """Long lines broken between words for a terminal; elsewhere as they are, to be searched."""
    if width_asked() is None and not stream.isatty():
        return text
    width = width_of_output()
    return "\n".join(_broken(line, width) for line in text.split("\n"))


def _broken(line: str, width: int) -> str:
    if len(line) <= width:
        return line
    indent = line[: len(line) - len(line.lstrip())] + "  "
    return textwrap.fill(
        line, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def plain(text: str) -> str:
    """A text whose control characters are ?, but for the ends of its lines."""
    return "".join(sign if sign in "\n\t" or category(sign)[0] != "C" else "?" for sign in text)


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A table, its numbers aligned right and never cut; see `flexmodal.cli.tables`.

    Args:
        title: above the table.
        columns: their headings.
        rows: cells as texts.
    """
    from flexmodal.cli.tables import table_text

    cells = [[plain(cell) for cell in row] for row in rows]
    headings = [plain(column) for column in columns]
    text = table_text(plain(title), headings, cells, width_of_output())
    with aside():
        sys.stdout.write(text + "\n\n")


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
    """The same, with a second function that puts a note beside the bar.

    Args:
        total: how many steps.
        label: beside the bar.
        quiet: whether to show none.
    """
    with shown_bar(total=total, desc=label, quiet=quiet) as bar:
        yield lambda: bar.update(1) and None, bar.set_postfix_str


@contextmanager
def busy(label: str, *, quiet: bool) -> Iterator[None]:
    """The time that passes beside a label, for work whose steps nobody counts; nothing off a terminal.

    Args:
        label: what is being done.
        quiet: whether to show none.
    """
    with shown_bar(desc=label, bar_format="{desc} {elapsed}", quiet=quiet):
        yield


@contextmanager
def stages(*, quiet: bool) -> Iterator[Callable[[str, float], None]]:
    """A bar for work in stages told of by name, with the time left of each; nothing off a terminal."""
    with shown_bar(total=1.0, bar_format=_STAGE, quiet=quiet) as bar:
        now = ""

        def advance(doing: str, part: float) -> None:
            nonlocal now
            if bar.disable:
                return
            if doing != now:
                now = doing
                bar.reset(1.0)
                bar.set_description(doing)
            bar.n = min(part, 1.0)
            bar.refresh()

        yield advance


def degrees(value: float, *, prismatic: bool = False, radians: bool = False) -> str:
    """A joint value for people: degrees, or metres for a prismatic joint.

    Args:
        value: of the joint [rad, m].
        prismatic: whether it is a length.
        radians: whether angles are wanted so.
    """
    import math

    if prismatic:
        return f"{value:z.4f} m"
    return f"{value:z.5f}" if radians else f"{math.degrees(value):z.2f}°"

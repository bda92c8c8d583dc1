"""Tables for people, as wide as the terminal and no wider, in which no number is ever cut.

Where a table is too wide its texts are wrapped, long names are shortened in the middle, and last the table is
cut between columns into parts, one below the other, each with the first column.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

_SHORTEST = 16
"""Characters that a name keeps at least."""

_LABEL = 24
"""Longest label of a row that is not wrapped."""

_FRAME, _BETWEEN = 3, 3
"""Columns that rich draws around a table, and between two of its columns."""

_WIDE = 100_000

_NUMBER = re.compile(r"[-+±−–<>≈~]?\s*\d")


@dataclass(frozen=True)
class _Column:
    heading: str
    cells: tuple[str, ...]
    is_first: bool

    @property
    def is_text(self) -> bool:
        """Whether it may be wrapped: no cell in it begins with a number."""
        return not any(_NUMBER.match(cell) for cell in self.cells)

    @property
    def natural(self) -> int:
        return max(cell_len(text) for text in (self.heading, *self.cells))

    @property
    def least(self) -> int:
        """Narrowest without a number or a word cut."""
        kept = self.cells if not self.is_text or (self.is_first and self.natural <= _LABEL) else ()
        words = self.heading.split() + [word for cell in self.cells if not kept for word in cell.split()]
        return max((cell_len(text) for text in (*words, *kept)), default=1)


def table_text(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> str:
    """A table laid out, its numbers aligned right, its texts left.

    Args:
        title: above the table.
        columns: their headings.
        rows: cells as texts.
        width: columns of the terminal.
    """
    given = [
        _Column(heading, tuple(row[place] for row in rows), place == 0)
        for place, heading in enumerate(columns)
    ]
    parts = ["\n".join(textwrap.wrap(title, width))] if title else []
    parts += [_drawn(part, width) for part in _parts(_shortened(given, width), width)]
    return "\n".join(parts).rstrip("\n")


def _total(widths: Sequence[int]) -> int:
    return _FRAME + sum(widths) + _BETWEEN * (len(widths) - 1)


def _shortened(columns: list[_Column], width: int) -> list[_Column]:
    """The same, long names cut in the middle where the table is too wide else and fits then.

    Where it does not fit even so the names stay whole, and the table is cut between columns; unless a name
    and a number beside it are too wide already.
    """
    if _fits(columns, width):
        return columns
    short = [_short_names(column) if column.is_text else column for column in columns]
    narrow = all(_fits(part, width) for part in _parts(columns, width))
    return columns if narrow and not _fits(short, width) else short


def _fits(columns: Sequence[_Column], width: int) -> bool:
    return _total([column.least for column in columns]) <= width


def _short_names(column: _Column) -> _Column:
    """Words longer than `_SHORTEST` shortened in the middle, unless two would look alike."""
    words = {word for cell in column.cells for word in cell.split() if cell_len(word) > _SHORTEST}
    for keep in range(_SHORTEST, max(map(cell_len, words), default=_SHORTEST)):
        short = {word: middle_cut(word, keep) for word in words}
        if len(set(short.values())) == len(words):
            break
    else:
        return column
    cells = tuple(" ".join(short.get(word, word) for word in cell.split(" ")) for cell in column.cells)
    return _Column(column.heading, cells, column.is_first)


def middle_cut(name: str, keep: int) -> str:
    """A name without its middle: what tells names apart is mostly at their ends.

    Args:
        name: of any length.
        keep: characters of the answer at most.
    """
    if len(name) <= keep:
        return name
    head = (keep - 1) // 2
    return f"{name[:head]}…{name[len(name) - (keep - 1 - head) :]}"


def _parts(columns: list[_Column], width: int) -> list[list[_Column]]:
    """The table in parts of columns that fit, each with the first."""
    if _fits(columns, width) or len(columns) < 3:
        return [columns]
    first, *others = columns
    parts: list[list[_Column]] = [[first]]
    for column in others:
        if len(parts[-1]) > 1 and not _fits((*parts[-1], column), width):
            parts.append([first])
        parts[-1].append(column)
    return parts


def _widths(columns: Sequence[_Column], width: int) -> list[int]:
    """Natural widths, the widest of those that can be wrapped narrowed until the table fits."""
    widths = [column.natural for column in columns]
    least = [column.least for column in columns]
    while _total(widths) > width:
        room = [now - low for now, low in zip(widths, least, strict=True)]
        if max(room) <= 0:
            break
        place = max(range(len(widths)), key=lambda at: (room[at] > 0, widths[at]))
        widths[place] -= 1
    return widths


def _drawn(columns: Sequence[_Column], width: int) -> str:
    table = Table(box=box.SIMPLE_HEAD)
    for column, wide in zip(columns, _widths(columns, width), strict=True):
        justify = "left" if column.is_first or column.is_text else "right"
        table.add_column(Text(column.heading), justify=justify, width=wide, overflow="fold")  # type: ignore[arg-type]
    for row in zip(*(column.cells for column in columns), strict=True):
        table.add_row(*(Text(cell) for cell in row))
    console = Console(width=_WIDE, highlight=False)
    with console.capture() as told:  # rich itself would leave with 1 where a pipe closes early
        console.print(table)
    return "\n".join(line.rstrip() for line in told.get().splitlines())

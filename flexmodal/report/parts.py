"""What a page is made of, as data: tables, pictures, facts, lists, and sections that hold them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True)
class Column:
    """One column of a table."""

    name: str
    unit: str = ""
    words: bool = False
    """Whether it holds words: to the left, and broken where they are long."""
    group: str = ""
    """Heading over several columns."""

    @property
    def head(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class Cell:
    """A cell with more in it than text."""

    text: str
    note: str = ""
    """Small, below."""
    tag: str = ""
    bar: float | None = None
    """A part of one, drawn as a bar."""
    interval: tuple[float, float, float] | None = None
    """Begin, value and end between −1 and 1, drawn along a line whose middle is 0."""

    @property
    def width(self) -> str:
        """Of the bar [%]."""
        return f"{100 * min(max(self.bar or 0.0, 0.0), 1.0):.1f}"

    @property
    def marks(self) -> tuple[str, str, str]:
        """Begin, width and value of the interval [%]."""
        low, value, high = (50 + 50 * min(max(one, -1.0), 1.0) for one in self.interval or (0.0, 0.0, 0.0))
        return f"{low:.1f}", f"{max(high - low, 0.5):.1f}", f"{value:.1f}"


@dataclass(frozen=True)
class Table:
    """Rows of cells under columns; wider than the page, it scrolls."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[str | Cell]]
    chosen: frozenset[int] = frozenset()
    """Numbers of the rows that stand out."""
    faint: frozenset[int] = frozenset()
    """Numbers of the rows that step back."""

    @property
    def lines(self) -> list[list[Cell]]:
        """The rows, each cell a `Cell`; spaces before a word stay, to set it in."""
        return [
            [
                cell
                if isinstance(cell, Cell)
                else Cell(cell.replace("  ", "\u2003") if cell[:1] == " " else cell)
                for cell in row
            ]
            for row in self.rows
        ]

    @property
    def stacks(self) -> bool:
        """Whether a narrow screen shows its rows one below the other rather than letting them scroll."""
        return len(self.rows) <= 20

    @property
    def groups(self) -> list[tuple[str, int]]:
        """Headings over columns, and over how many of them; empty where there are none."""
        found: list[tuple[str, int]] = []
        for column in self.columns:
            if found and found[-1][0] == column.group:
                found[-1] = (column.group, found[-1][1] + 1)
            else:
                found.append((column.group, 1))
        return found if len(found) > 1 else []


def columns(names: Sequence[str], *, words: Sequence[str] = ()) -> list[Column]:
    """Columns by their headings; the first holds words, and so do those named.

    Args:
        names: headings.
        words: those of columns that hold words, besides the first.
    """
    return [Column(name, words=not number or name in words) for number, name in enumerate(names)]


@dataclass(frozen=True)
class Picture:
    """A matplotlib figure with what it shows, for those who do not see it; drawn when the page is."""

    draw: Callable[[], Any]
    says: str
    caption: str = ""

    @property
    def svg(self) -> str:
        """The figure as an SVG element."""
        from flexmodal.report.figure import svg_text

        return svg_text(self.draw())


@dataclass(frozen=True)
class Gallery:
    """Pictures side by side as far as they fit, one by one on a narrow screen."""

    pictures: Sequence[Picture]


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    says: str
    note: bool = False
    """Whether it only explains what stands above."""
    tag: str = ""


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    says: str


@dataclass(frozen=True)
class Legend:
    """What the curves of several pictures are: names by `measured`, `noise`, `before` or `after`."""

    names: Mapping[str, str]


@dataclass(frozen=True)
class Facts:
    """Names with what they stand for."""

    values: Mapping[str, str]


@dataclass(frozen=True)
class Verdict:
    """The answer in a frame, with the numbers that matter, large."""

    state: Literal["found", "nothing", "open"]
    head: str
    says: Sequence[Text]
    figures: Sequence[tuple[str, str, str]] = ()
    """Name, value, and a remark on it."""


@dataclass(frozen=True)
class Task:
    """What to do next."""

    says: str
    facts: Facts


@dataclass(frozen=True)
class Items:
    """A list of sentences; `empty` where there are none."""

    says: Sequence[str]
    empty: str = ""


@dataclass(frozen=True)
class Folded:
    """Something that is shown when it is asked for; folded in print unless it is open."""

    title: str
    part: Part


@dataclass(frozen=True)
class Numbers:
    """An object as JSON, to be copied."""

    value: Mapping[str, Any]

    @property
    def text(self) -> str:
        """As JSON."""
        return json_text(self.value)


@dataclass(frozen=True)
class Live:
    """A place that a script of the page fills from numbers; the page's policy lets no other script run."""

    name: str
    """By which the script finds it: the attribute `data-live`."""
    data: Mapping[str, Any]
    script: str
    instead: str
    """What is said where no script runs."""

    @property
    def text(self) -> str:
        """The numbers as JSON that no markup can end."""
        return json.dumps(self.data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


Part = (
    Live
    | Table
    | Picture
    | Gallery
    | Text
    | Heading
    | Legend
    | Verdict
    | Task
    | Items
    | Facts
    | Folded
    | Numbers
)
Parts = Sequence[Part | str]
"""What a page or a section is made of; text by itself is a paragraph."""


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it."""

    title: str
    parts: Parts = ()


def json_text(value: Mapping[str, Any]) -> str:
    """An object as JSON text with a line break at its end; it may hold finite numbers only."""
    return json.dumps(value, allow_nan=False, indent=1) + "\n"


def finite(value: float) -> float | None:
    """A number for JSON; none where it is not finite."""
    return float(value) if math.isfinite(value) else None

"""The law-free look in the report: places by their misfit, and the curve that was found with its band."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from flexmodal.diagnosis.lawfree.port import BETWEEN
from flexmodal.diagnosis.lawfree.result import Curve, Findings, PlaceTried
from flexmodal.report import Cell, Column, Gallery, Part, Parts, Picture, Table, Text
from flexmodal.report.figure import INK, NARROW, drawing, frequency_axis, look, new_figure
from flexmodal.report.words import percent

_DRAWN = "real and imaginary part with their standard deviation"
_SHOWN = 8
"""Places in the table."""
_WIDEST = 0.5
"""Standard deviation over the size of the largest value, from which a line is not drawn: it says nothing."""
_MANY = 6
"""Functions that are all drawn."""
_COLUMNS = (
    Column("place", words=True), Column("what it would be", words=True), Column("free functions"),
    Column("misfit", "noise"), Column("held out", "noise"),
)  # fmt: skip
_TOGETHER = (
    Column("free together", words=True), Column("what it would be", words=True),
    Column("misfit without it", "noise"),
)  # fmt: skip
_NOTE = (
    "No law is assumed here: at each place the dynamic stiffness or compliance is one free complex number at "
    "every frequency, the same in all postures, and the robot's own parameters are fitted along. A wrong "
    "place cannot explain several postures with one function. Misfit: root mean square distance from the "
    "averages over repeats in units of their noise, 0.6 if perfect. The look is blind to places that move "
    "alike in every posture, which are listed as alike, and sees little with one point or few postures. The "
    "table has each place for itself; where one is not enough, further ones are freed beside it."
)


def look_parts(look: Findings) -> Parts:
    """The section."""
    rows: list[list[str | Cell]] = [
        ["none", "the robot re-tuned: the larger of both", "0", f"{look.alone:.2f}", "–"]
    ]
    alike = {key for one in look.found for key in one.alike if key != (one.port, one.where)}
    rows += [_row(one, tied=(one.port, one.where) in alike) for one in look.places[:_SHOWN]]
    chosen = {(one.port, one.where) for one in look.found} if look.needed else set()
    numbers = {k for k, one in enumerate(look.places[:_SHOWN], start=1) if (one.port, one.where) in chosen}
    parts: list[Part | str] = [look.says, Table(_COLUMNS, rows, chosen=frozenset(numbers or {0}))]
    if len(look.found) > 1:
        found = [[f"{one.port} {one.where}", one.says, f"{one.without:.2f}"] for one in look.found]
        parts += [Table(_TOGETHER, [["all of these", "", f"{look.left:.2f}"], *found])]
    pictures = [
        Picture(partial(draw_curve, one.curve), f"Free function of {one.port} at {one.where}, {_DRAWN}")
        for one in look.found
        if one.curve is not None
    ]
    if pictures:
        parts.append(Gallery(pictures))
    parts += [
        f"{each.says}: takes {percent(each.share)} of the curve."
        for one in look.found
        for each in one.classes
    ]
    return [*parts, Text(_NOTE, note=True)]


def _row(one: PlaceTried, *, tied: bool) -> list[str | Cell]:
    apart = "–" if one.held_out is None else f"{one.held_out:.2f}"
    place = Cell(f"{one.port} {one.where}".strip(), tag="alike" if tied else "")
    return [place, one.says, str(one.unknowns), f"{one.misfit:.2f}", apart]


def _drawn(curve: Curve) -> list[tuple[int, str]]:
    """Numbers and names of the functions that are drawn: all of few, or of many those on the diagonal."""
    every = list(enumerate(curve.names))
    return every if len(every) <= _MANY else [one for one in every if BETWEEN not in one[1]]


@drawing
def draw_curve(curve: Curve) -> Any:
    """Real and imaginary part of functions over frequency, with a band of one standard deviation.

    Of a matrix with more than six functions those on its diagonal.
    """
    figure = new_figure(NARROW, 3.6 + 0.15 * len(_drawn(curve)))
    panels = figure.subplots(2, 1, sharex=True)
    known = curve.deviation <= _WIDEST * np.abs(curve.value).max(axis=1, keepdims=True)
    for part, axes, word in ((np.real, panels[0], "real"), (np.imag, panels[1], "imaginary")):
        axes.axhline(0.0, color=INK, linewidth=0.6)
        for number, name in _drawn(curve):
            value, spread = part(curve.value[number]), curve.deviation[number]
            shown, style = known[number], look(number, marker=".", markersize=3, linewidth=1)
            f, y, d = curve.frequency[shown], value[shown], spread[shown]
            axes.fill_between(f, y - d, y + d, color=style["color"], alpha=0.25, linewidth=0)
            axes.plot(f, y, label=name, **style)
        unit = f" [{curve.unit}]" if curve.unit else ""
        axes.set_ylabel(f"{word}{unit}")
    frequency_axis(panels[1], curve.frequency)
    if len(curve.names) > 1:
        handles = panels[0].get_legend_handles_labels()
        figure.legend(*handles, fontsize=7, ncols=3, loc="outside lower left", frameon=False)
    return figure

"""Amplitude and phase of FRFs, readable in print and for the colour-blind."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from flexmodal.frf.frf import Frf
from flexmodal.report.figure import (
    DASHED,
    MARK,
    WIDE,
    drawing,
    frequency_axis,
    look,
    new_figure,
    phase_axis,
    positive,
    wrapped,
)

_MOST_CURVES = 12


def draw_one(found: Frf, *, title: str = "", mark: float | None = None) -> Any:
    """Draw one FRF; see `draw_frf`."""
    return draw_frf({"": found}, title=title, mark=mark)


@drawing
def draw_frf(curves: Mapping[str, Frf], *, title: str = "", mark: float | None = None) -> Any:
    """Draw the pairs of some FRFs over frequency.

    Args:
        curves: FRFs of one form, by the name that goes into the legend.
        title: heading of the picture.
        mark: a frequency to mark with a vertical line [Hz].

    Returns:
        A matplotlib figure.
    """
    figure = new_figure(WIDE, 5.4)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2.2, 1])
    lines = list(_pairs(curves))
    for place, (_, frequency, values, _) in enumerate(lines[:_MOST_CURVES]):
        style = look(place, marker="o" if len(frequency) == 1 else None)
        upper.plot(frequency, positive(values), label=str(place), **style)
        lower.plot(*wrapped(frequency, np.degrees(np.angle(values))), **style)
    form = next(iter(curves.values())).form
    units = sorted({unit for *_, unit in lines})
    upper.set_yscale("log")
    upper.set_ylabel(f"{form.capitalize()} amplitude [{', '.join(units)}]")
    phase_axis(lower)
    frequency_axis(lower, lines[0][1], wide=50.0)
    if mark is not None:
        for axes in (upper, lower):
            axes.axvline(mark, color=MARK, linewidth=1, linestyle=DASHED)
        upper.annotate(
            f"{mark:g} Hz", (mark, 0.02), xycoords=("data", "axes fraction"), xytext=(4, 0),
            textcoords="offset points", color=MARK, fontsize=9,
        )  # fmt: skip
    if len(lines) > 1:
        legend = upper.legend()
        for text, (label, *_) in zip(legend.get_texts(), lines, strict=False):
            text.set_text(label)  # names may begin with _, which a legend leaves out
        heading = title
    else:
        heading = ": ".join(part for part in (title, lines[0][0]) if part)
    upper.set_title(heading)
    return figure


def _pairs(curves: Mapping[str, Frf]) -> Iterator[tuple[str, np.ndarray, np.ndarray, str]]:
    for name, frf in curves.items():
        for row, column, pair in frf.pairs():
            label = f"{name}, {pair}" if name else pair
            yield label, frf.frequency, frf.value[:, row, column], frf.unit(row, column)

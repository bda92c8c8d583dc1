"""Amplitude and phase of FRFs, readable in print and for the colour-blind."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.files import whole_file
from flexmodal.frf.frf import Frf

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's colours; each curve also has a line style of its own."""

_STYLES = ("-", "--", "-.", ":")
_MOST_CURVES = 12
_SVG = {"svg.fonttype": "none", "svg.hashsalt": "flexmodal"}
"""Text as text, and the same names of its parts each time."""


def draw_frf(curves: Mapping[str, Frf], *, title: str = "", mark: float | None = None) -> Any:
    """Draw the pairs of some FRFs over frequency.

    Args:
        curves: FRFs of one form, by the name that goes into the legend.
        title: heading of the picture.
        mark: a frequency to mark with a vertical line [Hz].

    Returns:
        A matplotlib figure.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 5.4), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2.2, 1])
    lines = list(_pairs(curves))
    for place, (_, frequency, values, _) in enumerate(lines[:_MOST_CURVES]):
        style: dict[str, Any] = {
            "color": PALETTE[place % len(PALETTE)],
            "linestyle": _STYLES[place % len(_STYLES)],
            "linewidth": 1.6,
            "marker": "o" if len(frequency) == 1 else None,
        }
        size = np.where(np.abs(values) > 0, np.abs(values), np.nan)
        upper.plot(frequency, size, label=str(place), **style)
        phase = np.degrees(np.angle(values))
        jump = np.flatnonzero(np.abs(np.diff(phase)) > 180)
        lower.plot(
            np.insert(frequency, jump + 1, frequency[jump]), np.insert(phase, jump + 1, np.nan), **style
        )
    form = next(iter(curves.values())).form
    units = sorted({unit for *_, unit in lines})
    upper.set_yscale("log")
    upper.set_ylabel(f"{form.capitalize()} amplitude [{', '.join(units)}]")
    lower.set_ylabel("Phase [°]")
    lower.set_ylim(-190, 190)
    lower.set_yticks([-180, -90, 0, 90, 180])
    lower.set_xlabel("Frequency [Hz]")
    _scale_frequency(lower, lines[0][1])
    for axes in (upper, lower):
        axes.grid(True, which="major", color="0.82", linewidth=0.6)
        axes.grid(True, which="minor", color="0.92", linewidth=0.4)
        if mark is not None:
            axes.axvline(mark, color="0.35", linewidth=1, linestyle=(0, (2, 2)))
    if mark is not None:
        upper.annotate(
            f"{mark:g} Hz", (mark, 0.02), xycoords=("data", "axes fraction"), xytext=(4, 0),
            textcoords="offset points", color="0.25", fontsize=9,
        )  # fmt: skip
    if len(lines) > 1:
        legend = upper.legend(fontsize=9, frameon=True, framealpha=0.9)
        for text, (label, *_) in zip(legend.get_texts(), lines, strict=False):
            text.set(text=label, parse_math=False)  # names may hold $, or begin with _
        heading = title
    else:
        heading = ": ".join(part for part in (title, lines[0][0]) if part)
    upper.set_title(heading, loc="left", fontsize=11, parse_math=False)
    return figure


def write_plot(figure: Any, path: Path, *, overwrite: bool = False) -> None:
    """Write a figure as PNG or SVG, by the ending of the path; text in the SVG stays text.

    Raises:
        OutputExists: the file exists.
    """
    import matplotlib as mpl

    with whole_file(path, overwrite=overwrite) as scratch, mpl.rc_context(_SVG):
        figure.savefig(scratch, dpi=150)


def svg_text(figure: Any) -> str:
    """A figure as an SVG element for a page."""
    import matplotlib as mpl

    with io.StringIO() as file, mpl.rc_context(_SVG):
        figure.savefig(file, format="svg", metadata={"Date": None})
        text = file.getvalue()
    return text[text.index("<svg") :]


def _pairs(curves: Mapping[str, Frf]) -> Any:
    for name, frf in curves.items():
        for row, response in enumerate(frf.response):
            for column, reference in enumerate(frf.reference):
                pair = f"{response} per {reference}"
                label = f"{name}, {pair}" if name else pair
                yield label, frf.frequency, frf.value[:, row, column], frf.unit(row, column)


def _scale_frequency(axes: Any, frequency: np.ndarray) -> None:
    """A logarithmic axis over wide ranges, as analysers show them; a linear one otherwise."""
    if len(frequency) > 1 and frequency[0] > 0 and frequency[-1] / frequency[0] >= 50:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    if len(frequency) > 1:
        axes.set_xlim(frequency[0], frequency[-1])

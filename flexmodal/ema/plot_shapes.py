"""Pictures of shapes: along the arm, and against each other as a MAC matrix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.ema.shapes import FittedShapes
from flexmodal.report.figure import MARK, PALETTE, drawing, headline, new_figure, short

_HALF_BRIGHT = 0.42
"""Value above which black reads better on the colour map than white."""
_CROWDED = 9
"""More places than this get their names upright."""


@drawing
def draw_mac(
    matrix: Float[np.ndarray, "mode other"],
    rows: Sequence[str] = (),
    columns: Sequence[str] = (),
    *,
    first: str = "Mode of the first set",
    second: str = "Mode of the second set",
    title: str = "Modal assurance criterion",
) -> Any:
    """A MAC matrix with its numbers in the cells.

    Args:
        matrix: as `flexmodal.modal.mac` gives it.
        rows: names of the first set's modes; numbered if empty.
        columns: names of the second set's modes.
        first: what the rows are.
        second: what the columns are.
        title: heading.
    """
    count, other = matrix.shape
    figure = new_figure(1.8 + 0.75 * max(other, 2), 1.4 + 0.7 * max(count, 2))
    axes = figure.subplots()
    image = axes.imshow(matrix, vmin=0, vmax=1, aspect="auto")
    axes.grid(False)
    axes.set_xticks(range(other), list(columns) or [str(place + 1) for place in range(other)])
    axes.set_yticks(range(count), list(rows) or [str(place + 1) for place in range(count)])
    axes.set(xlabel=second, ylabel=first)
    if count * other <= 400:
        for row, column in np.ndindex(count, other):
            colour = "black" if matrix[row, column] > _HALF_BRIGHT else "white"
            axes.text(
                column, row, f"{matrix[row, column]:.2f}", ha="center", va="center", color=colour, fontsize=9
            )
    figure.colorbar(image, ax=axes, label="MAC [–]")
    headline(figure, title)
    return figure


@drawing
def draw_shapes(shapes: FittedShapes, names: Mapping[int, str], *, title: str = "") -> Any:
    """What each place does in each mode, in the campaign's order: filled in phase, open a quarter off.

    Args:
        shapes: of the fitted modes.
        names: of the points, by id.
        title: heading.
    """
    figure = new_figure(8.2, 4.2)
    axes = figure.subplots()
    places = range(len(shapes.places))
    for mode, frequency in enumerate(shapes.frequency):
        look = {"color": PALETTE[mode % len(PALETTE)], "marker": "osD^v"[mode % 5]}
        values = shapes.shape[:, mode]
        axes.plot(places, values.real, linestyle="-", label=f"{frequency:.4g} Hz", **look)
        axes.plot(places, values.imag, linestyle=":", linewidth=1, markerfacecolor="none", **look)
    axes.axhline(0, color=MARK, linewidth=0.9)
    labels = [f"{short(str(names.get(point, point)))}\n{_sense(way)}" for point, way in shapes.places]
    axes.set_xticks(places, labels, fontsize=8)
    if len(labels) > _CROWDED:
        axes.tick_params(axis="x", labelrotation=90)
    axes.set(ylabel="Residue over the largest [–]", ylim=(-1.15, 1.15))
    figure.legend(loc="outside right upper", title="solid: in phase\ndotted: 90° off")
    heading = title or f"Posture {shapes.posture}, {fixed_place(shapes, names)}"
    axes.set_title(heading)
    return figure


def fixed_place(shapes: FittedShapes, names: Mapping[int, str]) -> str:
    """Such as "hammer at tip +z".

    Args:
        shapes: of the fitted modes.
        names: of the points, by id.
    """
    point, way = shapes.fixed
    tool = "hammer" if shapes.side == "reference" else "sensor"
    return f"{tool} at {names.get(point, point)} {_sense(way)}"


def _sense(way: int) -> str:
    return f"{'+' if way > 0 else '-'}{'xyz'[abs(way) - 1]}"

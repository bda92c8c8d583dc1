"""Pictures of a prediction: receptances with their band, and the learning from postures left out."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.prediction.frf_prediction import FrfPrediction
from flexmodal.report.figure import (
    FITTED,
    MEASURED,
    SOFT,
    WIDE,
    drawing,
    frequency_axis,
    log_axis,
    new_figure,
    short,
)

MOST = 6
"""Receptances in one picture: those at drive points first."""


@drawing
def draw_prediction(prediction: FrfPrediction) -> Any:
    """Size of the receptances with the 95 % band, over frequency.

    Args:
        prediction: of one posture.

    Returns:
        A matplotlib figure.
    """
    chosen = sorted(prediction.frfs, key=lambda one: one.response != one.reference)[:MOST]
    columns = 2 if len(chosen) > 1 else 1
    count = -(-len(chosen) // columns)
    figure = new_figure(5.2 * columns, 2.6 * count + 0.7)
    panes = np.atleast_1d(figure.subplots(count, columns, sharex=True, squeeze=False)).ravel()
    frequency = prediction.frequency
    for pane, one in zip(panes, chosen, strict=False):
        pane.fill_between(
            frequency, one.low, one.high, color=FITTED, alpha=0.25, linewidth=0, label="95 % band"
        )
        pane.loglog(frequency, np.abs(one.value), color=FITTED, linewidth=1.2, label=prediction.method)
        pane.set_title(f"{one.response} per {one.reference}", fontsize=9)
        frequency_axis(pane, frequency, wide=1.0)
    for pane in panes[len(chosen) :]:
        pane.remove()
    for pane in panes[::columns][:count]:
        pane.set_ylabel("|receptance| [m/N]")
    for place, pane in enumerate(panes[: len(chosen)]):
        if place < len(chosen) - columns:
            pane.set_xlabel("")
        else:
            pane.tick_params(labelbottom=True)
    panes[0].legend(fontsize=8)
    return figure


@drawing
def draw_left_out(prediction: FrfPrediction) -> Any:
    """Gap of every method on each posture that it had not seen, and the noise floor.

    Args:
        prediction: with what was left out.

    Returns:
        A matplotlib figure.
    """
    left = prediction.left_out
    names = [left.panel.observations.postures[number].name for number in left.postures]
    figure = new_figure(WIDE, 1.6 + 0.34 * len(names))
    axes = figure.subplots()
    rows = np.arange(len(names))
    marks = {"physics": "s", "hybrid": "o", "process": "^", "mean": "x", "nearest": "+"}
    for name, marker in marks.items():
        colour = FITTED if name == prediction.method else SOFT
        axes.plot(left.gaps[name], rows, marker, color=colour, label=name, markersize=6, linestyle="none")
    axes.axvline(left.noise_floor, color=MEASURED, linewidth=1.2, linestyle=":", label="noise floor")
    axes.set_yticks(rows, [short(name, 30) for name in names])
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlabel("Gap on the posture left out, root mean square of |ln(predicted / measured)| [–]")
    log_axis(axes.xaxis)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=4)
    return figure

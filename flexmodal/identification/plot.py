"""Pictures of an identification: measured against model with the error band, modes, held-out gaps."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.identification.band import banded
from flexmodal.identification.evidence.both import Both
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.evidence.modal import ModalEvidence
from flexmodal.identification.observations import Observations
from flexmodal.identification.outcome import Identification
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

CARD = SOFT
MOST = 6
"""FRFs in one picture."""


@drawing
def draw_identification(outcome: Identification) -> Any:
    """Measured against model: FRFs with their band; errors of modes where they alone were fitted.

    Returns:
        A matplotlib figure.
    """
    evidence = outcome.problem.evidence
    if isinstance(evidence, ModalEvidence):
        return draw_modes(outcome, evidence)
    if isinstance(evidence, Both):
        evidence = evidence.frfs
    assert isinstance(evidence, FrfEvidence)
    return _draw_frfs(outcome, evidence)


@drawing
def draw_held_out(outcome: Identification) -> Any:
    """Gap of card and fit on each posture and point that the fit had not seen, and the noise."""
    held = outcome.held_out
    figure = new_figure(WIDE, 1.5 + 0.32 * len(held))
    axes = figure.subplots()
    rows = np.arange(len(held))
    for values, marker, colour, label in (
        ([one.before for one in held], "s", CARD, "card"),
        ([one.after for one in held], "o", FITTED, "fit that had not seen it"),
        ([one.noise_floor for one in held], "|", MEASURED, "noise floor"),
    ):
        axes.plot(values, rows, marker, color=colour, label=label, markersize=7, markeredgewidth=1.8)
    axes.set_yticks(rows, [f"{one.kind} {short(one.name, 30)}" for one in held])
    axes.set_ylim(len(held) - 0.4, -0.6)
    what = "errors of modes" if outcome.problem.source == "modes" else "|ln(model / measured)|"
    axes.set_xlabel(f"Gap, root mean square of {what} [–]")
    log_axis(axes.xaxis)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=3)
    axes.set_title("Held out")
    return figure


def _draw_frfs(outcome: Identification, evidence: FrfEvidence) -> Any:
    seen = evidence.observations
    chosen = _chosen(seen)
    keep = np.isin(np.arange(len(seen)), chosen)
    fitted = banded(evidence.model, outcome.at, seen, outcome.uncertainty, keep)
    card = evidence.predicted(np.zeros(len(evidence.space)))[keep]
    low, high = fitted.reach()
    columns = 2 if len(chosen) > 1 else 1
    count = -(-len(chosen) // columns)
    figure = new_figure(5.2 * columns, 2.6 * count + 0.7)
    panes = np.atleast_1d(figure.subplots(count, columns, sharex=True, squeeze=False)).ravel()
    frequency = seen.axis.frequency
    for place, (pane, row) in enumerate(zip(panes, np.flatnonzero(keep).tolist(), strict=False)):
        used = np.where(seen.used[row], np.abs(seen.value[row]), np.nan)
        pane.loglog(frequency, used, color=MEASURED, linewidth=2.4, alpha=0.55, label="measured")
        pane.loglog(frequency, np.abs(card[place]), color=CARD, linestyle=":", linewidth=1.3, label="card")
        pane.loglog(frequency, np.abs(fitted.value[place]), color=FITTED, linewidth=1.1, label="identified")
        pane.fill_between(
            frequency, low[place], high[place], color=FITTED, alpha=0.25, linewidth=0, label="95 % band"
        )
        pane.set_title(_title(seen, row), fontsize=9)
        frequency_axis(pane, frequency, wide=1.0)
    for pane in panes[len(chosen) :]:
        pane.remove()
    for pane in panes[::columns][:count]:
        pane.set_ylabel("|receptance| [m/N]")
    for pane in panes[: max(len(chosen) - columns, 0)]:
        pane.set_xlabel("")
    for pane in panes[max(len(chosen) - columns, 0) : len(chosen)]:
        pane.tick_params(labelbottom=True)
    panes[0].legend(fontsize=8)
    return figure


def _chosen(seen: Any) -> list[int]:
    """One FRF for each posture, at the drive point where there is one."""
    found = []
    for number in range(len(seen.postures)):
        rows = np.flatnonzero(seen.posture == number)
        if rows.size:
            drive = [r for r in rows.tolist() if np.array_equal(seen.response[r], seen.reference[r])]
            found.append((drive or rows.tolist())[0])
    return found[:MOST]


def _title(seen: Observations, row: int) -> str:
    posture = seen.postures[int(seen.posture[row])].name
    return f"{posture}: {seen.direction(seen.response[row])} per {seen.direction(seen.reference[row])}"


@drawing
def draw_modes(outcome: Identification, evidence: ModalEvidence) -> Any:
    """Errors of frequencies and damping ratios, of the card and of the fit, beside those of measurement.

    Args:
        outcome: what was found.
        evidence: the modes that were fitted, alone or beside FRFs.

    Returns:
        A matplotlib figure.
    """
    observed = evidence.observations
    before, after = evidence.predicted(np.zeros(len(evidence.space))), evidence.predicted(outcome.at)
    labels = [f"{observed.postures[m.posture].name}, {m.frequency:.1f} Hz" for m in observed.modes]
    met = np.isfinite(after[: len(labels), 0])
    labels = [label if there else f"{label}, not met" for label, there in zip(labels, met, strict=True)]
    rows = np.arange(len(labels))
    figure = new_figure(9.0, 1.4 + 0.24 * len(labels))
    left, right = figure.subplots(1, 2, sharey=True)
    frequency = [mode.frequency_error for mode in observed.modes]
    damping = [mode.damping_error for mode in observed.modes]
    errors = (
        (left, 0, 100.0, frequency, "Natural frequency: model / measured − 1 [%]"),
        (right, 1, 1000.0, damping, "Damping ratio: model / measured − 1 [%]"),
    )
    for axes, column, scale, error, label in errors:
        axes.errorbar(0 * rows, rows, xerr=196 * np.array(error), fmt="none", ecolor=MEASURED, elinewidth=5,
                      alpha=0.4, label="measured ± 1.96 standard errors")  # fmt: skip
        axes.plot(
            scale * before[: len(rows), column], rows, "s", color=CARD, markerfacecolor="none", label="card"
        )
        axes.plot(
            scale * after[: len(rows), column], rows, "o", color=FITTED, markersize=4, label="identified"
        )
        axes.axvline(0, color=SOFT, linewidth=0.8)
        axes.set_xlabel(label)
    left.set_yticks(rows, labels, fontsize=8)
    left.invert_yaxis()
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper right", ncols=3)
    return figure

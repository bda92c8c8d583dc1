"""Pictures of a diagnosis from modes: frequencies by posture, evidence, and shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmodal.diagnosis.findings import Findings, ModesSeen
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.report.pictures import AFTER, BEFORE, MEASURED
from flexmodal.diagnosis.report.words import placed
from flexmodal.diagnosis.verdict.modal_words import most_telling
from flexmodal.identification.evidence.likelihood.held_out import HeldOut
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.shapes import shapes_of
from flexmodal.report.figure import NARROW, SOFT, drawing, new_figure
from flexmodal.report.figure import short as cut

RETUNED = "re-tuned"
"""The robot with nothing added, in a picture or a table."""


def short(key: tuple[str, str]) -> str:
    """An explanation in a few words."""
    return "mode without structure" if key[0] == UNSTRUCTURED else placed(*key)


@drawing
def draw_frequencies(found: ModesSeen, after_name: str) -> Any:
    """Each measured mode over the postures, with what the models have there: one panel a mode.

    Args:
        found: the modes.
        after_name: what the second model is; `RETUNED` where nothing was added, and there is none.

    Returns:
        A matplotlib figure.
    """
    measured, numbers = found.measured, found.measured.numbers
    numbers = tuple(
        sorted(numbers, key=lambda n: np.median([m.frequency for m in measured.modes if m.number == n]))
    )
    figure = new_figure(NARROW, 1.45 * len(numbers) + 1.0)
    panels = np.atleast_1d(figure.subplots(len(numbers), 1, sharex=True))
    names = [p.name for p in measured.postures]
    for axes, number in zip(panels, numbers, strict=True):
        rows = [k for k, m in enumerate(measured.modes) if m.number == number]
        at = np.array([measured.modes[k].posture for k in rows])
        f = np.array([measured.modes[k].frequency for k in rows])
        bars = f * np.array([measured.modes[k].frequency_error for k in rows])
        axes.errorbar(
            at, f, yerr=2 * bars, fmt="o", color=MEASURED, capsize=3, label="measured, ±2 standard errors"
        )
        _partners(axes, found.before, rows, at - 0.14, BEFORE, "X", "re-tuned, nothing added")
        if after_name != RETUNED:
            _partners(axes, found.after, rows, at + 0.12, AFTER, "s", after_name)
        _predicted(axes, found.held_after, rows, at + 0.26, AFTER, f"{after_name}, posture held out")
        _lacking(axes, {RETUNED: found.before, after_name: found.after}, rows)
        middle = float(np.median(f))
        axes.set_ylabel(f"{middle:.3g} Hz")
        low, high = axes.get_ylim()
        wide = max(high - low, 0.06 * middle)
        axes.set_ylim((low + high - wide) / 2, (low + high + wide) / 2)
    panels[-1].set_xticks(range(len(names)), [cut(name) for name in names])
    if len(names) > 3:
        panels[-1].tick_params(axis="x", labelrotation=30)
    panels[-1].set_xlim(-0.5, len(names) - 0.5)
    panels[0].set_title("Natural frequency [Hz] by posture")
    handles: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="outside lower left", frameon=False)
    return figure


def _partners(
    axes: Any, fit: ModalFit, rows: list[int], x: np.ndarray, colour: str, marker: str, label: str
) -> None:
    y = [
        np.exp(fit.forecasts[fit.measured.modes[k].posture].log_frequency[fit.pairs[k]])
        if fit.pairs[k] >= 0
        else np.nan
        for k in rows
    ]
    if np.isfinite(y).any():
        axes.plot(x, y, marker, color=colour, markersize=6, label=label)


def _lacking(axes: Any, fits: dict[str, ModalFit], rows: list[int]) -> None:
    """Say in the panel which models have no such mode in any posture."""
    without = [name for name, fit in fits.items() if all(fit.pairs[k] < 0 for k in rows)]
    if without:
        axes.set_title(f"no such mode: {'; '.join(without)}", loc="right", fontsize=9, color=SOFT)


def _predicted(
    axes: Any, held: HeldOut | None, rows: list[int], x: np.ndarray, colour: str, label: str
) -> None:
    if held is None:
        return
    y = [held.frequency[k] for k in rows]
    if np.isfinite(y).any():
        axes.plot(x, y, "s", color=colour, markerfacecolor="none", markersize=6, label=label)


@drawing
def draw_evidence(found: Findings) -> Any:
    """What each explanation gains over the robot re-tuned, and how far that moves with the priors."""
    comparison = found.comparison
    order = [k for k in comparison.order if k]
    gain = comparison.table - comparison.table[0]
    figure = new_figure(NARROW, 0.36 * len(order) + 1.3)
    axes = figure.subplots()
    for place, k in enumerate(order):
        tied = comparison.models[k].key in found.tied
        colour = AFTER if tied else SOFT
        axes.plot([gain[k].min(), gain[k].max()], [place, place], color=colour, linewidth=2, alpha=0.6)
        axes.plot(gain[k, 0], place, "o" if tied else "D", color=colour, markersize=7)
    axes.axvline(0, color=SOFT, linewidth=1)
    axes.set_yticks(range(len(order)), [cut(short(comparison.models[k].key), 32) for k in order])
    axes.set_ylim(len(order) - 0.4, -0.6)
    axes.set_xlabel("Evidence over nothing added [nat]")
    figure.suptitle("● under the card, — under other priors; blue: tied", x=0.01, ha="left", fontsize=10)
    return figure


@drawing
def draw_shapes(found: Findings, one: ModalFit, other: ModalFit) -> Any:
    """The mode that two explanations differ in most, as they have it and as it was measured."""
    chosen = most_telling(found.shapes)
    measured = found.modes.measured
    figure = new_figure(NARROW, 4.2)
    axes = figure.subplots()
    rows = list(range(len(measured.responses)))
    seen_by = shapes_of(measured, chosen.number)
    models = [_shape(fit, chosen.number, next(iter(seen_by))) for fit in (one, other)]
    first = next((_turned(model) for model in models if model is not None), None)
    for number, (posture, (seen, residue)) in enumerate(seen_by.items()):
        turned = _turned(residue, None if first is None else first[seen])
        name = cut(measured.postures[posture].name)
        axes.plot(
            seen, turned.real, color=SOFT, linewidth=1, marker="osD^vP<>"[number % 8], markersize=5,
            label=f"measured, {name}",
        )  # fmt: skip
    styles = ((one, AFTER, "-"), (other, BEFORE, "--"))
    for (fit, colour, style), model in zip(styles, models, strict=True):
        if model is not None:
            axes.plot(
                rows, _turned(model, first).real, color=colour, linestyle=style, linewidth=2.4,
                label=short(fit.model.key),
            )  # fmt: skip
    names = [cut(measured.campaign.point(number).name, 12) for number, _ in measured.responses]
    axes.set_xticks(rows, names, rotation=30 if len(names) > 4 else 0)
    axes.set_ylabel("Shape, real part, largest = 1 [–]")
    axes.set_title(f"The mode near {chosen.frequency:.3g} Hz")
    figure.legend(loc="outside lower center", fontsize=8, frameon=False, ncols=2)
    return figure


def _turned(shape: np.ndarray, like: np.ndarray | None = None) -> np.ndarray:
    """A shape turned so that it is as real as can be, its largest part 1, its sign that of another."""
    found = shape * np.exp(-0.5j * np.angle(np.sum(shape**2)))
    found = found / np.abs(found).max()
    return -found if like is not None and np.vdot(like, found).real < 0 else found


def _shape(fit: ModalFit, number: int, posture: int) -> np.ndarray | None:
    for k, mode in enumerate(fit.measured.modes):
        if mode.number == number and mode.posture == posture and fit.pairs[k] >= 0:
            shape = fit.forecasts[posture].shape[:, fit.pairs[k]]
            return None if np.isnan(shape).any() else shape
    return None

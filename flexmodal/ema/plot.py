"""Pictures of FRFs and what was fitted to them: amplitude and phase, Nyquist, coherence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import COHERENT
from flexmodal.ema.fit import Fit
from flexmodal.ema.mode import EstimatedModes, ModeEstimate
from flexmodal.frf.form import unit
from flexmodal.report.figure import (
    DASHED,
    FITTED,
    MARK,
    MEASURED,
    THIRD,
    WIDE,
    drawing,
    headline,
    look,
    new_figure,
    phase_axis,
    positive,
    wrapped,
)


def draw_one(fit: Fit, *, title: str = "") -> Any:
    """Draw the FRFs of a fit and what was found in them; see `draw_fit`.

    Args:
        fit: of one posture.
        title: heading.
    """
    return draw_fit(fit.modes, title=title)


@drawing
def draw_fit(
    found: EstimatedModes,
    frf: int = 0,
    *,
    coherence: Float[np.ndarray, " line"] | None = None,
    title: str = "",
) -> Any:
    """Amplitude, phase and, where there is one, coherence of one FRF, measured and synthesised.

    Args:
        found: what a fit found.
        frf: which of its FRFs.
        coherence: on the lines of the fit.
        title: heading; the FRF's label if empty.

    Returns:
        A matplotlib figure.
    """
    measured, model = found.measured, found.synthesise()[:, frf]
    value, axis = measured.value[:, frf], measured.frequency
    rows = 3 if coherence is not None else 2
    figure = new_figure(WIDE, 5.4 + 1.2 * (rows - 2))
    panes = figure.subplots(rows, 1, sharex=True, height_ratios=[2.2, 1, 0.7][:rows])
    for values, style, label in ((value, look(0), "measured"), (model, look(1), "synthesised")):
        panes[0].semilogy(axis, positive(values), label=label, **style)
        panes[1].plot(*wrapped(axis, np.degrees(np.angle(values))), **style)
    panes[0].set_ylabel(f"{measured.form.capitalize()} amplitude [{unit(measured.form)}]")
    panes[0].legend()
    panes[0].set_title(title or measured.labels[frf])
    phase_axis(panes[1])
    if coherence is not None:
        panes[2].plot(axis, coherence, color=THIRD, linewidth=1.2)
        panes[2].set(ylabel="Coherence [–]", ylim=(0, 1.05))
    for pane in panes:
        for mode in found:
            pane.axvline(mode.frequency, color=MARK, linewidth=0.8, linestyle=DASHED)
    panes[-1].set(xlabel="Frequency [Hz]", xlim=(axis[0], axis[-1]))
    return figure


@drawing
def draw_nyquist(found: EstimatedModes, frf: int = 0, *, title: str = "") -> Any:
    """One FRF as mobility in the complex plane, measured and synthesised: as a whole, and round each mode.

    Args:
        found: what a fit found.
        frf: which of its FRFs.
        title: heading; the FRF's label if empty.

    Returns:
        A matplotlib figure.
    """
    value = found.measured.to("mobility").value[:, frf]
    model = found.synthesise(form="mobility")[:, frf]
    columns = min(len(found) + 1, 3)
    rows = -(-(len(found) + 1) // columns)
    figure = new_figure(3.1 * columns, 3.2 * rows + 0.5)
    panes = list(np.atleast_1d(figure.subplots(rows, columns)).ravel())
    lines = [np.ones(len(value), dtype=bool), *(_round(mode, found) for mode in found)]
    headings = ["whole band", *(f"{mode.frequency:.4g} Hz" for mode in found)]
    for pane, shown, heading, mode in zip(panes, lines, headings, [None, *found], strict=False):
        curve = model
        if mode is not None:
            curve = found.synthesise(_fine(mode, found.measured.frequency[shown]), "mobility")[:, frf]
        style = "-" if mode is None else ""
        pane.plot(value[shown].real, value[shown].imag, f"o{style}", color=MEASURED, markersize=2.5,
                  linewidth=0.6, label="measured")  # fmt: skip
        pane.plot(curve.real, curve.imag, color=FITTED, linewidth=1.4, linestyle="--", label="synthesised")
        if mode is not None:
            at = found.synthesise(np.array([mode.frequency]), "mobility")[0, frf]
            pane.plot([at.real], [at.imag], "D", color=THIRD, markersize=6, label="natural frequency")
        pane.set_aspect("equal", adjustable="datalim")
        pane.ticklabel_format(style="sci", scilimits=(-2, 3))
        pane.tick_params(labelsize=8)
        pane.set_title(heading, fontsize=10)
    for pane in panes[len(found) + 1 :]:
        pane.set_axis_off()
    for pane in panes[::columns]:
        pane.set_ylabel(f"Im mobility [{unit('mobility')}]", fontsize=9)
    for pane in panes[max(len(found) + 1 - columns, 0) : len(found) + 1]:
        pane.set_xlabel(f"Re mobility [{unit('mobility')}]", fontsize=9)
    figure.legend(*panes[min(1, len(found))].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    headline(figure, title or found.measured.labels[frf])
    return figure


def _round(mode: ModeEstimate, found: EstimatedModes) -> np.ndarray:
    """The lines within two half-power bandwidths of a mode, the five nearest at least."""
    distance = np.abs(found.measured.frequency - mode.frequency)
    lines: np.ndarray = distance <= max(
        4 * abs(mode.damping_ratio) * mode.frequency, float(np.sort(distance)[4])
    )
    return lines


def _fine(mode: ModeEstimate, lines: np.ndarray) -> np.ndarray:
    """Frequencies over these lines that run round the circle of a mode evenly, however narrow it is [Hz]."""
    first, last = lines[[0, -1]].tolist()
    turn = np.tan(np.linspace(-1.5, 1.5, 200))
    close = mode.frequency * (1 + max(abs(mode.damping_ratio), 1e-9) * turn)
    return np.union1d(np.linspace(first, last, 200), close[(close >= first) & (close <= last)])


@drawing
def draw_coherence(
    frequency: Float[np.ndarray, " line"],
    coherence: Float[np.ndarray, "frf line"],
    labels: Sequence[str] = (),
    *,
    title: str = "Coherence",
) -> Any:
    """Ordinary coherence of some FRFs over frequency, on one scale from 0 to 1.

    Args:
        frequency: of the lines [Hz].
        coherence: of each FRF, 0 to 1.
        labels: of the FRFs.
        title: heading.
    """
    figure = new_figure(8.2, 3.4)
    axes = figure.subplots()
    for place, values in enumerate(coherence[:12]):
        label = labels[place] if place < len(labels) else f"FRF {place + 1}"
        axes.plot(frequency, values, label=label, **look(place, linewidth=1.2))
    axes.axhline(COHERENT, color=MARK, linewidth=0.9, linestyle=DASHED)
    axes.set(
        xlabel="Frequency [Hz]", ylabel="Coherence [–]", ylim=(0, 1.05), xlim=(frequency[0], frequency[-1])
    )
    figure.legend(loc="outside right upper", fontsize=8)
    axes.set_title(title)
    return figure

"""Pictures of how poles were found: the circle with its traverse rate, and the stabilisation diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmodal.ema.methods.circle import CircleFit
from flexmodal.ema.methods.stabilisation import Stabilisation
from flexmodal.ema.methods.standing import mode_indicator
from flexmodal.frf.form import unit
from flexmodal.report.figure import (
    DASHED,
    FITTED,
    MARK,
    MEASURED,
    NOISE,
    SOFT,
    THIRD,
    WIDE,
    drawing,
    headline,
    new_figure,
)


@drawing
def draw_circle(fit: CircleFit, *, title: str = "") -> Any:
    """The Nyquist arc with its circle, and the traverse rate with the curve that the mode predicts.

    Args:
        fit: of one mode in one FRF.
        title: heading.
    """
    mode = fit.mode
    natural, damping = 2 * np.pi * mode.frequency, mode.damping_ratio
    figure = new_figure(9.5, 4.6)
    left, right = figure.subplots(1, 2)
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 361))
    ring = fit.centre + fit.radius * turn
    top = fit.centre + fit.radius * np.exp(1j * fit.orientation)
    far = fit.centre - fit.radius * np.exp(1j * fit.orientation)
    left.plot(ring.real, ring.imag, color=FITTED, linestyle="--", linewidth=1.4, label="fitted circle")
    left.plot(fit.arc.real, fit.arc.imag, "o", color=MEASURED, markersize=4, label="measured lines")
    left.plot([far.real, top.real], [far.imag, top.imag], color=MARK, linewidth=0.9, linestyle=":")
    left.plot([top.real], [top.imag], "D", color=THIRD, markersize=8, label="resonance")
    left.set_aspect("equal", adjustable="datalim")
    left.set(xlabel=f"Re mobility [{unit('mobility')}]", ylabel=f"Im mobility [{unit('mobility')}]")
    left.ticklabel_format(style="sci", scilimits=(-2, 3))
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower left", ncols=3)
    heading = f"{mode.frequency:.4g} Hz, ζ = {100 * damping:.3g} %"
    headline(figure, f"{title}: {heading}" if title else heading)
    middle = (fit.frequency[1:] + fit.frequency[:-1]) / 2
    fine = np.linspace(fit.frequency[0], fit.frequency[-1], 400)
    right.plot(middle, fit.traverse_rate, "o", color=MEASURED, markersize=4, label="between lines")
    right.plot(
        fine, _rate(2 * np.pi * fine, natural, damping), color=FITTED, linestyle="--", label="of the fit"
    )
    right.axhline(
        1 / (2 * damping * natural**2), color=MARK, linewidth=0.9, linestyle=":", label="1/(2ζω_n²)"
    )
    right.axvline(mode.frequency, color=MARK, linewidth=0.9, linestyle=DASHED)
    right.set(xlabel="Frequency [Hz]", ylabel="Traverse rate |dθ/d(ω²)| [s²]")
    right.set_ylim(bottom=0)
    right.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower right", ncols=3)
    return figure


def _rate(omega: np.ndarray, natural: float, damping: float) -> np.ndarray:
    """|dθ/d(ω²)| of tan θ = (ω_n² − ω²)/(2ζω_nω)."""
    below = 2 * damping * natural * omega
    tangent = (natural**2 - omega**2) / below
    return (1 / below + tangent / (2 * omega**2)) / (1 + tangent**2)


@drawing
def draw_stabilisation(
    diagram: Stabilisation, chosen: Sequence[float] = (), *, title: str = "Stabilisation diagram"
) -> Any:
    """Poles by frequency and order over the mode indicator; chosen frequencies are marked.

    Args:
        diagram: poles by order.
        chosen: frequencies to mark [Hz].
        title: heading.
    """
    figure = new_figure(WIDE, 4.8)
    axes = figure.subplots()
    behind = axes.twinx()
    behind.grid(False)
    behind.spines["right"].set_visible(True)
    indicator = mode_indicator(diagram.measured)
    behind.semilogy(diagram.measured.frequency, indicator, color=NOISE, linewidth=1.1, zorder=0)
    behind.set_ylabel("Mode indicator Σ|Y|²/noise [–]", color=SOFT)
    behind.tick_params(colors=SOFT)
    axes.set_zorder(behind.get_zorder() + 1)
    axes.patch.set_visible(False)
    fresh = ~diagram.stable_frequency
    half = diagram.stable_frequency & ~diagram.stable
    for which, marker, colour, label in (
        (fresh, ".", NOISE, "new"),
        (half, "x", FITTED, "stable frequency"),
        (diagram.stable, "o", MEASURED, "stable frequency and damping"),
    ):
        face = "none" if marker == "o" else colour
        style = {"color": colour, "markersize": 5, "markerfacecolor": face, "label": label}
        axes.plot(diagram.frequency[which], diagram.order[which], marker, **style)
    for frequency in chosen:
        axes.axvline(frequency, color=THIRD, linewidth=1.2, linestyle=(0, (4, 2)))
    axes.set(xlabel="Frequency [Hz]", ylabel="Order of the denominator [–]")
    axes.set_xlim(diagram.measured.frequency[0], diagram.measured.frequency[-1])
    axes.set_ylim(0, diagram.orders[-1] + 1)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    axes.set_title(title)
    return figure

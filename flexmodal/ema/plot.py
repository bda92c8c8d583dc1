"""Pictures of a modal fit: FRF and synthesis, circle, stabilisation, MAC, coherence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.ema.circle import CircleFit
from flexmodal.ema.mode import EstimatedModes
from flexmodal.ema.select import mode_indicator
from flexmodal.ema.shapes import FittedShapes
from flexmodal.ema.stabilisation import Stabilisation
from flexmodal.frf.form import unit
from flexmodal.frf.plot import PALETTE

MEASURED, FITTED, THIRD, MARK = PALETTE[0], PALETTE[1], PALETTE[2], "0.35"


def _figure(width: float, height: float) -> Any:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _grid(axes: Any) -> None:
    axes.grid(True, which="major", color="0.85", linewidth=0.6)
    axes.set_axisbelow(True)


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
    figure = _figure(7.5, 5.4 + 1.2 * (rows - 2))
    panes = figure.subplots(rows, 1, sharex=True, height_ratios=[2.2, 1, 0.7][:rows])
    panes[0].semilogy(axis, _above_zero(value), color=MEASURED, linewidth=1.2, label="measured")
    panes[0].semilogy(
        axis, _above_zero(model), color=FITTED, linewidth=1.6, linestyle="--", label="synthesised"
    )
    panes[0].set_ylabel(f"{measured.form.capitalize()} amplitude [{unit(measured.form)}]")
    panes[0].legend(fontsize=9, frameon=True, framealpha=0.9)
    panes[0].set_title(title or measured.labels[frf], loc="left", fontsize=11)
    for values, colour, style in ((value, MEASURED, "-"), (model, FITTED, "--")):
        lines, phase = _wrapped(axis, values)
        panes[1].plot(lines, phase, color=colour, linestyle=style, linewidth=1.3)
    panes[1].set(ylabel="Phase [°]", ylim=(-190, 190), yticks=[-180, -90, 0, 90, 180])
    if coherence is not None:
        panes[2].plot(axis, coherence, color=THIRD, linewidth=1.2)
        panes[2].set(ylabel="Coherence [–]", ylim=(0, 1.05))
    for pane in panes:
        _grid(pane)
        for mode in found:
            pane.axvline(mode.frequency, color=MARK, linewidth=0.8, linestyle=(0, (2, 2)))
    panes[-1].set(xlabel="Frequency [Hz]", xlim=(axis[0], axis[-1]))
    return figure


def _above_zero(values: np.ndarray) -> np.ndarray:
    return np.where(np.abs(values) > 0, np.abs(values), np.nan)


def _wrapped(axis: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Phase in degrees with a gap where it wraps, so that no line crosses the picture."""
    phase = np.degrees(np.angle(values))
    jump = np.flatnonzero(np.abs(np.diff(phase)) > 180) + 1
    return np.insert(axis, jump, axis[jump]), np.insert(phase, jump, np.nan)


def draw_circle(fit: CircleFit, *, title: str = "") -> Any:
    """The Nyquist arc with its circle, and the traverse rate with the curve that the mode predicts."""
    mode = fit.mode
    natural, damping = 2 * np.pi * mode.frequency, mode.damping_ratio
    figure = _figure(9.5, 4.6)
    left, right = figure.subplots(1, 2)
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 361))
    ring = fit.centre + fit.radius * turn
    top = fit.centre + fit.radius * np.exp(1j * fit.orientation)
    far = fit.centre - fit.radius * np.exp(1j * fit.orientation)
    left.plot(ring.real, ring.imag, color=FITTED, linestyle="--", linewidth=1.4, label="fitted circle")
    left.plot(fit.arc.real, fit.arc.imag, "o", color=MEASURED, markersize=4, label="measured lines")
    left.plot([far.real, top.real], [far.imag, top.imag], color=MARK, linewidth=0.9, linestyle=":")
    left.plot([top.real], [top.imag], "D", color=THIRD, markersize=8, label=f"{mode.frequency:.4g} Hz")
    left.set_aspect("equal", adjustable="datalim")
    left.set(xlabel=f"Re mobility [{unit('mobility')}]", ylabel=f"Im mobility [{unit('mobility')}]")
    left.ticklabel_format(style="sci", scilimits=(-2, 3))
    left.legend(fontsize=9, frameon=True, framealpha=0.9)
    left.set_title(title or f"ζ = {damping:.4g} ± {mode.damping_error:.2g}", loc="left", fontsize=11)
    middle = (fit.frequency[1:] + fit.frequency[:-1]) / 2
    fine = np.linspace(fit.frequency[0], fit.frequency[-1], 400)
    right.plot(middle, fit.traverse_rate, "o", color=MEASURED, markersize=4, label="between lines")
    right.plot(
        fine, _rate(2 * np.pi * fine, natural, damping), color=FITTED, linestyle="--", label="of the fit"
    )
    right.axhline(
        1 / (2 * damping * natural**2), color=MARK, linewidth=0.9, linestyle=":", label="1/(2ζω_n²)"
    )
    right.axvline(mode.frequency, color=MARK, linewidth=0.9, linestyle=(0, (2, 2)))
    right.set(xlabel="Frequency [Hz]", ylabel="Traverse rate |dθ/d(ω²)| [s²]")
    right.set_ylim(bottom=0)
    right.legend(fontsize=9, frameon=True, framealpha=0.9)
    for pane in (left, right):
        _grid(pane)
    return figure


def _rate(omega: np.ndarray, natural: float, damping: float) -> np.ndarray:
    """|dθ/d(ω²)| of tan θ = (ω_n² − ω²)/(2ζω_nω)."""
    below = 2 * damping * natural * omega
    tangent = (natural**2 - omega**2) / below
    return (1 / below + tangent / (2 * omega**2)) / (1 + tangent**2)


def draw_stabilisation(
    diagram: Stabilisation, chosen: Sequence[float] = (), *, title: str = "Stabilisation diagram"
) -> Any:
    """Poles by frequency and order over the mode indicator; chosen frequencies are marked."""
    figure = _figure(7.5, 4.8)
    axes = figure.subplots()
    behind = axes.twinx()
    indicator = mode_indicator(diagram.measured)
    behind.semilogy(diagram.measured.frequency, indicator, color="0.72", linewidth=1.1, zorder=0)
    behind.set_ylabel("Mode indicator Σ|Y|²/noise [–]", color="0.45")
    behind.tick_params(colors="0.45")
    axes.set_zorder(behind.get_zorder() + 1)
    axes.patch.set_visible(False)
    fresh = ~diagram.stable_frequency
    half = diagram.stable_frequency & ~diagram.stable
    for which, marker, colour, label in (
        (fresh, ".", "0.6", "new"),
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
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=9)
    axes.set_title(title, loc="left", fontsize=11)
    return figure


def draw_mac(
    matrix: Float[np.ndarray, "mode other"],
    rows: Sequence[str] = (),
    columns: Sequence[str] = (),
    *,
    title: str = "Modal assurance criterion",
) -> Any:
    """A MAC matrix with its numbers in the cells.

    Args:
        matrix: as `flexmodal.modal.mac` gives it.
        rows: names of the first set's modes; numbered if empty.
        columns: names of the second set's modes.
        title: heading.
    """
    count, other = matrix.shape
    figure = _figure(1.8 + 0.75 * max(other, 2), 1.4 + 0.7 * max(count, 2))
    axes = figure.subplots()
    image = axes.imshow(matrix, vmin=0, vmax=1, cmap="cividis", aspect="auto")
    axes.set_xticks(range(other), list(columns) or [str(place + 1) for place in range(other)])
    axes.set_yticks(range(count), list(rows) or [str(place + 1) for place in range(count)])
    axes.set(xlabel="Mode of the second set", ylabel="Mode of the first set")
    if count * other <= 400:
        for row, column in np.ndindex(count, other):
            colour = "black" if matrix[row, column] > 0.55 else "white"
            axes.text(
                column, row, f"{matrix[row, column]:.2f}", ha="center", va="center", color=colour, fontsize=9
            )
    figure.colorbar(image, ax=axes, label="MAC [–]")
    axes.set_title(title, loc="left", fontsize=11)
    return figure


def draw_shapes(shapes: FittedShapes, names: Mapping[int, str]) -> Any:
    """What each point does in each mode, in the campaign's order: filled in phase, open a quarter off."""
    figure = _figure(7.5, 4.2)
    axes = figure.subplots()
    points = range(len(shapes.places))
    for mode, frequency in enumerate(shapes.frequency):
        look = {"color": PALETTE[mode % len(PALETTE)], "marker": "osD^v"[mode % 5]}
        values = shapes.shape[:, mode]
        axes.plot(points, values.real, linestyle="-", label=f"{frequency:.4g} Hz, in phase", **look)
        axes.plot(points, values.imag, linestyle=":", linewidth=1, markerfacecolor="none", **look)
    axes.axhline(0, color=MARK, linewidth=0.9)
    labels = [
        f"{names.get(point, point)}\n{'+' if way > 0 else '-'}{'xyz'[abs(way) - 1]}"
        for point, way in shapes.places
    ]
    axes.set_xticks(points)
    for tick, label in zip(axes.set_xticklabels(labels, fontsize=8), labels, strict=True):
        tick.set(text=label, parse_math=False)
    axes.set(ylabel="Residue over the largest [–]", ylim=(-1.15, 1.15))
    axes.legend(fontsize=9, frameon=True, framealpha=0.9)
    axes.set_title(f"Posture {shapes.posture}: shapes; dotted, a quarter period off", loc="left", fontsize=11)
    _grid(axes)
    return figure


def draw_coherence(
    frequency: Float[np.ndarray, " line"],
    coherence: Float[np.ndarray, "frf line"],
    labels: Sequence[str] = (),
    *,
    title: str = "Coherence",
) -> Any:
    """Ordinary coherence of some FRFs over frequency, on one scale from 0 to 1."""
    figure = _figure(7.5, 3.2)
    axes = figure.subplots()
    styles = ("-", "--", "-.", ":")
    for place, values in enumerate(coherence[:12]):
        label = labels[place] if place < len(labels) else f"FRF {place + 1}"
        look = {"color": PALETTE[place % len(PALETTE)], "linestyle": styles[place % len(styles)]}
        axes.plot(frequency, values, linewidth=1.2, label=label, **look)
    axes.axhline(0.8, color=MARK, linewidth=0.9, linestyle=(0, (2, 2)))
    axes.set(
        xlabel="Frequency [Hz]", ylabel="Coherence [–]", ylim=(0, 1.05), xlim=(frequency[0], frequency[-1])
    )
    axes.legend(fontsize=9, frameon=True, framealpha=0.9)
    axes.set_title(title, loc="left", fontsize=11)
    _grid(axes)
    return figure

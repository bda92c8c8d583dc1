"""Pictures of the report: disagreement over posture and frequency, FRFs with their noise, the gap's descent.

Drawn narrow, so that they can be read on a telephone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.disagreement.compare import excess
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report.words import pair, placed
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.report.figure import (
    DASHED,
    INK,
    NARROW,
    NOISE,
    PALETTE,
    SOFT,
    drawing,
    frequency_axis,
    log_axis,
    new_figure,
    phase_axis,
    short,
    wrapped,
)

BEFORE, AFTER, MEASURED, MARK = PALETTE[1], PALETTE[0], INK, PALETTE[4]
MOST_PAIRS = 6
"""FRFs shown at most."""
_BINS = 56
_HOTTEST = 30.0
"""Times the noise at which the colours of the map end."""

Stage = Complex[np.ndarray, "observation line"]


def over_noise(
    observations: Observations, predicted: Stage, edges: Float[np.ndarray, " edge"]
) -> Float[np.ndarray, "posture bin"]:
    """Root mean square of |ln(model / measured)| over that of the noise; NaN in bands without lines."""
    squared = np.where(observations.used, np.abs(residual(predicted, observations.value)) ** 2, 0.0)
    noise = np.where(observations.used, observations.variance, 0.0)
    which = np.digitize(observations.axis.frequency, edges[1:-1])
    count = len(edges) - 1
    total = np.zeros((2, len(observations.postures), count))
    for number in range(len(observations.postures)):
        rows = observations.posture == number
        for place, values in enumerate((squared, noise)):
            total[place, number] = np.bincount(which, values[rows].sum(axis=0), count)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(total[1] > 0, np.sqrt(total[0] / total[1]), np.nan)


@drawing
def draw_map(diagnosis: Diagnosis, stage: str, title: str) -> Any:
    """Disagreement of one stage over posture and frequency, as a multiple of the noise."""
    from matplotlib.colors import LogNorm

    observations = diagnosis.observations
    frequency = observations.axis.frequency
    edges = _bands(frequency)
    values = over_noise(observations, diagnosis.predicted[stage], edges)
    figure = new_figure(NARROW, 1.5 + 0.27 * len(values))
    axes = figure.subplots()
    image = axes.pcolormesh(
        edges, np.arange(len(values) + 1), np.clip(values, 1.0, _HOTTEST), norm=LogNorm(1.0, _HOTTEST),
        edgecolors="face", linewidth=0.3,
    )  # fmt: skip
    axes.grid(False)
    frequency_axis(axes, frequency, wide=1.0)
    axes.set_ylim(len(values), 0)
    names = [short(p.name) + (" *" if p.id in diagnosis.held_out else "") for p in observations.postures]
    axes.set_yticks(np.arange(len(values)) + 0.5, names)
    axes.tick_params(length=0, axis="y")
    bar = figure.colorbar(image, ax=axes, pad=0.02, aspect=14)
    bar.set_ticks([1, 3, 10, 30], labels=["noise", "3 ×", "10 ×", "≥ 30 ×"])
    bar.ax.minorticks_off()
    axes.set_title(title)
    return figure


def _bands(frequency: Float[np.ndarray, " line"]) -> Float[np.ndarray, " edge"]:
    """Edges of bands of about equal width on a logarithmic scale, each with a line in it at least."""
    middles = np.sqrt(frequency[1:] * frequency[:-1])
    wanted = np.geomspace(frequency[0], frequency[-1], _BINS + 1)[1:-1]
    inner = np.unique(np.searchsorted(middles, wanted)) if len(middles) else np.zeros(0, dtype=int)
    inner = inner[(inner >= 0) & (inner < len(middles))]
    return np.concatenate([frequency[:1], middles[inner], frequency[-1:]])


def telling_rows(diagnosis: Diagnosis) -> list[int]:
    """Observations that show most of the disagreement: one for each pair, then further postures."""
    observations = diagnosis.observations
    above = excess(observations, diagnosis.predicted["before"]).sum(axis=1)
    if not above.any():
        above = np.mean(np.abs(residual(diagnosis.predicted["before"], observations.value)) ** 2, axis=1)
    order = np.argsort(-above, kind="stable").tolist()
    chosen: list[int] = []
    seen: dict[tuple[int, ...], int] = {}
    for row in order:
        key = (*observations.response[row].tolist(), *observations.reference[row].tolist())
        posture = (-1, int(observations.posture[row]))
        if seen.get(key, 0) < 1 and seen.get(posture, 0) < 2:
            chosen.append(row)
            seen[key], seen[posture] = 1, seen.get(posture, 0) + 1
    for row in order:
        if len(chosen) >= min(MOST_PAIRS, len(observations)):
            break
        if row not in chosen:
            chosen.append(row)
    return chosen[:MOST_PAIRS]


@drawing
def draw_pair(diagnosis: Diagnosis, row: int) -> Any:
    """One FRF: measured with its noise, the model before and after; amplitude and phase."""
    observations = diagnosis.observations
    frequency, measured = observations.axis.frequency, observations.value[row]
    figure = new_figure(NARROW, 5.2)
    upper, lower, off = figure.subplots(3, 1, sharex=True, height_ratios=[2.4, 0.9, 1.5])
    used = observations.used[row]
    shown = np.where(used, np.abs(measured), np.nan)
    spread = np.exp(2 * np.sqrt(np.where(used, observations.variance[row], 0.0) / 2))
    for region in diagnosis.disagreement:
        if _is_of(observations, row, region.posture, region.response, region.reference):
            for axes in (upper, lower, off):
                axes.axvspan(*region.band, color=MARK, alpha=0.22, linewidth=0)
    upper.fill_between(frequency, shown / spread, shown * spread, color=NOISE, linewidth=0)
    noise = np.sqrt(np.where(used, observations.variance[row], np.nan))
    off.fill_between(frequency, 0, 2 * noise, color=NOISE, linewidth=0)
    for stage, colour, style in curves_of(diagnosis):
        value = diagnosis.predicted[stage][row]
        look = {"color": colour, "linestyle": style}
        upper.plot(frequency, np.abs(value), linewidth=1.8, **look)
        lower.plot(*wrapped(frequency, np.degrees(np.angle(value))), **look)
        far = np.where(used, np.abs(residual(value, measured)), np.nan)
        off.plot(frequency, far, linewidth=1.2, **look)
    phase = np.where(used, np.degrees(np.angle(measured)), np.nan)
    upper.plot(frequency, shown, color=MEASURED, linewidth=0.8)
    lower.plot(*wrapped(frequency, phase), color=MEASURED, linewidth=0.8)
    upper.set(yscale="log", ylabel="Receptance [m/N]")
    phase_axis(lower)
    off.set(yscale="log", ylabel="|ln(model/\nmeasured)|")
    off.set_ylim(bottom=3e-3)
    frequency_axis(off, frequency)
    posture = observations.postures[int(observations.posture[row])]
    held = " (held out)" if posture.id in diagnosis.held_out else ""
    upper.set_title(f"{short(posture.name, 24)}{held}\n{short(pair(observations, row), 48)}", fontsize=10)
    return figure


@drawing
def draw_descent(diagnosis: Diagnosis) -> Any:
    """The gap step by step, on all postures and on those held out, above the noise floor."""
    gaps = diagnosis.gaps
    stages = [("card as\nit came", gaps.believed, None), ("re-tuned", gaps.before, gaps.held_out_before)]
    for step in diagnosis.steps:
        name = "+ " + placed(step.effect, step.where).replace(" (", "\n(")
        stages.append((name, step.gaps.after, step.gaps.held_out_after))
    if diagnosis.model.placed and not diagnosis.steps:
        stages.append(("best that\nwas tried", gaps.after, gaps.held_out_after))
    elif diagnosis.steps and not np.isclose(gaps.after, diagnosis.steps[-1].gaps.after, rtol=0.005):
        stages.append(("all fitted\ntogether", gaps.after, gaps.held_out_after))
    labels, every, held = zip(*stages, strict=True)
    places = np.arange(len(labels))
    figure = new_figure(max(NARROW, 1.25 * len(labels) + 0.8), 3.5)
    axes = figure.subplots()
    axes.axhspan(0, gaps.noise_floor, color=NOISE, alpha=0.6, linewidth=0)
    axes.axhline(gaps.noise_floor, color=SOFT, linewidth=1, linestyle=DASHED)
    first = np.array([np.nan if value is None else value for value in every], dtype=float)
    second = np.array([np.nan if value is None else value for value in held], dtype=float)
    axes.plot(places, first, color=AFTER, marker="o", markersize=7, label="all postures")
    if np.isfinite(second).any():
        axes.plot(
            places, second, color=BEFORE, marker="s", linestyle="--", markersize=7, markerfacecolor="none",
            label="held-out postures",
        )  # fmt: skip
    for place, value in zip(places, first, strict=True):
        if np.isfinite(value):
            axes.annotate(
                f"{value:.3g}", (place, value), xytext=(6, 6), textcoords="offset points", fontsize=9
            )
    log_axis(axes.yaxis)
    finite = np.concatenate([first[np.isfinite(first)], second[np.isfinite(second)], [gaps.noise_floor]])
    axes.set_ylim(0.6 * finite[finite > 0].min(initial=1.0), 1.9 * finite.max())
    axes.set_xlim(-0.4, len(labels) - 0.35)
    axes.set_xticks(places, labels)
    says = f"noise floor {gaps.noise_floor:.3g}"
    axes.text(-0.35, gaps.noise_floor * 0.97, says, ha="left", va="top", fontsize=9, color=SOFT)
    axes.set_ylabel("Gap [–]")
    axes.legend()
    return figure


def _is_of(
    observations: Observations, row: int, posture: int, response: Sequence[int], reference: Sequence[int]
) -> bool:
    return (
        observations.postures[int(observations.posture[row])].id == posture
        and observations.response[row].tolist() == list(response)
        and observations.reference[row].tolist() == list(reference)
    )


def curves_of(diagnosis: Diagnosis) -> list[tuple[str, str, Any]]:
    """Stages that are drawn, with colour and line style."""
    before: list[tuple[str, str, Any]] = [("before", BEFORE, (0, (4, 2)))]
    return [*before, ("after", AFTER, "-")] if diagnosis.model.placed else before

"""An identification as one self-contained HTML page."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

from flexmodal.identification.baselines import Baselines
from flexmodal.identification.evidence.both import Both
from flexmodal.identification.outcome import Estimate, Identification
from flexmodal.identification.plot import draw_held_out, draw_identification, draw_modes
from flexmodal.report import (
    Facts,
    Items,
    Parts,
    Picture,
    Section,
    Table,
    Text,
    columns,
    page_text,
    write_page,
)
from flexmodal.report.words import DASH, minus, noises, size

HEADER = ("parameter", "value", "standard error", "95 % interval", "card", "remarks")
GAPS = ("", "card", "fit", "noise floor")
_LINES = "|ln(model / measured)| over all coherent lines, each weighted by its coherence"
GAP_OF = {
    "frf": _LINES,
    "both": _LINES,
    "modes": "the relative errors of frequency, a tenth of those of damping ratio, and 1 − MAC",
}
GAP_NOTE = (
    "Of FRFs, a gap of 0.1 means that on a typical line the model is about 10 % off in size or 6° in phase. "
    "The noise floor is what the noise of the measurement alone makes of it: no model can come nearer. Held "
    "out: predicted by a fit that had not seen it."
)
STAGES = ("stage", "gap", "× the noise", "took")
STAGES_NOTE = (
    "Little was known of the card, so the fit went in stages. Each is told with its gap, and with the part "
    "of the squared distance above the noise, as the card had it, that it took."
)
BESIDE = ("held out", "model", "mean of the others", "nearest posture", "which", "noise floor")
BESIDE_NOTE = (
    "The FRFs of the other postures taken for those of the posture that was held out: their mean at each "
    "line, and those of the posture whose angles differ least. A model is worth having where it comes "
    "nearer. Shuffled: fitted while every posture bears another's angles, on what was fitted."
)
KEYS = {"fitted_to": "fitted to", "held_out": "held out", "numbers": "numbers fitted"}


def write_identification_page(outcome: Identification, path: Path, *, overwrite: bool = False) -> None:
    """Write the page; it needs no network.

    Args:
        outcome: of an identification.
        path: of the new file.
        overwrite: replace a file that stands there.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    problem = outcome.problem
    rows = [estimate_cells(one) for one in outcome.estimates]
    faint = frozenset(k for k, one in enumerate(outcome.estimates) if not one.identified)
    verdict = outcome.verdict[:1].upper() + outcome.verdict[1:]
    lead: Parts = [
        f"{verdict}.",
        f"Before the fit: {outcome.before_fit.verdict}.",
        *outcome.problem.warnings,
        Table(columns(HEADER, words=HEADER[-1:]), rows, faint=faint),
    ]
    gap: Parts = [f"The gap between model and measurement: the root mean square of {GAP_OF[problem.source]}.",
           Table(columns(GAPS), gap_cells(outcome)), Text(GAP_NOTE, note=True)]  # fmt: skip
    if outcome.stages:
        gap = [*gap, STAGES_NOTE, Table(columns(STAGES, words=STAGES[:1]), stage_cells(outcome))]
    beside = outcome.baselines
    if beside is not None:
        table = Table(columns(BESIDE, words=["which"]), baseline_cells(beside))
        gap = [*gap, f"Beside simple baselines: {beside.verdict}.", table, Text(BESIDE_NOTE, note=True)]
    pictures = [Picture(partial(draw_identification, outcome), "Measured and modelled")]
    if isinstance(problem.evidence, Both):
        pictures.append(Picture(partial(draw_modes, outcome, problem.evidence.modes), "Errors of the modes"))
    if outcome.held_out:
        pictures.append(Picture(partial(draw_held_out, outcome), "Gaps of what the fit had not seen"))
    tied = ", ".join(f"{a} and {b} ({minus(f'{r:+.3f}')})" for a, b, r in outcome.correlated)
    left = [Items([one.says for one in outcome.not_identified], "Nothing.")]
    provenance = {KEYS.get(key, key): _shown(key, value) for key, value in outcome.provenance.items()}
    sections = [
        Section("Gap", gap),
        Section("Measured against model", pictures),
        Section("What the data leave open", [*left, *([f"Closely correlated: {tied}."] if tied else [])]),
        Section("Where it comes from", [Facts(provenance)]),
    ]
    title = f"{problem.campaign.title}: identification of {problem.robot.name}"
    write_page(path, page_text(title, lead, sections), overwrite=overwrite)


def estimate_cells(one: Estimate) -> tuple[str, ...]:
    """One row of text, under `HEADER`."""
    unit = f" {one.unit}" if one.unit else ""
    remarks = [
        text
        for text, here in (
            ("at its bound: no error can be given", one.at_bound),
            ("not identified", not one.identified and not one.at_bound),
        )
        if here
    ]
    low, high = one.interval
    return (
        one.name,
        f"{_number(one.value)}{unit}",
        DASH if math.isnan(low) else _number(one.standard_error, 2),
        DASH if math.isnan(low) else f"{_number(low)} to {_number(high)}",
        _number(one.card),
        ", ".join(remarks),
    )


def gap_cells(outcome: Identification) -> list[tuple[str, ...]]:
    """Rows of text under `GAPS`: what was fitted, what was held out, and each part of that."""
    gap = outcome.gap
    cells = [("fitted", gap.before, gap.after, gap.noise_floor)]
    if gap.held_out_before is not None and gap.held_out_after is not None:
        floor = gap.held_out_noise_floor or gap.noise_floor
        cells.append(("held out", gap.held_out_before, gap.held_out_after, floor))
    cells += [
        (f"  {one.kind} {one.name}", one.before, one.after, one.noise_floor) for one in outcome.held_out
    ]
    return [(name, *(size(value) for value in values)) for name, *values in cells]


def stage_cells(outcome: Identification) -> list[tuple[str, ...]]:
    """Rows of text under `STAGES`.

    Args:
        outcome: of a fit in stages.
    """
    cells: list[tuple[str, ...]] = []
    for number, one in enumerate(outcome.stages):
        took = f"{100 * one.share:.0f} %" if number else ""
        cells.append((one.name, f"{one.gap:.3g}", noises(one.over_noise), minus(took)))
    return cells


def baseline_cells(found: Baselines) -> list[tuple[str, ...]]:
    """Rows of text under `BESIDE`: everything that was held out, each posture of it, and the control.

    Args:
        found: on the postures that were held out.
    """
    cells = [_beside("all", found.model, found.mean, found.nearest, "", found.noise_floor)]
    cells += [
        _beside(f"  {one.posture}", one.model, one.mean, one.nearest, one.nearest_posture, one.noise_floor)
        for one in found.each
    ]
    if found.shuffled is not None and found.fitted is not None:
        for name, value in (("fitted, angles right", found.fitted), ("fitted, shuffled", found.shuffled)):
            cells.append((name, f"{value:.3g}", DASH, DASH, "", DASH))
    return cells


def _beside(
    name: str, model: float, mean: float, nearest: float, which: str, floor: float
) -> tuple[str, ...]:
    return name, f"{model:.3g}", f"{mean:.3g}", f"{nearest:.3g}", which, f"{floor:.2g}"


def _number(value: float, digits: int = 5) -> str:
    """So many digits that count, written out where that is not long."""
    text = f"{value:.{digits}g}"
    if "e" not in text or not 1e-4 <= abs(value) < 1e8:
        return text
    return f"{float(text):.0f}"


def _shown(key: str, value: Any) -> str:
    if key == "band":
        return f"{value[0]:g} to {value[1]:g} Hz"
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)

"""The report of a diagnosis from modes: one page of its own, in the style of the other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.diagnosis.modes.evidence import ModalFit
from flexmodal.diagnosis.modes.findings import Findings
from flexmodal.diagnosis.modes.gap import Errors, errors, figures
from flexmodal.diagnosis.modes.pictures import draw_evidence, draw_frequencies, draw_shapes, short
from flexmodal.diagnosis.modes.variants import VARIANTS
from flexmodal.diagnosis.modes.words import left_words, named, shape_words, tie_words
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report.arm_picture import draw_arm
from flexmodal.diagnosis.report.pictures import draw_descent
from flexmodal.diagnosis.report.tables import base_rows, effect_rows, next_words, region_rows
from flexmodal.diagnosis.report.words import percent, placed, size
from flexmodal.frf.plot import svg_text

TEMPLATE = Path(__file__).with_name("template.html")
STYLE = Path(__file__).parents[1] / "report" / "template.html"


def modal_text(diagnosis: Diagnosis, notes: Sequence[str] = ()) -> str:
    """The page as text."""
    from jinja2 import Environment

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    style = STYLE.read_text(encoding="utf-8").partition("<style>")[2].partition("</style>")[0]
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    return template.render(**_content(diagnosis, notes), style=style)


def _content(diagnosis: Diagnosis, notes: Sequence[str]) -> dict[str, Any]:
    found = diagnosis.modal
    assert found is not None
    name = after_name(diagnosis, found)
    pair = compared_fits(found)
    return {
        "d": diagnosis,
        "found": found,
        "state": "open"
        if not diagnosis.verdict.explained
        else "found"
        if diagnosis.verdict.effects
        else "nothing",
        "headline": headline(diagnosis, found),
        "verdict": verdict_paragraphs(diagnosis, found),
        "tied": found.tied,
        "summary": summary_rows(found, name),
        "regions": region_rows(diagnosis.disagreement),
        "remaining": region_rows(diagnosis.remaining) if diagnosis.steps else [],
        "frequencies": svg_text(draw_frequencies(found, name)),
        "evidence": svg_text(draw_evidence(found)) if len(found.comparison.models) > 1 else "",
        "shapes": svg_text(draw_shapes(found, *pair)) if pair and found.shapes else "",
        "shape_rows": shape_rows(found),
        "compared": [] if found.compared is None else [named(key) for key in found.compared],
        "arm": svg_text(draw_arm(diagnosis)),
        "descent": svg_text(draw_descent(diagnosis)) if diagnosis.steps else "",
        "weighing": weighing_rows(found),
        "variants": [variant.name for variant in VARIANTS],
        "modes": mode_rows(found),
        "name": name,
        "steps": [
            {
                "name": placed(s.effect, s.where),
                "parameters": effect_rows(s),
                "confidence": percent(s.confidence),
            }
            for s in diagnosis.steps
        ],
        "base": base_rows(diagnosis),
        "next": None
        if diagnosis.next_measurement is None
        else next_words(diagnosis, diagnosis.next_measurement),
        "notes": notes,
        "size": size,
    }


def headline(diagnosis: Diagnosis, found: Findings) -> str:
    """The verdict in a line."""
    if diagnosis.steps:
        names = " and ".join(placed(s.effect, s.where) for s in diagnosis.steps)
        return f"{'Added as asked, not decided' if found.tied else 'Missing'}: {names}"
    if diagnosis.verdict.explained:
        return "Nothing is missing that these modes could show"
    if not found.missing:
        return "Something is missing; these modes do not say what"
    return "A mode is missing; these data do not say what makes it"


def verdict_paragraphs(diagnosis: Diagnosis, found: Findings) -> list[dict[str, Any]]:
    """The verdict's sentences by what they are of: the gap, the ties, the shapes, what is left."""
    says = diagnosis.verdict.says
    tie = tie_words(found) if found.tied else ""
    for part in filter(None, (tie, shape_words(found), left_words(found))):
        says = says.replace(part, f"\n{part}\n")
    parts = [one.strip() for one in says.split("\n")]
    return [{"says": one, "tie": one == tie} for one in parts if one]


def after_name(diagnosis: Diagnosis, found: Findings) -> str:
    """What the second model of the pictures is."""
    name = short(found.after.explanation.key)
    if found.after.explanation.key[0] == NONE:
        return "re-tuned"
    if diagnosis.steps:
        return f"with {' and '.join(placed(s.effect, s.where) for s in diagnosis.steps)}"
    return f"best of what is tied: {name}"


def compared_fits(found: Findings) -> tuple[ModalFit, ModalFit] | None:
    """The two explanations whose shapes are compared."""
    if found.compared is None:
        return None
    table = {one.key: one.fit for one in found.comparison.models}
    return table[found.compared[0]], table[found.compared[1]]


def summary_rows(found: Findings, name: str) -> list[list[str]]:
    """Re-tuned, with what was added, the two baselines: fitted, and each posture held out."""
    rows = [
        _figures(
            "re-tuned, nothing added",
            errors(found.before),
            None if found.held_before is None else found.held_before.errors,
        )
    ]
    if found.after.explanation.key[0] not in (NONE, UNSTRUCTURED):
        rows.append(
            _figures(name, errors(found.after), None if found.held_after is None else found.held_after.errors)
        )
    if found.free is not None:
        rows.append(
            _figures(
                "one more mode with no structure",
                errors(found.free),
                None if found.held_free is None else found.held_free.errors,
            )
        )
    rows.append(_figures("the mean of the other postures", None, found.mean))
    return rows


def _figures(name: str, fitted: Errors | None, held: Errors | None) -> list[str]:
    cells = [name]
    for table in (fitted, held):
        if table is None:
            cells += ["–"] * 5
            continue
        f = figures(table)
        cells += [str(f.missing), f"{100 * f.frequency:.2f} %", f"{100 * f.damping:.0f} %",
                  f"{f.mac:.2f}" if np.isfinite(f.mac) else "–", size(f.gap)]  # fmt: skip
    return cells


def weighing_rows(found: Findings) -> list[dict[str, Any]]:
    """Everything that was weighed, the most probable first."""
    comparison, rows = found.comparison, []
    base = len(comparison.models[0].fit.explanation.space)
    gain = comparison.table - comparison.table[0]
    for k in comparison.order:
        one = comparison.models[k]
        rows.append({
            "name": "nothing added" if k == 0 else short(one.key),
            "adds": len(one.fit.explanation.space) - base,
            "missing": sum(partner < 0 for partner in one.fit.pairs),
            "gain": f"{gain[k, 0]:.1f}".replace("-", "−"),
            "range": f"{gain[k].min():.0f} … {gain[k].max():.0f}".replace("-", "−"),
            "held": "–" if one.held is None or comparison.models[0].held is None
            else f"{one.held.score - comparison.models[0].held.score:+.1f}".replace("-", "−"),
            "probability": percent(comparison.probability[k]),
            "width": 100 * comparison.probability[k],
            "tied": one.key in found.tied,
        })  # fmt: skip
    return rows


def shape_rows(found: Findings) -> list[list[str]]:
    """Shape by shape: what was measured, what two explanations predict."""

    def two(value: float) -> str:
        return f"{value:.2f}" if np.isfinite(value) else "–"

    return [
        [f"{s.frequency:.3g} Hz", two(s.measured), f"{two(s.model[0])}, {two(s.model[1])}", two(s.alike),
         f"{two(s.met[0])}, {two(s.met[1])}", f"{s.says:+.1f}".replace("-", "−"), f"{s.clean:.0f}"]
        for s in found.shapes
    ]  # fmt: skip


def mode_rows(found: Findings) -> list[list[str]]:
    """Every measured mode beside the models."""
    rows = []
    for k, mode in enumerate(found.measured.modes):
        cells = [
            found.measured.postures[mode.posture].name,
            f"{mode.frequency:.2f} ± {mode.frequency * mode.frequency_error:.2f}",
        ]
        cells += [_frequency(found.before, k), _frequency(found.after, k)]
        held = float("nan") if found.held_after is None else found.held_after.frequency[k]
        cells += [
            f"{held:.2f}" if np.isfinite(held) else "–",
            f"{mode.frequency * (1 + found.mean[k, 0]):.2f}" if found.mean[k, 0] != 1 else "–",
        ]
        cells += [
            f"{mode.damping_ratio:.3f}" if np.isfinite(mode.damping_ratio) else "–",
            _damping(found.before, k),
            _damping(found.after, k),
        ]
        rows.append(cells)
    return rows


def _frequency(fit: ModalFit, k: int) -> str:
    seen = fit.forecasts[fit.measured.modes[k].posture]
    return f"{np.exp(seen.log_frequency[fit.pairs[k]]):.2f}" if fit.pairs[k] >= 0 else "–"


def _damping(fit: ModalFit, k: int) -> str:
    seen = fit.forecasts[fit.measured.modes[k].posture]
    return f"{np.exp(seen.log_damping[fit.pairs[k]]):.3f}" if fit.pairs[k] >= 0 else "–"

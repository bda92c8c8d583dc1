"""A diagnosis as one self-contained HTML page: no script, no network, every name escaped."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from flexmodal.diagnosis.names import UNKNOWN
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report.arm_picture import draw_arm
from flexmodal.diagnosis.report.pictures import draw_descent, draw_map, draw_pair, telling_rows
from flexmodal.diagnosis.report.tables import (
    base_rows,
    effect_rows,
    next_words,
    refused_rows,
    region_rows,
    weighing_rows,
)
from flexmodal.diagnosis.report.words import effect_words, pair, percent, placed, posture_name, size
from flexmodal.files import whole_file
from flexmodal.frf.plot import svg_text

TEMPLATE = "template.html"


def write_report(
    diagnosis: Diagnosis, path: Path, *, notes: Sequence[str] = (), overwrite: bool = False
) -> None:
    """Write the page.

    Args:
        diagnosis: what `diagnose` found.
        path: a new `.html` file.
        notes: sentences about what the files of the improved robot do not hold.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
    """
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(report_text(diagnosis, notes), encoding="utf-8")


def report_text(diagnosis: Diagnosis, notes: Sequence[str] = ()) -> str:
    """The page as text."""
    if diagnosis.modal is not None:
        from flexmodal.diagnosis.modes.page import modal_text

        return modal_text(diagnosis, notes)
    from jinja2 import Environment

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    template = Path(__file__).with_name(TEMPLATE).read_text(encoding="utf-8")
    return environment.from_string(template).render(**_content(diagnosis, notes))


def _content(diagnosis: Diagnosis, notes: Sequence[str]) -> dict[str, Any]:
    words = effect_words(diagnosis)
    observations = diagnosis.observations
    return {
        "d": diagnosis,
        "state": _state(diagnosis),
        "headline": _headline(diagnosis),
        "certainty": _certainty(diagnosis),
        "figures": _figures(diagnosis),
        "regions": region_rows(diagnosis.disagreement),
        "remaining": region_rows(diagnosis.remaining),
        "maps": [_svg(figure) for figure in _maps(diagnosis)],
        "arm": _svg(draw_arm(diagnosis)),
        "pairs": [
            {"svg": _svg(draw_pair(diagnosis, row)), "name": pair(observations, row)}
            for row in telling_rows(diagnosis)
        ],
        "steps": [
            {
                "name": placed(step.effect, step.where),
                "says": words.get(step.effect, ""),
                "rows": weighing_rows(diagnosis, step),
                "parameters": effect_rows(step),
                "ties": [placed(*tie) for tie in step.ties],
                "confidence": percent(step.confidence),
            }
            for step in diagnosis.steps
        ],
        "refused": refused_rows(diagnosis),
        "descent": _svg(draw_descent(diagnosis)),
        "base": base_rows(diagnosis),
        "next": None
        if diagnosis.next_measurement is None
        else next_words(diagnosis, diagnosis.next_measurement),
        "held": [posture_name(observations, number) for number in diagnosis.held_out],
        "notes": notes,
        "size": size,
    }


def _state(diagnosis: Diagnosis) -> str:
    if not diagnosis.verdict.explained:
        return "open"
    return "found" if diagnosis.verdict.effects else "nothing"


def _headline(diagnosis: Diagnosis) -> str:
    names = [placed(effect, where) for effect, where in diagnosis.verdict.effects if effect != UNKNOWN]
    if not diagnosis.verdict.explained:
        return "Something is missing that the catalogue does not know"
    return f"Missing: {' and '.join(names)}" if names else "Nothing is missing"


def _certainty(diagnosis: Diagnosis) -> str:
    """The least sure of the steps, in a word; nothing where there is none."""
    if not diagnosis.steps:
        return ""
    return percent(min(step.confidence for step in diagnosis.steps))


def _figures(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """The gaps, large."""
    gaps = diagnosis.gaps
    over = gaps.after / gaps.noise_floor if gaps.noise_floor > 0 else float("inf")
    cards = [
        {"name": "the card as it came", "value": size(gaps.believed), "more": ""},
        {"name": "re-tuned, nothing added", "value": size(gaps.before), "more": _held(gaps.held_out_before)},
    ]
    if diagnosis.model.placed:
        name = "with what was added" if diagnosis.steps else "with the best that was tried"
        cards.append({"name": name, "value": size(gaps.after), "more": _held(gaps.held_out_after)})
    floor = {
        "name": "noise floor",
        "value": size(gaps.noise_floor),
        "more": f"the model is at {over:.2f}\u00a0×",
    }
    return [*cards, floor]


def _held(value: float | None) -> str:
    return "" if value is None else f"held out: {size(value)}"


def _maps(diagnosis: Diagnosis) -> Iterator[Any]:
    yield draw_map(diagnosis, "before", "Re-tuned, nothing added")
    if diagnosis.model.placed:
        yield draw_map(diagnosis, "after", "With what was added")


def _svg(figure: Any) -> str:
    with warnings.catch_warnings():  # letters that the font lacks are drawn by the browser all the same
        warnings.filterwarnings("ignore", message="Glyph .* missing")
        return svg_text(figure)

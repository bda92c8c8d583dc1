"""An identification as one self-contained HTML page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flexmodal.files import whole_file
from flexmodal.frf.plot import svg_text
from flexmodal.identification.outcome import Estimate, Identification
from flexmodal.identification.plot import draw_held_out, draw_identification

_TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{{ title }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  color: #111 }
svg { width: 100%; height: auto; max-width: 54rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { padding: .15rem .7rem; text-align: right; border-bottom: 1px solid #ddd }
th:first-child, td:first-child, .words td { text-align: left }
.words td + td { overflow-wrap: anywhere }
.wide { overflow-x: auto }
.wide th, .wide td { white-space: nowrap }
.open td { color: #666 }
figure { margin: 1rem 0; break-inside: avoid; overflow-x: auto }
h2 { break-after: avoid }
@media (max-width: 40rem) { h1 { font-size: 1.4rem } figure svg { min-width: 34rem } }
@media print { body { margin: 0; max-width: none; font-size: 12px } .wide, figure { overflow: visible }
  tr { break-inside: avoid } }
</style></head><body>
<h1>{{ title }}</h1>
<p>{{ verdict }}.</p>
<p>Before the fit: {{ before }}.</p>
<div class="wide"><table>
<tr>{% for cell in header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in rows %}<tr{% if not row.known %} class="open"{% endif %}>
{% for cell in row.cells %}<td>{{ cell
}}</td>{% endfor %}</tr> {% endfor %}</table></div>
<h2>Gap</h2>
<p>Root mean square of {{ gap_of }}. Held out: by a fit that had not seen it.</p>
<div class="wide"><table>
<tr>{% for cell in gap_header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in gaps %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
<h2>Measured against model</h2>
{% for picture in pictures %}<figure>{{ picture | safe }}</figure>
{% endfor %}
<h2>What the data leave open</h2>
<ul>{% for line in open %}<li>{{ line }}</li>{% else %}<li>nothing</li>{% endfor %}</ul>
{% if tied %}<p>Closely correlated: {{ tied }}.</p>{% endif %}
<h2>Where it comes from</h2>
<table class="words">{% for key, value in provenance %}<tr><td>{{ key }}</td><td>{{ value }}</td></tr>
{% endfor %}</table>
</body></html>
"""
HEADER = ("parameter", "value", "standard error", "95 % interval", "card", "remarks")
GAPS = ("", "card", "fit", "noise floor")
_LINES = "|ln(model / measured)| over all coherent lines, each weighted by its coherence"
GAP_OF = {
    "frf": _LINES,
    "both": _LINES,
    "modes": "the relative errors of frequency, a tenth of those of damping ratio, and 1 − MAC",
}
KEYS = {"fitted_to": "fitted to", "held_out": "held out", "numbers": "numbers fitted"}


def write_identification_page(outcome: Identification, path: Path, *, overwrite: bool = False) -> None:
    """Write the page; it needs no network.

    Raises:
        OutputExists: the file exists.
    """
    from jinja2 import Environment

    figures = [draw_identification(outcome)] + ([draw_held_out(outcome)] if outcome.held_out else [])
    text = (
        Environment(autoescape=True)
        .from_string(_TEMPLATE)
        .render(
            title=f"{outcome.problem.campaign.title}: identification of {outcome.problem.robot.name}",
            verdict=outcome.verdict[:1].upper() + outcome.verdict[1:],
            before=outcome.before_fit.verdict,
            header=HEADER,
            rows=[{"cells": estimate_cells(one), "known": one.identified} for one in outcome.estimates],
            gap_of=GAP_OF[outcome.problem.source],
            gap_header=GAPS,
            gaps=gap_cells(outcome),
            tied=", ".join(f"{a} and {b} ({r:+.3f})" for a, b, r in outcome.correlated),
            pictures=[svg_text(figure) for figure in figures],
            open=[one.says for one in outcome.not_identified],
            provenance=[
                (KEYS.get(key, key), _shown(key, value)) for key, value in outcome.provenance.items()
            ],
        )
    )
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def estimate_cells(one: Estimate) -> tuple[str, ...]:
    """One row of text, under `HEADER`."""
    unit = f" {one.unit}" if one.unit else ""
    remarks = [
        text
        for text, here in (("at its bound", one.at_bound), ("not identified", not one.identified))
        if here
    ]
    low, high = one.interval
    return (
        one.name,
        f"{_number(one.value)}{unit}",
        _number(one.standard_error, 2),
        f"{_number(low)} to {_number(high)}",
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
    return [(name, *(f"{value:.4g}" for value in values)) for name, *values in cells]


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

"""An identification as one self-contained HTML page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flexmodal.files import whole_file
from flexmodal.frf.plot import svg_text
from flexmodal.identification.outcome import Estimate, Outcome
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
th:first-child, td:first-child { text-align: left }
.wide { overflow-x: auto }
.open td { color: #777 }
figure { margin: 1rem 0; break-inside: avoid }
@media print { body { margin: 0; max-width: none } }
</style></head><body>
<h1>{{ title }}</h1>
<p>{{ verdict }}.</p>
<p>Before the fit: {{ before }}.</p>
<div class="wide"><table>
<tr>{% for cell in header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in rows %}<tr{% if not row.known %} class="open"{% endif %}>
{% for cell in row.cells %}<td>{{ cell
}}</td>{% endfor %}</tr> {% endfor %}</table></div>
<h2>Measured against model</h2>
{% for picture in pictures %}<figure>{{ picture | safe }}</figure>
{% endfor %}
<h2>What the data leave open</h2>
<ul>{% for line in open %}<li>{{ line }}</li>{% else %}<li>nothing</li>{% endfor %}</ul>
<h2>Where it comes from</h2>
<table>{% for key, value in provenance %}<tr><td>{{ key }}</td><td>{{ value }}</td></tr>
{% endfor %}</table>
</body></html>
"""
HEADER = ("parameter", "value", "standard error", "95 % interval", "card", "remarks")


def write_identification_page(outcome: Outcome, path: Path, *, overwrite: bool = False) -> None:
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
            verdict=outcome.verdict,
            before=outcome.before_fit.verdict,
            header=HEADER,
            rows=[{"cells": estimate_cells(one), "known": one.identified} for one in outcome.estimates],
            pictures=[svg_text(figure) for figure in figures],
            open=[one.says for one in outcome.not_identified],
            provenance=[(key, _shown(value)) for key, value in outcome.provenance.items()],
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
    return (
        one.name,
        f"{one.value:.5g}{unit}",
        f"{one.standard_error:.2g}",
        f"{one.interval[0]:.5g} to {one.interval[1]:.5g}",
        f"{one.card:.5g}",
        ", ".join(remarks),
    )


def _shown(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)

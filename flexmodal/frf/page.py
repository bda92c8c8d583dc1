"""FRFs as one self-contained HTML page: the picture, and the numbers behind it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from flexmodal.files import whole_file
from flexmodal.frf.frf import Frf
from flexmodal.frf.plot import draw_frf, svg_text

_ROWS = 400
"""Most lines a table shows; longer ones are thinned, and say so."""

_TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{{ title }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  color: #111 }
svg { width: 100%; height: auto }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { padding: .15rem .8rem; text-align: right; border-bottom: 1px solid #ddd }
.wide { overflow-x: auto }
@media print { body { margin: 0; max-width: none } details:not([open]) { display: none } }
</style></head><body>
<h1>{{ title }}</h1>
<p>{{ form | capitalize }}, {{ lines }} lines from {{ "%g" | format(first) }} to
{{ "%g" | format(last) }} Hz.</p>
{{ picture | safe }}
{% for table in tables %}
<details><summary>{{ table.label }} [{{ table.unit }}]{{ table.note }}</summary><div class="wide"><table>
<tr><th>Frequency [Hz]</th><th>Real part</th><th>Imaginary part</th><th>Amplitude</th><th>Phase [°]</th></tr>
{% for row in table.rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div></details>
{% endfor %}
</body></html>
"""


def write_page(curves: Mapping[str, Frf], path: Path, *, title: str, overwrite: bool = False) -> None:
    """Write FRFs as a page that needs no network.

    Raises:
        OutputExists: the file exists.
    """
    from jinja2 import Environment

    first = next(iter(curves.values()))
    text = (
        Environment(autoescape=True)
        .from_string(_TEMPLATE)
        .render(
            title=title,
            form=first.form,
            lines=len(first.frequency),
            first=float(first.frequency[0]),
            last=float(first.frequency[-1]),
            picture=svg_text(draw_frf(curves)),
            tables=[table for name, frf in curves.items() for table in _tables(name, frf)],
        )
    )
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def _tables(name: str, frf: Frf) -> list[dict[str, object]]:
    step = -(-len(frf.frequency) // _ROWS)
    tables: list[dict[str, object]] = []
    for row, response in enumerate(frf.response):
        for column, reference in enumerate(frf.reference):
            pair = f"{response} per {reference}"
            numbers = zip(frf.frequency[::step], frf.value[::step, row, column], strict=True)
            tables.append(
                {
                    "label": f"{name}, {pair}" if name else pair,
                    "unit": frf.unit(row, column),
                    "note": f", one line in {step}" if step > 1 else "",
                    "rows": [_cells(float(frequency), complex(value)) for frequency, value in numbers],
                }
            )
    return tables


def _cells(frequency: float, value: complex) -> list[str]:
    phase = float(np.degrees(np.angle(value)))
    return [f"{frequency:g}", f"{value.real:.6e}", f"{value.imag:.6e}", f"{abs(value):.6e}", f"{phase:.2f}"]

"""A fit as one self-contained HTML page: the modes, what is odd about the data, and every picture."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from flexmodal.campaign import Campaign, QualityFlag
from flexmodal.ema.fit import Fit
from flexmodal.ema.pictures import Picture
from flexmodal.ema.table import HEADER, LEGEND, flag_lines, mode_cells
from flexmodal.files import whole_file
from flexmodal.frf.plot import svg_text

_MOST = 12
"""Pictures of one kind; the page says how many more there would be."""

_TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{{ title }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 66rem; margin: 2rem auto; padding: 0 1rem;
  color: #111 }
svg { width: 100%; height: auto; max-width: 50rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem }
th, td { padding: .15rem .7rem; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap }
th:first-child, td:first-child, th:last-child, td:last-child { text-align: left }
td:last-child { white-space: normal; min-width: 14rem }
th { white-space: normal; vertical-align: bottom }
.wide { overflow-x: auto }
figure { margin: 1rem 0; break-inside: avoid }
@media print { body { margin: 0; max-width: none } }
</style></head><body>
<h1>{{ title }}</h1>
<p>Modes by {{ method }}. {{ legend }} Residues are those of the receptance.</p>
<div class="wide"><table>
<tr>{% for cell in header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% if refused %}<h2>Refused</h2>
<ul>{% for line in refused %}<li>{{ line }}</li>{% endfor %}</ul>{% endif %}
<h2>Quality of the data</h2>
{% if flags %}<ul>{% for line in flags %}<li>{{ line }}</li>{% endfor %}</ul>
{% else %}<p>Nothing was flagged.</p>{% endif %}
{% for section in sections %}<h2>{{ section.title }}</h2>
{% if section.note %}<p>{{ section.note }}</p>{% endif %}
{% for picture in section.pictures %}<figure>{{ picture | safe }}</figure>
{% endfor %}{% endfor %}
</body></html>
"""


def write_fit_page(
    fits: Sequence[Fit],
    drawn: Sequence[Picture],
    flags: Sequence[QualityFlag],
    campaign: Campaign,
    path: Path,
    *,
    overwrite: bool = False,
) -> None:
    """Write the page; names are escaped, and it needs no network.

    Args:
        fits: what `fit` found.
        drawn: its pictures, as `pictures` gives them.
        flags: what is odd about the data.
        campaign: for its title.
        path: a new `.html` file.
        overwrite: replace an existing one.

    Raises:
        OutputExists: the file exists.
    """
    from jinja2 import Environment

    sections = []
    for title, some in groupby(drawn, key=lambda picture: picture.section):
        these = list(some)
        note = f"The first {_MOST} of {len(these)}." if len(these) > _MOST else ""
        svgs = [svg_text(picture.draw()) for picture in these[:_MOST]]
        sections.append({"title": title, "note": note, "pictures": svgs})
    text = (
        Environment(autoescape=True)
        .from_string(_TEMPLATE)
        .render(
            title=campaign.title,
            method=fits[0].modes.method if fits else "",
            header=HEADER,
            legend=LEGEND,
            rows=[cells for one in fits for cells in mode_cells(one)],
            refused=[line for one in fits for line in refused_lines(one)],
            flags=flag_lines(flags),
            sections=sections,
        )
    )
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def refused_lines(one: Fit) -> list[str]:
    """What the fit found no mode in, and why, as sentences."""
    where = str(one.places[0]) if len(one.places) == 1 else "all FRFs"
    return [f"posture {one.posture}, {where}, {f:.4g} Hz: {why}" for f, why in one.modes.refused]

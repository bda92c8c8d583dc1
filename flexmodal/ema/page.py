"""A fit as one self-contained HTML page: the modes, and every picture an engineer would ask for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign import Campaign, FrfRecords
from flexmodal.ema.circle import CircleFit, fit_circle
from flexmodal.ema.estimate import Choices, peaks_of
from flexmodal.ema.fit import Fit
from flexmodal.ema.plot import (
    draw_circle,
    draw_coherence,
    draw_fit,
    draw_mac,
    draw_shapes,
    draw_stabilisation,
)
from flexmodal.ema.records import grouped
from flexmodal.ema.shapes import fitted_shapes
from flexmodal.ema.stabilisation import stabilise
from flexmodal.ema.table import HEADER, LEGEND, mode_cells
from flexmodal.files import whole_file
from flexmodal.frf.plot import svg_text
from flexmodal.modal import mac

_MOST = 12
"""Pictures of one kind; the page says how many more there would be."""

_TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{{ title }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  color: #111 }
svg { width: 100%; height: auto; max-width: 50rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { padding: .15rem .7rem; text-align: right; border-bottom: 1px solid #ddd }
th:first-child, td:first-child { text-align: left }
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
{% for section in sections %}<h2>{{ section.title }}</h2>
{% if section.note %}<p>{{ section.note }}</p>{% endif %}
{% for picture in section.pictures %}<figure>{{ picture | safe }}</figure>
{% endfor %}{% endfor %}
</body></html>
"""


def write_fit_page(
    fits: Sequence[Fit], records: FrfRecords, campaign: Campaign, path: Path, *, overwrite: bool = False
) -> None:
    """Write the page; names are escaped, and it needs no network.

    Args:
        fits: what `fit_campaign` found.
        records: the FRFs it was found in, for their coherence.
        campaign: for names.
        path: a new `.html` file.
        overwrite: replace an existing one.

    Raises:
        OutputExists: the file exists.
    """
    from jinja2 import Environment

    names = {point.id: point.name for point in campaign.points}
    sections = [
        {"title": title, "note": _more(pictures), "pictures": [svg_text(p) for p in pictures[:_MOST]]}
        for title, pictures in _sections(fits, records, names)
        if pictures
    ]
    text = (
        Environment(autoescape=True)
        .from_string(_TEMPLATE)
        .render(
            title=campaign.title,
            method=fits[0].modes.method if fits else "",
            header=HEADER,
            legend=LEGEND,
            rows=[cells for one in fits for cells in mode_cells(one)],
            sections=sections,
        )
    )
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def _more(pictures: Sequence[Any]) -> str:
    return f"The first {_MOST} of {len(pictures)}." if len(pictures) > _MOST else ""


def _sections(
    fits: Sequence[Fit], records: FrfRecords, names: Mapping[int, str]
) -> Iterator[tuple[str, list[Any]]]:
    shown = [(one, frf) for one in fits for frf in range(len(one.places))]
    yield "Measured and synthesised", [_fit_picture(one, frf, records) for one, frf in shown]
    if records.coherence is not None:
        labels = [str(place) for place in grouped(records, "separate")]
        yield "Coherence", [draw_coherence(records.frequency, records.coherence[:_MOST], labels[:_MOST])]
    if fits and fits[0].modes.method == "circle":
        yield "Circles", [draw_circle(circle) for one, frf in shown[:_MOST] for circle in _circles(one, frf)]
    if any(one.modes.method == "lscf" for one in fits):
        yield "Stabilisation", [_stabilisation(one) for one in fits[:_MOST]]
    shapes = fitted_shapes(fits)
    yield "Shapes along the arm", [draw_shapes(one, names) for one in shapes[:_MOST]]
    tables = []
    for first, second in zip(shapes, (*shapes[1:], *shapes[:1]), strict=True):
        if (first.places, first.side) == (second.places, second.side):
            title = f"MAC: posture {first.posture} against posture {second.posture}"
            rows, columns = ([f"{f:.4g} Hz" for f in one.frequency] for one in (first, second))
            tables.append(draw_mac(mac(first.shape, second.shape), rows, columns, title=title))
    yield "Modal assurance criterion", tables


def _fit_picture(one: Fit, frf: int, records: FrfRecords) -> Any:
    place = one.places[frf]
    coherence = None
    if records.coherence is not None:
        rows = grouped(records, "average" if place.trial is None else "separate")[place]
        lines = np.isin(records.frequency, one.modes.measured.frequency)
        coherence = records.coherence[rows][:, lines].mean(axis=0)
    return draw_fit(one.modes, frf, coherence=coherence, title=f"Posture {one.posture}: {place}")


def _circles(one: Fit, frf: int) -> list[CircleFit]:
    single = one.modes.measured.only(frf)
    peaks = peaks_of(single, Choices(at=[mode.frequency for mode in one.modes])) if len(one.modes) else []
    return [circle for peak in peaks if isinstance(circle := fit_circle(single, peak), CircleFit)]


def _stabilisation(one: Fit) -> Any:
    title = f"Posture {one.posture}: {one.places[0] if len(one.places) == 1 else 'all FRFs'}"
    return draw_stabilisation(stabilise(one.modes.measured), list(one.modes.frequency), title=title)

"""Results as CSV and JSON files, pictures and pages."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.files import whole_file
from flexmodal.frf.plot import svg_text
from flexmodal.machining.depth import Comparison, PostureDepth
from flexmodal.machining.plot import draw_comparison, draw_lobes
from flexmodal.machining.report.rows import (
    BEST,
    NUMBERS,
    POSTURES,
    best_rows,
    chatter,
    numbers,
    posture_rows,
)

LOBES_COLUMNS = (
    "spindle_speed_rev_per_min", "stable_depth_m", "chatter_frequency_hz", "lobe", "period_doubling",
    "surface_error_m", "dynamic_error_m", "static_x_m", "static_y_m", "static_z_m", "peak_x_m", "peak_y_m",
    "peak_z_m",
)  # fmt: skip
COMPARISON_COLUMNS = (
    "posture", "parameter", "critical_depth_m", "critical_speed_rev_per_min", "chatter_frequency_hz",
    "best_depth_m", "best_speed_rev_per_min", "unconditional_depth_m", "mode_coupling_depth_m",
    "mode_coupling_frequency_hz",
)  # fmt: skip

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{{ title }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  color: #111 }
svg { width: 100%; height: auto; max-width: 54rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1rem 0 }
th, td { padding: .15rem .8rem; text-align: right; border-bottom: 1px solid #ddd }
th:first-child, td:first-child { text-align: left }
.wide { overflow-x: auto }
</style></head><body>
<h1>{{ title }}</h1>
<p>{{ lead }}</p>
{{ picture | safe }}
{% for table in tables %}<h2>{{ table.title }}</h2>
<div class="wide"><table>
<tr>{% for cell in table.header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in table.rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% endfor %}
</body></html>
"""


def write_lobes_csv(found: PostureDepth, path: Path, *, overwrite: bool = False) -> None:
    """One row for each speed; empty where there is no limit or no wall.

    Raises:
        OutputExists: the file exists.
    """
    lobes, forced = found.lobes, found.forced
    rows = []
    for place, speed in enumerate(lobes.speed):
        more: list[float] = [] if forced is None else [
            forced.surface_error[place], forced.dynamic_error[place],
            *forced.static[place], *forced.peak[place],
        ]  # fmt: skip
        lobe = int(lobes.lobe[place])
        head = [speed, lobes.depth[place], lobes.chatter_frequency[place]]
        rows.append([*map(_cell, head), lobe if lobe >= 0 else "", int(lobes.flip[place]), *map(_cell, more)])
    _write_csv(path, LOBES_COLUMNS[: 5 if forced is None else None], rows, overwrite)


def write_comparison_csv(found: Comparison, path: Path, *, overwrite: bool = False) -> None:
    """One row for each posture.

    Raises:
        OutputExists: the file exists.
    """
    rows = []
    for one in found.postures:
        best = int(np.argmax(one.lobes.depth))
        values = [
            one.critical_depth, one.lobes.critical_speed, chatter(one), one.lobes.depth[best],
            one.lobes.speed[best], one.unconditional[0], one.coupling.depth, one.coupling.frequency,
        ]  # fmt: skip
        parameter = "" if one.parameter is None else repr(one.parameter)
        rows.append([str(one.posture), parameter, *map(_cell, values)])
    _write_csv(path, COMPARISON_COLUMNS, rows, overwrite)


def write_lobes_page(robot: str, found: PostureDepth, path: Path, *, overwrite: bool = False) -> None:
    """Lobes of one posture as a page that needs no network.

    Raises:
        OutputExists: the file exists.
    """
    tables = [
        {"title": "Limits", "header": NUMBERS, "rows": numbers(found)},
        {"title": "Speeds between the lobes", "header": BEST, "rows": best_rows(found)},
    ]
    title = f"{robot} at {found.posture}: {found.lobes.cut.title}"
    _write_page(title, found.lobes.method, svg_text(lobes_picture(robot, found)), tables, path, overwrite)


def write_comparison_page(found: Comparison, path: Path, *, overwrite: bool = False) -> None:
    """Postures compared as a page that needs no network.

    Raises:
        OutputExists: the file exists.
    """
    tables = [{"title": "Postures", "header": POSTURES, "rows": posture_rows(found)}]
    title, method = f"{found.robot.name}: {found.cut.title}", found.postures[0].lobes.method
    _write_page(title, method, svg_text(draw_comparison(found)), tables, path, overwrite)


def write_json(found: dict[str, Any], path: Path, *, overwrite: bool = False) -> None:
    """An object as a file.

    Raises:
        OutputExists: the file exists.
    """
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(json.dumps(found, allow_nan=False, indent=1) + "\n", encoding="utf-8")


def lobes_picture(robot: str, found: PostureDepth) -> Any:
    """The picture of one posture's lobes."""
    title = f"{robot} at {found.posture}\n{found.lobes.cut.title}"
    depth = found.lobes.cut.engagement.depth
    curves = {"": found.lobes}
    return draw_lobes(curves, title=title, coupling=found.coupling.depth, depth=depth, forced=found.forced)


def _cell(value: float) -> str:
    return repr(float(value)) if math.isfinite(value) else ""


def _write_csv(path: Path, header: Sequence[str], rows: Sequence[Sequence[Any]], overwrite: bool) -> None:
    with whole_file(path, overwrite=overwrite) as scratch, scratch.open("w", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def _write_page(
    title: str, method: str, picture: str, tables: list[dict[str, Any]], path: Path, overwrite: bool
) -> None:
    from jinja2 import Environment

    lead = f"Stability of the cut over spindle speed, {method} solution. Depths are axial depths of cut."
    page = Environment(autoescape=True).from_string(_PAGE)
    text = page.render(title=title, lead=lead, picture=picture, tables=tables)
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")

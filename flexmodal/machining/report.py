"""Results as JSON objects, CSV files and pages."""

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

NUMBERS = ("", "value", "unit")
BEST = ("spindle speed [rev/min]", "stable depth [mm]")
POSTURES = (
    "posture", "critical depth [mm]", "at [rev/min]", "chatter [Hz]", "best depth [mm]", "at [rev/min]",
    "mode coupling [mm]",
)  # fmt: skip


def lobes_object(robot: str, found: PostureDepth) -> dict[str, Any]:
    """What `flexmodal lobes --json` prints for one posture; null where there is no limit."""
    lobes = found.lobes
    return {
        "robot": robot,
        "posture": dict(found.posture.values),
        "cut": lobes.cut.title,
        "method": lobes.method,
        **_judged(found),
        "best": [{"spindle_speed": speed, "depth": finite(depth)} for speed, depth in lobes.best()],
        "spindle_speed": lobes.speed.tolist(),
        "depth": [finite(value) for value in lobes.depth],
        "chatter_frequency": [finite(value) for value in lobes.chatter_frequency],
        "lobe": [int(value) if value >= 0 else None for value in lobes.lobe],
        "period_doubling": [bool(value) for value in lobes.flip],
        "forced": _forced(found),
    }


def comparison_object(found: Comparison) -> dict[str, Any]:
    """What `flexmodal lobes --json` prints for several postures."""
    return {
        "robot": found.robot.name,
        "cut": found.cut.title,
        "method": found.postures[0].lobes.method,
        "family": found.family,
        "postures": [
            {
                "posture": dict(one.posture.values),
                "name": one.posture.name or None,
                "parameter": one.parameter,
            }
            | _judged(one)
            for one in found.postures
        ],
        "best": found.best,
        "gain": finite(found.gain),
    }


def numbers(found: PostureDepth) -> list[list[str]]:
    """Rows under `NUMBERS`."""
    lobes = found.lobes
    rows = [
        ["critical depth over the range of speeds", millimetres(found.critical_depth), "mm"],
        ["  at", f"{lobes.critical_speed:.0f}" if math.isfinite(found.critical_depth) else "–", "rev/min"],
        ["  chatter frequency", hertz(_chatter(found)), "Hz"],
        ["depth stable at any speed at all", millimetres(found.unconditional[0]), "mm"],
        ["mode coupling begins at", millimetres(found.coupling.depth), "mm"],
        ["  at a frequency of", hertz(found.coupling.frequency), "Hz"],
    ]
    if found.forced is not None:
        rows.append(["intended depth", millimetres(found.forced.depth), "mm"])
        rows.append(["  stable at", stable_part(found), "of the range"])
        for name, metres in (
            ("  error of the wall, size", found.forced.surface_error),
            ("  without the mean deflection", found.forced.dynamic_error),
        ):
            size = 1e6 * np.abs(metres)
            if np.all(np.isfinite(size)):
                rows.append([name, f"{size.min():.3g} to {size.max():.3g}", "µm"])
    return rows


def best_rows(found: PostureDepth) -> list[list[str]]:
    """Rows under `BEST`."""
    return [[f"{speed:.0f}", millimetres(depth)] for speed, depth in found.lobes.best()]


def posture_rows(found: Comparison) -> list[list[str]]:
    """Rows under `POSTURES`."""
    rows = []
    for one in found.postures:
        best = int(np.argmax(one.lobes.depth))
        rows.append(
            [
                _name(one), millimetres(one.critical_depth), f"{one.lobes.critical_speed:.0f}",
                hertz(_chatter(one)), millimetres(float(one.lobes.depth[best])),
                f"{one.lobes.speed[best]:.0f}", millimetres(one.coupling.depth),
            ]
        )  # fmt: skip
    return rows


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
            one.critical_depth, one.lobes.critical_speed, _chatter(one), one.lobes.depth[best],
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
    """One of the objects above as a file.

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


def stable_part(found: PostureDepth) -> str:
    """How much of the range of speeds is stable at the intended depth."""
    depth = found.lobes.cut.engagement.depth or 0.0
    stable, speed = found.lobes.depth > depth, found.lobes.speed
    width = np.diff(speed, prepend=speed[0], append=speed[-1])
    share = (width[:-1] + width[1:]) / 2
    return f"{100 * np.sum(share[stable]) / np.sum(share):.0f} %" if np.sum(share) else str(bool(stable[0]))


def finite(value: float) -> float | None:
    """A number for JSON; none where it is not finite."""
    return float(value) if math.isfinite(value) else None


def millimetres(depth: float) -> str:
    """A depth for people."""
    return f"{1e3 * depth:.4g}" if math.isfinite(depth) else "no limit"


def hertz(frequency: float) -> str:
    """A frequency for people."""
    return f"{frequency:.4g}" if math.isfinite(frequency) else "–"


def _chatter(found: PostureDepth) -> float:
    return float(found.lobes.chatter_frequency[np.argmin(found.lobes.depth)])


def _judged(found: PostureDepth) -> dict[str, Any]:
    best = int(np.argmax(found.lobes.depth))
    limited = math.isfinite(found.critical_depth)
    return {
        "critical_depth": finite(found.critical_depth),
        "critical_speed": found.lobes.critical_speed if limited else None,
        "critical_frequency": finite(_chatter(found)),
        "best_depth": finite(float(found.lobes.depth[best])),
        "best_speed": float(found.lobes.speed[best]),
        "unconditional_depth": finite(found.unconditional[0]),
        "mode_coupling": None
        if not math.isfinite(found.coupling.depth)
        else {"depth": found.coupling.depth, "frequency": found.coupling.frequency},
    }


def _forced(found: PostureDepth) -> dict[str, Any] | None:
    forced = found.forced
    if forced is None:
        return None
    return {
        "depth": forced.depth,
        "stable": [bool(value) for value in found.lobes.depth > forced.depth],
        "surface_error": [finite(value) for value in forced.surface_error],
        "dynamic_error": [finite(value) for value in forced.dynamic_error],
        "static": forced.static.tolist(),
        "peak": forced.peak.tolist(),
    }


def _name(one: PostureDepth) -> str:
    return one.posture.name or (str(one.posture) if one.parameter is None else f"{one.parameter:.4f}")


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

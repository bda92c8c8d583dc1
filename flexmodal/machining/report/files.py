"""Results as CSV and JSON files, pictures and pages."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.files import whole_file
from flexmodal.machining.depth import Comparison, PostureDepth
from flexmodal.machining.plot import draw_comparison, draw_lobes
from flexmodal.machining.report.objects import comparison_object, lobes_object
from flexmodal.machining.report.rows import (
    BEST,
    NUMBERS,
    POSTURES,
    best_rows,
    chatter,
    numbers,
    posture_rows,
)
from flexmodal.report import (
    Column,
    Folded,
    Numbers,
    Picture,
    Section,
    Table,
    columns,
    json_text,
    page_text,
    write_page,
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

    Args:
        robot: its name.
        found: as `posture_depth` gives it.
        path: a new `.html` file.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
    """
    title = f"{robot} at {found.posture}: {found.lobes.cut.title}"
    picture = Picture(partial(lobes_picture, robot, found), "Stable depth of cut over spindle speed")
    sections = [
        Section("Limits", [Table(columns(NUMBERS, words=NUMBERS[-1:]), numbers(found))]),
        Section("Speeds between the lobes", [Table([Column(name) for name in BEST], best_rows(found))]),
        Section("The numbers", [Folded("Everything as JSON", Numbers(lobes_object(robot, found)))]),
    ]
    write_page(path, page_text(title, [_lead(found), picture], sections), overwrite=overwrite)


def write_comparison_page(found: Comparison, path: Path, *, overwrite: bool = False) -> None:
    """Postures compared as a page that needs no network.

    Raises:
        OutputExists: the file exists.
    """
    picture = Picture(partial(draw_comparison, found), "Critical depth of cut by posture")
    sections = [
        Section("Postures", [Table(columns(POSTURES), posture_rows(found))]),
        Section("The numbers", [Folded("Everything as JSON", Numbers(comparison_object(found)))]),
    ]
    title = f"{found.robot.name}: {found.cut.title}"
    write_page(path, page_text(title, [_lead(found.postures[0]), picture], sections), overwrite=overwrite)


def _lead(found: PostureDepth) -> str:
    return (
        f"Stability of the cut over spindle speed, {found.lobes.method} solution. Depths are axial depths of "
        "cut; above the critical one there are speeds at which the cut chatters."
    )


def write_json(found: dict[str, Any], path: Path, *, overwrite: bool = False) -> None:
    """An object as a file.

    Raises:
        OutputExists: the file exists.
    """
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(json_text(found), encoding="utf-8")


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

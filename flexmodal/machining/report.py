"""Results as JSON objects, rows of tables, CSV files, pictures and pages."""

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
from flexmodal.report import (
    Column,
    Folded,
    Numbers,
    Picture,
    Section,
    Table,
    columns,
    page_text,
    write_page,
)
from flexmodal.report.parts import finite
from flexmodal.report.words import DASH

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
NUMBERS = ("", "value", "unit")
BEST = ("spindle speed [rev/min]", "stable depth [mm]")
POSTURES = (
    "posture", "critical depth [mm]", "at [rev/min]", "chatter [Hz]", "best depth [mm]", "at [rev/min]",
    "mode coupling [mm]",
)  # fmt: skip


def lobes_object(robot: str, found: PostureDepth) -> dict[str, Any]:
    """What `flexmodal lobes --json` prints for one posture; null where there is no limit."""
    lobes, forced = found.lobes, found.forced
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
        "forced": None
        if forced is None
        else {
            "depth": forced.depth,
            "stable": [bool(value) for value in lobes.depth > forced.depth],
            "surface_error": [finite(value) for value in forced.surface_error],
            "dynamic_error": [finite(value) for value in forced.dynamic_error],
            "static": forced.static.tolist(),
            "peak": forced.peak.tolist(),
        },
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


def _judged(found: PostureDepth) -> dict[str, Any]:
    """What a posture is judged by; null where there is no limit."""
    lobes, coupling = found.lobes, found.coupling
    best, least = int(np.argmax(lobes.depth)), int(np.argmin(lobes.depth))
    limited = math.isfinite(found.critical_depth)
    coupled = {"depth": coupling.depth, "frequency": coupling.frequency}
    return {
        "critical_depth": finite(found.critical_depth),
        "critical_speed": lobes.critical_speed if limited else None,
        "critical_frequency": finite(lobes.chatter_frequency[least]),
        "best_depth": finite(lobes.depth[best]),
        "best_speed": float(lobes.speed[best]),
        "unconditional_depth": finite(found.unconditional[0]),
        "mode_coupling": coupled if math.isfinite(coupling.depth) else None,
    }


def numbers(found: PostureDepth) -> list[list[str]]:
    """Rows under `NUMBERS`."""
    one, speed = _judged(found), found.lobes.critical_speed
    coupling = one["mode_coupling"] or {"depth": None, "frequency": None}
    rows = [
        ["critical depth over the range of speeds", millimetres(one["critical_depth"]), "mm"],
        ["  at", DASH if one["critical_speed"] is None else f"{speed:.0f}", "rev/min"],
        ["  chatter frequency", hertz(one["critical_frequency"]), "Hz"],
        ["depth stable at any speed at all", millimetres(one["unconditional_depth"]), "mm"],
        ["mode coupling begins at", millimetres(coupling["depth"]), "mm"],
        ["  at a frequency of", hertz(coupling["frequency"]), "Hz"],
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
        name = str(one.posture) if one.parameter is None else f"{one.parameter:.4f}"
        judged = _judged(one)
        rows.append(
            [
                one.posture.name or name, millimetres(judged["critical_depth"]),
                f"{one.lobes.critical_speed:.0f}", hertz(judged["critical_frequency"]),
                millimetres(judged["best_depth"]), f"{judged['best_speed']:.0f}",
                millimetres(one.coupling.depth),
            ]
        )  # fmt: skip
    return rows


def stable_part(found: PostureDepth) -> str:
    """How much of the range of speeds is stable at the intended depth."""
    depth = found.lobes.cut.engagement.depth or 0.0
    stable, speed = found.lobes.depth > depth, found.lobes.speed
    width = np.diff(speed, prepend=speed[0], append=speed[-1])
    share = (width[:-1] + width[1:]) / 2
    return f"{100 * np.sum(share[stable]) / np.sum(share):.0f} %" if np.sum(share) else str(bool(stable[0]))


def millimetres(depth: float | None) -> str:
    """A depth for people [m]."""
    return "no limit" if depth is None or not math.isfinite(depth) else f"{1e3 * depth:.4g}"


def hertz(frequency: float | None) -> str:
    """A frequency for people."""
    return DASH if frequency is None or not math.isfinite(frequency) else f"{frequency:.4g}"


def write_lobes_csv(found: PostureDepth, path: Path, *, overwrite: bool = False) -> None:
    """One row for each speed; empty where there is no limit or no wall.

    Args:
        found: of one posture.
        path: of the new file.
        overwrite: replace a file that stands there.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    lobes, forced = found.lobes, found.forced
    lobe = [int(value) if value >= 0 else None for value in lobes.lobe]
    table: list[Any] = [
        lobes.speed,
        lobes.depth,
        lobes.chatter_frequency,
        lobe,
        lobes.flip.astype(int),
    ]
    if forced is not None:
        table += [forced.surface_error, forced.dynamic_error, *forced.static.T, *forced.peak.T]
    _write_csv(path, LOBES_COLUMNS[: len(table)], list(zip(*table, strict=True)), overwrite)


def write_comparison_csv(found: Comparison, path: Path, *, overwrite: bool = False) -> None:
    """One row for each posture.

    Args:
        found: of several postures.
        path: of the new file.
        overwrite: replace a file that stands there.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    rows = []
    for one in found.postures:
        *judged, _ = (_judged(one) | {"critical_speed": one.lobes.critical_speed}).values()
        rows.append([str(one.posture), one.parameter, *judged, one.coupling.depth, one.coupling.frequency])
    _write_csv(path, COMPARISON_COLUMNS, rows, overwrite)


def _write_csv(path: Path, header: Sequence[str], rows: Sequence[Sequence[Any]], overwrite: bool) -> None:
    def cell(value: Any) -> str:
        if isinstance(value, float):
            return repr(float(value)) if math.isfinite(value) else ""
        return "" if value is None else str(value)

    with whole_file(path, overwrite=overwrite) as scratch, scratch.open("w", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([cell(value) for value in row] for row in rows)


def lobes_picture_of(found: PostureDepth) -> Any:
    """The picture of one posture's lobes, whatever robot they are of."""
    return lobes_picture("lobes", found)


def lobes_picture(robot: str, found: PostureDepth) -> Any:
    """The picture of one posture's lobes."""
    title = f"{robot} at {found.posture}\n{found.lobes.cut.title}"
    depth = found.lobes.cut.engagement.depth
    curves = {"": found.lobes}
    return draw_lobes(curves, title=title, coupling=found.coupling.depth, depth=depth, forced=found.forced)


def write_lobes_page(robot: str, found: PostureDepth, path: Path, *, overwrite: bool = False) -> None:
    """Lobes of one posture as a page that needs no network.

    Args:
        robot: its name.
        found: as `posture_depth` gives it.
        path: a new `.html` file.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
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
        NotWritten: the disk is full, or the folder may not be written.
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

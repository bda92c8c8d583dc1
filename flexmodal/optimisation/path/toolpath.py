"""Where the tool goes and which way it is pushed: from a table, along a line or an arc."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.text.reading import read_regular
from flexmodal.text.words import FaultList, shown

_POSITION, _FORCE = ("x", "y", "z"), ("fx", "fy", "fz")
MOST_POINTS = 2000
"""More points than this are not planned in one go."""
LARGEST = 20_000_000
"""The most a table may hold [bytes]."""


@dataclass(frozen=True, eq=False)
class Toolpath:
    """Points in the order they are passed."""

    position: Float[np.ndarray, "point axis"]
    """Coordinates: x, z of a planar chain or x, y, z [m]."""
    time: Float[np.ndarray, " point"]
    """When each is passed, from 0 [s]."""
    force: Float[np.ndarray, "point 3"] | None = None
    """Direction of the cutting force at each, unit vectors in the world; none if the same everywhere."""


def line(start: tuple[float, ...], end: tuple[float, ...], points: int, feed: float) -> Toolpath:
    """Points evenly spaced along a line, both ends included, passed at a feed [m/s].

    Args:
        start: x, y, z, or the two of a planar arm [m].
        end: likewise [m].
        points: how many, both ends included.
        feed: speed along the line [m/s].

    Raises:
        InvalidRequest: fewer than two points, a feed that is none, or ends that are one.
    """
    shares = np.linspace(0, 1, _count(points))[:, None]
    first, last = _places("line", start, end)
    return _timed(first + shares * (last - first), feed)


def arc(
    start: tuple[float, ...], via: tuple[float, ...], end: tuple[float, ...], points: int, feed: float
) -> Toolpath:
    """Points evenly spaced along the circular arc from start through via to end, passed at a feed [m/s].

    Args:
        start: x, y, z, or the two of a planar arm [m].
        via: a place on the way [m].
        end: where the arc ends [m].
        points: how many, both ends included.
        feed: speed along the arc [m/s].

    Raises:
        InvalidRequest: as for `line`, or three places on one line.
    """
    shares = np.linspace(0, 1, _count(points))
    first, middle, last = _places("arc", start, via, end)
    a, b = middle - first, last - first
    flat = float(a @ a * (b @ b) - (a @ b) ** 2)
    if flat <= 1e-12 * float(a @ a * (b @ b)):
        raise InvalidRequest(Fault("call", "arc", "three places on one line", "three that span a circle"))
    # centre = first + s a + t b, equally far from all three
    s = (b @ b) * (a @ a - a @ b) / (2 * flat)
    t = (a @ a) * (b @ b - a @ b) / (2 * flat)
    out = -(s * a + t * b)
    radius = float(np.linalg.norm(out))
    along = out / radius
    across = a - (a @ along) * along
    across /= np.linalg.norm(across)
    centre = first - out
    angles = [np.arctan2(p @ across, p @ along) % (2 * np.pi) for p in (middle - centre, last - centre)]
    sweep = angles[1] if angles[0] < angles[1] else angles[1] - 2 * np.pi
    turned = shares * sweep
    around = np.cos(turned)[:, None] * along + np.sin(turned)[:, None] * across
    return _timed(centre + radius * around, feed)


def read_toolpath(path: str | Path, *, planar: bool, feed: float | None = None) -> Toolpath:
    """Read a CSV table with the columns x, z (and y), perhaps fx, fy, fz, and perhaps time.

    Args:
        path: the file; its first line names the columns.
        planar: whether y may be left out.
        feed: speed along the path where there is no column `time` [m/s].

    Raises:
        InvalidRequest: every fault of the file.
    """
    file = Path(path)
    faults = FaultList(file)
    content = read_regular(file, limit=LARGEST, kind="a CSV file with a header")
    if isinstance(content, Fault):
        raise InvalidRequest(content)
    try:
        rows = list(csv.reader(io.StringIO(content.decode("utf-8-sig"), newline="")))
    except (UnicodeDecodeError, csv.Error):
        raise InvalidRequest(Fault(str(file), "", "not a text table", "a CSV file with a header")) from None
    header = [name.strip().lower() for name in rows[0]] if rows else []
    wanted = ("x", "z") if planar and "y" not in header else _POSITION
    force = [name for name in _FORCE if name in header]
    known = {*_POSITION, *_FORCE, "time"}
    for name in wanted:
        if name not in header:
            faults.add("header", f"no column {name}", f"the columns {', '.join(wanted)}")
    for name in header:
        if name not in known or header.count(name) > 1:
            faults.add("header", f"column {shown(name)}", f"each once: {', '.join(sorted(known))}")
    if "time" not in header and feed is None:
        faults.add("header", "no column time", "a column time [s], or a feed")
    if faults.faults:
        raise InvalidRequest(faults.faults)
    table = _numbers(faults, header, [row for row in rows[1:] if any(cell.strip() for cell in row)])
    if not 2 <= len(table) <= MOST_POINTS:
        faults.add("rows", str(len(table)), f"2 to {MOST_POINTS} points")
    columns = {name: table[:, place] for place, name in enumerate(header)}
    pushes = None
    if force:
        pushes = np.array([columns.get(name, np.zeros(len(table))) for name in _FORCE]).T
        sizes = np.linalg.norm(pushes, axis=1)
        if np.any(sizes == 0):
            faults.add(
                f"row {int(np.argmin(sizes)) + 2}", "a force without a direction", "fx, fy, fz not all 0"
            )
        pushes = pushes / np.where(sizes > 0, sizes, 1.0)[:, None]
    if "time" in columns and np.any(np.diff(columns["time"]) <= 0):
        place = int(np.argmin(np.diff(columns["time"]))) + 3
        faults.add(f"row {place}: time", "no later than the row before", "times that increase")
    if faults.faults:
        raise InvalidRequest(faults.faults)
    position = np.array([columns[name] for name in wanted]).T
    if "time" in columns:
        return Toolpath(position, columns["time"] - columns["time"][0], pushes)
    assert feed is not None
    timed = _timed(position, feed, source=str(file))
    return Toolpath(timed.position, timed.time, pushes)


def _numbers(faults: FaultList, header: list[str], rows: list[list[str]]) -> np.ndarray:
    """The cells as numbers; what is none is a fault, and 1 stands in for it."""
    table = np.ones((len(rows), len(header)))
    for place, row in enumerate(rows):
        if len(row) != len(header):
            faults.add(f"row {place + 2}", f"{len(row)} cells", str(len(header)))
            continue
        for column, cell in enumerate(row):
            try:
                table[place, column] = float(cell)
            except ValueError:
                table[place, column] = np.nan
            if not abs(table[place, column]) <= 1e6:
                faults.add(f"row {place + 2}: {header[column]}", shown(cell), "a finite number, at most 1e6")
                table[place, column] = 1.0
        if len(faults.faults) > 20:
            break
    return table


def _places(key: str, *given: tuple[float, ...]) -> list[np.ndarray]:
    places = [np.array(place, dtype=float) for place in given]
    if len({len(place) for place in places}) > 1 or not all(np.all(np.isfinite(place)) for place in places):
        raise InvalidRequest(Fault("call", key, str(given), "places with as many finite coordinates each"))
    if np.array_equal(places[0], places[-1]):
        raise InvalidRequest(Fault("call", key, "two ends in one place", "two places"))
    return places


def _count(points: int) -> int:
    if not 2 <= points <= MOST_POINTS:
        raise InvalidRequest(Fault("call", "points", str(points), f"2 to {MOST_POINTS}"))
    return points


def _timed(position: np.ndarray, feed: float, *, source: str = "call") -> Toolpath:
    if not (np.isfinite(feed) and feed > 0):
        raise InvalidRequest(Fault("call", "feed", f"{feed:g} m/s", "a finite speed above 0"))
    steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
    if np.any(steps == 0):
        place = int(np.argmin(steps)) + 2
        raise InvalidRequest(Fault(source, f"point {place}", "where the one before is", "another place"))
    return Toolpath(position, np.r_[0.0, np.cumsum(steps)] / feed)

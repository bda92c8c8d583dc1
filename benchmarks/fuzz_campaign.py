"""Spoilt campaigns for the fuzz: a small sound one with every kind of data, and second readers of it."""

from __future__ import annotations

import csv
import io
import re
import struct
import tempfile
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from fuzz_judges import Misread

from flexmodal.campaign import (
    Blow,
    Campaign,
    CampaignPoint,
    CampaignPosture,
    FrfRecords,
    ModeTable,
    Trial,
    import_table,
    read_campaign,
    write_campaign,
)

EXPORT = "export.uff"
"""A universal file without its campaign.toml."""
CLOSE = 1e-9
"""Relative difference of two readers that is rounding."""
MAP = """\
format = 1
campaign = "campaign.toml"
table = "table.csv"
abscissa = "f"
[[frf]]
posture = 1
trial = 1
response = [1, 3]
reference = [2, -3]
form = "inertance"
re = "re"
im = "im"
coherence = "g"
"""


def sound_campaign() -> Campaign:
    """Small, with every kind of data."""
    rng = np.random.default_rng(0)
    lines, samples = 9, 16
    frfs = FrfRecords(
        frequency=0.5 * np.arange(lines),
        value=rng.normal(size=(2, lines)) + 1j * rng.normal(size=(2, lines)),
        coherence=rng.uniform(0.5, 1, size=(2, lines)),
        posture=np.array([1, 1]),
        trial=np.array([1, 2]),
        response=np.array([[1, 3], [1, 3]]),
        reference=np.array([[2, -3], [2, -3]]),
        form="inertance",
    )
    axis = np.arange(samples) / 64
    blow = Blow(
        1, 1, 1, (2, -3), axis, rng.normal(size=samples) + 50, ((1, 3),), rng.normal(size=(1, samples))
    )
    whole, real = np.array([1, 1]), np.array([7.4, np.nan])
    modes = ModeTable(whole, whole, whole + 1, whole, real, real / 100, real * (1 + 1j), ("", "a:missing"))
    return Campaign(
        title="fuzz",
        robot="fanuc_s360",
        band=(0.5, 4.0),
        postures=(CampaignPosture(1, "bent", {"q1": 0.5}),),
        points=(
            CampaignPoint(1, "tip", "hand", (0.1, 0.0, 0.0)),
            CampaignPoint(2, "wrist", "arm", (0.0, 0.0, 0.0)),
        ),
        trials=(Trial(1, 100.0, 2, "soft", record_length=1.0), Trial(2, 90.0, 2, "hard", repeat_of=1)),
        frfs=frfs,
        blows=(blow,),
        modes=modes,
    )


@cache
def sound() -> dict[str, tuple[bytes, str]]:
    """What is spoilt: name to sound content and the file it becomes."""
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        return _sources(Path(folder))


@cache
def names() -> tuple[str, ...]:
    """The names of `sound`, in an order that stays."""
    return tuple(sorted(sound()))


def _sources(folder: Path) -> dict[str, tuple[bytes, str]]:
    found = {}
    for binary in (False, True):
        made = write_campaign(sound_campaign(), folder / f"sound_{binary}", binary=binary)
        for name in ("frf.uff", "time.uff"):
            found[f"{name} {'binary' if binary else 'ASCII'}"] = ((made / name).read_bytes(), name)
            if binary is (name == "frf.uff"):
                found[f"{name} by itself"] = ((made / name).read_bytes(), EXPORT)
    found["campaign.toml"] = ((made / "campaign.toml").read_bytes(), "campaign.toml")
    found["modes.csv"] = ((made / "modes.csv").read_bytes(), "modes.csv")
    table = "f,re,im,g\n" + "".join(f"{0.5 * n},{n},{-n},0.9\n" for n in range(9))
    found["table.csv"] = (table.encode(), "table.csv")
    found["map.toml"] = (MAP.encode(), "map.toml")
    return found


def read_one(name: str, content: bytes, folder: Path) -> None:
    """Lay the files out, one of them spoilt, read them, and have what is accepted judged.

    Args:
        name: one of `names`.
        content: what stands in its place.
        folder: empty.

    Raises:
        FlexmodalError: it is refused.
        Misread: it is accepted, and a second reader finds something else.
    """
    file = sound()[name][1]
    reader: Callable[[Path], Campaign] = read_campaign
    (folder / "campaign.toml").write_bytes(sound()["campaign.toml"][0])
    if file in ("table.csv", "map.toml"):
        (folder / "map.toml").write_bytes(sound()["map.toml"][0])
        (folder / "table.csv").write_bytes(sound()["table.csv"][0])
        reader = import_table
    elif file == "campaign.toml":
        (folder / "modes.csv").write_bytes(sound()["modes.csv"][0])
    (folder / file).write_bytes(content)
    path = folder / "map.toml" if reader is import_table else folder
    found = reader(folder / EXPORT if file == EXPORT else path)
    judge(name, file, content, found)


def judge(name: str, file: str, content: bytes, found: Campaign) -> None:
    """What was accepted, read again by something else.

    Raises:
        Misread: it differs.
    """
    if found.frfs is not None and not np.all(np.isfinite(found.frfs.value)):
        raise Misread("values that are not finite came through")
    if file == "campaign.toml":
        _judge_toml(tomllib.loads(content.decode("utf-8")), found)
    elif file == "modes.csv":
        _judge_modes(content.decode("utf-8-sig"), found)
    elif file == "table.csv":
        try:
            _judge_table(content.decode("utf-8-sig"), found)
        except UnicodeDecodeError:  # older analysers
            _judge_table(content.decode("latin-1"), found)
    elif name.startswith("frf.uff"):
        _judge_frfs(content, found)


def _judge_toml(given: dict[str, object], found: Campaign) -> None:
    postures = {one["id"]: one for one in given["posture"]}  # type: ignore[attr-defined, index, call-overload]
    if {one.id for one in found.postures} != set(postures) or len(found.postures) != len(given["posture"]):  # type: ignore[arg-type]
        raise Misread("a posture lost or twice")
    for one in found.postures:
        theirs = {name: float(value) for name, value in postures[one.id].get("q", {}).items()}
        if dict(one.q) != theirs or not all(abs(value) <= 1e4 for value in theirs.values()):
            raise Misread(f"posture {one.id}: {dict(one.q)}")
    for one, point in zip(found.points, given["point"], strict=True):  # type: ignore[call-overload]
        if (one.id, one.link) != (point["id"], point["link"]) or list(one.xyz) != list(point["xyz"]):
            raise Misread(f"point {one.id}: {one.xyz}")
    if "band" in given and list(found.band) != [float(one) for one in given["band"]]:
        raise Misread(f"band {found.band}")


def _judge_modes(text: str, found: Campaign) -> None:
    rows = [
        row
        for row in csv.DictReader(io.StringIO(text.lstrip("\r\n"), newline=""))
        if any((cell or "").strip() for cell in row.values())
    ]
    modes = found.modes
    if modes is None or len(rows) != len(modes.natural_frequency):
        raise Misread(f"{len(rows)} rows of modes read as {modes and len(modes.natural_frequency)}")
    for key in ("natural_frequency", "damping_ratio"):
        theirs = [float(row[key].strip()) if row[key].strip() else np.nan for row in rows]
        _same(key, getattr(modes, key), theirs)


def _judge_table(text: str, found: Campaign) -> None:
    rows = [
        row
        for row in csv.DictReader(io.StringIO(text, newline=""))
        if any((cell or "").strip() for cell in row.values())
    ]
    rows = [{name.strip(): cell for name, cell in row.items() if name is not None} for row in rows]
    if found.frfs is None:
        raise Misread("a table without FRFs")
    _same("frequency", found.frfs.frequency, [float(row["f"].strip()) for row in rows])
    theirs = np.array([float(row["re"].strip()) + 1j * float(row["im"].strip()) for row in rows])
    _same("values", found.frfs.value[0], theirs)


def _judge_frfs(content: bytes, found: Campaign) -> None:
    """Every FRF that was accepted stands in the file, in the units it was written in."""
    theirs = frfs_of(content)
    for record in () if found.frfs is None else found.frfs.value:
        if not any(len(one) == len(record) and _near(one, record) for one in theirs):
            raise Misread(f"an FRF that does not stand in the file: {record[:3]} …")


def frfs_of(content: bytes) -> list[np.ndarray]:
    """Frequency responses (function type 4) of a universal file's datasets 58, by columns and bytes alone.

    Args:
        content: ASCII or binary (58b), as the format's description has them.

    Returns:
        Their values, in the file's own units.
    """
    found = []
    for start in re.finditer(rb"(?m)^ {4}58(b?)[^\n]*\n", content):
        lines, rest = [start[0]], content[start.end() :]
        for _ in range(11):
            line, _, rest = rest.partition(b"\n")
            lines.append(line)
        try:
            one = _dataset([line.rstrip(b"\r") for line in lines], rest)
        except (ValueError, IndexError, struct.error):  # whoever accepts it accepts what is not in the list
            continue
        if one is not None:
            found.append(one)
    return found


def _dataset(header: list[bytes], rest: bytes) -> np.ndarray | None:
    """The values behind a header of twelve lines; none of another function."""
    kind, count, even = int(header[6][:5]), int(header[7][10:20]), int(header[7][20:30])
    number = int(header[7][:10])
    complex_, double = number in (5, 6), number in (4, 6)
    columns = count * (2 if complex_ else 1) + (0 if even else count)
    if kind != 4 or not complex_ or not 0 < count < 10_000:
        return None
    if header[0].strip()[2:3] == b"b":
        size = 8 if double else 4
        order = "<" if int(header[0][7:13]) == 1 else ">"
        numbers = np.array(struct.unpack(f"{order}{columns}{'d' if double else 'f'}", rest[: columns * size]))
    else:
        body, _, _ = rest.partition(b"\n    -1")
        numbers = np.array([float(one) for one in _columns(body, complex_, even, double)][:columns])
    table = numbers.reshape(count, -1)
    return table[:, -2] + 1j * table[:, -1]


def _columns(body: bytes, complex_: bool, even: int, double: bool) -> list[bytes]:
    """The cells of the data lines of an ASCII dataset, which hold numbers of 13 or 20 columns."""
    pattern = [20 if double else 13]
    if not even:  # E13.5 for the abscissa before each value
        pattern = [13, 20, 20] if complex_ else [13, 20]
        pattern = pattern if double else [13] * len(pattern)
    cells = []
    for line in body.split(b"\n"):
        place, width = 0, 0
        while line[place:].strip():
            size = pattern[width % len(pattern)]
            cells.append(line[place : place + size])
            place, width = place + size, width + 1
    return cells


def _near(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.all(np.abs(one - other) <= CLOSE * (np.abs(one) + np.abs(other))))


def _same(what: str, ours: object, theirs: object) -> None:
    one, other = np.asarray(ours), np.asarray(theirs)
    if one.shape != other.shape or not np.allclose(one, other, rtol=CLOSE, atol=0, equal_nan=True):
        raise Misread(f"{what}: {one.tolist()} here, {other.tolist()} by the other reader")

"""Studies from `robots/<robot>/studies.toml`."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.files import catalogue_folder
from flexmodal.optimisation.studies.study import KINDS, Study
from flexmodal.text.toml import parse_toml
from flexmodal.text.words import FaultList, listing, nearest, shown

FILE = "studies.toml"

_TEXTS = ("title", "kind", "says", "direction", "objective", "start", "printed", "family", "posture")
_NUMBERS = ("frequency", "printed_start", "printed_final", "printed_best")
_LISTS = ("hold", "printed_ends", "band", "starts")
_NEEDED = {"posture": ("start",), "sweep": ("family", "frequency"), "frequency": ("posture", "band")}


def shipped_studies() -> dict[str, Study]:
    """The studies of the catalogue by name, those of one robot together.

    Raises:
        InvalidRequest: a file with faults, or a name that two files give.
    """
    found: dict[str, Study] = {}
    for file in sorted((catalogue_folder() / "robots").glob(f"*/{FILE}")):
        for study in read_studies(file):
            if study.name in found:
                raise InvalidRequest(Fault(str(file), study.name, "a name in use", "a name of its own"))
            found[study.name] = study
    return found


def read_studies(path: str | Path) -> tuple[Study, ...]:
    """Read a file of studies.

    Raises:
        InvalidRequest: every fault of the file.
    """
    file = Path(path)
    content = parse_toml(file, kind="a file of studies")
    if isinstance(content, Fault):
        raise InvalidRequest(content)
    faults = FaultList(file)
    if content.get("format") != 1:
        faults.add("format", shown(content.get("format", "none")), "1")
    robot = content.get("robot")
    if not isinstance(robot, str):
        faults.add("robot", shown(robot) if "robot" in content else "none", "the name of a card, or a path")
        robot = ""
    tables = content.get("study", {})
    if not isinstance(tables, dict) or not tables:
        faults.add("study", "none", "tables [study.NAME]")
        tables = {}
    for key in content:
        if key not in ("format", "robot", "study"):
            faults.add(key, "an unknown key", "format, robot, [study.NAME]")
    studies = [_study(faults, name, robot, table) for name, table in tables.items()]
    if faults.faults:
        raise InvalidRequest(faults.faults)
    return tuple(study for study in studies if study is not None)


def _study(faults: FaultList, name: str, robot: str, table: Any) -> Study | None:
    where = f"study.{name}"
    if not isinstance(table, dict):
        faults.add(where, shown(table), "a table")
        return None
    known = [field.name for field in fields(Study) if field.name not in ("name", "robot")]
    given: dict[str, Any] = {}
    before = len(faults.faults)
    for key, value in table.items():
        if key not in known:
            faults.add(f"{where}.{key}", "an unknown key", f"{nearest(key, known)}one of {listing(known)}")
        elif key in _TEXTS and not isinstance(value, str):
            faults.add(f"{where}.{key}", shown(value), "a text")
        elif key in _NUMBERS and not _is_number(value):
            faults.add(f"{where}.{key}", shown(value), "a number")
        elif key in _LISTS and not (isinstance(value, list) and all(map(_is_number, value))):
            faults.add(f"{where}.{key}", shown(value), "a list of numbers")
        else:
            given[key] = tuple(map(float, value)) if key in _LISTS else value
    for key in ("title", "kind", "says", *_NEEDED.get(str(table.get("kind")), ())):
        if key not in table:
            faults.add(f"{where}.{key}", "none", "a value")
    for key, allowed in (("kind", KINDS), ("objective", ("receptance", "stiffness"))):
        if key in table and table[key] not in allowed:
            faults.add(f"{where}.{key}", shown(table[key]), " or ".join(allowed))
    return Study(name, robot, **given) if len(faults.faults) == before else None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)

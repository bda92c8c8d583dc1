"""A measurement that somebody asked for: `next_measurement` of a `diagnosis.json`, read and checked."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.text.frozen import FrozenDict
from flexmodal.text.words import FaultList

Place = tuple[int, int]
"""Point id, and direction ±1 ±2 ±3."""
_WHOLE = "diagnosis.json, or its next_measurement with a posture"
_PLACE = "[id of a point, direction ±1 ±2 ±3]"


@dataclass(frozen=True)
class Asked:
    """One posture, and in it one FRF or, where none is named, every one that the campaign has elsewhere."""

    posture: Mapping[str, float]
    """Angles of commanded joints [rad, m]; those left out stay at 0."""
    response: Place | None = None
    reference: Place | None = None
    force_peak: float | None = None
    """Of the blows [N]; every kind of blow that the campaign has if None."""
    new_points: Mapping[int, str] = field(default_factory=dict)
    """Names in the robot's card of points that the campaign has not used yet, by the ids they get."""
    locked: tuple[str, ...] = ()
    """Flexible joints to lock."""
    masses: Mapping[str, float] = field(default_factory=FrozenDict)
    """Masses to bolt on, by the name of the point [kg]."""


def read_asked(path: str | Path) -> Asked:
    """What a diagnosis asked for; of several measurements the first, which is the best.

    Args:
        path: of `diagnosis.json`, or of its `next_measurement` by itself.

    Raises:
        InvalidRequest: no such file, no JSON, no measurement asked for, values that are none; all at once.
    """
    try:
        found = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InvalidRequest(Fault(str(path), "", f"a file that cannot be read ({error})", _WHOLE)) from None
    if isinstance(found, dict) and "next_measurement" in found:
        found = found["next_measurement"]
        if found is None or found == []:
            raise InvalidRequest(Fault(str(path), "next_measurement", "null: nothing was asked for", _WHOLE))
    if isinstance(found, list) and found:
        found = found[0]
    posture = found.get("posture") if isinstance(found, dict) else None
    if not isinstance(posture, dict) or not posture:
        raise InvalidRequest(Fault(str(path), "posture", "none", _WHOLE))
    faults = FaultList(Path(path))
    asked = Asked(
        posture=_numbers(faults, posture, "posture", "a finite angle [rad] or way [m]", least=-math.inf),
        response=_place(faults, found, "response"),
        reference=_place(faults, found, "reference"),
        force_peak=_peak(faults, found.get("force_peak")),
        new_points=_new_points(faults, found.get("new_points", {})),
        locked=_names(faults, found.get("locked", [])),
        masses=_numbers(faults, found.get("masses", {}), "masses", "a mass in kg, above 0", least=0.0),
    )
    if (asked.response is None) != (asked.reference is None) and not faults.faults:
        missing = "response" if asked.response is None else "reference"
        faults.add(missing, "none", "response and reference, or neither for every place of the campaign")
    if faults.faults:
        raise InvalidRequest(faults.faults)
    return asked


def _is_number(value: Any) -> bool:
    return not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value)


def _numbers(faults: FaultList, table: Any, key: str, allowed: str, *, least: float) -> FrozenDict[float]:
    if not isinstance(table, dict):
        faults.add(key, repr(table)[:60], f"a table of {allowed}")
        return FrozenDict()
    for name, value in table.items():
        if not _is_number(value) or value <= least:
            faults.add(f"{key}.{name}", repr(value)[:60], allowed)
    return FrozenDict({name: float(value) for name, value in table.items() if _is_number(value)})


def _place(faults: FaultList, table: dict[str, Any], key: str) -> Place | None:
    given = table.get(key)
    if given is None:
        return None
    whole = isinstance(given, list) and len(given) == 2 and all(type(one) is int for one in given)
    if not whole or given[0] < 1 or abs(given[1]) not in (1, 2, 3):
        faults.add(key, repr(given)[:60], _PLACE)
        return None
    return given[0], given[1]


def _peak(faults: FaultList, given: Any) -> float | None:
    if given is None:
        return None
    if not _is_number(given) or not 0 < given <= 1e6:
        faults.add("force_peak", repr(given)[:60], "a force in N, above 0")
        return None
    return float(given)


def _names(faults: FaultList, given: Any) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(one, str) for one in given):
        faults.add("locked", repr(given)[:60], "a list of names of flexible joints")
        return ()
    return tuple(dict.fromkeys(given))


def _new_points(faults: FaultList, given: Any) -> Mapping[int, str]:
    allowed = "a table of id = name of a point in the robot's card"
    if not isinstance(given, dict):
        faults.add("new_points", repr(given)[:60], allowed)
        return {}
    found = {}
    for number, name in given.items():
        if not number.isascii() or not number.isdigit() or not int(number) or not isinstance(name, str):
            faults.add(f"new_points.{number}", repr(name)[:60], allowed)
        else:
            found[int(number)] = name
    return found

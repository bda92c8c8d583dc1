"""From pydantic's complaints about a campaign.toml to sentences about the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flexmodal.text.words import FaultList, listing, nearest, shown

_TEXT = "some text, not empty"
_ID = "a whole number from 1 to 9999999999"
_WINDOW = '"none", or { kind = "force" or "exponential", decay = a number in 1/s, 0 or more }'

ALLOWED: dict[str, dict[str, str]] = {
    "": {
        "format": "1",
        "title": _TEXT,
        "robot": "a card's name, or a path relative to this file",
        "band": "two frequencies in Hz, the lower first",
        "posture": "at least one table [[posture]]",
        "point": "at least one table [[point]]",
        "trial": "at least one table [[trial]]",
    },
    "posture": {"id": _ID, "name": _TEXT, "q": "a table of joint = finite angle in rad"},
    "point": {
        "id": _ID,
        "name": _TEXT,
        "link": "the name of a URDF link",
        "xyz": "three finite numbers in m",
    },
    "trial": {
        "id": "a whole number from 1 to 99999",
        "force_peak": "a number in N, above 0",
        "averages": "a whole number, 1 or more",
        "tip": _TEXT,
        "record_length": "a number in s, above 0",
        "window": _WINDOW,
        "repeat_of": "the id of another trial",
    },
}
"""Section and key to what may stand there; the keys are also all the keys a section has."""


def add_faults(faults: FaultList, errors: Sequence[Mapping[str, Any]]) -> None:
    """Add a fault for each of pydantic's errors.

    Args:
        faults: where they go.
        errors: what `ValidationError.errors()` gives.
    """
    seen = set()
    for error in errors:
        location = [part for part in error["loc"] if part not in ("[key]", "WindowTable", "literal['none']")]
        key = key_of(location)
        if error["type"] == "extra_forbidden" and "window" not in location:
            names = ALLOWED["" if len(location) == 1 else str(location[0])]
            hint = nearest(str(location[-1]), names)
            found, allowed = "an unknown key", f"{hint}the keys here are {listing(names)}"
        else:
            found = "nothing" if error["type"] == "missing" else shown(error["input"])
            found = "no table" if error["type"] == "too_short" and error["input"] == [] else found
            allowed = _allowed(location)
            if "window" in location:
                key, found = key_of(location[:3]), "something else" if len(location) > 3 else found
        if key not in seen:
            faults.add(key, found, allowed)
            seen.add(key)


def key_of(location: Sequence[str | int]) -> str:
    """`posture[0].q.q1` from its parts."""
    key = ""
    for part in location:
        key += f"[{part}]" if isinstance(part, int) else f"{'.' if key else ''}{part}"
    return key


def _allowed(location: Sequence[str | int]) -> str:
    if not location:
        return "a table"
    section = str(location[0])
    if len(location) == 1 or section == "band":
        return ALLOWED[""][section]
    if len(location) == 2:
        return f"a table with {listing(ALLOWED[section])}"
    return ALLOWED[section][str(location[2])]

"""From pydantic's complaints about a card to sentences about the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flexmodal.text.words import FaultList, listing, nearest, shown

CARD_NAME = "a name of letters, digits, _ . and -"
CARD_TEXT = "some text, not empty"

ALLOWED: dict[str, dict[str, str]] = {
    "": {
        "format": "1",
        "name": CARD_NAME,
        "title": CARD_TEXT,
        "urdf": "a path to a URDF: relative to this file, absolute, or package://",
        "tool": "the name of a URDF link",
        "source": CARD_TEXT + ": where the numbers come from",
        "loss_frequency": "a number in Hz, above 0, at most 1e18, where lossy joints have their stiffness",
        "joint": "at least one table [joint.<name>]",
        "coupling": 'tables [coupling."jointA+jointB"]',
        "point": "tables [point.<name>]",
        "posture": "tables [posture.<name>]",
        "family": "tables [family.<name>]",
    },
    "joint": {
        "stiffness": "a number in N·m/rad (N/m for a prismatic joint), above 0 and at most 1e18",
        "damping": "a number in N·m·s/rad (N·s/m for a prismatic joint), from 0 to 1e18",
        "pseudo": "true or false",
        "rotor_inertia": "a number in kg·m² (kg for a prismatic joint), from 0 to 1e18",
        "loss_factor": "a number from 0 to 10",
        "lower": "a factor on the values of the card, above 0 and below 1",
        "upper": "a factor on the values of the card, above 1",
        "scale": "a relative standard deviation, above 0",
    },
    "coupling": {"stiffness": "a number in N·m/rad, of either sign, of at most 1e18"},
    "point": {"link": "the name of a URDF link", "xyz": "three finite numbers in m"},
    "family": {
        "parameter": "the name of a joint",
        "from": "a finite number in rad (m for a prismatic joint)",
        "to": "a finite number in rad (m for a prismatic joint)",
        "follow": "a table of joint = finite factor",
    },
}
"""Section and key to what may stand there; the keys are also all the keys a section has."""

ANGLE = "a finite number in rad (m for a prismatic joint)"
FACTOR = "a finite factor"


def add_faults(faults: FaultList, errors: Sequence[Mapping[str, Any]]) -> None:
    """Add a fault for each of pydantic's errors.

    Args:
        faults: where they go.
        errors: what `ValidationError.errors()` gives.
    """
    for error in errors:
        location = [part for part in error["loc"] if part != "[key]"]
        key = _key(location)
        if error["type"] == "extra_forbidden":
            names = ALLOWED["" if len(location) == 1 else str(location[0])]
            hint = nearest(str(location[-1]), names)
            faults.add(key, "an unknown key", f"{hint}the keys here are {listing(names)}")
        elif error["type"] == "value_error":
            _add_family_fault(faults, key, error)
        elif error["loc"] and error["loc"][-1] == "[key]":
            faults.add(key, f"the name {shown(location[-1])}", _allowed_name(location))
        else:
            found = "nothing" if error["type"] == "missing" else shown(error["input"])
            if error["type"] == "too_short" and isinstance(error["input"], dict):
                found = "no table"
            faults.add(key, found, _allowed(location))


def _key(location: Sequence[str | int]) -> str:
    key = ".".join(str(part) for part in location if isinstance(part, str))
    index = [part for part in location if isinstance(part, int)]
    return f"{key}[{index[0]}]" if index else key


def _allowed(location: Sequence[str | int]) -> str:
    section, depth = str(location[0]), len(location)
    if depth == 1:
        return ALLOWED[""][section]
    if section == "posture":
        return "a table of joint = angle" if depth == 2 else ANGLE
    if depth == 2:
        return f"a table with {listing(ALLOWED[section])}"
    if section == "family" and depth > 3:
        return FACTOR
    return ALLOWED[section][str(location[2])]


def _allowed_name(location: Sequence[str | int]) -> str:
    is_joint = location[0] == "joint" or len(location) > 2
    return "the name of a joint" if is_joint else CARD_NAME


def _add_family_fault(faults: FaultList, key: str, error: Mapping[str, Any]) -> None:
    table, which = error["input"], str(error["ctx"]["error"])
    if which == "from":
        faults.add(f"{key}.from", shown(table["from"]), f"less than to, which is {shown(table['to'])}")
    else:
        parameter = table["parameter"]
        faults.add(f"{key}.follow.{parameter}", "the parameter itself", "other joints that follow it")

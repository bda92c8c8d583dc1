"""What each key of a cut may hold: how it is read, and the sentence for when it cannot be."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmodal.text.words import FaultList, listing, nearest, shown

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Field:
    """One key."""

    read: Callable[[Any], Any]
    """From what stands in the file to the value; ValueError where it may not stand there."""
    allowed: str
    required: bool = False


def number(low: float, high: float) -> Callable[[Any], float]:
    """A finite number from `low` to `high`.

    Args:
        low: least value.
        high: greatest value.
    """

    def read(given: Any) -> float:
        if isinstance(given, bool) or not isinstance(given, int | float | np.integer | np.floating):
            raise ValueError
        try:
            value = float(given)
        except OverflowError:
            raise ValueError from None
        if not low <= value <= high:
            raise ValueError
        return value

    return read


def angle(low: float, high: float) -> Callable[[Any], float]:
    """A number in rad, or text such as "30deg"; limits in degrees.

    Args:
        low: least value [°].
        high: greatest value [°].
    """
    judge = number(low, high)

    def read(given: Any) -> float:
        if isinstance(given, str):
            text = given.strip()
            if not text.endswith("deg"):
                raise ValueError
            return math.radians(judge(float(text.removesuffix("deg"))))
        value = number(-10.0, 10.0)(given)
        judge(round(math.degrees(value), 9))
        return value

    return read


def whole(low: int, high: int) -> Callable[[Any], int]:
    """A whole number; true is none.

    Args:
        low: least value.
        high: greatest value.
    """

    def read(given: Any) -> int:
        if isinstance(given, bool) or not isinstance(given, int | np.integer) or not low <= given <= high:
            raise ValueError
        return int(given)

    return read


def text(*choices: str) -> Callable[[Any], str]:
    """Text that is not empty, one of `choices` if there are any."""

    def read(given: Any) -> str:
        if not isinstance(given, str) or not given.strip() or (choices and given not in choices):
            raise ValueError
        return given

    return read


def numbers(count: int, low: float, high: float) -> Callable[[Any], tuple[float, ...]]:
    """That many numbers.

    Args:
        count: how many.
        low: least value of each.
        high: greatest value of each.
    """
    judge = number(low, high)

    def read(given: Any) -> tuple[float, ...]:
        if not isinstance(given, list | tuple | np.ndarray) or len(given) != count:
            raise ValueError
        return tuple(judge(value) for value in given)

    return read


def direction(given: Any) -> tuple[float, ...]:
    """A unit vector from "+x", "-z" or three numbers that are not all 0."""
    if isinstance(given, str):
        sign = -1.0 if given.startswith("-") else 1.0
        name = given.removeprefix("+" if sign > 0 else "-")
        if name not in _AXES:
            raise ValueError
        return tuple(sign * part + 0.0 for part in _AXES[name])
    vector = np.array(numbers(3, -1e9, 1e9)(given))
    length = float(np.linalg.norm(vector))
    if length < 1e-9:
        raise ValueError
    return tuple((vector / length).tolist())


def read_table(
    content: Any, fields: Mapping[str, Field], section: str, faults: FaultList
) -> dict[str, Any] | None:
    """Read one table by its fields.

    Args:
        content: what stands in the file.
        fields: every key the table may have.
        section: its name, for the keys of the faults; empty for the file itself.
        faults: where they go.

    Returns:
        The values of the keys that stand there, or None if there was any fault.
    """
    before = len(faults.faults)
    if not isinstance(content, Mapping):
        found = "nothing" if content is None else shown(content)
        faults.add(section, found, f"a table with {listing(fields)}")
        return None
    values: dict[str, Any] = {}
    for key, given in content.items():
        place = f"{section}.{key}" if section else str(key)
        if key not in fields:
            faults.add(place, "an unknown key", f"{nearest(key, fields)}the keys here are {listing(fields)}")
            continue
        try:
            values[key] = fields[key].read(given)
        except ValueError:
            faults.add(place, shown(given), fields[key].allowed)
    for key, field in fields.items():
        if field.required and key not in content:
            faults.add(f"{section}.{key}" if section else key, "nothing", field.allowed)
    return values if len(faults.faults) == before else None

"""A point and a direction at it, written "tool:+z"; a point's own name may hold colons, as `ns:tool0`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidPoint

AXES = ("x", "y", "z", "rx", "ry", "rz")
"""Translations, then rotations, along and about the axes of the world frame."""

_TEXT = re.compile(r"(?P<point>[^:\s](.*[^:\s])?):(?P<sign>[+-]?)(?P<axis>r?[xyz])", re.DOTALL)


@dataclass(frozen=True)
class PointDirection:
    """One row of a Jacobian: a named point, an axis of the world frame, and a sense.

    As a response it is a displacement [m] or rotation [rad]; as a reference a force [N] or moment [N·m].

    >>> PointDirection("tool", "-z") == PointDirection.parse("tool:-z")
    True
    """

    point: str
    axis: str
    sign: int = 1

    def __post_init__(self) -> None:
        if self.axis[:1] in ("+", "-"):  # PointDirection("tool", "-z")
            object.__setattr__(self, "sign", -self.sign if self.axis[0] == "-" else self.sign)
            object.__setattr__(self, "axis", self.axis[1:])
        named = self.point and self.point == self.point.strip(": \t")
        if not named or self.axis not in AXES or self.sign not in (1, -1):
            raise _fault(f"{self.point}:{self.sign:+d}{self.axis}")

    @classmethod
    def parse(cls, text: str | PointDirection, *, source: str = "call") -> PointDirection:
        """Read "name:+z", "name:-x" or, for rotations, "name:+ry"; no sign means +.

        Args:
            text: such as "tool:+z"; a direction is given back as it is.
            source: where the text came from, for the error.

        Raises:
            InvalidPoint: the text has another form.
        """
        if isinstance(text, PointDirection):
            return text
        match = _TEXT.fullmatch(text.strip())
        if match is None:
            raise _fault(text, source)
        return cls(match["point"], match["axis"], -1 if match["sign"] == "-" else 1)

    def __repr__(self) -> str:
        """As it is written."""
        return f"PointDirection({str(self)!r})"

    @property
    def is_rotation(self) -> bool:
        """Whether it turns about its axis instead of moving along it."""
        return self.axis.startswith("r")

    @property
    def selector(self) -> Float[np.ndarray, "6"]:
        """Row vector that picks this direction from a six-row Jacobian."""
        row = np.zeros(6)
        row[AXES.index(self.axis)] = self.sign
        return row

    def __str__(self) -> str:
        """The text that `parse` reads."""
        return f"{self.point}:{'+' if self.sign > 0 else '-'}{self.axis}"


def directions_of(given: str | PointDirection | Iterable[str | PointDirection]) -> tuple[PointDirection, ...]:
    """One direction or several, as texts or not.

    Args:
        given: such as "tool:+z", or several of the kind.

    Raises:
        InvalidPoint: a text of another form.
    """
    several = [given] if isinstance(given, str | PointDirection) else given
    return tuple(PointDirection.parse(one) for one in several)


def _fault(found: str, source: str = "call") -> InvalidPoint:
    return InvalidPoint(
        Fault(source, "direction", repr(found), "point and direction, such as tool:+z, tool:-x, tool:+ry")
    )

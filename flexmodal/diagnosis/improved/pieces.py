"""Pieces of a robot being changed: where a link was cut, and what was hung on one."""

from __future__ import annotations

from dataclasses import dataclass

from flexmodal.diagnosis.improved.joints import Vector
from flexmodal.structure.arm import Body


@dataclass(frozen=True, eq=False)
class Cut:
    """Where a link was cut in two."""

    place: Vector
    """In the frame of the link [m]."""
    way: Vector
    """Unit vector towards what lies beyond."""
    outer: str
    """The link beyond; its frame is turned as that of the link and sits in the cut."""


@dataclass(frozen=True, eq=False)
class Hung:
    """Something attached to a link: rigidly, or free along some directions or about them."""

    link: str
    place: Vector
    """In the frame of the link [m]."""
    body: Body
    """In a frame at that place, turned as that of the link."""
    joints: tuple[str, ...]
    ways: tuple[Vector, ...] = ()
    kind: str = "fixed"
    """Of these joints."""

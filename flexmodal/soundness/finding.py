"""One thing that is wrong with a hammer test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

FindingKind = Literal[
    "sign", "axes swapped", "points swapped", "hammer positions swapped", "scale", "postures exchanged",
    "joint sign", "axes in another frame", "degrees for radians", "reciprocity", "drive point", "double hit",
    "AC coupling", "overload", "drift", "FRFs against blows", "joint left out",
]  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """What is wrong; nothing is repaired silently."""

    kind: FindingKind
    where: str
    """Posture, point, direction, blow."""
    evidence: str
    """What was seen, with its numbers."""
    cost: str
    """What it does to the results."""
    remedy: str
    """What to do."""
    harmless: bool = False
    """Whether it may stay as it is."""

    def __str__(self) -> str:
        """As one line."""
        return f"{self.kind}, {self.where}: {self.evidence}; {self.cost}; {self.remedy}"

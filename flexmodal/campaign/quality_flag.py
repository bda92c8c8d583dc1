"""One doubt about a blow or an averaged FRF."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

FlagKind = Literal["double hit", "overload", "low energy in band", "low coherence"]


@dataclass(frozen=True)
class QualityFlag:
    """One doubt about one blow or record."""

    kind: FlagKind
    posture: int
    trial: int
    blow: int | None
    """Sequence number; None where the average of the blows is meant."""
    point: tuple[int, int]
    """Point and direction of the channel: the force's, or a response's."""
    says: str
    """The evidence, as a phrase."""

    def __str__(self) -> str:
        """One sentence."""
        where = f"posture {self.posture}, trial {self.trial}"
        where += "" if self.blow is None else f", blow {self.blow}"
        return f"{where}, point {self.point[0]} direction {self.point[1]:+d}: {self.kind}: {self.says}"

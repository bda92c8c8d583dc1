"""An effect in a place."""

from __future__ import annotations

from dataclasses import dataclass

from flexmodal.diagnosis.effects.effect import Effect


@dataclass(frozen=True, eq=False)
class Placed:
    """An effect in a place."""

    effect: Effect
    where: str

    @property
    def label(self) -> str:
        """Prefix of its parameters."""
        return f"{self.effect.name}@{self.where}"

    @property
    def key(self) -> tuple[str, str]:
        """Name and place."""
        return self.effect.name, self.where

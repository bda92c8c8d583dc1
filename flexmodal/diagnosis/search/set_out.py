"""Where the fits of one more effect set out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.diagnosis.hypothesis import Hypothesis

NEAR_BY = 2
"""Effects beside which another one is looked for near what is fitted, no longer from the card too."""
Start = tuple[Mapping[str, float], Float[np.ndarray, " before"]]
"""Values of an effect, and coordinates of what is there beside it."""


def _nothing(effect: Effect, where: str) -> Sequence[Start]:
    """Nobody tells."""
    return ()


@dataclass(frozen=True, eq=False)
class SetOut:
    """Coordinates of what is there, and what was found at an effect's place without a law."""

    before: Sequence[Float[np.ndarray, " before"]]
    told: Callable[[Effect, str], Sequence[Start]] = _nothing

    def starts(self, hypothesis: Hypothesis) -> list[list[Float[np.ndarray, " parameter"]]]:
        """Coordinates of a hypothesis, its last effect started from everywhere.

        Args:
            hypothesis: with the effect.

        Returns:
            Those that set out from the same coordinates together, and those that were told.
        """
        placed = hypothesis.placed[-1]
        given = placed.effect.starts(hypothesis.context, placed.where)
        found = [[hypothesis.start(placed, one, x) for one in given] for x in self.before]
        told = [hypothesis.start(placed, *one) for one in self.told(placed.effect, placed.where)]
        return [*found, told] if told else found

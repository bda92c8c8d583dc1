"""Parameters of the robot that a fit takes further from the card than the card is trusted to be off."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from flexmodal.structure import ParameterSpace

FAR = 5.0
"""Standard deviations of the prior from which a parameter is beyond belief."""


def beyond_words(space: ParameterSpace, x: Float[np.ndarray, " parameter"], count: int) -> tuple[str, ...]:
    """A sentence for each parameter of the robot that is beyond belief.

    Args:
        space: of the robot, then of its effects.
        x: coordinates, 0 at the card.
        count: how many are the robot's own.
    """
    found = []
    for parameter, at in list(zip(space, x.tolist(), strict=True))[:count]:
        off = abs(at) / parameter.deviation if parameter.deviation > 0 else 0.0
        if off > FAR and parameter.log:
            found.append(
                f"The fit takes {parameter.name} to {math.exp(at):.3g} times the card's value, {off:.0f} "
                "standard deviations of what the card is trusted to be off by: either it is wrong there, or "
                "something is missing that acts in the same way."
            )
    return tuple(found)

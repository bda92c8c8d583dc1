"""Sensors that move on in sets: while one point is measured, its neighbours carry a sensor too.

Points are measured in the order in which the campaign lists them, so many at once (Ewins, Modal Testing,
2nd ed., section 3.5, on what transducers weigh that rove).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.sensors import mounted
from flexmodal.structure.assembly import Assembly

SIZES = (2, 3, 4)
"""How many sensors there may be."""


def neighbours(context: Context, size: int) -> Mapping[int, tuple[int, ...]]:
    """Points that carry a sensor while one is measured, itself among them, by its id.

    Args:
        context: of the diagnosis.
        size: of the sets.
    """
    every = [point.id for point in context.points]
    sets = [tuple(every[k : k + size]) for k in range(0, len(every), size)]
    return {point: one for one in sets for point in one}


def motions(assembly: Assembly, placement: Placement, size: int) -> Float[np.ndarray, "sensor system 6 dof"]:
    """How each of the sensors moves in the systems; those that a last set lacks do not.

    Args:
        assembly: with all motions.
        placement: with how far off the surface they sit.
        size: of the sets.
    """
    found = np.zeros((size, len(placement.posture), 6, len(assembly.coordinates)))
    together = neighbours(placement.context, size)
    for number in np.unique(placement.response[:, 0]).tolist():
        here = placement.response[:, 0] == number
        for k, one in enumerate(together[number]):
            place = mounted(placement.context, one, placement.values)
            found[k, here] = assembly.motion(placement.context.point(one).link, place)[here]
    return found


def weigh(assembly: Assembly, placement: Placement, size: int) -> None:
    """All of them weigh alike, as the one that is read.

    Args:
        assembly: to which they are added.
        placement: of the effect.
        size: of the sets.
    """
    for motion in motions(assembly, placement, size):
        for k in range(3):
            assembly.add_inertia(motion[:, k], placement["mass"])
            assembly.add_inertia(motion[:, k + 3], placement["mass"] * placement["gyration"] ** 2)

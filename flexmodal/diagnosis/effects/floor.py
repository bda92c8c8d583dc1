"""Whether what gives under a robot is a foundation of its own, or a floor that goes up and down.

What a machine stands on is stiffer upright than level, whether that is soil under a footing, of half a space
k_z / k_x = (2 − ν) / (2 − 2ν), never below 1 (Gazetas, Formulas and charts for impedances of surface and
embedded foundations, J. Geotech. Eng. 117, 1991, 1363), or mounts, whose rubber is softer in shear (Rivin,
Passive Vibration Isolation, ASME Press 2003, chapter 3). It tilts on supports that are nearer to each other
than the arm is long. What gives upright far more than level, and does not tilt much either, is a floor with
whatever else stands on it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.foundation import Spring, length_of, motions
from flexmodal.diagnosis.effects.foundation_law import FoundationLaw
from flexmodal.structure import Parameter, ParameterSpace

UPRIGHT = 0.15
"""Part of all motion of the arm's far end, twisting about the upright axis apart, that is upright on a floor;
of foundations that were drawn at random and fitted 0.03 at most, of floors 0.2 and more."""
OVER_LEVEL = 2.0
"""By how much a floor gives more upright than level; foundations give less."""
LINES = 100
"""Over the band."""
SAYS = "what the robot stands on goes up and down more than sideways, as a floor does and no foundation"


def floor_like(
    context: Context,
    values: Mapping[str, float],
    parameters: Sequence[Parameter],
    bolts: Callable[[Placement], Sequence[Spring]] | None = None,
) -> float:
    """How far beyond a foundation something gives upright; from 0 on it moves as a floor does.

    By the means over the band of the sizes of compliances, tilts at the arm's length.

    Args:
        context: of the diagnosis.
        values: of the parameters.
        parameters: of the law.
        bolts: springs between the foundation and the root, if there are any.

    Returns:
        Logarithm of the lesser of the two ratios to their limits; −∞ of an arm that moves level only.
    """
    motion = motions(context.normal)[1]
    if not motion[2].any():
        return -np.inf
    count, space = motion.shape[1], ParameterSpace(tuple(parameters))
    omega = 2 * np.pi * np.linspace(*context.band, LINES)
    pairs = np.array([np.arange(count), np.arange(count)])
    law = FoundationLaw(context, space, bolts, omega, np.eye(count), pairs)
    x = space.coordinates({name: values[name] for name in space.names})
    arms = np.where(motion[3:].any(axis=0), length_of(context), 1.0)
    moved = np.abs(law.compliance(x)).mean(axis=0) * arms**2
    upright, counted = np.abs(motion[2]) > 0.5, np.abs(motion[5]) < 0.5
    level = ~upright & ~motion[3:].any(axis=0)
    part = float(moved[upright].sum() / moved[counted].sum())
    over = float(moved[upright].sum() / moved[level].max())
    return float(np.log(min(part / UPRIGHT, over / OVER_LEVEL)))

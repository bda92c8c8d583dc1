"""Regenerative lobes of a tool that moves in one direction: turning, boring, plunging, drilling.

Tlusty's closed form: with the specific force K_s and the receptance G of the cut's chip thickness per force,
the width `b = −1 / (2 K_s Re G)` is the limit at each frequency where Re G is negative, and the tooth period
there is `T = (2πk + 3π + 2ψ) / ω` with ψ the phase of G between −π and 0 (Tlusty and Poláček 1963; Tobias and
Fishwick 1958; Altintas, Manufacturing Automation, 2nd ed. 2012, section 4.4.1). Nothing is averaged or cut
off: the cut is never interrupted, so this is exact, and a check on all the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest


@dataclass(frozen=True, eq=False)
class DirectionLobes:
    """Lobes as curves: each lobe's speed and width at the frequencies where it exists."""

    frequency: Float[np.ndarray, " line"]
    """Chatter frequencies, where Re G is negative [Hz]."""
    width: Float[np.ndarray, " line"]
    """Limit of the width of cut, the same for all lobes [m]."""
    speed: Float[np.ndarray, "lobe line"]
    """Spindle speed, lobe 0 first [rev/min]."""

    @property
    def limiting_width(self) -> float:
        """Width that is stable at every speed [m]; infinite if Re G is nowhere negative."""
        return float(np.min(self.width, initial=np.inf))


def oriented(
    receptance: Complex[np.ndarray, "line 3 3"], force: np.ndarray, normal: np.ndarray
) -> Complex[np.ndarray, " line"]:
    """Receptance of the chip thickness per force: how far the tool dips into the work under a unit force.

    Args:
        receptance: of the tool's point [m/N].
        force: direction of the cutting force on the tool.
        normal: direction away from the cut surface: the chip gets thinner as the tool moves along it.

    Raises:
        InvalidRequest: a direction that is none.
    """
    unit = []
    for name, given in (("force", force), ("normal", normal)):
        vector = np.asarray(given, dtype=float)
        length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
        if not 1e-9 < length < 1e9:
            raise InvalidRequest(Fault("call", name, repr(given), "three finite numbers, not all 0"))
        unit.append(vector / length)
    return np.einsum("i,lij,j->l", unit[1], receptance, unit[0])


def single_direction(
    frequency: Float[np.ndarray, " line"],
    receptance: Complex[np.ndarray, " line"],
    specific_force: float,
    *,
    teeth: int = 1,
    lobes: int = 10,
) -> DirectionLobes:
    """Lobes of a single direction.

    Args:
        frequency: ascending [Hz].
        receptance: G, along the normal per cutting force, see `oriented` [m/N].
        specific_force: K_s, cutting force per width and chip thickness [N/m²].
        teeth: cutting edges on the turn.
        lobes: how many, from 0 on.

    Raises:
        InvalidRequest: a specific force that is not positive, no tooth or no lobe.
    """
    if not (0 < specific_force < np.inf and teeth >= 1 and lobes >= 1):
        found = f"specific_force {specific_force}, teeth {teeth}, lobes {lobes}"
        raise InvalidRequest(
            Fault("call", "arguments", found, "a force above 0, one tooth and one lobe or more")
        )
    able = (receptance.real < 0) & (frequency > 0)
    line, value = frequency[able], receptance[able]
    phase = np.angle(value)
    phase = np.where(phase > 0, phase - 2 * np.pi, phase)
    wave = np.arange(lobes)[:, None] * 2 * np.pi + 3 * np.pi + 2 * phase
    period = wave / (2 * np.pi * line)
    with np.errstate(divide="ignore"):
        speed = 60 / (teeth * period)
    return DirectionLobes(line, -1 / (2 * specific_force * value.real), speed)

"""A belt from joint to joint over a roller on a spring, which keeps it tight and swings within the band.

Along q₁ − r q₂ it is 1/(1/k + 1/(k_t + c s + m s²)): the belt, and behind it the roller with its spring and
damper (Beikmann, Perkins and Ulsoy, ASME J. Vibration and Acoustics 118, 1996, 406).
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.diagnosis.effects.rod import pairs
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

SIZES, RATIOS, SWINGS = (0.2, 1.0, 4.0), (0.5, 1.0, 2.0), 4
"""Stiffness of the belt over the first joint's, and ratios of either sign, from which fits start; and how
many frequencies of the roller, over the band."""


def _first(context: Context, where: str) -> float:
    """Stiffness of the first joint by the card [N·m/rad]."""
    return float(context.robot.joints[where.split("+", maxsplit=1)[0]].stiffness)


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k, (low, high) = _first(context, where), context.band
    return (
        positive("belt_stiffness", "N·m/rad", k, 1.5, 1e-3 * k, 100 * k),
        signed("belt_ratio", "", 1.0, -8.0, 8.0, centre=1.0),
        positive("tightness", "of the belt's stiffness", 1.0, 1.0, 0.01, 100.0),
        positive("roller_frequency", "Hz", 0.4 * high, 0.7, low, 10 * high),
        positive("roller_damping_ratio", "", 0.05, 1.0, 1e-3, 1.0),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    k, (low, high) = _first(context, where), context.band
    swings = np.geomspace(max(3 * low, 0.08 * high), 0.8 * high, SWINGS).tolist()
    return [
        {"belt_stiffness": size * k, "belt_ratio": sign * ratio, "roller_frequency": own}
        for size, ratio, sign, own in product(SIZES, RATIOS, (1, -1), swings)
    ]


def _shape(assembly: Assembly, placement: Placement) -> None:
    assembly.add_coordinates([f"{placement.where} roller"])


def _act(assembly: Assembly, placement: Placement) -> None:
    one, other = placement.where.split("+")
    roller, belt = assembly.row(f"{placement.where} roller"), placement["belt_stiffness"]
    stretch = assembly.stretch_of(one) - placement["belt_ratio"] * assembly.stretch_of(other)
    tight, omega = placement["tightness"] * belt, 2 * np.pi * placement["roller_frequency"]
    inertia = (belt + tight) / omega**2
    assembly.add_spring(stretch - roller, belt)
    assembly.add_spring(roller, tight)
    assembly.add_damper(roller, 2 * placement["roller_damping_ratio"] * inertia * omega)
    assembly.add_inertia(roller, inertia)


def _extend(draft: Draft, placement: Placement) -> None:
    """What it is while it is slow."""
    one, other = placement.where.split("+")
    ratio, belt = placement["belt_ratio"], placement["belt_stiffness"]
    still = belt * placement["tightness"] / (1 + placement["tightness"])
    draft.couple(one, other, -ratio * still)
    draft.stiffen(one, still)
    draft.stiffen(other, ratio**2 * still)
    own = f"{placement['roller_frequency']:.3g} Hz"
    draft.notes.append(f"the files have the belt between {one} and {other} and lack its roller, {own}")


TENSIONED = Effect(
    name="joint_coupling",
    says="a mechanism couples two joints",
    places=pairs,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    extend=_extend,
)

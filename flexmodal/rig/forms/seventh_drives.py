"""Seventh forms of what drives joints: a stepping motor, gears of polymer, two joints controlled together."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from flexmodal.rig.effects.effect import (
    Effect,
    Parameters,
    Site,
    Stand,
    drawing,
    each,
    either_sign,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.joint_coupling import EFFECT as COUPLING
from flexmodal.rig.effects.servo_compliance import EFFECT as SERVO
from flexmodal.rig.effects.servo_compliance import free_rotor
from flexmodal.rig.forms.maxwell_rows import MOST, Series, middle
from flexmodal.rig.forms.structural_damping import BIOT, MOST_LOSS, acting
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import Branch, Feedback

DECADES = np.linspace(-5.0, 2.0, 22)
"""Relaxation times over τ, on a logarithmic scale, of which a stretched exponential is made up."""


def _draw_stepper(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A magnet as stiff as the loop of the rig's own, windings of 1 to 6 ms."""
    drawn = SERVO.draw(stand, where, random)
    return {
        "magnetic_stiffness": drawn["proportional_gain"],
        "back_emf": drawn["derivative_gain"],
        "winding_time": float(random.uniform(1e-3, 6e-3)),
        "rotor_inertia": drawn["rotor_inertia"],
    }


def _act_stepper(assembly: PlantAssembly, site: Site) -> None:
    """The rotor between the joint's spring and the field, k_m + c s/(1 + τ s) with τ = L/R of the winding.

    Speed induces a voltage, which drives a current through R and L in a row: a damper behind a spring c/τ.
    """
    motor, time = free_rotor(assembly, site, site["rotor_inertia"]), site["winding_time"]
    assembly.add_spring(motor, site["magnetic_stiffness"])
    assembly.branches.append(Branch(motor, site["back_emf"] / time, time))


def _scaled_stepper(parameters: Parameters, s: float) -> dict[str, float]:
    softer = {"magnetic_stiffness": 1 / s, "back_emf": s**-0.5}
    return {name: float(value * softer.get(name, 1.0)) for name, value in parameters.items()}


@lru_cache(maxsize=64)
def _stretched_parts(exponent: float) -> tuple[np.ndarray, np.ndarray]:
    """Parts and times over τ of the exponentials that exp(−(t/τ)^β) is made up of; the parts add up to 1."""
    from scipy.optimize import nnls

    ages, times = np.geomspace(1e-7, 1e3, 300), 10.0**DECADES
    left = np.exp(-(ages**exponent))
    parts, _ = nnls(np.exp(-ages[:, None] / times), left)
    kept = parts > 1e-9
    return parts[kept] / parts.sum(), times[kept]


def stretched(loss: float, frequency: float, exponent: float) -> Series:
    """Relaxation by a stretched exponential, the largest loss factor given; 1 at rest.

    Args:
        loss: the largest, as far as β allows: about tan(βπ/2) at most.
        frequency: 1/(2πτ) [Hz].
        exponent: β, between 0 and 1.
    """
    from scipy.optimize import brentq

    parts, times = _stretched_parts(exponent)
    slow = 1 / (2 * np.pi * frequency)
    omega = np.geomspace(1e-4, 1e6, 400) / slow

    def over(size: float) -> float:
        value = Series(1.0, size * parts, slow * times).modulus(omega)
        return float((value.imag / value.real).max()) - loss

    size = MOST if loss > 0 else 0.0
    if loss > 0 and over(MOST) > 0:
        size = float(brentq(over, 0.0, MOST))
    return Series(1.0, size * parts, slow * times)


def _draw_stretched(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """It relaxes, as slowly as τ, in the lower half of the band on a logarithmic scale or just below."""
    low, high = stand.plan.band
    drawn = drawing(loss_factor=(0.04, 0.12), viscous=(0.2, 1.0), exponent=(0.35, 0.7))(stand, where, random)
    return {**drawn, "frequency": float(np.exp(random.uniform(np.log(low / 2), np.log(low * high) / 2)))}


def _stretched(site: Site, joint: int) -> Series:
    made = stretched(site["loss_factor"], site["frequency"], site["exponent"])
    return made.scaled_at(middle(site.stand.plan.band))


def _draw_cross_coupled(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """The one joint answers a half or nearly all of what the other does; filters far above the band."""
    return {
        "coupling": either_sign(random, 0.2, 0.5),
        "answer": float(random.uniform(0.5, 0.9)),
        "filter_time": 1 / (2 * np.pi * float(random.uniform(3.0, 8.0)) * stand.plan.band[1]),
    }


def _act_cross_coupled(assembly: PlantAssembly, site: Site) -> None:
    """Each joint is pushed by c √(k_A k_B) times the other's angle through 1/(1 + T s), one of them less."""
    one, other = site.where.split("+")
    k, time = site.stand.true.stiffness, site["filter_time"]
    size = site["coupling"] * float(np.sqrt(k[one] * k[other]))
    a, b = np.array([[-1 / time]]), np.array([1 / time])
    for sensed, driven, part in ((one, other, 1.0), (other, one, site["answer"])):
        pushed = np.array([part * size])
        fed = Feedback(assembly.row(sensed), assembly.row(driven), a, b, np.zeros(1), pushed)
        assembly.feedbacks.append(fed)


STEPPER: Effect = replace(
    SERVO,
    form="stepper",
    says="a stepping motor that only its field holds: a magnetic spring, damped by the current that its own "
    "motion induces",
    source="Acarnley, Stepping Motors: A Guide to Theory and Practice, 4th ed., IEE 2002, chapters 3 and 4; "
    "rotor after Spong, as brake",
    units={
        "magnetic_stiffness": "N·m/rad, at the joint",
        "back_emf": "N·m·s/rad, at the joint, while slow",
        "winding_time": "s, inductance over resistance",
        "rotor_inertia": "kg·m², at the joint",
    },
    draw=_draw_stepper,
    scaled=_scaled_stepper,
    check=positive("magnetic_stiffness", "back_emf", "winding_time", "rotor_inertia"),
    act=_act_stepper,
)
STRETCHED: Effect = replace(
    BIOT,
    form="stretched",
    says="gears or belts of polymer, which relax by a stretched exponential: loss that falls slowly with "
    "frequency above its peak",
    source="Williams and Watts, Trans. Faraday Society 66 (1970) 80; Ferry, Viscoelastic Properties of "
    "Polymers, 3rd ed., Wiley 1980, chapter 3",
    units={
        "loss_factor": "the largest",
        "viscous": "part of the card's viscous damping that is there too",
        "exponent": "β",
        "frequency": "Hz, 1/(2πτ)",
    },
    draw=_draw_stretched,
    check=within(
        loss_factor=(0.0, MOST_LOSS), viscous=(0.0, np.inf), exponent=(0.2, 1.0), frequency=(1e-3, 1e6)
    ),
    act=acting(_stretched),
)
CROSS_COUPLED: Effect = replace(
    COUPLING,
    form="cross_coupled",
    says="two joints whose controller feeds the error of each into the other's drive, the one more than the "
    "other, through a filter",
    source="Koren, ASME J. Dynamic Systems, Measurement and Control 102 (1980) 265 (cross-coupled control)",
    units={
        "coupling": "torque on the second joint by the first, over √(k₁ k₂)",
        "answer": "the other way round, over that",
        "filter_time": "s",
    },
    draw=_draw_cross_coupled,
    scaled=multiplied("coupling"),
    check=each(within(coupling=(-0.9, 0.9), answer=(0.0, 1.0)), positive("filter_time")),
    act=_act_cross_coupled,
    active=True,
)

FORMS = (STEPPER, STRETCHED, CROSS_COUPLED)

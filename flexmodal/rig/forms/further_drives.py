"""Further forms of what drives joints: a belted motor, springs with mini-oscillators, a seat of two gears."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import (
    Effect,
    Parameters,
    Site,
    Stand,
    damping_time,
    divided,
    drawing,
    each,
    either_sign,
    positive,
    within,
)
from flexmodal.rig.effects.joint_coupling import EFFECT as COUPLING
from flexmodal.rig.effects.servo_compliance import EFFECT as SERVO
from flexmodal.rig.forms.joint_coupling import ROD
from flexmodal.rig.forms.maxwell_rows import middle
from flexmodal.rig.forms.structural_damping import ZENER
from flexmodal.rig.plant.assembly import PlantAssembly


def _draw_belted(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A belt about as stiff as the loop; the wheel it drives weighs a part of the rotor."""
    drawn = SERVO.draw(stand, where, random)
    return {
        **drawn,
        "belt_stiffness": float(random.uniform(1.0, 4.0)) * drawn["proportional_gain"],
        "belt_damping_time": damping_time(random),
        "wheel_inertia": float(random.uniform(0.1, 0.5)) * drawn["rotor_inertia"],
    }


def _act_belted(assembly: PlantAssembly, site: Site) -> None:
    """Link, joint spring, wheel, belt, rotor, loop: one behind the other, all seen at the joint."""
    joint = site.where
    k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
    assembly.add_coordinates([f"{joint} wheel", f"{joint} motor"])
    link, wheel, motor = assembly.stretch(joint), *map(assembly.row, (f"{joint} wheel", f"{joint} motor"))
    belt = site["belt_stiffness"]
    for row, spring, damper in (
        (link, -k, -b),
        (link - wheel, k, b),
        (wheel - motor, belt, site["belt_damping_time"] * belt),
        (motor, site["proportional_gain"], site["derivative_gain"]),
    ):
        assembly.add_spring(row, spring, damper)
    assembly.add_inertia(wheel, site["wheel_inertia"])
    assembly.add_inertia(motor, site["rotor_inertia"])
    assembly.elongation[joint] = link - wheel


def _scaled_belted(parameters: Parameters, s: float) -> dict[str, float]:
    softer = {"proportional_gain": 1 / s, "belt_stiffness": 1 / s, "derivative_gain": s**-0.5}
    return {name: float(value * softer.get(name, 1.0)) for name, value in parameters.items()}


def oscillators(
    loss: float, frequencies: np.ndarray, damping_ratio: float, band: tuple[float, float]
) -> tuple[float, float]:
    """Static spring, and spring of each oscillator, for a real part of 1 at the middle of the band.

    K = k + Σ a (s² + 2 ζ ω s)/(s² + 2 ζ ω s + ω²).

    Args:
        loss: the largest loss factor in the band.
        frequencies: ω of the oscillators [rad/s].
        damping_ratio: ζ.
        band: of the campaign [Hz].
    """
    from scipy.optimize import brentq

    def modulus(omega: np.ndarray, size: float) -> np.ndarray:
        inner = 2j * damping_ratio * frequencies * omega[:, None] - omega[:, None] ** 2
        return np.asarray(1 + size * np.sum(inner / (inner + frequencies**2), axis=1))

    def over(size: float) -> float:
        value = modulus(2 * np.pi * np.geomspace(*band, 60), size)
        return float((value.imag / value.real).max()) - loss

    size = float(brentq(over, 0.0, 1e3))
    whole = float(modulus(np.array([middle(band)]), size)[0].real)
    return 1 / whole, size / whole


def _draw_oscillators(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    low, high = stand.plan.band
    peak = float(np.exp(random.uniform(np.log(2 * low), np.log(0.3 * high))))
    drawn = drawing(loss_factor=(0.03, 0.12), viscous=(0.2, 1.0), apart=(2.0, 6.0), damping_ratio=(1.0, 3.0))
    return {**drawn(stand, where, random), "frequency": peak}


def _act_oscillators(assembly: PlantAssembly, site: Site) -> None:
    """Behind a spring a mass with a damper to the ground, twice beside each joint's own spring."""
    loss = site["damping_ratio"]
    omega = 2 * loss * 2 * np.pi * site["frequency"] * np.array([1.0, site["apart"]])
    static, part = oscillators(site["loss_factor"], omega, loss, site.stand.plan.band)
    for joint in site.stand.robot.joints:
        k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
        names = [f"{joint} oscillator {number}" for number in (1, 2)]
        assembly.add_coordinates(names)
        assembly.add_spring(assembly.stretch(joint), (static - 1) * k, (site["viscous"] - 1) * b)
        for name, own in zip(names, omega.tolist(), strict=True):
            inner = assembly.row(name)
            assembly.add_spring(assembly.stretch(joint) - inner, part * k)
            assembly.add_spring(inner, 0.0, 2 * loss * part * k / own)
            assembly.add_inertia(inner, part * k / own**2)


def _draw_seat(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A seat as stiff as the stiffer joint or stiffer, which swings near the band's end or beyond."""
    stiffness = float(random.uniform(1.0, 4.0)) * max(stand.true.stiffness[name] for name in where.split("+"))
    omega = 2 * np.pi * random.uniform(0.8, 2.5) * stand.plan.band[1]
    return {
        "seat_stiffness": stiffness,
        "ratio": either_sign(random, 0.3, 1.0),
        "inertia": float(stiffness / omega**2),
        "damping_time": damping_time(random),
    }


def _shape_seat(assembly: PlantAssembly, site: Site) -> None:
    """Both gears push against the same seat: the springs are stretched by q_A − ψ and q_B − r ψ."""
    assembly.add_coordinates([f"{site.where} seat"])
    seat = assembly.row(f"{site.where} seat")
    for joint, part in zip(site.where.split("+"), (1.0, site["ratio"]), strict=True):
        assembly.elongation[joint] = assembly.stretch(joint) - part * seat


def _act_seat(assembly: PlantAssembly, site: Site) -> None:
    seat, spring = assembly.row(f"{site.where} seat"), site["seat_stiffness"]
    assembly.add_spring(seat, spring, site["damping_time"] * spring)
    assembly.add_inertia(seat, site["inertia"])


BELTED: Effect = replace(
    SERVO,
    form="belted",
    says="the motor on its loop drives the joint over a toothed belt",
    source="Rivin, Mechanical Design of Robots, McGraw-Hill 1988, on compliance of transmissions",
    units={
        **SERVO.units,
        "belt_stiffness": "N·m/rad, at the joint",
        "belt_damping_time": "s",
        "wheel_inertia": "kg·m², of what the belt drives, at the joint",
    },
    draw=_draw_belted,
    scaled=_scaled_belted,
    check=each(SERVO.check, positive("belt_stiffness", "wheel_inertia")),
    act=_act_belted,
)
OSCILLATORS: Effect = replace(
    ZENER,
    form="oscillators",
    says="beside each spring two others with a damped mass behind them: mini-oscillators",
    source="Golla and Hughes, J. Applied Mechanics 52 (1985) 897; McTavish and Hughes, ASME J. Vibration and "
    "Acoustics 115 (1993) 103",
    units={
        "loss_factor": "the largest in the band",
        "viscous": ZENER.units["viscous"],
        "apart": "frequency of the second oscillator over that of the first",
        "damping_ratio": "of both",
        "frequency": "Hz, where the first one loses most",
    },
    draw=_draw_oscillators,
    check=each(
        within(loss_factor=(0.0, 0.6), viscous=(0.0, np.inf)), positive("apart", "damping_ratio", "frequency")
    ),
    act=_act_oscillators,
)
SEAT: Effect = replace(
    COUPLING,
    form="seat",
    says="the gears of two joints sit on one seat, which gives: each turns the other",
    source="Rivin, as belted, on what housings add to compliance; springs one behind the other",
    units={
        "seat_stiffness": "N·m/rad",
        "ratio": "of its turn that the second joint feels",
        "inertia": "kg·m²",
        "damping_time": "s",
    },
    places=ROD.places,
    place_is=ROD.place_is,
    draw=_draw_seat,
    scaled=divided("seat_stiffness"),
    most=lambda parameters: 30.0,
    check=each(positive("seat_stiffness", "inertia"), within(damping_time=(0.0, 0.1))),
    shape=_shape_seat,
    act=_act_seat,
    active=False,
)
FORMS = (BELTED, OSCILLATORS, SEAT)

"""Sixth forms of what drives joints: a motor on a torque arm, gears that warm up, a stiffness of the tool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import (
    Effect,
    Parameters,
    Site,
    Stand,
    drawing,
    each,
    multiplied,
    positive,
    standing,
    within,
)
from flexmodal.rig.effects.joint_coupling import EFFECT as COUPLING
from flexmodal.rig.effects.servo_compliance import EFFECT as SERVO
from flexmodal.rig.forms.maxwell_rows import MOST, Series, middle
from flexmodal.rig.forms.structural_damping import BIOT, MOST_LOSS
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import reach

TRIED = 6
"""Directions in which a tool may be held, of which the one that ties its joints most is taken."""
SPREAD = np.arange(-3, 4) * 0.8
"""Relaxation times of a bell of them, over its width, on a logarithmic scale."""


def _draw_torque_arm(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A bush about as stiff as the loop; the housing swings on it in the upper half of the band or beyond."""
    drawn = SERVO.draw(stand, where, random)
    bush = float(random.uniform(0.8, 3.0)) * drawn["proportional_gain"]
    omega = 2 * np.pi * float(random.uniform(0.5, 1.5)) * stand.plan.band[1]
    return {
        **drawn,
        "bush_stiffness": bush,
        "bush_loss": float(random.uniform(0.05, 0.15)),
        "housing_inertia": bush / omega**2,
    }


def _act_torque_arm(assembly: PlantAssembly, site: Site) -> None:
    """The shaft turns by the housing's angle and by what the rotor turns in it, on which the loop acts."""
    joint = site.where
    k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
    assembly.add_coordinates([f"{joint} motor", f"{joint} housing"])
    link, motor, housing = (
        assembly.stretch(joint),
        *map(assembly.row, (f"{joint} motor", f"{joint} housing")),
    )
    bush, inertia = site["bush_stiffness"], site["housing_inertia"]
    for row, spring, damper in (
        (link, -k, -b),
        (link - motor - housing, k, b),
        (motor, site["proportional_gain"], site["derivative_gain"]),
        (housing, bush, site["bush_loss"] * float(np.sqrt(bush * inertia))),
    ):
        assembly.add_spring(row, spring, damper)
    assembly.add_inertia(motor, site["rotor_inertia"])
    assembly.add_inertia(housing, inertia)
    assembly.elongation[joint] = link - motor - housing


def _scaled_torque_arm(parameters: Parameters, s: float) -> dict[str, float]:
    softer = {"proportional_gain": 1 / s, "bush_stiffness": 1 / s, "derivative_gain": s**-0.5}
    return {name: float(value * softer.get(name, 1.0)) for name, value in parameters.items()}


def bell(loss: float, frequency: float, width: float) -> Series:
    """Relaxation times spread as a bell over their logarithm, the largest loss factor given; 1 at rest.

    Args:
        loss: the largest.
        frequency: 1/(2πτ) at the middle of the bell [Hz].
        width: standard deviation of ln τ.
    """
    from scipy.optimize import brentq

    times = np.exp(width * SPREAD) / (2 * np.pi * frequency)
    weights = np.exp(-(SPREAD**2) / 2)
    weights = weights / weights.sum()
    omega = 2 * np.pi * frequency * np.geomspace(1e-4, 1e4, 400)

    def over(size: float) -> float:
        value = Series(1.0, size * weights, times).modulus(omega)
        return float((value.imag / value.real).max()) - loss

    size = float(brentq(over, 0.0, MOST)) if loss > 0 else 0.0
    return Series(1.0, size * weights, times)


def _draw_warming(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """It peaks in the band at first, and two to eight times as high in the end."""
    low, high = stand.plan.band
    drawn = drawing(loss_factor=(0.04, 0.12), viscous=(0.2, 1.0), width=(0.6, 1.4))(stand, where, random)
    return {
        **drawn,
        "frequency": float(np.exp(random.uniform(np.log(2 * low), np.log(0.3 * high)))),
        "warming": float(np.exp(random.uniform(np.log(2.0), np.log(8.0)))),
    }


def number_of(assembly: PlantAssembly, stand: Stand) -> int:
    """Which posture of the plan this is, or comes nearest to.

    Args:
        assembly: the plant in the making, in its posture.
        stand: with the plan.
    """
    asked = [stand.robot.at(dict(posture.q)).posture.values for posture in stand.plan.postures]
    here = assembly.posture.values
    off = [sum(abs(values[name] - here[name]) for name in here) for values in asked]
    return int(np.argmin(off))


def _act_warming(assembly: PlantAssembly, site: Site) -> None:
    """All relaxation times get shorter by one factor, a_T, from posture to posture; springs stay as they are.

    What they are is set in the first posture, at the middle of the band.
    """
    count = len(site.stand.plan.postures)
    cold = bell(site["loss_factor"], site["frequency"], site["width"])
    made = cold.scaled_at(middle(site.stand.plan.band))
    quicker = site["warming"] ** (number_of(assembly, site.stand) / max(count - 1, 1))
    for joint in site.stand.robot.joints:
        k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
        row = assembly.stretch(joint)
        assembly.add_spring(row, (made.static - 1) * k, (site["viscous"] - 1) * b)
        assembly.add_relaxation(row, made.strengths * k, made.times / quicker)


def tied(assembly: PlantAssembly, stand: Stand, where: str, way: np.ndarray) -> np.ndarray:
    """How far the tool moves along a direction by each of two joints [m].

    Args:
        assembly: the plant in the making, in its posture.
        stand: whose tool.
        where: both joints.
        way: unit vector in the world.
    """
    tool = stand.robot.tool
    moved = way @ assembly.motion(tool, reach(stand.robot, tool))[:3]
    return np.array([moved[assembly.coordinates.index(name)] for name in where.split("+")])


def _draw_tool_held(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Along the direction that ties both joints most, two fifths to all as stiff as they are there."""
    _, own = base_directions(stand.normal)
    plane = own[:3, : 2 if stand.normal is not None else 3]
    root = np.sqrt([stand.true.stiffness[name] for name in where.split("+")])
    everywhere = standing(stand)
    found: list[tuple[float, float, np.ndarray]] = []
    for _ in range(TRIED):
        way = plane @ random.standard_normal(plane.shape[1])
        way = way / np.linalg.norm(way)
        over = np.array([tied(assembly, stand, where, way) for assembly in everywhere]) / root
        largest = max(float(np.sum(over**2, axis=1).max()), 1e-12)
        found.append((float(np.abs(over[:, 0] * over[:, 1]).mean()) / largest, largest, way))
    _, largest, way = max(found, key=lambda one: one[0])
    return {
        "stiffness": float(random.uniform(0.4, 1.0)) / largest,
        "damping_time": float(random.uniform(2e-4, 2e-3)),
        **dict(zip(("dx", "dy", "dz"), map(float, way), strict=True)),
    }


def _act_tool_held(assembly: PlantAssembly, site: Site) -> None:
    """Jᵀ k J of both joints, J the tool's motion along one direction of the world by them."""
    way = site.vector("dx", "dy", "dz")
    parts = tied(assembly, site.stand, site.where, way / np.linalg.norm(way))
    row = sum(part * assembly.row(name) for part, name in zip(parts, site.where.split("+"), strict=True))
    assembly.add_spring(np.asarray(row), site["stiffness"], site["damping_time"] * site["stiffness"])


TORQUE_ARM: Effect = replace(
    SERVO,
    form="torque_arm",
    says="a gear motor that sits on the shaft and is held by a torque arm in a rubber bush: its housing "
    "swings too, and the loop sees the rotor against the housing",
    source="Rivin, Stiffness and Damping in Mechanical Design, Marcel Dekker 1999, on what housings add to "
    "drives; rotor after Spong, as brake",
    units={
        **SERVO.units,
        "bush_stiffness": "N·m/rad, about the joint",
        "bush_loss": "twice the damping ratio of the housing on it",
        "housing_inertia": "kg·m², about the joint",
    },
    draw=_draw_torque_arm,
    scaled=_scaled_torque_arm,
    check=each(SERVO.check, positive("bush_stiffness", "housing_inertia"), within(bush_loss=(0.0, 2.0))),
    act=_act_torque_arm,
)
WARMING: Effect = replace(
    BIOT,
    form="warming",
    says="gears and grease that warm up in the course of the test: a broad peak of loss that lies higher "
    "from posture to posture",
    source="Ferry, Viscoelastic Properties of Polymers, 3rd ed., Wiley 1980, chapter 11 (time and "
    "temperature); Nowick and Berry, Anelastic Relaxation in Crystalline Solids, Academic Press "
    "1972, chapter 4 (bells)",
    units={
        "loss_factor": "the largest", "viscous": "part of the card's viscous damping that is there too",
        "width": "standard deviation of ln τ", "frequency": "Hz, 1/(2πτ) in the first posture",
        "warming": "the same in the last posture over that",
    },
    draw=_draw_warming,
    check=within(
        loss_factor=(0.0, MOST_LOSS), viscous=(0.0, np.inf), width=(0.0, 5.0), frequency=(1e-3, 1e6),
        warming=(1e-3, 1e3),
    ),
    act=_act_warming,
)  # fmt: skip
TOOL_HELD: Effect = replace(
    COUPLING,
    form="tool_held",
    says="two joints whose controller holds the tool along one direction of the world: each answers to what "
    "the other does",
    source="Salisbury, Proc. 19th IEEE Conf. Decision and Control (1980) 95 (active stiffness, JᵀKJ)",
    units={
        "stiffness": "N/m, of the tool along the direction", "damping_time": "damping over stiffness, s",
        "dx": "", "dy": "", "dz": "direction in the world",
    },
    draw=_draw_tool_held,
    scaled=multiplied("stiffness"),
    most=lambda parameters: 30.0,
    check=each(positive("stiffness"), within(damping_time=(0.0, 0.1))),
    act=_act_tool_held,
    active=False,
)  # fmt: skip

FORMS = (TORQUE_ARM, WARMING, TOOL_HELD)

"""Fifth forms of what drives joints: an observer of disturbances, springs pressed by weight, a tensioner."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

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
from flexmodal.rig.effects.servo_compliance import EFFECT as SERVO
from flexmodal.rig.effects.servo_compliance import free_rotor
from flexmodal.rig.effects.structural_damping import EFFECT as DAMPING
from flexmodal.rig.effects.structural_damping import maxwell
from flexmodal.rig.forms.added_mass import GRAVITY
from flexmodal.rig.forms.joint_coupling import RATIO
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import Feedback


def _draw_observer(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """While it is slow, as the motor of the rig's own form; a filter that is quicker than that swings."""
    drawn = SERVO.draw(stand, where, random)
    stiffness = drawn["proportional_gain"] + stand.true.stiffness[where]
    return {
        **drawn,
        "trust": float(random.uniform(0.3, 0.7)),
        "filter_time": float(random.uniform(0.1, 0.45) * np.sqrt(drawn["rotor_inertia"] / stiffness)),
    }


def _act_observer(assembly: PlantAssembly, site: Site) -> None:
    """What disturbs is told from J s² q and the torque, both through Q = g/(1 + T s), and taken off.

    (C + Q J s²)/(1 − Q) with C a spring and a damper: ((K + D s)(1 + (1 − g) τ s) + g J s²)/(1 + τ s), where
    K, D, J are what it seems while slow and τ = T/(1 − g).
    """
    trust, time = site["trust"], site["filter_time"]
    motor = free_rotor(assembly, site, (1 - trust) * site["rotor_inertia"])
    spring, damper, ahead = site["proportional_gain"], site["derivative_gain"], (1 - trust) * time
    rate = (damper * ahead + trust * site["rotor_inertia"]) / time
    angle = (damper + spring * ahead - rate) / time
    a, by_angle = np.array([[-1 / time]]), np.array([1 / time])
    fed = Feedback(motor, motor, a, by_angle, np.zeros(1), np.array([spring - angle]), angle, rate)
    assembly.feedbacks.append(fed)


def _scaled_observer(parameters: Parameters, s: float) -> dict[str, float]:
    """As other loops: gains are divided, and a stiffer loop takes its filter along."""
    factors = {"proportional_gain": 1 / s, "derivative_gain": s**-0.5, "filter_time": min(s, 1.0) ** 0.5}
    return {name: float(value * factors.get(name, 1.0)) for name, value in parameters.items()}


def weights(assembly: PlantAssembly, stand: Stand) -> dict[str, float]:
    """Torque, or force, that each joint holds against the weight of the robot [N·m, N].

    Args:
        assembly: the plant in the making, in its posture.
        stand: with the bodies.
    """
    raised = sum(
        GRAVITY * body.mass * assembly.motion(link, body.com)[2] for link, body in stand.true.bodies.items()
    )
    return {name: float(assembly.row(name) @ raised) for name in stand.robot.joints}


def _draw_pressed(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A half of the loss is gone at a part of the largest torque that a weight puts on a joint."""
    largest = max(abs(torque) for one in standing(stand) for torque in weights(one, stand).values())
    drawn = drawing(loss_factor=(0.06, 0.2), viscous=(0.2, 1.0))(stand, where, random)
    return {**drawn, "load": float(random.uniform(0.1, 0.6)) * max(largest, 1.0)}


def _act_pressed(assembly: PlantAssembly, site: Site) -> None:
    """A loss factor η/(1 + |τ|/τ₀) in each joint, τ what it carries of the weight."""
    carried = weights(assembly, site.stand)
    for joint in site.stand.robot.joints:
        loss = site["loss_factor"] / (1 + abs(carried[joint]) / site["load"])
        static, strengths, times = maxwell(loss, site.stand.plan.band)
        k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
        row = assembly.stretch(joint)
        assembly.add_spring(row, (static - 1) * k, (site["viscous"] - 1) * b)
        assembly.add_relaxation(row, strengths * k, times)


def _draw_tensioner(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A roller that swings within the band where both joints are held."""
    drawn, (low, high) = RATIO.draw(stand, where, random), stand.plan.band
    return {
        "stiffness": 1.5 * drawn["stiffness"],
        "ratio": drawn["ratio"],
        "tightness": float(np.exp(random.uniform(np.log(0.5), np.log(2.0)))),
        "frequency": float(np.exp(random.uniform(np.log(max(4 * low, 0.1 * high)), np.log(0.7 * high)))),
        "damping_ratio": float(random.uniform(0.03, 0.15)),
    }


def _act_tensioner(assembly: PlantAssembly, site: Site) -> None:
    """1/(1/k + 1/(k_t + c s + m s²)) along q_A − r q_B: the belt, and how far its roller gives."""
    one, other = site.where.split("+")
    name = f"{site.where} roller"
    assembly.add_coordinates([name])
    roller, belt, omega = assembly.row(name), site["stiffness"], 2 * np.pi * site["frequency"]
    tight = site["tightness"] * belt
    inertia = (belt + tight) / omega**2
    assembly.add_spring(assembly.row(one) - site["ratio"] * assembly.row(other) - roller, belt)
    assembly.add_spring(roller, tight, 2 * site["damping_ratio"] * inertia * omega)
    assembly.add_inertia(roller, inertia)


OBSERVER: Effect = replace(
    SERVO,
    form="observer",
    says="the motor on a loop with an observer, which takes off what disturbs it: stiff while it is slow, "
    "soft beyond",
    source="Ohnishi, Shibata and Murakami, IEEE/ASME Trans. Mechatronics 1 (1996) 56 (disturbance observers)",
    units={
        "proportional_gain": "N·m/rad, as it seems while slow",
        "derivative_gain": "N·m·s/rad, likewise",
        "rotor_inertia": "kg·m², likewise",
        "trust": "g, of the disturbance, how much is taken off",
        "filter_time": "s, of the observer, over 1 − g",
    },
    draw=_draw_observer,
    scaled=_scaled_observer,
    check=each(SERVO.check, positive("filter_time"), within(trust=(0.0, 0.95))),
    act=_act_observer,
)
PRESSED: Effect = replace(
    DAMPING,
    form="pressed",
    says="hysteretic loss in the joints, the less of it the more weight a joint carries",
    source="Beards, Shock and Vibration Digest 24 (1992) no. 7, 3 (damping in structural joints); Ungar, "
    "J. Sound and Vibration 26 (1973) 141 (built-up structures)",
    units={
        "loss_factor": "of a joint that carries nothing",
        "viscous": DAMPING.units["viscous"],
        "load": "N·m or N, at which a half of it is gone",
    },
    draw=_draw_pressed,
    check=each(within(loss_factor=(0.0, 0.6), viscous=(0.0, np.inf)), positive("load")),
    act=_act_pressed,
)
TENSIONER: Effect = replace(
    RATIO,
    form="tensioner",
    says="a belt from joint to joint over a roller on a spring, which keeps it tight and swings",
    source="Beikmann, Perkins and Ulsoy, ASME J. Vibration and Acoustics 118 (1996) 406 (belt drives with a "
    "tensioner); the ratio of Tsai",
    units={
        **RATIO.units,
        "tightness": "stiffness of the roller's spring over the belt's",
        "frequency": "Hz, of the roller where both joints are held",
        "damping_ratio": "likewise",
    },
    draw=_draw_tensioner,
    scaled=multiplied("stiffness"),
    check=each(positive("stiffness", "tightness", "frequency"), within(damping_ratio=(0.0, 1.0))),
    act=_act_tensioner,
    active=False,
)

FORMS = (OBSERVER, PRESSED, TENSIONER)

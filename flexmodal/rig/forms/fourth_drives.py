"""Fourth forms of what drives joints: two motors on one gear, a lopsided peak of loss, a balancing spring."""

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
from flexmodal.rig.effects.joint_coupling import EFFECT as COUPLING
from flexmodal.rig.effects.servo_compliance import EFFECT as SERVO
from flexmodal.rig.forms.joint_coupling import ROD
from flexmodal.rig.forms.maxwell_rows import MOST, Series, fitted
from flexmodal.rig.forms.structural_damping import BIOT, acting
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import reach
from flexmodal.rig.plant.geometry import across, turn

TRIED = 6
"""Ways to hang a balancing spring, of which the one that ties its joints most is taken."""


def _draw_two_motors(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Together as stiff and as heavy as the motor of the rig's own form; not alike."""
    return drawing(SERVO.draw, second=(0.3, 0.8), share=(0.3, 0.7))(stand, where, random)


def _act_two_motors(assembly: PlantAssembly, site: Site) -> None:
    """A part of the joint's spring goes to each of two rotors: Σ 1/(1/(pᵢ k) + 1/(Kᵢ + Dᵢ s + Jᵢ s²))."""
    joint, share, second = site.where, site["share"], site["second"]
    k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
    names = [f"{joint} motor {number}" for number in (1, 2)]
    assembly.add_coordinates(names)
    link = assembly.stretch(joint)
    assembly.add_spring(link, -k, -b)
    for name, part, loop in zip(
        names, (share, 1 - share), (1 / (1 + second), second / (1 + second)), strict=True
    ):
        motor = assembly.row(name)
        assembly.add_spring(link - motor, part * k, part * b)
        assembly.add_spring(motor, loop * site["proportional_gain"], site["derivative_gain"] / 2)
        assembly.add_inertia(motor, site["rotor_inertia"] / 2)
    one, other = map(assembly.row, names)
    assembly.elongation[joint] = link - share * one - (1 - share) * other


def _scaled_two_motors(parameters: Parameters, s: float) -> dict[str, float]:
    softer = {"proportional_gain": 1 / s, "derivative_gain": s**-0.5}
    return {name: float(value * softer.get(name, 1.0)) for name, value in parameters.items()}


def lopsided(loss: float, frequency: float, below: float, above: float, band: tuple[float, float]) -> Series:
    """Havriliak's and Negami's relaxation, 1 + g (1 − (1 + (iωτ)^α)^−β): a peak of loss that leans.

    The loss rises as ω^α below the peak and falls as ω^−αβ above it.

    Args:
        loss: the largest in the band.
        frequency: 1/(2πτ) [Hz].
        below: α, between 0 and 1.
        above: β, likewise.
        band: of the campaign [Hz].
    """
    from scipy.optimize import brentq

    def lost(omega: np.ndarray, size: float) -> np.ndarray:
        turned = (1j * omega / (2 * np.pi * frequency)) ** below
        value = 1 + size * (1 - (1 + turned) ** -above)
        return np.asarray(value.imag / value.real)

    every = 2 * np.pi * np.geomspace(*band, 60)
    size = MOST
    if lost(every, MOST).max() > loss:
        size = float(brentq(lambda size: lost(every, size).max() - loss, 0.0, MOST))
    return fitted(lambda omega: lost(omega, size), band, 11, 6.0)


def _draw_lopsided(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """It peaks somewhere within the band."""
    low, high = stand.plan.band
    frequency = float(np.exp(random.uniform(np.log(3 * low), np.log(0.5 * high))))
    drawn = drawing(loss_factor=(0.03, 0.12), viscous=(0.2, 1.0), below=(0.6, 0.95), above=(0.2, 0.6))
    return {**drawn(stand, where, random), "frequency": frequency}


def _lopsided(site: Site, joint: int) -> Series:
    band = site.stand.plan.band
    return lopsided(site["loss_factor"], site["frequency"], site["below"], site["above"], band)


def curvature(assembly: PlantAssembly, where: str, parameters: Parameters) -> np.ndarray:
    """Second derivatives of |d|²/2 by the angles of two joints, d from the hook before to the one after [m²].

    With p the far hook, r from a joint to it and a the joint's axis: (a × r)·(b × r') + d·(a × (b × r')).

    Args:
        assembly: the plant in the making.
        where: both joints, the inner one first.
        parameters: cranks to both hooks [m], and the angles at which they stand [rad].
    """
    urdf = assembly.robot.urdf
    joints = [urdf.joint_by_name[name] for name in where.split("+")]
    hooks, axes, pivots = [], [], []
    for joint, link, end in zip(joints, (joints[0].parent, joints[1].child), ("near", "far"), strict=True):
        mount = assembly.orientation(link)
        axis = assembly.orientation(joint.child) @ joint.axis / np.linalg.norm(joint.axis)
        local = mount.T @ axis
        stands = turn(local, parameters[f"{end}_angle"]) @ across(local, None)[0]
        pivots.append(assembly.origin(joint.child))
        axes.append(axis)
        hooks.append(pivots[-1] + parameters[f"{end}_crank"] * mount @ stands)
    apart = hooks[1] - hooks[0]
    moved = [np.cross(axis, hooks[1] - pivot) for axis, pivot in zip(axes, pivots, strict=True)]
    found = np.zeros((2, 2))
    for one, other in ((0, 0), (0, 1), (1, 1)):
        value = moved[one] @ moved[other] + apart @ np.cross(axes[one], moved[other])
        found[one, other] = found[other, one] = value
    return found


def _draw_balancer(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Hooks about as far from their joints as these are apart; a fifth to two fifths of the joints' own."""
    names = where.split("+")
    first = stand.robot.urdf.joint_by_name[names[0]]
    between = max(float(np.linalg.norm(reach(stand.robot, first.child))), 0.1)
    root = np.sqrt([stand.true.stiffness[name] for name in names])
    everywhere = standing(stand)
    found: list[tuple[float, float, dict[str, float]]] = []
    for _ in range(TRIED):
        drawn = {
            "near_crank": float(random.uniform(0.5, 1.0)) * between,
            "far_crank": float(random.uniform(0.5, 1.0)) * between,
            "near_angle": float(random.uniform(0.0, 2 * np.pi)),
            "far_angle": float(random.uniform(0.0, 2 * np.pi)),
        }
        bent = np.array([curvature(assembly, where, drawn) for assembly in everywhere]) / np.outer(root, root)
        largest = float(np.abs(np.linalg.eigvalsh(bent)).max())
        found.append((float(np.abs(bent[:, 0, 1]).mean()) / largest, largest, drawn))
    _, largest, drawn = max(found, key=lambda one: one[0])
    return {"stiffness": float(random.uniform(0.2, 0.4)) / largest, **drawn}


def _act_balancer(assembly: PlantAssembly, site: Site) -> None:
    """A spring of no free length between both hooks: k times the curvature, beside the joints' springs."""
    own = np.array([assembly.row(name) for name in site.where.split("+")])
    values, vectors = np.linalg.eigh(site["stiffness"] * curvature(assembly, site.where, site.parameters))
    for value, row in zip(values.tolist(), vectors.T @ own, strict=True):
        assembly.add_spring(row, value)


TWO_MOTORS: Effect = replace(
    SERVO,
    form="two_motors",
    says="two motors drive the joint together, each over a gear and on a loop of its own",
    source="Gawronski, Modeling and Control of Antennas and Telescopes, Springer 2008 (axes with two "
    "drives); each rotor after Spong, as brake",
    units={
        "proportional_gain": "N·m/rad, of both loops together",
        "derivative_gain": "N·m·s/rad, likewise",
        "rotor_inertia": "kg·m², of both",
        "second": "proportional gain of the second loop over that of the first",
        "share": "of the joint's spring, what goes to the first",
    },
    draw=_draw_two_motors,
    scaled=_scaled_two_motors,
    check=each(SERVO.check, positive("second"), within(share=(0.05, 0.95))),
    act=_act_two_motors,
)
LOPSIDED: Effect = replace(
    BIOT,
    form="lopsided",
    says="a peak of loss that leans: it rises with frequency more steeply than it falls",
    source="Havriliak and Negami, Polymer 8 (1967) 161; Hartmann, Lee and Lee, J. Acoustical Society of "
    "America 95 (1994) 226",
    units={
        "loss_factor": "the largest in the band",
        "viscous": BIOT.units["viscous"],
        "below": "α, by which it rises",
        "above": "β: it falls by αβ",
        "frequency": "Hz, 1/(2πτ)",
    },
    draw=_draw_lopsided,
    check=within(
        loss_factor=(0.0, 0.6), viscous=(0.0, np.inf), below=(0.05, 1.0), above=(0.05, 1.0),
        frequency=(1e-3, 1e6),
    ),
    act=acting(_lopsided),
)  # fmt: skip
BALANCER: Effect = replace(
    COUPLING,
    form="balancer",
    says="a taut balancing spring from before the first joint to after the second: its pull turns with both",
    source="Herder, Energy-free Systems, thesis, Delft 2001 (springs of no free length); Arakelian and "
    "Briot, Balancing of Linkages and Robot Manipulators, Springer 2015",
    units={
        "stiffness": "N/m", "near_crank": "m, from the first joint to its hook",
        "far_crank": "m, from the second joint to its hook", "near_angle": "rad, about the first joint",
        "far_angle": "rad, about the second",
    },
    places=ROD.places,
    place_is=ROD.place_is,
    draw=_draw_balancer,
    scaled=multiplied("stiffness"),
    most=lambda parameters: 2.0,
    check=positive("stiffness", "near_crank", "far_crank"),
    act=_act_balancer,
)  # fmt: skip

FORMS = (TWO_MOTORS, LOPSIDED, BALANCER)

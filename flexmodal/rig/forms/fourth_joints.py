"""Fourth forms of what sits in joints: a clamped hub that slips, a flange that gapes, a slotted shaft."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.bearing_flexibility import EFFECT as BEARING
from flexmodal.rig.effects.bearing_flexibility import draw_springs, rows
from flexmodal.rig.effects.coulomb_friction import EFFECT as FRICTION_EFFECT
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, each, multiplied, positive, within
from flexmodal.rig.effects.nonlinear_stiffness import EFFECT as SPRING
from flexmodal.rig.forms.behind import behind, draw_hub, hold
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import FRICTION, SATURATING, NonlinearElement

SLIPPED = 4.0
"""Largest compliance of a hub that slips over that of its joint."""
CLOSED = 1.0
"""Likewise, of a flange that is closed."""


def _draw_clamped(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A clamp that a weak blow makes slip here and there, and a hard one throughout."""
    weak = stand.true.stiffness[where] * stand.deflection[where][0]
    return {
        "torque": float(random.uniform(0.1, 0.4) * weak),
        "softer": float(random.uniform(0.4, 1.2)),
        "sticking": float(random.uniform(2.0, 5.0)),
        **draw_hub(stand, random),
    }


def _act_clamped(assembly: PlantAssembly, site: Site) -> None:
    """Behind the joint's spring k: k₂ θ and Dahl's friction; it slips from 1/k + 1/(k₂ + σ) to 1/k + 1/k₂."""
    own = site.stand.true.stiffness[site.where] / site["softer"]
    sticking = site["sticking"] * own
    hub = assembly.row(f"{site.where} hub")
    hold(assembly, site, hub, own, own + sticking)
    assembly.elements.append(NonlinearElement(hub, FRICTION, (site["torque"], sticking, 0.0)))


def _draw_gaping(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Bolts whose preload a hard blow overcomes and a weak one does not, or hardly."""
    hard = stand.true.stiffness[where] * stand.deflection[where][1]
    return {
        "torque": float(random.uniform(0.15, 0.5) * hard),
        "softer": float(random.uniform(0.15, 0.4)),
        "bolts": float(random.uniform(0.15, 0.35)),
        **draw_hub(stand, random),
    }


def _act_gaping(assembly: PlantAssembly, site: Site) -> None:
    """Behind the joint's spring: b k₂ θ + (1 − b) k₂ θ₀ tanh(θ/θ₀), from k₂ while it is closed to b k₂."""
    closed = site.stand.true.stiffness[site.where] / site["softer"]
    opens, faces = site["torque"] / closed, (1 - site["bolts"]) * closed
    flange = assembly.row(f"{site.where} flange")
    hold(assembly, site, flange, site["bolts"] * closed, closed)
    assembly.elements.append(NonlinearElement(flange, SATURATING, (faces * opens, opens, 0.0)))


def _draw_slotted(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A stub whose end tilts under a moment as the rig's own bearing does."""
    drawn, length = draw_springs(stand, where, random), float(random.uniform(0.05, 0.15))
    return {
        "bending_stiffness": drawn["tilt_stiffness"] * length,
        "length": length,
        "ratio": float(random.uniform(0.15, 0.5)),
        "phase": float(random.uniform(0.0, 2 * np.pi)),
        "axial_stiffness": drawn["axial_stiffness"],
        "damping_time": drawn["damping_time"],
    }


def _act_slotted(assembly: PlantAssembly, site: Site) -> None:
    """The end of a clamped stub whose two rigidities turn with the joint.

    3 E I/l³ u² + 4 E I/l (φ − 3 u/(2 l))² each way; a chain in a plane puts no moment on it.
    """
    x, y, z, rx, ry = rows(assembly, site)
    length, angle = site["length"], site["phase"] + assembly.posture.values[site.where]
    cos, sin = np.cos(angle), np.sin(angle)
    held = [(z, site["axial_stiffness"])]
    for shift, slope, part in (
        (cos * x + sin * y, cos * ry - sin * rx, 1.0),
        (cos * y - sin * x, -sin * ry - cos * rx, site["ratio"]),
    ):
        rigidity = part * site["bending_stiffness"]
        held.append((shift, 3 * rigidity / length**3))
        if assembly.normal is None:
            held.append((slope - 1.5 / length * shift, 4 * rigidity / length))
    for row, spring in held:
        assembly.add_spring(row, spring, site["damping_time"] * spring)


CLAMPED: Effect = replace(
    FRICTION_EFFECT,
    form="clamped",
    says="a hub that is clamped on behind the joint's spring and slips there: friction behind it, not beside",
    source="Gaul and Nitsche, Applied Mechanics Reviews 54 (2001) 93 (friction in mechanical joints); Dahl's "
    "law, as the rig's own",
    units={
        "torque": "N·m, at which it slips",
        "softer": "compliance of the hub where it slips, over the joint's",
        "sticking": "stiffness of what sticks over that of what stays",
        "frequency": "Hz, of the hub where it sticks",
        "damping_time": "damping over stiffness of what stays, s",
    },
    draw=_draw_clamped,
    scaled=multiplied("softer"),
    most=lambda parameters: SLIPPED / max(parameters["softer"], 1e-9),
    check=each(
        positive("torque", "softer", "sticking", "frequency"),
        within(softer=(0.0, SLIPPED + 1e-9), damping_time=(0.0, 0.1)),
    ),
    shape=behind("hub"),
    act=_act_clamped,
)
GAPING: Effect = replace(
    SPRING,
    form="gaping",
    says="a bolted flange behind the joint's spring, which gapes under a hard blow: then only bolts hold",
    source="Bickford, An Introduction to the Design and Behavior of Bolted Joints, 3rd ed., Marcel Dekker "
    "1995, on loads beyond the preload; springs one behind the other",
    units={
        "torque": "N·m, about which it gapes",
        "softer": "compliance of the closed flange over the joint's",
        "bolts": "stiffness of the bolts over that of the closed flange",
        "frequency": "Hz, of the flange while it is closed",
        "damping_time": "damping over stiffness of the bolts, s",
    },
    draw=_draw_gaping,
    scaled=multiplied("softer"),
    most=lambda parameters: CLOSED / max(parameters["softer"], 1e-9),
    check=each(
        positive("torque", "softer", "frequency"),
        within(softer=(0.0, CLOSED + 1e-9), bolts=(0.05, 1.0), damping_time=(0.0, 0.1)),
    ),
    shape=behind("flange"),
    act=_act_gaping,
)
SLOTTED: Effect = replace(
    BEARING,
    form="slotted",
    says="a joint at the end of a stub shaft with a slot for cables: it bends, more easily one way, which "
    "turns with the joint",
    source="Dimentberg, Flexural Vibrations of Rotating Shafts, Butterworths 1961 (shafts of unequal "
    "rigidities); Przemieniecki, Theory of Matrix Structural Analysis, McGraw-Hill 1968, section 5.6",
    units={
        "bending_stiffness": "N·m², the stiff way", "length": "m, of the stub",
        "ratio": "of the other way's over that", "phase": "rad, of the stiff way where the joint is at 0",
        "axial_stiffness": "N/m", "damping_time": "damping over stiffness, s",
    },
    draw=_draw_slotted,
    scaled=divided("bending_stiffness", "axial_stiffness"),
    check=each(BEARING.check, positive("bending_stiffness", "length"), within(ratio=(0.01, 1.0))),
    act=_act_slotted,
)  # fmt: skip

FORMS = (CLAMPED, GAPING, SLOTTED)

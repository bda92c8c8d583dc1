"""Other laws of dry friction: by the speed, by bristles, by sliders in parallel, by a hysteresis equation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.coulomb_friction import EFFECT as OWN
from flexmodal.rig.effects.effect import (
    Check,
    Effect,
    Site,
    Stand,
    each,
    either_sign,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import BOUC_WEN, LOADED, LUGRE, SLIDER, STRIBECK, NonlinearElement

SLIDERS = 6
"""Of Iwan's model."""
MOST_OF_LOAD = 0.6
"""Friction of a gear over what it carries."""


def _torque(stand: Stand, where: str, random: np.random.Generator) -> float:
    """3 to 15 % of the spring's peak torque under the weakest blow."""
    return float(random.uniform(0.03, 0.15) * stand.true.stiffness[where] * stand.deflection[where][0])


def _speed(stand: Stand, where: str) -> float:
    """Of the order of the joint's peak under the weakest blow, were it to swing mid-band [rad/s]."""
    low, high = stand.plan.band
    return float(stand.deflection[where][0] * 2 * np.pi * np.sqrt(low * high))


def _element(assembly: PlantAssembly, site: Site, kind: int, *numbers: float) -> None:
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), kind, numbers))


def _draw_smooth(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {
        "torque": _torque(stand, where, random),
        "speed": float(random.uniform(0.05, 0.2) * _speed(stand, where)),
    }


def _act_smooth(assembly: PlantAssembly, site: Site) -> None:
    _element(assembly, site, STRIBECK, site["torque"], site["torque"], 1.0, site["speed"])


def _draw_stribeck(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = _draw_smooth(stand, where, random)
    return {
        **drawn,
        "breakaway": float(random.uniform(1.2, 1.8)),
        "stribeck_speed": float(random.uniform(3.0, 10.0) * drawn["speed"]),
    }


def _act_stribeck(assembly: PlantAssembly, site: Site) -> None:
    torque = site["torque"]
    numbers = (torque, torque * site["breakaway"], site["stribeck_speed"], site["speed"])
    _element(assembly, site, STRIBECK, *numbers)


def _draw_lugre(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Bristles four to ten times as stiff as the joint, damped over some milliseconds."""
    stiffness = random.uniform(4.0, 10.0) * stand.true.stiffness[where]
    return {
        "torque": _torque(stand, where, random),
        "bristle_stiffness": float(stiffness),
        "bristle_damping": float(random.uniform(0.2e-3, 1.0e-3) * stiffness),
        "breakaway": float(random.uniform(1.1, 1.5)),
        "stribeck_speed": float(random.uniform(0.2, 0.8) * _speed(stand, where)),
    }


def _act_lugre(assembly: PlantAssembly, site: Site) -> None:
    """With a damper of σ₂ = σ₁ (F_s − F_c)/F_c beside it, from which on the model is passive."""
    torque, most = site["torque"], site["torque"] * site["breakaway"]
    damping = site["bristle_damping"]
    assembly.add_spring(assembly.stretch(site.where), 0.0, damping * (site["breakaway"] - 1))
    _element(assembly, site, LUGRE, site["bristle_stiffness"], damping, torque, most, site["stribeck_speed"])


def _draw_presliding(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {
        "torque": _torque(stand, where, random),
        "presliding_stiffness": float(random.uniform(3.0, 8.0) * stand.true.stiffness[where]),
    }


def _act_iwan(assembly: PlantAssembly, site: Site) -> None:
    """Sliders alike in stiffness, their limits spread evenly from 0 to twice the mean."""
    stiffness = site["presliding_stiffness"] / SLIDERS
    for number in range(SLIDERS):
        _element(assembly, site, SLIDER, stiffness, site["torque"] * (2 * number + 1) / SLIDERS**2)


def _draw_segalman(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {**_draw_presliding(stand, where, random), "exponent": float(random.uniform(-0.7, -0.2))}


def _act_segalman(assembly: PlantAssembly, site: Site) -> None:
    """Sliders alike in stiffness whose limits φ come as often as φ^χ: many slip early, few late."""
    parts = ((np.arange(SLIDERS) + 0.5) / SLIDERS) ** (1 / (1 + site["exponent"]))
    for part in parts / parts.sum():
        stiffness = site["presliding_stiffness"] / SLIDERS
        _element(assembly, site, SLIDER, stiffness, site["torque"] * float(part))


def _draw_seal(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    smooth, sticking = _draw_smooth(stand, where, random), _draw_presliding(stand, where, random)
    return {**sticking, "speed": smooth["speed"], "share": float(random.uniform(0.3, 0.7))}


def _act_seal(assembly: PlantAssembly, site: Site) -> None:
    """A part of the torque goes with the speed, as of a wet seal; the rest sticks before it slides."""
    wet = site["share"] * site["torque"]
    _element(assembly, site, STRIBECK, wet, wet, 1.0, site["speed"])
    _element(assembly, site, SLIDER, site["presliding_stiffness"], site["torque"] - wet)


def _draw_loaded(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A mesh that loses 3 to 12 % of what it carries, the weight of the arm among it."""
    drawn = _draw_presliding(stand, where, random)
    return {
        **drawn,
        "torque": float(random.uniform(0.2, 0.6) * drawn["torque"]),
        "growing": float(random.uniform(0.03, 0.12)),
        "weight": either_sign(random, 0.2, 1.0) * float(stand.deflection[where][0]),
    }


def _act_loaded(assembly: PlantAssembly, site: Site) -> None:
    """It slips at F + μ |k (u + u₀)|, u₀ what gravity winds the joint up by."""
    growing = site["growing"] * site.stand.true.stiffness[site.where]
    _element(assembly, site, LOADED, site["presliding_stiffness"], site["torque"], growing, site["weight"])


def _act_bouc_wen(assembly: PlantAssembly, site: Site) -> None:
    _element(assembly, site, BOUC_WEN, site["presliding_stiffness"], site["torque"])


def _check_breakaway(*names: str) -> Check:
    return each(within(breakaway=(1.0, 3.0)), positive(*names))


_TORQUE = {"torque": "N·m, sliding"}
_BREAKAWAY = {
    "breakaway": "torque at rest over the sliding one",
    "stribeck_speed": "rad/s, over which it falls to the sliding one",
}
_STIFF = {"presliding_stiffness": "N·m/rad"}

TANH: Effect = replace(
    OWN,
    form="tanh",
    says="Coulomb's friction, a hyperbolic tangent of the speed",
    source="Andersson, Söderberg and Björklund, Tribology International 40 (2007) 580",
    units={**_TORQUE, "speed": "rad/s, where three quarters are reached"},
    draw=_draw_smooth,
    scaled=multiplied("torque"),
    check=positive("torque", "speed"),
    act=_act_smooth,
)
STRIBECK_CURVE: Effect = replace(
    TANH,
    form="stribeck",
    says="more friction at rest than when it slides",
    source="Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083",
    units={**TANH.units, **_BREAKAWAY},
    draw=_draw_stribeck,
    check=_check_breakaway("torque", "speed", "stribeck_speed"),
    act=_act_stribeck,
)
LUGRE_MODEL: Effect = replace(
    OWN,
    form="lugre",
    says="bristles that bend before they slip",
    source="Canudas de Wit, Olsson, Åström and Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419; "
    "passive: Barahanov and Ortega, IEEE Trans. Autom. Control 45 (2000) 830",
    units={
        **_TORQUE, "bristle_stiffness": "N·m/rad", "bristle_damping": "N·m·s/rad", **_BREAKAWAY,
    },
    draw=_draw_lugre,
    scaled=multiplied("torque", "bristle_damping"),
    check=_check_breakaway("torque", "bristle_stiffness", "bristle_damping", "stribeck_speed"),
    act=_act_lugre,
)  # fmt: skip
IWAN: Effect = replace(
    OWN,
    form="iwan",
    says="springs that slip one after the other, as Masing's",
    source="Iwan, Journal of Applied Mechanics 33 (1966) 893",
    units={**_TORQUE, **_STIFF},
    draw=_draw_presliding,
    scaled=multiplied("torque"),
    check=positive("torque", "presliding_stiffness"),
    act=_act_iwan,
)
BOUC_WEN_MODEL: Effect = replace(
    IWAN,
    form="bouc_wen",
    says="a smooth hysteresis loop with straight ways back",
    source="Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249, with n = 2 and β = γ",
    act=_act_bouc_wen,
)

SEGALMAN: Effect = replace(
    IWAN,
    form="segalman",
    says="springs that slip one after the other, most of them early",
    source="Segalman, Journal of Applied Mechanics 72 (2005) 752, without what slips last at once",
    units={**IWAN.units, "exponent": "χ, of how often a limit comes"},
    draw=_draw_segalman,
    check=each(within(exponent=(-0.95, 0.0)), positive("torque", "presliding_stiffness")),
    act=_act_segalman,
)
SEAL: Effect = replace(
    IWAN,
    form="seal",
    says="a wet seal beside a dry gear: a hyperbolic tangent of the speed and a spring that slips",
    source="Andersson, as tanh; Dahl, Aerospace Corp. TOR-0158 (1968), for the part that sticks",
    units={**IWAN.units, "speed": "rad/s, of the seal", "share": "of the torque, the seal's"},
    draw=_draw_seal,
    check=each(within(share=(0.0, 1.0)), positive("torque", "presliding_stiffness", "speed")),
    act=_act_seal,
)
LOADED_MESH: Effect = replace(
    IWAN,
    form="loaded",
    says="a gear whose friction grows with the torque that it carries",
    source="Hamon, Gautier and Garrec, Proc. IEEE/RSJ IROS 2010, on friction that depends on load and "
    "velocity",
    units={
        **IWAN.units,
        "growing": "friction over the torque of the joint",
        "weight": "rad, deflection under gravity",
    },
    draw=_draw_loaded,
    scaled=multiplied("torque", "growing"),
    most=lambda parameters: min(10.0, MOST_OF_LOAD / max(parameters["growing"], 1e-9)),
    check=each(within(growing=(0.0, MOST_OF_LOAD)), positive("torque", "presliding_stiffness")),
    act=_act_loaded,
)

FORMS = (TANH, IWAN, STRIBECK_CURVE, LUGRE_MODEL, BOUC_WEN_MODEL, SEGALMAN, SEAL, LOADED_MESH)

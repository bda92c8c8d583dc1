"""Other links that bend: on hinges, tapered, stepped, cracked, at flanges, with shear, twisting."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.rig.effects.effect import (
    Check,
    Draw,
    Effect,
    Site,
    Stand,
    divided,
    drawing,
    each,
    positive,
    within,
)
from flexmodal.rig.effects.link_flexibility import EFFECT as OWN
from flexmodal.rig.effects.link_flexibility import plane_in, span
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import Beam
from flexmodal.rig.plant.chain import children, slender_links
from flexmodal.rig.plant.flexure import Flexure, Hinges, Shaft
from flexmodal.rig.plant.geometry import across
from flexmodal.structure.arm import plane_normal

FLANGE = 0.97
"""Where the flange of a link gives, over its length."""
PIECES = (1 / 6, 1 / 2, 5 / 6)
"""Where the hinges between stiff pieces are, over the length of the link."""


def _mass(site: Site) -> float:
    return max(site.stand.true.bodies[site.where].mass, 1e-9)


def _loss(site: Site, spring: float) -> float:
    """Damper over spring [s]: of a stiff link that turns on a spring at its root, 2 ζ/ω."""
    length, _ = span(site.where, site.stand)
    return 2 * site["damping_ratio"] * float(np.sqrt(_mass(site) * length**2 / 3 / spring))


def _give(assembly: PlantAssembly, site: Site, spring: float, made: Callable[[float, int], Flexure]) -> None:
    """Put a flexure into each plane of the link; `made` takes its length and the number of the plane."""
    length, axis = span(site.where, site.stand)
    normal = plane_in(assembly, site.where)
    for plane, side in enumerate(across(axis, normal)):
        assembly.add_flexure(site.where, made(length, plane), axis, side, _loss(site, spring))


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """EI as in the rig's own form."""
    drawn = OWN.draw(stand, where, random)
    return {**drawn, "ratio": float(np.exp(random.uniform(np.log(0.4), np.log(2.5))))}


def _draw_spring(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A spring half to one and a half times the stiffest joint before the link."""
    drawn = _draw(stand, where, random)
    length, _ = span(where, stand)
    stiffness = drawn.pop("bending_stiffness") / length
    return {"stiffness": stiffness, **drawn}


def _shape_hinge(assembly: PlantAssembly, site: Site) -> None:
    def made(length: float, plane: int) -> Flexure:
        spring = site["stiffness"] * (site["ratio"] if plane else 1.0)
        return Hinges(length, (site["place"] * length,), (spring,))

    _give(assembly, site, site["stiffness"], made)


def _shape_flange(assembly: PlantAssembly, site: Site) -> None:
    def made(length: float, plane: int) -> Flexure:
        spring = site["stiffness"] * (site["ratio"] if plane else 1.0)
        return Hinges(length, (FLANGE * length,), (spring,))

    _give(assembly, site, site["stiffness"], made)


def _draw_pieces(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = _draw_spring(stand, where, random)
    return {**drawn, "stiffness": 3 * drawn["stiffness"], "fall": float(random.uniform(0.3, 0.9))}


def _shape_pieces(assembly: PlantAssembly, site: Site) -> None:
    def made(length: float, plane: int) -> Flexure:
        spring = site["stiffness"] * (site["ratio"] if plane else 1.0)
        places = tuple(part * length for part in PIECES)
        return Hinges(length, places, tuple(spring * site["fall"] ** k for k in range(len(PIECES))))

    _give(assembly, site, site["stiffness"] / 3, made)


def _shape_flanges(assembly: PlantAssembly, site: Site) -> None:
    def made(length: float, plane: int) -> Flexure:
        spring = site["stiffness"] * (site["ratio"] if plane else 1.0)
        return Hinges(length, ((1 - FLANGE) * length, FLANGE * length), (spring, spring * site["far"]))

    _give(assembly, site, site["stiffness"], made)


def _beam(
    site: Site, length: float, plane: int, step: tuple[float, float] = (1.0, 1.0), **others: float
) -> Beam:
    rigidity = site["bending_stiffness"] * (site["ratio"] if plane else 1.0)
    return Beam(length, rigidity, _mass(site) / length, step=step, **others)


def _shape_stepped(assembly: PlantAssembly, site: Site) -> None:
    length, _ = span(site.where, site.stand)
    _give(
        assembly, site, 3 * site["bending_stiffness"] / length,
        lambda length, plane: _beam(site, length, plane, (site["place"], site["outer"])),
    )  # fmt: skip


def _shape_cracked(assembly: PlantAssembly, site: Site) -> None:
    """A beam in each plane, and in the first a hinge where the crack is."""
    length, axis = span(site.where, site.stand)
    rigidity = site["bending_stiffness"] / length
    _give(assembly, site, 3 * rigidity, lambda length, plane: _beam(site, length, plane))
    opened = Hinges(length, (site["place"] * length,), (site["crack"] * rigidity,))
    side = across(axis, plane_in(assembly, site.where))[0]
    assembly.add_flexure(site.where, opened, axis, side, _loss(site, 3 * rigidity))


def _shape_tapered(assembly: PlantAssembly, site: Site) -> None:
    length, _ = span(site.where, site.stand)
    _give(
        assembly, site, 3 * site["bending_stiffness"] / length,
        lambda length, plane: _beam(site, length, plane, taper=site["taper"]),
    )  # fmt: skip


def _shape_timoshenko(assembly: PlantAssembly, site: Site) -> None:
    length, _ = span(site.where, site.stand)
    _give(
        assembly, site, 3 * site["bending_stiffness"] / length,
        lambda length, plane: _beam(site, length, plane, shear=site["shear"] * length**2),
    )  # fmt: skip


def _shape_twisting(assembly: PlantAssembly, site: Site) -> None:
    length, axis = span(site.where, site.stand)
    spring = site["bending_stiffness"] / length
    _give(assembly, site, 3 * spring, lambda length, plane: _beam(site, length, plane))
    shaft = Shaft(length, site["torsion"] * spring)
    assembly.add_flexure(site.where, shaft, axis, None, _loss(site, 3 * spring))


def _carrying(robot: Robot, points: Sequence[CampaignPoint]) -> tuple[str, ...]:
    """Links with a joint at their far end."""
    return tuple(link for link in slender_links(robot) if children(robot.urdf, link))


def _spatial(robot: Robot, points: Sequence[CampaignPoint]) -> tuple[str, ...]:
    return () if plane_normal(robot) is not None else slender_links(robot)


def _checking(stiffness: str, **spans: tuple[float, float]) -> Check:
    return each(positive(stiffness), within(damping_ratio=(0.0, 1.0), ratio=(0.05, 20.0), **spans))


def _with(**spans: tuple[float, float]) -> Draw:
    """These drawn before the numbers of a beam."""

    def drawn(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
        others = drawing(**spans)(stand, where, random)
        return {**_draw(stand, where, random), **others}

    return drawn


_DAMPED = {"damping_ratio": "of the link on a clamped root", "ratio": "of stiffness in the second plane"}
_SPRING = {"stiffness": "N·m/rad", **_DAMPED}
_BEAM = {"bending_stiffness": "N·m²", **_DAMPED}

HINGE: Effect = replace(
    OWN,
    form="hinge",
    says="the link bends at one hinge somewhere along it",
    source="Yoshikawa and Hosoda, Int. J. Robotics Research 15 (1996) 290 (virtual links, passive joints)",
    units={**_SPRING, "place": "over the length"},
    draw=drawing(_draw_spring, place=(0.2, 0.8)),
    scaled=divided("stiffness"),
    check=_checking("stiffness", place=(0.0, 0.99)),
    shape=_shape_hinge,
)
TAPERED: Effect = replace(
    OWN,
    form="tapered",
    says="a beam that tapers, stiffer in one plane than in the other",
    source="Géradin and Rixen, Mechanical Vibrations, 3rd ed., section 5.3, in steps of an element",
    units={**_BEAM, "taper": "fall of EI from root to end"},
    draw=_with(taper=(0.4, 0.85)),
    check=_checking("bending_stiffness", taper=(0.0, 0.95)),
    shape=_shape_tapered,
)
FLANGED: Effect = replace(
    HINGE,
    form="flange",
    says="the flange at the far end of the link tilts",
    source="Ibrahim and Pettit, Journal of Sound and Vibration 279 (2005) 857, on bolted joints",
    units=_SPRING,
    places=_carrying,
    place_is="a link that is long enough to bend and carries another",
    draw=_draw_spring,
    check=_checking("stiffness"),
    shape=_shape_flange,
)
TIMOSHENKO: Effect = replace(
    OWN,
    form="timoshenko",
    says="a beam that bends and shears",
    source="Przemieniecki, Theory of Matrix Structural Analysis, McGraw-Hill 1968, section 5.6",
    units={**_BEAM, "shear": "12 E I/(κ G A) over the square of the length"},
    draw=_with(shear=(0.3, 2.0)),
    check=_checking("bending_stiffness", shear=(0.0, 20.0)),
    shape=_shape_timoshenko,
)
TWISTING: Effect = replace(
    OWN,
    form="twisting",
    says="a beam that bends in two planes and twists",
    source="De Luca and Siciliano, IEEE Trans. Syst. Man Cybern. 21 (1991) 826; Saint-Venant's twist",
    units={**_BEAM, "torsion": "G J over E I"},
    places=_spatial,
    place_is="a link of a spatial arm that is long enough to bend",
    draw=_with(torsion=(0.3, 0.9)),
    check=_checking("bending_stiffness", torsion=(0.01, 100.0)),
    shape=_shape_twisting,
)
PIECEWISE: Effect = replace(
    HINGE,
    form="pieces",
    says="stiff pieces on three hinges, each softer than the one before",
    source="Huston, Multibody Dynamics, Butterworth-Heinemann 1990, chapter 11 (finite segments)",
    units={**_SPRING, "fall": "of the spring from hinge to hinge"},
    draw=_draw_pieces,
    check=_checking("stiffness", fall=(0.05, 1.0)),
    shape=_shape_pieces,
)

STEPPED: Effect = replace(
    OWN,
    form="stepped",
    says="two tubes one after the other, the outer one softer",
    source="Géradin and Rixen, Mechanical Vibrations, 3rd ed., section 5.3, in two steps",
    units={**_BEAM, "place": "of the step, over the length", "outer": "EI beyond it over that before"},
    draw=_with(place=(0.3, 0.7), outer=(0.15, 0.5)),
    check=_checking("bending_stiffness", place=(0.0, 1.0), outer=(0.01, 10.0)),
    shape=_shape_stepped,
)
FLANGES: Effect = replace(
    FLANGED,
    form="flanges",
    says="both flanges of a link tilt, the far one more or less than the near one",
    units={**_SPRING, "far": "spring of the far flange over that of the near one"},
    draw=drawing(_draw_spring, far=(0.4, 2.5)),
    check=_checking("stiffness", far=(0.05, 20.0)),
    shape=_shape_flanges,
)
CRACKED: Effect = replace(
    OWN,
    form="cracked",
    says="a beam with a crack, which opens in one plane",
    source="Dimarogonas, Engineering Fracture Mechanics 55 (1996) 831: a crack is a hinge with a spring",
    units={**_BEAM, "place": "of the crack, over the length", "crack": "its spring over E I/length"},
    draw=_with(place=(0.1, 0.6), crack=(0.5, 3.0)),
    check=_checking("bending_stiffness", place=(0.0, 0.99), crack=(0.01, 1e6)),
    shape=_shape_cracked,
)

FORMS = (HINGE, TAPERED, FLANGED, TIMOSHENKO, TWISTING, PIECEWISE, STEPPED, FLANGES, CRACKED)

"""Other things a card may lack: points, disc, body on a soft stalk, rod, duct, counterweight, tank."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.added_mass import EFFECT as OWN
from flexmodal.rig.effects.added_mass import on_link
from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, drawing, each, positive, within
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import cuboid

SLOSH, GRAVITY = 1.8411837813406593, 9.81
"""First zero of J₁', of a liquid that swings in a round tank; m/s²."""

_PLACE = {"mass": "kg", "x": "m", "y": "m", "z": "m"}
_AXIS = {"ax": "", "ay": "", "az": "unit vector, in the frame of the link"}


def _draw_point(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = OWN.draw(stand, where, random)
    return {name: drawn[name] for name in _PLACE}


def _act_point(assembly: PlantAssembly, site: Site) -> None:
    assembly.add_body(site.where, site.vector("x", "y", "z"), site["mass"])


def _draw_two(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = _draw_point(stand, where, random)
    other = on_link(stand, where, random.uniform(0.1, 1.0), random.uniform(-0.12, 0.12))
    found = dict(zip(("x2", "y2", "z2"), map(float, other), strict=True))
    return {**drawn, **found, "share": float(random.uniform(0.3, 0.7))}


def _act_two(assembly: PlantAssembly, site: Site) -> None:
    assembly.add_body(site.where, site.vector("x", "y", "z"), site["mass"] * (1 - site["share"]))
    assembly.add_body(site.where, site.vector("x2", "y2", "z2"), site["mass"] * site["share"])


def _draw_duct(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A duct beside a link from somewhere near its root to somewhere near its far end."""
    mass, beside = OWN.draw(stand, where, random)["mass"], float(random.uniform(-0.15, 0.15))
    ends = [on_link(stand, where, random.uniform(*span), beside) for span in ((0.0, 0.25), (0.75, 1.0))]
    names = ("x", "y", "z", "x2", "y2", "z2")
    return {"mass": mass, **dict(zip(names, map(float, np.concatenate(ends)), strict=True))}


def _act_duct(assembly: PlantAssembly, site: Site) -> None:
    """A thin line of mass from one place to the other."""
    start, end = site.vector("x", "y", "z"), site.vector("x2", "y2", "z2")
    along = end - start
    inertia = site["mass"] / 12 * (along @ along * np.eye(3) - np.outer(along, along))
    assembly.add_body(site.where, (start + end) / 2, site["mass"], inertia)


def _draw_counterweight(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Behind the joint."""
    drawn = OWN.draw(stand, where, random)
    thickness = drawn.pop("gyration")
    place = on_link(stand, where, random.uniform(-0.6, -0.2), random.uniform(-0.1, 0.1))
    return {
        **drawn,
        **dict(zip("xyz", map(float, place), strict=True)),
        "thickness": thickness,
        "depth": float(random.uniform(0.1, 0.4)),
    }


def _act_counterweight(assembly: PlantAssembly, site: Site) -> None:
    """A cuboid twice as wide as it is thick, as deep as it is drawn, square to the frame of its link."""
    sizes = np.array([site["depth"], 2 * site["thickness"], site["thickness"]])
    assembly.add_body(site.where, site.vector("x", "y", "z"), site["mass"], cuboid(site["mass"], sizes))


def _direction(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Any direction; in the plane of a planar chain, where it makes a difference."""
    way, normal = random.standard_normal(3), stand.normal_in(where)
    if normal is not None:
        way = way - (way @ normal) * normal
    way = way / np.linalg.norm(way)
    return dict(zip(_AXIS, map(float, way), strict=True))


def _draw_axis(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {**_draw_point(stand, where, random), **_direction(stand, where, random)}


def _act_disc(assembly: PlantAssembly, site: Site) -> None:
    """Thin: m r²/2 about its axis, half of it about the others."""
    axis = site.vector(*_AXIS)
    inertia = site["mass"] * site["radius"] ** 2 / 4 * (np.eye(3) + np.outer(axis, axis))
    assembly.add_body(site.where, site.vector("x", "y", "z"), site["mass"], inertia)


def _act_rod(assembly: PlantAssembly, site: Site) -> None:
    """Held at one end: its centre half a length away, m l²/12 about it."""
    axis, length = site.vector(*_AXIS), site["length"]
    inertia = site["mass"] * length**2 / 12 * (np.eye(3) - np.outer(axis, axis))
    assembly.add_body(site.where, site.vector("x", "y", "z") + length / 2 * axis, site["mass"], inertia)


def _draw_stalk(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Its own resonance on a link held still lies beyond the band."""
    return {
        **_draw_point(stand, where, random),
        "frequency": float(random.uniform(1.3, 3.0) * stand.plan.band[1]),
        "damping_ratio": float(random.uniform(0.01, 0.05)),
    }


def _act_stalk(assembly: PlantAssembly, site: Site) -> None:
    """A point that moves on equal springs each way."""
    carried = assembly.motion(site.where, site.vector("x", "y", "z"))[:3]
    names = [f"stalk {axis}" for axis in "xyz"]
    assembly.add_on_springs(names, carried, site["mass"], site["frequency"], site["damping_ratio"])


def _draw_half_full(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A tank whose liquid sloshes at 1 to 3 Hz, below what a hammer test looks at."""
    return {
        **_draw_point(stand, where, random),
        "radius": float(random.uniform(0.08, 0.2)),
        "depth": float(random.uniform(0.6, 1.5)),
        "damping_ratio": float(random.uniform(0.02, 0.1)),
    }


def _act_half_full(assembly: PlantAssembly, site: Site) -> None:
    """An upright cylinder: all of the liquid goes up and down, a part of it stays behind sideways.

    m₁/m = 2 tanh(ξ h/R)/(ξ (ξ² − 1) h/R), ω² = ξ g/R tanh(ξ h/R), h/2 − 2R/ξ tanh(ξ h/2R) above the centre
    of the liquid; ξ the first zero of J₁'.
    """
    depth, radius, mass = site["depth"], site["radius"], site["mass"]
    part = 2 * np.tanh(SLOSH * depth) / (SLOSH * (SLOSH**2 - 1) * depth)
    omega = float(np.sqrt(SLOSH * GRAVITY / radius * np.tanh(SLOSH * depth)))
    high = radius * (depth / 2 - 2 / SLOSH * np.tanh(SLOSH * depth / 2))
    axes, centre = assembly.orientation(site.where), site.vector("x", "y", "z")

    def moved(height: float) -> np.ndarray:
        return assembly.motion(site.where, centre + height * axes.T[:, 2])[:3]

    swinging, stays = moved(high), moved(-high * part / (1 - part))
    assembly.add_inertia(moved(0.0)[2], mass)
    for way in (0, 1):
        assembly.add_inertia(stays[way], (1 - part) * mass)
    names, frequency = ["slosh x", "slosh y"], omega / 2 / np.pi
    assembly.add_on_springs(names, swinging[:2], part * mass, frequency, site["damping_ratio"])


def _check_unit(parameters: Parameters) -> str | None:
    size = float(np.linalg.norm([parameters[name] for name in _AXIS]))
    return None if abs(size - 1) <= 1e-6 else f"ax, ay, az of length {size:g}, where 1 is needed"


_INERTIA = "Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 2.13"

POINT: Effect = replace(
    OWN, form="point", says="a point mass beside the axis of a link", source=_INERTIA, units=_PLACE,
    draw=_draw_point, act=_act_point,
)  # fmt: skip
TWO: Effect = replace(
    POINT,
    form="two",
    says="two point masses on a link",
    units={**_PLACE, "x2": "m", "y2": "m", "z2": "m, of the second", "share": "of the mass, the second's"},
    draw=_draw_two,
    check=each(within(share=(0.0, 1.0)), positive("mass")),
    act=_act_two,
)
DISC: Effect = replace(
    POINT,
    form="disc",
    says="a disc with an axis of its own",
    units={**_PLACE, **_AXIS, "radius": "m"},
    draw=drawing(_draw_axis, radius=(0.05, 0.2)),
    check=each(_check_unit, positive("mass", "radius")),
    act=_act_disc,
)
ROD: Effect = replace(
    POINT,
    form="rod",
    says="a rod held at one end",
    units={**_PLACE, **_AXIS, "length": "m"},
    draw=drawing(_draw_axis, length=(0.15, 0.5)),
    check=each(_check_unit, positive("mass", "length")),
    act=_act_rod,
)
STALK: Effect = replace(
    POINT,
    form="stalk",
    says="a body on a short stalk that gives",
    source="Den Hartog, Mechanical Vibrations, 4th ed., section 2.5: an appendage below its own resonance",
    units={**_PLACE, "frequency": "Hz, on a link held still", "damping_ratio": ""},
    draw=_draw_stalk,
    check=positive("mass", "frequency"),
    act=_act_stalk,
)

DUCT: Effect = replace(
    POINT,
    form="duct",
    says="a cable duct along a link",
    units={**_PLACE, "x2": "m", "y2": "m", "z2": "m, of its other end"},
    draw=_draw_duct,
    act=_act_duct,
)
COUNTERWEIGHT: Effect = replace(
    POINT,
    form="counterweight",
    says="a counterweight behind the joint of a link",
    units={**_PLACE, "thickness": "m", "depth": "m"},
    draw=_draw_counterweight,
    check=positive("mass", "thickness", "depth"),
    act=_act_counterweight,
)
HALF_FULL: Effect = replace(
    POINT,
    form="half_full",
    says="a tank that is half full: sideways a part of the liquid stays behind",
    source="Abramson, ed., The Dynamic Behavior of Liquids in Moving Containers, NASA SP-106, 1966",
    units={
        **_PLACE,
        "radius": "m, of the tank",
        "depth": "of the liquid, over the radius",
        "damping_ratio": "",
    },
    draw=_draw_half_full,
    check=positive("mass", "radius", "depth"),
    act=_act_half_full,
)

FORMS = (POINT, TWO, DISC, ROD, STALK, DUCT, COUNTERWEIGHT, HALF_FULL)

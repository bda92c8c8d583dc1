"""Other resilient things on a link: free two ways, a pendulum, two, one on rubber, whip, string, stack."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, drawing, each, positive, within
from flexmodal.rig.effects.local_absorber import EFFECT as OWN
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import across
from flexmodal.rig.plant.plant import Branch


def ways(assembly: PlantAssembly, site: Site) -> tuple[np.ndarray, np.ndarray]:
    """The direction of the mass and one across it, in the plane of a planar chain; world axes.

    Args:
        assembly: the plant in the making.
        site: the link, and the direction as dx, dy, dz.
    """
    axes = assembly.orientation(site.where)
    way = site.vector("dx", "dy", "dz")
    way = way / np.linalg.norm(way)
    normal = None if assembly.normal is None else axes.T @ assembly.normal
    if normal is not None and np.linalg.norm(np.cross(normal, way)) < 1e-9:
        normal = None
    return axes @ way, axes @ across(way, normal)[0]


def coordinates(assembly: PlantAssembly, count: int) -> list[np.ndarray]:
    """Rows of new coordinates.

    Args:
        assembly: the plant in the making.
        count: how many.
    """
    names = [f"absorber {len(assembly.coordinates) + k}" for k in range(count)]
    assembly.add_coordinates(names)
    return [assembly.row(name) for name in names]


def _hang(assembly: PlantAssembly, link: str, place: np.ndarray, mass: float, own: np.ndarray) -> None:
    """A mass that moves with its link and by `own` besides [3, coordinate]."""
    carried = assembly.motion(link, place)[:3]
    for axis in range(3):
        assembly.add_inertia(carried[axis] + own[axis], mass)


def _spring(assembly: PlantAssembly, row: np.ndarray, mass: float, frequency: float, ratio: float) -> None:
    omega = 2 * np.pi * frequency
    assembly.add_spring(row, mass * omega**2, 2 * ratio * mass * omega)


def _act_two_way(assembly: PlantAssembly, site: Site) -> None:
    first, second = ways(assembly, site)
    one, other = coordinates(assembly, 2)
    moved = np.outer(first, one) + np.outer(second, other)
    _hang(assembly, site.where, site.vector("x", "y", "z"), site["mass"], moved)
    _spring(assembly, one, site["mass"], site["frequency"], site["damping_ratio"])
    _spring(assembly, other, site["mass"], site["frequency"] * site["second"], site["damping_ratio"])


def _act_pendulum(assembly: PlantAssembly, site: Site) -> None:
    """A body on an arm that turns about a hinge; the arm points along `d`, the hinge lies across."""
    arm, sweep = ways(assembly, site)
    axis, length, mass = np.cross(arm, sweep), site["arm"], site["mass"]
    (own,) = coordinates(assembly, 1)
    axes = assembly.orientation(site.where)
    hinge = site.vector("x", "y", "z")
    _hang(assembly, site.where, hinge + length * (axes.T @ arm), mass, length * np.outer(sweep, own))
    turning, inertia = assembly.motion(site.where, hinge)[3:], mass * site["gyration"] ** 2
    for k in range(3):
        assembly.add_inertia(turning[k] + axis[k] * own, inertia)
    _spring(assembly, own, mass * length**2 + inertia, site["frequency"], site["damping_ratio"])


def _act_twin(assembly: PlantAssembly, site: Site) -> None:
    """The second hangs at the first one's place and swings across it."""
    first, second = ways(assembly, site)
    place = site.vector("x", "y", "z")
    for way, share, factor in ((first, 1 - site["share"], 1.0), (second, site["share"], site["second"])):
        (own,) = coordinates(assembly, 1)
        mass = share * site["mass"]
        _hang(assembly, site.where, place, mass, np.outer(way, own))
        _spring(assembly, own, mass, factor * site["frequency"], site["damping_ratio"])


def _act_rubber(assembly: PlantAssembly, site: Site) -> None:
    """A spring beside a Maxwell element whose loss is largest where the mass would swing."""
    way, _ = ways(assembly, site)
    (own,) = coordinates(assembly, 1)
    _hang(assembly, site.where, site.vector("x", "y", "z"), site["mass"], np.outer(way, own))
    omega, strength = 2 * np.pi * site["frequency"], site["relaxing"]
    static = site["mass"] * omega**2 / (1 + strength / 2)
    assembly.add_spring(own, static)
    assembly.branches.append(Branch(own, strength * static, 1 / omega))


WHIP = ((1.0, 0.6131, 0.7265), (6.2669, 0.1883, 0.2092))
"""Of the first two modes of a clamped, uniform beam: frequency over the first, part of the mass, and how high
that is over the length."""


def _act_whip(assembly: PlantAssembly, site: Site) -> None:
    """A thin beam clamped to the link, free both ways across; what two modes leave is stiff.

    Mass and first moment are the beam's.
    """
    one, up = ways(assembly, site)
    axes, place, mass = assembly.orientation(site.where), site.vector("x", "y", "z"), site["mass"]
    left = 1 - sum(part for _, part, _ in WHIP)
    height = (0.5 - sum(part * high for _, part, high in WHIP)) / left

    def moved(over: float) -> np.ndarray:
        return assembly.motion(site.where, place + over * site["length"] * (axes.T @ up))[:3]

    assembly.add_inertia(up @ moved(0.0), mass)
    for side in (one, np.cross(one, up))[: 1 if assembly.normal is not None else 2]:
        assembly.add_inertia(side @ moved(height), left * mass)
        for times, part, high in WHIP:
            (own,) = coordinates(assembly, 1)
            assembly.add_inertia(side @ moved(high) + own, part * mass)
            _spring(assembly, own, part * mass, times * site["frequency"], site["damping_ratio"])


def _act_string(assembly: PlantAssembly, site: Site) -> None:
    """A taut line along `d`, held at both ends: three modes each way across, and what they leave is stiff.

    Of mode n, n times as fast as the first, 8/(π n)² of the mass moves at its middle where n is odd; where n
    is even 24/(π n)² of the moment of inertia of a rod turns about the middle.
    """
    way, one = ways(assembly, site)
    mass, length = site["mass"], site["length"]
    inertia = mass * length**2 / 12

    def moved(along: np.ndarray, turned: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        motion = assembly.motion(site.where, site.vector("x", "y", "z"))
        return along @ motion[:3], turned @ motion[3:]

    assembly.add_inertia(moved(way, way)[0], mass)
    for side in (one, np.cross(way, one))[: 1 if assembly.normal is not None else 2]:
        left = [mass, inertia]
        for number in (1, 2, 3):
            (own,) = coordinates(assembly, 1)
            even = 1 - number % 2
            part = (inertia * 24 if even else mass * 8) / (np.pi * number) ** 2
            left[even] -= part
            assembly.add_inertia(moved(side, np.cross(way, side))[even] + own, part)
            _spring(assembly, own, part, number * site["frequency"], site["damping_ratio"])
        for row, rest in zip(moved(side, np.cross(way, side)), left, strict=True):
            assembly.add_inertia(row, rest)


def _act_stacked(assembly: PlantAssembly, site: Site) -> None:
    """The second mass hangs on the first, not on the link; both swing the same way."""
    way, _ = ways(assembly, site)
    place, omega = site.vector("x", "y", "z"), site["frequency"]
    one, other = coordinates(assembly, 2)
    outer, inner = (1 - site["share"]) * site["mass"], site["share"] * site["mass"]
    _hang(assembly, site.where, place, outer, np.outer(way, one))
    _hang(assembly, site.where, place, inner, np.outer(way, one + other))
    _spring(assembly, one, site["mass"], omega, site["damping_ratio"])
    _spring(assembly, other, inner, site["second"] * omega, site["damping_ratio"])


def _draw_rubber(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = drawing(OWN.draw, relaxing=(0.1, 0.6))(stand, where, random)
    del drawn["damping_ratio"]
    return drawn


def _check_own(parameters: Parameters) -> str | None:
    return OWN.check({"damping_ratio": 0.0, **parameters})


_SECOND = {"second": "frequency of the second way over the first"}

TWO_WAY: Effect = replace(
    OWN,
    form="two_way",
    says="a mass on springs that is free two ways",
    source="Den Hartog, Mechanical Vibrations, 4th ed., chapter 3",
    units={**OWN.units, **_SECOND},
    draw=drawing(OWN.draw, second=(0.5, 2.2)),
    check=each(positive("second"), _check_own),
    act=_act_two_way,
)
PENDULUM: Effect = replace(
    OWN,
    form="pendulum",
    says="a body on an arm that turns about a hinge",
    source="Hunt, Dynamic Vibration Absorbers, Mechanical Engineering Publications 1979 (pendulum absorbers)",
    units={**OWN.units, "arm": "m", "gyration": "m, radius"},
    draw=drawing(OWN.draw, arm=(0.05, 0.25), gyration=(0.01, 0.06)),
    check=each(positive("arm", "gyration"), _check_own),
    act=_act_pendulum,
)
TWIN: Effect = replace(
    OWN,
    form="twin",
    says="two masses on springs, one across the other",
    source="Iwanami and Seto, Bulletin of JSME 27 (1984) 1506 (dual dynamic dampers)",
    units={**OWN.units, **_SECOND, "share": "of the mass, the second's"},
    draw=drawing(OWN.draw, second=(1.3, 2.5), share=(0.3, 0.6)),
    check=each(positive("second", "share"), within(share=(0.0, 0.999)), _check_own),
    act=_act_twin,
)
RUBBER: Effect = replace(
    OWN,
    form="rubber",
    says="a mass on rubber: a Maxwell element beside the spring",
    source="Snowdon, Vibration and Shock in Damped Mechanical Systems, Wiley 1968",
    units={
        **{name: unit for name, unit in OWN.units.items() if name != "damping_ratio"},
        "relaxing": "stiffness that relaxes over the one that stays",
    },
    draw=_draw_rubber,
    check=each(positive("relaxing"), _check_own),
    act=_act_rubber,
)

WHIPPING: Effect = replace(
    OWN,
    form="whip",
    says="a thin beam that stands on the link: an antenna, a lance, a bundle of hoses",
    source="Géradin and Rixen, Mechanical Vibrations, 3rd ed., section 4.3 (clamped beam, effective masses)",
    units={**OWN.units, "length": "m"},
    draw=drawing(OWN.draw, length=(0.1, 0.4)),
    check=each(positive("length"), _check_own),
    act=_act_whip,
)
STRING: Effect = replace(
    OWN,
    form="string",
    says="a taut line along the link: a hose or a cable between two clips",
    source="Géradin and Rixen, Mechanical Vibrations, 3rd ed., section 4.2 (string between fixed ends)",
    units={**OWN.units, "length": "m, between the clips"},
    draw=drawing(OWN.draw, length=(0.15, 0.6)),
    check=each(positive("length"), _check_own),
    act=_act_string,
)
STACKED: Effect = replace(
    OWN,
    form="stacked",
    says="a mass on springs that carries another on springs: a cabinet and what hangs in it",
    source="Zuo, ASME J. Vibration and Acoustics 131 (2009) 031003 (tuned masses in series)",
    units={
        **OWN.units,
        "second": "frequency of the second on a first held still, over the first's with both",
        "share": "of the mass, the second's",
    },
    draw=drawing(OWN.draw, second=(0.7, 1.8), share=(0.25, 0.6)),
    check=each(positive("second", "share"), within(share=(0.0, 0.999)), _check_own),
    act=_act_stacked,
)

FORMS = (TWO_WAY, PENDULUM, TWIN, RUBBER, WHIPPING, STRING, STACKED)

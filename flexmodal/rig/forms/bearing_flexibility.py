"""Other bearings that give: rows of rollers, a housing softer one way, a seat that relaxes, bolts, balls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.bearing_flexibility import EFFECT as OWN
from flexmodal.rig.effects.bearing_flexibility import draw_springs, rows, shape
from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, divided, positive
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import Branch

BOLTS, BALLS = 8, 16
"""Of a ring."""


def _draw_rows(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Rows 6 to 20 cm apart that tilt as the rig's own bearing does; the rear one a part as stiff."""
    drawn = draw_springs(stand, where, random)
    apart, rear = float(random.uniform(0.06, 0.2)), float(random.uniform(0.3, 1.0))
    front = drawn["tilt_stiffness"] * (1 + rear) / (rear * apart**2)
    return {
        "front_stiffness": front,
        "rear": rear,
        "apart": apart,
        "middle": float(random.uniform(-0.5, 0.5) * apart),
        "axial": float(random.uniform(0.3, 1.0)),
        "damping_time": drawn["damping_time"],
    }


def _act_rows(assembly: PlantAssembly, site: Site) -> None:
    """A point at z on the axis shifts by x + z ry and y − z rx, (x, y, z) the frame's axes."""
    x, y, z, rx, ry = rows(assembly, site)
    front, time = site["front_stiffness"], site["damping_time"]
    for place, spring in (
        (site["middle"] + site["apart"] / 2, front),
        (site["middle"] - site["apart"] / 2, front * site["rear"]),
    ):
        for row in (x + place * ry, y - place * rx):
            assembly.add_spring(row, spring, spring * time)
    axial = site["axial"] * front * (1 + site["rear"])
    assembly.add_spring(z, axial, axial * time)


def _draw_housing(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {
        **draw_springs(stand, where, random),
        "ratio": float(np.exp(random.uniform(np.log(0.25), np.log(0.7)))),
        "angle": float(random.uniform(0, np.pi)),
    }


def _act_housing(assembly: PlantAssembly, site: Site) -> None:
    """Softer along one direction across the axis, and in the tilt about the other."""
    x, y, z, rx, ry = rows(assembly, site)
    c, s = np.cos(site["angle"]), np.sin(site["angle"])
    soft, time = site["ratio"], site["damping_time"]
    radial, tilt = site["radial_stiffness"], site["tilt_stiffness"]
    for row, spring in (
        (c * x + s * y, radial * soft),
        (c * y - s * x, radial),
        (z, site["axial_stiffness"]),
        (c * rx + s * ry, tilt),
        (c * ry - s * rx, tilt * soft),
    ):
        assembly.add_spring(row, spring, spring * time)


def _draw_relaxing(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    low, high = stand.plan.band
    corner = 2 * np.pi * float(np.exp(random.uniform(np.log(3 * low), np.log(0.7 * high))))
    return {
        **draw_springs(stand, where, random),
        "relaxing": float(random.uniform(0.2, 0.8)),
        "time": 1 / corner,
    }


def _act_relaxing(assembly: PlantAssembly, site: Site) -> None:
    """Each spring with a Maxwell element beside it."""
    spring = [site["radial_stiffness"]] * 2 + [site["axial_stiffness"]] + [site["tilt_stiffness"]] * 2
    for row, stiffness in zip(rows(assembly, site), spring, strict=True):
        assembly.add_spring(row, stiffness, stiffness * site["damping_time"])
        assembly.branches.append(Branch(row, site["relaxing"] * stiffness, site["time"]))


def _draw_bolts(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A ring that would tilt as the rig's own bearing does if all its bolts were tight."""
    drawn, radius = draw_springs(stand, where, random), float(random.uniform(0.05, 0.15))
    return {
        "bolt_stiffness": 2 * drawn["tilt_stiffness"] / (BOLTS * radius**2),
        "radius": radius,
        "shear": float(random.uniform(0.3, 1.0)),
        "loose": float(random.integers(2, 5)),
        "tightness": float(random.uniform(0.1, 0.5)),
        "angle": float(random.uniform(0, 2 * np.pi)),
        "damping_time": drawn["damping_time"],
    }


def _act_bolts(assembly: PlantAssembly, site: Site) -> None:
    """A bolt at angle φ stretches by z + r (rx sin φ − ry cos φ); some next to one another are loose."""
    x, y, z, rx, ry = rows(assembly, site)
    radius, time = site["radius"], site["damping_time"]
    for number in range(BOLTS):
        angle = site["angle"] + 2 * np.pi * number / BOLTS
        spring = site["bolt_stiffness"] * (site["tightness"] if number < site["loose"] else 1.0)
        stretched = z + radius * (np.sin(angle) * rx - np.cos(angle) * ry)
        assembly.add_spring(stretched, spring, spring * time)
        for row in (x, y):
            assembly.add_spring(row, site["shear"] * spring, site["shear"] * spring * time)


def _draw_balls(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Balls that are pressed evenly would tilt as the rig's own bearing does."""
    drawn, radius = draw_springs(stand, where, random), float(random.uniform(0.05, 0.15))
    angle, rear = float(random.uniform(0.4, 0.8)), float(random.uniform(0.3, 1.0))
    apart = float(random.uniform(0.2, 0.8)) * radius
    lever = np.cos(angle) * apart / 2 + np.sin(angle) * radius
    return {
        "ball_stiffness": float(2 * drawn["tilt_stiffness"] / (BALLS * lever**2 * (1 + rear))),
        "radius": radius,
        "apart": apart,
        "contact_angle": angle,
        "rear": rear,
        "uneven": float(random.uniform(0.2, 0.7)),
        "angle": float(random.uniform(0, 2 * np.pi)),
        "damping_time": drawn["damping_time"],
    }


def _act_balls(assembly: PlantAssembly, site: Site) -> None:
    """Back to back: a ball at φ of the row at ±d/2 is pressed along (cos α cos φ, cos α sin φ, ∓sin α)."""
    x, y, z, rx, ry = rows(assembly, site)
    across, along, time = np.cos(site["contact_angle"]), np.sin(site["contact_angle"]), site["damping_time"]
    for side, part in ((1, 1.0), (-1, site["rear"])):
        place = side * site["apart"] / 2
        for angle in 2 * np.pi * np.arange(BALLS) / BALLS:
            c, s = np.cos(angle), np.sin(angle)
            spring = part * site["ball_stiffness"] * (1 + site["uneven"] * np.cos(angle - site["angle"]))
            pressed = across * (c * (x + place * ry) + s * (y - place * rx))
            pressed = pressed - side * along * (z + site["radius"] * (s * rx - c * ry))
            assembly.add_spring(pressed, spring, spring * time)


def _draw_pinion(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {
        **draw_springs(stand, where, random),
        "base_radius": float(random.uniform(0.06, 0.18)),
        "angle": float(random.uniform(0, 2 * np.pi)),
    }


def _shape_pinion(assembly: PlantAssembly, site: Site) -> None:
    """The drive pushes a tooth along the line of action: r θ and the bearing's shift add up there."""
    shape(assembly, site)
    x, y, *_ = rows(assembly, site)
    shift = np.cos(site["angle"]) * x + np.sin(site["angle"]) * y
    assembly.elongation[site.where] = assembly.stretch(site.where) + shift / site["base_radius"]


def _check(*names: str) -> Effect:
    def check(parameters: Parameters) -> str | None:
        return OWN.check(parameters) or positive(*names)(parameters)

    return replace(OWN, check=check)


ROWS: Effect = replace(
    _check("rear", "apart", "axial"),
    form="rows",
    says="a joint on two rows of rolling elements",
    source="Lim and Singh, Journal of Sound and Vibration 139 (1990) 179: stiffness matrix of a bearing",
    units={
        "front_stiffness": "N/m", "rear": "over the front row", "apart": "m", "middle": "m",
        "axial": "over both rows", "damping_time": "damping over stiffness, s",
    },
    draw=_draw_rows,
    scaled=divided("front_stiffness"),
    act=_act_rows,
)  # fmt: skip
HOUSING: Effect = replace(
    _check("ratio"),
    form="housing",
    says="a bearing in a housing that is softer one way",
    source="Harris and Kotzalas, Rolling Bearing Analysis, 5th ed., CRC 2006, chapter 1, on housings",
    units={**OWN.units, "ratio": "of the softer way over the other", "angle": "rad"},
    draw=_draw_housing,
    act=_act_housing,
)
RELAXING: Effect = replace(
    _check("relaxing", "time"),
    form="relaxing",
    says="a bearing whose seat relaxes",
    source="Zener, Elasticity and Anelasticity of Metals, University of Chicago Press 1948, part two",
    units={**OWN.units, "relaxing": "stiffness that relaxes, relative", "time": "s"},
    draw=_draw_relaxing,
    act=_act_relaxing,
)

RING: Effect = replace(
    _check("radius", "shear", "tightness"),
    form="bolts",
    says="a bearing whose ring is bolted on, some of the bolts loose",
    source="springs on a circle, summed; Ibrahim and Pettit, J. Sound and Vibration 279 (2005) 857",
    units={
        "bolt_stiffness": "N/m, along the bolt", "radius": "m, of their circle", "shear": "over along",
        "loose": "how many of eight", "tightness": "stiffness of a loose one over a tight one",
        "angle": "rad, of the first loose one", "damping_time": "damping over stiffness, s",
    },
    draw=_draw_bolts,
    scaled=divided("bolt_stiffness"),
    act=_act_bolts,
)  # fmt: skip
CONTACT: Effect = replace(
    _check("ball_stiffness", "radius", "apart", "contact_angle", "rear"),
    form="angular_contact",
    says="two rows of balls back to back, pressed unevenly",
    source="Harris and Kotzalas, Rolling Bearing Analysis, 5th ed., CRC 2006, chapter 7; springs, summed",
    units={
        "ball_stiffness": "N/m, of a contact", "radius": "m, of the ring", "apart": "m, of the rows",
        "contact_angle": "rad", "rear": "stiffness of the other row over that of the first",
        "uneven": "how much stiffer the most pressed contact is, relative", "angle": "rad, of that one",
        "damping_time": "damping over stiffness, s",
    },
    draw=_draw_balls,
    scaled=divided("ball_stiffness"),
    act=_act_balls,
)  # fmt: skip
PINION: Effect = replace(
    _check("base_radius"),
    form="pinion",
    says="a bearing beside which a pinion drives: the teeth push what it carries aside",
    source="Kahraman, Özgüven, Houser and Zakrajsek, ASME J. Mechanical Design 114 (1992) 507 (gear mesh)",
    units={**OWN.units, "base_radius": "m, of the gear", "angle": "rad, of the line of action"},
    draw=_draw_pinion,
    shape=_shape_pinion,
)

FORMS = (ROWS, HOUSING, RELAXING, RING, CONTACT, PINION)

"""Other foundations that give: each way its own spring, feet, a block on soil, bolts besides, waves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.base_flexibility import EFFECT as OWN
from flexmodal.rig.effects.base_flexibility import base_coordinates, base_directions
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, positive
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import Feedback
from flexmodal.structure.arm import carried


def _rows(assembly: PlantAssembly, place: np.ndarray, prefix: str = "base") -> np.ndarray:
    """Motion of a point of the base along each of its directions [direction, coordinate]."""
    names, motion = base_directions(assembly.normal)
    own = np.array([assembly.row(name.replace("base", prefix)) for name in names])
    return np.asarray(motion.T @ carried(motion, place) @ own)


def _tilts(assembly: PlantAssembly) -> np.ndarray:
    """Which of the base's directions are tilts."""
    _, motion = base_directions(assembly.normal)
    return np.any(motion[3:] != 0, axis=0)


def _upright(assembly: PlantAssembly) -> np.ndarray:
    _, motion = base_directions(assembly.normal)
    return np.abs(motion[2]) > 0.5


def _springs(assembly: PlantAssembly, site: Site) -> np.ndarray:
    """Stiffness of each direction: two of the campaign's numbers, the upright one stiffer."""
    found = np.where(_tilts(assembly), site["tilt_stiffness"], site["translation_stiffness"])
    return np.where(_upright(assembly), found * site["vertical_over_horizontal"], found)


def _sideways(assembly: PlantAssembly) -> np.ndarray:
    _, motion = base_directions(assembly.normal)
    return motion[:3, 0]


def _centre(assembly: PlantAssembly, site: Site) -> np.ndarray:
    return site["aside"] * _sideways(assembly) - site["below"] * np.array([0.0, 0.0, 1.0])


def _offset(stand: Stand, random: np.random.Generator) -> dict[str, float]:
    """Centre of stiffness a few per cent of the arm's length aside, and below the root's frame."""
    size = sum(float(np.linalg.norm(joint.xyz)) for joint in stand.robot.urdf.joints)
    return {
        "aside": float(random.uniform(-0.1, 0.1) * size),
        "below": float(random.uniform(0.03, 0.2) * size),
    }


def _draw_directions(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {
        **OWN.draw(stand, where, random),
        **_offset(stand, random),
        "spread": float(random.uniform(0.3, 0.8)),
        "phase": float(random.uniform(0, 2 * np.pi)),
    }


def _act_directions(assembly: PlantAssembly, site: Site) -> None:
    """Each direction its own stiffness and damping, about a centre that is not the root's origin."""
    rows = _rows(assembly, _centre(assembly, site))
    time = np.sqrt(site.stand.mass / site["translation_stiffness"])
    for number, (row, spring) in enumerate(zip(rows, _springs(assembly, site), strict=True)):
        angle = site["phase"] + 2.399963 * number
        stiffness = spring * float(np.exp(site["spread"] * np.sin(angle)))
        loss = site["damping_ratio"] * float(np.exp(site["spread"] * np.cos(angle)))
        assembly.add_spring(row, stiffness, 2 * loss * stiffness * time)


def _draw_feet(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Four feet that carry the robot as stiffly as the rig's own foundation does."""
    drawn = OWN.draw(stand, where, random)
    upright = drawn["translation_stiffness"] * drawn["vertical_over_horizontal"]
    width = float(np.sqrt(drawn["tilt_stiffness"] / upright))
    return {
        "foot_stiffness": upright / 4,
        "half_width": width,
        "below": float(random.uniform(0.1, 0.5) * width),
        "horizontal": float(random.uniform(0.3, 1.0)),
        "worst": float(random.uniform(0.25, 0.7)),
        "damping_ratio": drawn["damping_ratio"],
    }


def _act_feet(assembly: PlantAssembly, site: Site) -> None:
    """The first foot is worse than the others; three springs a foot."""
    time = np.sqrt(site.stand.mass / (4 * site["foot_stiffness"]))
    ahead = _sideways(assembly)
    beside = np.cross(np.array([0.0, 0.0, 1.0]), ahead)
    _, motion = base_directions(assembly.normal)
    for number, (one, other) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        place = site["half_width"] * (one * ahead + other * beside) - site["below"] * np.array([0, 0, 1.0])
        factor = site["worst"] if number == 0 else 1.0
        for row, direction in zip(_rows(assembly, place), motion.T, strict=True):
            if np.any(direction[3:]):
                continue
            spring = site["foot_stiffness"] * factor
            spring *= 1.0 if abs(direction[2]) > 0.5 else site["horizontal"]
            assembly.add_spring(row, spring, 2 * site["damping_ratio"] * spring * time)


def _draw_block(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A block of one to four times the robot's mass; soil as much stiffer."""
    drawn = OWN.draw(stand, where, random)
    over = float(random.uniform(1.0, 4.0))
    return {
        "translation_stiffness": drawn["translation_stiffness"] * (1 + over),
        "tilt_stiffness": drawn["tilt_stiffness"] * (1 + over),
        "damping_ratio": drawn["damping_ratio"],
        "vertical_over_horizontal": drawn["vertical_over_horizontal"],
        **_offset(stand, random),
        "block_mass": over * stand.mass,
    }


def _block_inertia(site: Site) -> np.ndarray:
    """Of a cube as deep as its centre is below the root, twice."""
    return site["block_mass"] * (2 * site["below"]) ** 2 / 6 * np.eye(3)


def _act_block(assembly: PlantAssembly, site: Site) -> None:
    """The robot stands fast on a block, its centre below; the soil's springs at the bottom of it."""
    centre, root = _centre(assembly, site), assembly.robot.urdf.root
    axes = assembly.orientation(root)
    assembly.add_body(root, axes.T @ centre, site["block_mass"], _block_inertia(site))
    bottom = centre - site["below"] * np.array([0.0, 0.0, 1.0])
    _soil(assembly, site, _rows(assembly, bottom), site.stand.mass + site["block_mass"])


def _soil(assembly: PlantAssembly, site: Site, rows: np.ndarray, mass: float) -> None:
    time = np.sqrt(mass / site["translation_stiffness"])
    for row, spring in zip(rows, _springs(assembly, site), strict=True):
        assembly.add_spring(row, float(spring), 2 * site["damping_ratio"] * float(spring) * time)


def _draw_bolted(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {**_draw_block(stand, where, random), "bolts": float(random.uniform(0.8, 3.0))}


def _shape_bolted(assembly: PlantAssembly, site: Site) -> None:
    base_coordinates(assembly, site)
    names, _ = base_directions(assembly.normal)
    assembly.add_coordinates([name.replace("base", "block") for name in names])


def _act_bolted(assembly: PlantAssembly, site: Site) -> None:
    """The block moves by itself, on soil; bolts between it and the robot, `bolts` times as stiff."""
    centre = _centre(assembly, site)
    own, (_, motion) = _rows(assembly, centre, "block"), base_directions(assembly.normal)
    inertia = _block_inertia(site)
    for row, direction in zip(own, motion.T, strict=True):
        tilting = float(direction[3:] @ inertia @ direction[3:])
        assembly.add_inertia(row, tilting if np.any(direction[3:]) else site["block_mass"])
    bottom = centre - site["below"] * np.array([0.0, 0.0, 1.0])
    _soil(assembly, site, _rows(assembly, bottom, "block"), site.stand.mass + site["block_mass"])
    between = _rows(assembly, np.zeros(3)) - _rows(assembly, np.zeros(3), "block")
    time = np.sqrt(site.stand.mass / (site["bolts"] * site["translation_stiffness"]))
    for row, spring in zip(between, _springs(assembly, site), strict=True):
        stiffness = site["bolts"] * float(spring)
        assembly.add_spring(row, stiffness, site["damping_ratio"] * stiffness * time)


def _draw_radiating(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = _draw_block(stand, where, random)
    return {
        **drawn,
        "damping_ratio": float(random.uniform(0.1, 0.3)),
        "trapped": float(random.uniform(0.3, 1.0)),
    }


def _act_radiating(assembly: PlantAssembly, site: Site) -> None:
    """Cones: a spring and a damper for translations; for tilts the damper works on a mass of its own."""
    centre, root = _centre(assembly, site), assembly.robot.urdf.root
    axes = assembly.orientation(root)
    assembly.add_body(root, axes.T @ centre, site["block_mass"], _block_inertia(site))
    rows = _rows(assembly, centre - site["below"] * np.array([0.0, 0.0, 1.0]))
    time = np.sqrt((site.stand.mass + site["block_mass"]) / site["translation_stiffness"])
    for row, spring, tilt in zip(rows, _springs(assembly, site), _tilts(assembly), strict=True):
        damper = 2 * site["damping_ratio"] * float(spring) * time
        assembly.add_spring(row, float(spring), 0.0 if tilt else damper)
        if tilt:
            rate = 1 / (site["trapped"] * time)  # damper over the inertia that it works on
            assembly.feedbacks.append(
                Feedback(
                    row,
                    row,
                    np.array([[-rate]]),
                    np.zeros(1),
                    np.array([rate]),
                    np.array([-damper]),
                    0.0,
                    damper,
                )
            )


_SOIL = {
    "translation_stiffness": "N/m", "tilt_stiffness": "N·m/rad", "damping_ratio": "",
    "vertical_over_horizontal": "",
}  # fmt: skip
_CENTRE = {"aside": "m, of the centre", "below": "m, of the centre"}
_BLOCK = {**_SOIL, **_CENTRE, "block_mass": "kg"}

DIRECTIONS: Effect = replace(
    OWN,
    form="directions",
    says="springs and dampers of the foundation each their own, about a centre beside the root",
    source="Gazetas, J. Geotech. Eng. 117 (1991) 1363: springs and dashpots of each mode of a footing",
    units={**_SOIL, **_CENTRE, "spread": "of the logarithms", "phase": "rad"},
    draw=_draw_directions,
    act=_act_directions,
)
BLOCK: Effect = replace(
    OWN,
    form="block",
    says="the robot stands on a block with a mass of its own",
    source="Richart, Hall and Woods, Vibrations of Soils and Foundations, Prentice-Hall 1970, chapter 10",
    units=_BLOCK,
    draw=_draw_block,
    check=positive("translation_stiffness", "tilt_stiffness", "vertical_over_horizontal", "below"),
    act=_act_block,
)
FEET: Effect = replace(
    OWN,
    form="feet",
    says="the robot stands on four feet, one of them worse than the others",
    source="Rivin, Passive Vibration Isolation, ASME Press 2003, chapter 1: machines on mounts",
    units={
        "foot_stiffness": "N/m, upright", "half_width": "m", "below": "m", "horizontal": "over upright",
        "worst": "stiffness of one foot over the others", "damping_ratio": "",
    },
    draw=_draw_feet,
    scaled=divided("foot_stiffness"),
    check=positive("foot_stiffness", "half_width", "horizontal", "worst"),
    act=_act_feet,
)  # fmt: skip
BOLTED: Effect = replace(
    BLOCK,
    form="bolted",
    says="bolts that give between the robot and a block on soil",
    source="Richart, Hall and Woods, as block; Ibrahim and Pettit, J. Sound and Vibration 279 (2005) 857",
    units={**_BLOCK, "bolts": "stiffness over the soil's"},
    draw=_draw_bolted,
    check=positive("translation_stiffness", "tilt_stiffness", "vertical_over_horizontal", "below", "bolts"),
    shape=_shape_bolted,
    act=_act_bolted,
)
RADIATING: Effect = replace(
    BLOCK,
    form="radiating",
    says="a block on soil that carries waves away",
    source="Wolf, Foundation Vibration Analysis Using Simple Physical Models, Prentice-Hall 1994 (cones)",
    units={**_BLOCK, "trapped": "inertia behind the damper of a tilt, over damper and period"},
    draw=_draw_radiating,
    check=positive("translation_stiffness", "tilt_stiffness", "vertical_over_horizontal", "below", "trapped"),
    act=_act_radiating,
)

FORMS = (DIRECTIONS, BLOCK, FEET, BOLTED, RADIATING)

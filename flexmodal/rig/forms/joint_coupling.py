"""Other mechanisms that tie two joints: a spring over a ratio, an idler, a belt, a rod, meshes, a hose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    drawing,
    each,
    either_sign,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.joint_coupling import EFFECT as OWN
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import commanded_joints, reach
from flexmodal.rig.plant.geometry import across
from flexmodal.rig.plant.plant import Branch


def _draw_ratio(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """About as stiff as the joints themselves, over a ratio that makes it count alike at both."""
    one, other = (stand.true.stiffness[name] for name in where.split("+"))
    return {
        "stiffness": float(random.uniform(0.2, 0.8) * one),
        "ratio": either_sign(random, 0.5, 1.6) * float(np.sqrt(other / one)),
    }


def _row(assembly: PlantAssembly, site: Site) -> np.ndarray:
    """q_A − r q_B."""
    one, other = site.where.split("+")
    return assembly.row(one) - site["ratio"] * assembly.row(other)


def _act_ratio(assembly: PlantAssembly, site: Site) -> None:
    assembly.add_spring(_row(assembly, site), site["stiffness"])


def _draw_damped(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A damper that is as stiff as its spring between the middle of the band and ten times that."""
    drawn, (low, high) = _draw_ratio(stand, where, random), stand.plan.band
    corner = 2 * np.pi * np.sqrt(low * high) * 10 ** random.uniform(0.0, 1.0)
    return {**drawn, "damping": float(drawn["stiffness"] / corner)}


def _act_damped(assembly: PlantAssembly, site: Site) -> None:
    assembly.add_spring(_row(assembly, site), site["stiffness"], site["damping"])


def _draw_belt(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn, (low, high) = _draw_ratio(stand, where, random), stand.plan.band
    corner = 2 * np.pi * np.exp(random.uniform(np.log(0.3), np.log(3.0))) * np.sqrt(low * high)
    return {**drawn, "relaxing": float(random.uniform(0.4, 1.0)), "time": float(1 / corner)}


def _act_belt(assembly: PlantAssembly, site: Site) -> None:
    row = _row(assembly, site)
    assembly.add_spring(row, site["stiffness"])
    assembly.branches.append(Branch(row, site["relaxing"] * site["stiffness"], site["time"]))


def _draw_idler(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """An idler between two springs that would swing on both from a third of the band to its end."""
    drawn, high = _draw_ratio(stand, where, random), stand.plan.band[1]
    k = 2 * drawn["stiffness"]
    omega = 2 * np.pi * float(np.exp(random.uniform(np.log(0.35 * high), np.log(1.0 * high))))
    inertia = 2 * k / omega**2
    return {
        **drawn,
        "stiffness": k,
        "inertia": inertia,
        "damping": float(2 * random.uniform(0.01, 0.05) * np.sqrt(2 * k * inertia) / 2),
    }


def _act_idler(assembly: PlantAssembly, site: Site) -> None:
    one, other = site.where.split("+")
    assembly.add_coordinates([f"{site.where} idler"])
    idler = assembly.row(f"{site.where} idler")
    assembly.add_inertia(idler, site["inertia"])
    for row in (assembly.row(one) - idler, idler - site["ratio"] * assembly.row(other)):
        assembly.add_spring(row, site["stiffness"], site["damping"])


def _draw_differential(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = _draw_ratio(stand, where, random)
    return {
        "stiffness": drawn["stiffness"],
        "ratio": abs(drawn["ratio"]),
        "second": float(np.exp(random.uniform(np.log(0.15), np.log(0.6)))),
        "loss": float(random.uniform(1e-4, 1e-3)),
    }


def _act_differential(assembly: PlantAssembly, site: Site) -> None:
    """Two bevel gears: one mesh gives with q_A + r q_B, the other with q_A − r q_B."""
    one, other = map(assembly.row, site.where.split("+"))
    for sign, part in ((1.0, 1.0), (-1.0, site["second"])):
        spring = part * site["stiffness"]
        assembly.add_spring(one + sign * site["ratio"] * other, spring, site["loss"] * spring)


def _neighbours(robot: Robot, points: Sequence[CampaignPoint]) -> tuple[str, ...]:
    """Joints that turn one after the other: from one link to the next, and from there to the third."""
    turning = [name for name in commanded_joints(robot) if not robot.urdf.joint_by_name[name].is_prismatic]
    order = list(commanded_joints(robot))
    return tuple(f"{one}+{other}" for one, other in pairwise(order) if one in turning and other in turning)


def _draw_rod(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Cranks of a fifth to two fifths of the link between the joints; as stiff at them as the first joint."""
    first = stand.robot.urdf.joint_by_name[where.split("+", maxsplit=1)[0]]
    between = max(float(np.linalg.norm(reach(stand.robot, first.child))), 0.1)
    crank = random.uniform(0.2, 0.4) * between
    k = random.uniform(0.3, 1.0) * min(stand.true.stiffness[name] for name in where.split("+"))
    return {
        "stiffness": float(k / crank**2),
        "crank": float(crank),
        "angle": float(random.uniform(0.0, 2 * np.pi)),
        "turn": float(random.uniform(-0.6, 0.6)),
    }


def _ends(assembly: PlantAssembly, site: Site) -> tuple[np.ndarray, np.ndarray]:
    """Of a rod from a crank on the link before the first joint to one on the link after the second.

    Returns:
        How the far end moves against the near one [3, coordinate], and the unit vector from this to that.
    """
    urdf = assembly.robot.urdf
    first, last = (urdf.joint_by_name[name] for name in site.where.split("+"))
    ends = []
    for joint, link, centre, angle in (
        (first, first.parent, np.asarray(first.xyz, dtype=float), site["angle"]),
        (last, last.child, np.zeros(3), site["angle"] + site["turn"]),
    ):
        axes = assembly.orientation(link)
        axis = axes.T @ assembly.orientation(joint.child) @ joint.axis
        one, other = across(axis / np.linalg.norm(axis), None)
        ends.append((link, centre + site["crank"] * (np.cos(angle) * one + np.sin(angle) * other)))
    places = [assembly.origin(link) + assembly.orientation(link) @ place for link, place in ends]
    way = places[1] - places[0]
    way = way / max(float(np.linalg.norm(way)), 1e-9)
    near, far = (assembly.motion(link, place)[:3] for link, place in ends)
    return far - near, way


def _act_rod(assembly: PlantAssembly, site: Site) -> None:
    moved, way = _ends(assembly, site)
    assembly.add_spring(way @ moved, site["stiffness"])


def _act_hose(assembly: PlantAssembly, site: Site) -> None:
    """Springs and dampers all three ways, the one along it apart."""
    moved, way = _ends(assembly, site)
    spring, time = site["stiffness"], site["damping_time"]
    assembly.add_spring(way @ moved, spring, time * spring)
    for side in across(way, None):
        assembly.add_spring(side @ moved, site["across"] * spring, time * site["across"] * spring)


_RATIO = {"stiffness": "N·m/rad, at the first joint", "ratio": "of the second joint to the first"}

RATIO: Effect = replace(
    OWN,
    form="ratio",
    says="a spring between one joint and a multiple of the other",
    source="Tsai, Robot Analysis, Wiley 1999, chapter 7: tendons and gears over several joints, KᵀSK",
    units=_RATIO,
    draw=_draw_ratio,
    scaled=multiplied("stiffness"),
    most=lambda parameters: 10.0,
    check=positive("stiffness"),
    act=_act_ratio,
)
DAMPED: Effect = replace(
    RATIO,
    form="damped",
    says="the same with a damper beside the spring",
    source="the ratio of Tsai; Flügge, Viscoelasticity, Springer 1975, chapter 1 (Kelvin solid)",
    units={**_RATIO, "damping": "N·m·s/rad"},
    draw=_draw_damped,
    scaled=multiplied("stiffness", "damping"),
    check=positive("stiffness", "damping"),
    act=_act_damped,
)
IDLER: Effect = replace(
    RATIO,
    form="idler",
    says="two springs with an idler between them",
    source="Tsai, Robot Analysis, Wiley 1999, chapter 7, an idler of the gear train kept with its inertia",
    units={**_RATIO, "inertia": "kg·m², of the idler", "damping": "N·m·s/rad, beside each spring"},
    draw=_draw_idler,
    scaled=multiplied("stiffness", "inertia", "damping"),
    check=positive("stiffness", "inertia"),
    act=_act_idler,
)
BELT: Effect = replace(
    RATIO,
    form="belt",
    says="a belt that creeps: a spring and a Maxwell element over a ratio",
    source="the ratio of Tsai; Flügge, Viscoelasticity, Springer 1975, chapter 1 (three-parameter solid)",
    units={**_RATIO, "relaxing": "stiffness that relaxes over the one that stays", "time": "s"},
    draw=_draw_belt,
    check=positive("stiffness", "time"),
    act=_act_belt,
)
ROD: Effect = replace(
    RATIO,
    form="rod",
    says="an elastic rod from a crank before the first joint to one after the second",
    source="Siciliano, Sciavicco, Villani and Oriolo, Robotics, Springer 2009, section 2.9 (parallelogram)",
    units={
        "stiffness": "N/m", "crank": "m", "angle": "rad, of the first crank", "turn": "rad, second to first",
    },
    places=_neighbours,
    place_is="a pair of joints that turn one after the other, jointA+jointB",
    draw=_draw_rod,
    check=positive("stiffness", "crank"),
    act=_act_rod,
)  # fmt: skip

DIFFERENTIAL: Effect = replace(
    RATIO,
    form="differential",
    says="a differential whose two meshes give differently",
    source="Tsai, Robot Analysis, Wiley 1999, chapter 7, bevel-gear wrists: KᵀSK with two springs",
    units={
        **_RATIO,
        "second": "stiffness of the second mesh over the first",
        "loss": "damper over spring, s",
    },
    draw=_draw_differential,
    check=positive("stiffness", "ratio", "second"),
    act=_act_differential,
)
HOSE: Effect = replace(
    ROD,
    form="hose",
    says="a stiff package of hoses from the link before two joints to the one after them",
    source="as rod, with springs across it too: a beam's end, Przemieniecki (as timoshenko), section 5.6",
    units={
        **ROD.units,
        "across": "stiffness across it over along",
        "damping_time": "damping over stiffness, s",
    },
    draw=drawing(_draw_rod, across=(0.1, 0.8), damping_time=(5e-4, 3e-3)),
    scaled=multiplied("stiffness"),
    check=each(positive("stiffness", "crank"), within(across=(0.0, 10.0), damping_time=(0.0, 1.0))),
    act=_act_hose,
)

FORMS = (RATIO, IDLER, DAMPED, BELT, ROD, DIFFERENTIAL, HOSE)

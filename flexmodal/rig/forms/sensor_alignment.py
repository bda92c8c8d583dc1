"""Other ways for a sensor to look elsewhere than recorded: across its axis, off its point, askew, swapped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.model.placements import link_placements
from flexmodal.rig.effects.effect import (
    Effect,
    Parameters,
    Site,
    Stand,
    drawing,
    either_sign,
    multiplied,
    within,
)
from flexmodal.rig.effects.sensors import SENSOR_MISALIGNMENT
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.sensing import Sensor

_AXIS = {"ax": "", "ay": "", "az": "unit vector, in the frame of the link"}
_CROSS = {
    "xy": "",
    "xz": "",
    "yx": "",
    "yz": "",
    "zx": "",
    "zy": "of what axis by which motion, over the angle",
}


def _mix(sensors: dict[str, Sensor], site: Site) -> None:
    """Each axis feels a part of the one that a quarter turn brings onto it, and loses nothing."""
    axis = site.vector("ax", "ay", "az")
    quarter = turn(axis, np.pi / 2) - np.outer(axis, axis)
    sensors[site.where].turned = (np.eye(3) + site["angle"] * quarter) @ sensors[site.where].turned


def _cross(sensors: dict[str, Sensor], site: Site) -> None:
    """Each axis feels parts of both others; an axis is a column."""
    mixed = np.eye(3)
    for name in _CROSS:
        mixed["xyz".index(name[1]), "xyz".index(name[0])] = site["angle"] * site[name]
    sensors[site.where].turned = mixed @ sensors[site.where].turned


def _draw_cross(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    others = {name: either_sign(random, 0.3, 1.0) for name in _CROSS}
    return {"angle": float(random.uniform(0.1, 0.4)), **others}


def _stand_off(sensors: dict[str, Sensor], site: Site) -> None:
    sensor, axis = sensors[site.where], site.vector("ax", "ay", "az")
    sensor.turned = turn(axis, site["angle"]) @ sensor.turned
    sensor.offset = sensor.offset + site.vector("x", "y", "z")


def _draw_stand_off(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A block that is 10 to 40 mm high, on a surface that slopes."""
    off = random.standard_normal(3)
    off *= random.uniform(0.01, 0.04) / np.linalg.norm(off)
    place = dict(zip("xyz", map(float, off), strict=True))
    return {**SENSOR_MISALIGNMENT.draw(stand, where, random), **place}


def _lean(sensors: dict[str, Sensor], site: Site) -> None:
    link = site.stand.link_of(site.where)
    axis, normal = site.vector("ax", "ay", "az"), site.stand.normal
    axis = axis if normal is None else np.sign(site.stand.normal_in(link) @ axis) * normal
    sensors[site.where].leaning = turn(axis, site["angle"]) @ sensors[site.where].leaning


def _skew(sensors: dict[str, Sensor], site: Site) -> None:
    """The three axes turn by different angles: they are no longer square to one another."""
    axis = site.vector("ax", "ay", "az")
    parts = (1.0, site["second"], site["third"])
    columns = [turn(axis, site["angle"] * part)[:, k] for k, part in enumerate(parts)]
    sensors[site.where].turned = np.stack(columns, axis=1) @ sensors[site.where].turned


def _draw_skew(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    others = drawing(second=(0.3, 1.2), third=(0.3, 1.2))(stand, where, random)
    return {**SENSOR_MISALIGNMENT.draw(stand, where, random), **others}


def _swap(sensors: dict[str, Sensor], site: Site) -> None:
    """Two of its cables are exchanged; the third axis stays, across the plane of a planar chain."""
    link = site.stand.link_of(site.where)
    normal = site.stand.normal_in(link)
    stays = int(site["stays"]) if normal is None else int(np.argmax(np.abs(normal)))
    order = np.arange(3)
    order[np.delete(order, stays)] = np.delete(order, stays)[::-1]
    sensors[site.where].turned = np.eye(3)[order] @ sensors[site.where].turned


def _follow(sensors: dict[str, Sensor], site: Site) -> None:
    """Turned along with its link by a part of what it turned since the first posture.

    Where readings are to be along the axes of the link, it stays behind by as much.
    """
    link, plan = site.stand.link_of(site.where), site.stand.plan
    first = link_placements(site.stand.robot, dict(plan.postures[0].q))[link][:3, :3]
    world = next(one for one in plan.points if one.name == site.where).frame == "world"
    sensors[site.where].following = (first, site["part"] if world else -site["part"])


def _least(parameters: Parameters) -> float:
    return 1.0 / max(abs(parameters["angle"]), 1e-9)


CROSS: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="cross",
    says="a sensor that also feels what goes across its axis",
    source="ISO 16063-31, transverse sensitivity",
    units={"angle": "transverse over axial sensitivity", **_AXIS},
    most=_least,
    sense=_mix,
)
STAND_OFF: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="stand_off",
    says="a sensor on a block, askew and off its point",
    source="ISO 5348, mechanical mounting of accelerometers",
    units={**SENSOR_MISALIGNMENT.units, "x": "m", "y": "m", "z": "m, off the point"},
    draw=_draw_stand_off,
    sense=_stand_off,
)
LEANING: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="leaning",
    says="a sensor set up by eye anew in each posture, leaning alike in the world",
    source="Ewins, Modal Testing, 2nd ed., section 3.5 (attachment and location of transducers)",
    sense=_lean,
)
SKEWED: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="skewed",
    says="a sensor whose axes are not square to one another",
    source="ISO 16063-31, transverse sensitivity, of three axes in one housing",
    units={
        **SENSOR_MISALIGNMENT.units,
        "second": "turn of the second axis, relative",
        "third": "of the third",
    },
    draw=_draw_skew,
    sense=_skew,
)

CROSS_AXIS: Effect = replace(
    CROSS,
    form="cross_axis",
    says="a sensor in one chip, whose axes feel one another unevenly",
    source="IEEE Std 2700, on the cross-axis sensitivity of sensors in one chip",
    units={"angle": "largest transverse over axial sensitivity", **_CROSS},
    draw=_draw_cross,
    check=within(angle=(-1.3, 1.3), **dict.fromkeys(_CROSS, (-1.0, 1.0))),
    sense=_cross,
)
SWAPPED: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="swapped",
    says="a sensor two of whose cables are exchanged",
    source="Ewins, Modal Testing, 2nd ed., section 3.5, on what goes wrong before a test",
    units={"stays": "number of the axis that stays"},
    draw=lambda stand, where, random: {"stays": float(random.integers(0, 3))},
    scaled=lambda parameters, s: dict(parameters),
    most=lambda parameters: 1.0,
    check=within(stays=(0.0, 2.0)),
    sense=_swap,
)
FOLLOWING: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="following",
    says="a sensor set anew by eye in each posture, not as far as its link has turned since the first",
    source="Ewins, as leaning; the rotation between two attitudes: Siciliano, Sciavicco, Villani and Oriolo, "
    "Robotics, Springer 2009, section 2.5",
    units={"part": "of the link's turn since the first posture"},
    draw=drawing(part=(0.15, 0.4)),
    scaled=multiplied("part"),
    most=lambda parameters: 1.0 / max(parameters["part"], 1e-9),
    check=within(part=(0.0, 1.0)),
    sense=_follow,
)

FORMS = (CROSS, STAND_OFF, LEANING, SKEWED, CROSS_AXIS, SWAPPED, FOLLOWING)

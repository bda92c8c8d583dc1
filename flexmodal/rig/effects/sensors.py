"""What sensors do to a measurement: weigh, read too much, lag, look askew, clip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.rig.effects.added_mass import arm_mass
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    directed,
    each,
    either_sign,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.sensing import Sensor
from flexmodal.structure.arm import moved_bodies


def points_that_move(robot: Robot, points: Sequence[CampaignPoint]) -> tuple[str, ...]:
    """Points with a sensor on links that move.

    Args:
        robot: which.
        points: all of them.
    """
    moved = moved_bodies(robot)
    return tuple(point.name for point in points if point.link in moved)


def _weigh(sensors: dict[str, Sensor], site: Site) -> None:
    for sensor in sensors.values():
        sensor.mass += site["mass"]


def _gain(sensors: dict[str, Sensor], site: Site) -> None:
    sensors[site.where].gain *= 1 + site["error"]


def _delay(sensors: dict[str, Sensor], site: Site) -> None:
    sensors[site.where].delay += site["delay"]


def _turn(sensors: dict[str, Sensor], site: Site) -> None:
    axis = site.vector("ax", "ay", "az")
    sensors[site.where].turned = turn(axis, site["angle"]) @ sensors[site.where].turned


def _draw_turn(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    axis = random.standard_normal(3)
    link = stand.link_of(where)
    normal = stand.normal_in(link)
    axis = axis if normal is None else normal
    axis = axis / np.linalg.norm(axis)
    angle = either_sign(random, np.radians(8), np.radians(25))
    return {"angle": angle, "ax": float(axis[0]), "ay": float(axis[1]), "az": float(axis[2])}


SENSOR_MASS = Effect(
    name="sensor_mass",
    says="the accelerometer's mass, which moves with it from point to point",
    units={"mass": "kg"},
    places=lambda robot, points: ("sensor",),
    place_is="the sensor",
    draw=lambda stand, where, random: {"mass": float(random.uniform(0.01, 0.05) * arm_mass(stand))},
    scaled=multiplied("mass"),
    check=positive("mass"),
    sense=_weigh,
)
SENSOR_GAIN = Effect(
    name="sensor_gain",
    says="a sensor calibrated wrongly",
    units={"error": "relative: 0.1 reads 10 % too much"},
    places=points_that_move,
    place_is="a point with a sensor",
    draw=lambda stand, where, random: {"error": either_sign(random, 0.1, 0.35)},
    scaled=multiplied("error"),
    most=lambda parameters: (2.0 if parameters["error"] > 0 else 0.7) / max(abs(parameters["error"]), 1e-9),
    check=within(error=(-0.9, 9.0)),
    sense=_gain,
)
TIME_DELAY = Effect(
    name="time_delay",
    says="a sensor that lags",
    units={"delay": "s"},
    places=points_that_move,
    place_is="a point with a sensor",
    draw=lambda stand, where, random: {"delay": float(random.uniform(0.02, 0.12) / stand.plan.band[1])},
    scaled=multiplied("delay"),
    most=lambda parameters: 0.01 / max(parameters["delay"], 1e-9),
    check=within(delay=(0.0, 0.02)),
    sense=_delay,
)
SENSOR_MISALIGNMENT = Effect(
    name="sensor_misalignment",
    says="a sensor, fixed to its link, that points elsewhere than recorded",
    units={"angle": "rad", "ax": "", "ay": "", "az": "axis of the turn, in the frame of the link"},
    places=points_that_move,
    place_is="a point with a sensor",
    draw=_draw_turn,
    scaled=multiplied("angle"),
    most=lambda parameters: 1.0 / max(abs(parameters["angle"]), 1e-9),
    check=each(directed("ax", "ay", "az"), within(angle=(-1.3, 1.3))),
    sense=_turn,
)

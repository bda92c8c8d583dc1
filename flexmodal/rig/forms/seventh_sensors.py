"""Seventh forms of what sensors do: a transmitter beside them, a warm-up, channels in a row, a knock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.rig.effects.effect import Effect, Site, Stand, each, multiplied, positive, within
from flexmodal.rig.effects.sensors import SENSOR_GAIN, SENSOR_MASS, SENSOR_MISALIGNMENT, TIME_DELAY
from flexmodal.rig.forms.sensor_mass import everywhere
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import heading
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.sensing import Sensor


def _draw_transmitter(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A box as heavy as the rig's own sensor, one to four times as heavy as what it sends for."""
    mass = SENSOR_MASS.draw(stand, where, random)["mass"]
    return {
        "mass": mass / float(random.uniform(1.0, 4.0)),
        "box_mass": mass,
        "apart": float(random.uniform(0.05, 0.2)),
        "size": float(random.uniform(0.04, 0.1)),
    }


def _transmitter(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The sensor on its point, and a cube on the same link, towards the link's near end."""
    place = np.array(point.xyz)
    assembly.add_body(point.link, place, site["mass"])
    cube = site["box_mass"] * site["size"] ** 2 / 6 * np.eye(3)
    back = place - site["apart"] * heading(site.stand.robot, point.link)
    assembly.add_body(point.link, back, site["box_mass"], cube)


def _draw_warm_up(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    error = SENSOR_GAIN.draw(stand, where, random)["error"]
    return {"error": 1.4 * error, "postures": float(random.uniform(0.8, 4.0))}


def _warm_up(sensors: dict[str, Sensor], site: Site) -> None:
    """1 + e exp(−n/n₀) in the posture n, counted from 0 on."""

    def later(sensor: Sensor, number: int) -> None:
        sensor.gain *= 1 + site["error"] * float(np.exp(-number / site["postures"]))

    sensors[site.where].later.append(later)


def _draw_scanned(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """The first axis a good deal after the hammer, the others a quarter to all of that later each."""
    delay = TIME_DELAY.draw(stand, where, random)["delay"]
    return {"delay": delay, "step": float(random.uniform(0.25, 1.0)) * delay}


def _scan(sensors: dict[str, Sensor], site: Site) -> None:
    """The first axis late by `delay`, each further one by `step` more."""
    sensors[site.where].delay += site["delay"]
    sensors[site.where].step += site["step"]


def _draw_knocked(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {**SENSOR_MISALIGNMENT.draw(stand, where, random), "when": float(random.uniform(0.2, 0.8))}


def knocked_at(when: float, count: int) -> int:
    """The first posture after the knock, counted from 0 on; between two postures, where there are two.

    Args:
        when: part of the test that is over.
        count: of the postures.
    """
    return min(max(round(when * count), 1), count - 1)


def _knock(sensors: dict[str, Sensor], site: Site) -> None:
    """As it should be at first, then turned on its link."""
    axis, first = site.vector("ax", "ay", "az"), knocked_at(site["when"], len(site.stand.plan.postures))

    def later(sensor: Sensor, number: int) -> None:
        if number >= first:
            sensor.turned = turn(axis, site["angle"]) @ sensor.turned

    sensors[site.where].later.append(later)


TRANSMITTER: Effect = replace(
    SENSOR_MASS,
    form="transmitter",
    says="a wireless sensor whose box, with battery and transmitter, is strapped to the link beside it and "
    "moves on with it",
    source="Lynch and Loh, Shock and Vibration Digest 38 (2006) 91 (wireless sensors and what they are built "
    "of); Ewins, Modal Testing, 2nd ed., section 3.5",
    units={
        "mass": "kg, of the sensor",
        "box_mass": "kg",
        "apart": "m, from the sensor back along the link",
        "size": "m, of the box",
    },
    draw=_draw_transmitter,
    scaled=multiplied("mass", "box_mass"),
    check=each(positive("mass", "box_mass"), within(apart=(0.0, 10.0), size=(0.0, 10.0))),
    sense=everywhere(_transmitter),
)
WARM_UP: Effect = replace(
    SENSOR_GAIN,
    form="warm_up",
    says="a sensor that was not given time to warm up: it reads wrongly at first, and less so from posture "
    "to posture",
    source="Fraden, Handbook of Modern Sensors, 3rd ed., Springer 2004, chapter 2 (warm-up time); ISO "
    "16063-34, on sensitivity at other temperatures",
    units={"error": "relative, in the first posture", "postures": "after how many it is an e-th of that"},
    draw=_draw_warm_up,
    check=each(SENSOR_GAIN.check, within(postures=(0.05, 1e6))),
    sense=_warm_up,
)
SCANNED: Effect = replace(
    TIME_DELAY,
    form="scanned",
    says="a sensor on a converter that takes its channels in turn: the hammer first, then one axis after the "
    "other, each later than the one before",
    source="Austerlitz, Data Acquisition Techniques Using PCs, 2nd ed., Academic Press 2003, on multiplexers "
    "and the skew of their channels; Brandt, Noise and Vibration Analysis, Wiley 2011, chapter 11",
    units={"delay": "s, of the first axis", "step": "s, how much later each further axis is"},
    draw=_draw_scanned,
    scaled=multiplied("delay", "step"),
    check=each(TIME_DELAY.check, within(step=(0.0, 0.02))),
    sense=_scan,
)
KNOCKED: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="knocked",
    says="a sensor that somebody knocks between two postures: right before that, askew afterwards",
    source="ISO 5348, on mountings that are not firm; McConnell and Varoto, Vibration Testing, 2nd ed., "
    "Wiley 2008, chapter 4, on how accelerometers are attached",
    units={**SENSOR_MISALIGNMENT.units, "when": "part of the test that is over by then"},
    draw=_draw_knocked,
    check=each(SENSOR_MISALIGNMENT.check, within(when=(0.0, 1.0))),
    sense=_knock,
)

FORMS = (TRANSMITTER, WARM_UP, SCANNED, KNOCKED)

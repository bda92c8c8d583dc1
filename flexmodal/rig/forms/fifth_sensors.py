"""Fifth forms of what sensors do: several at once, a filter that droops, a drifting clock, a loose stud."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, each, positive, within
from flexmodal.rig.effects.sensors import SENSOR_GAIN, SENSOR_MASS, SENSOR_MISALIGNMENT, TIME_DELAY
from flexmodal.rig.forms.sensor_mass import everywhere
from flexmodal.rig.forms.sensors import filtering
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.sensing import Filter, Sensor


def _draw_in_sets(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Two to four of them, each a half to all of the rig's own."""
    mass = SENSOR_MASS.draw(stand, where, random)["mass"]
    return {"mass": float(random.uniform(0.5, 1.0)) * mass, "together": float(random.integers(2, 5))}


def _in_sets(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """Whatever point is measured, its neighbours in the plan carry a sensor too: one set after the other."""
    points, size = site.stand.plan.points, int(site["together"])
    number = next(k for k, one in enumerate(points) if one.name == point.name)
    first = number - number % size
    for one in points[first : first + size]:
        assembly.add_body(one.link, np.array(one.xyz), site["mass"])


def _draw_droop(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """It leaves 45 to 75 % at the band's end, or nearly so: ln sinc x is about −(π x)²/6."""
    order, left = float(random.integers(3, 6)), float(random.uniform(0.45, 0.75))
    part = float(np.sqrt(-6 * np.log(left) / order)) / np.pi
    return {"null": stand.plan.band[1] / part, "order": order}


def _droop(site: Site) -> Filter:
    """(sin x/x)ᴺ with x = π f/f₀; its delay is known and was taken out."""
    return lambda omega: np.sinc(omega / (2 * np.pi * site["null"])) ** int(site["order"])


def _drift(sensors: dict[str, Sensor], site: Site) -> None:
    """By as much more in each posture, up to `delay` in the last."""
    count = len(site.stand.plan.postures)

    def later(sensor: Sensor, number: int) -> None:
        sensor.delay += site["delay"] * (number + 1) / count

    sensors[site.where].later.append(later)


def _loosen(sensors: dict[str, Sensor], site: Site) -> None:
    """By as much more in each posture, up to `angle` in the last."""
    axis, count = site.vector("ax", "ay", "az"), len(site.stand.plan.postures)

    def later(sensor: Sensor, number: int) -> None:
        sensor.turned = turn(axis, site["angle"] * (number + 1) / count) @ sensor.turned

    sensors[site.where].later.append(later)


def _draw_loosening(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = SENSOR_MISALIGNMENT.draw(stand, where, random)
    return {**drawn, "angle": 1.6 * drawn["angle"]}


IN_SETS: Effect = replace(
    SENSOR_MASS,
    form="in_sets",
    says="several sensors that move on together: while one point is measured, its neighbours carry one too",
    source="Ewins, Modal Testing, 2nd ed., section 3.5 (mass loading as transducers rove); Cakar and "
    "Sanliturk, Mechanical Systems and Signal Processing 19 (2005) 87 (its removal)",
    units={"mass": "kg, of each", "together": "how many"},
    draw=_draw_in_sets,
    check=each(positive("mass"), within(together=(1.0, 100.0))),
    sense=everywhere(_in_sets),
)
DROOP: Effect = replace(
    SENSOR_GAIN,
    form="droop",
    says="a sensor behind a converter whose droop nobody equalised: it reads less and less towards the "
    "band's end, in phase",
    source="Hogenauer, IEEE Trans. Acoustics, Speech and Signal Processing 29 (1981) 155, on the droop of "
    "decimating filters in the band",
    units={"null": "Hz, where nothing is left", "order": "how many running means"},
    draw=_draw_droop,
    scaled=divided("null"),
    most=lambda parameters: 2.0,
    check=each(positive("null"), within(order=(1.0, 8.0))),
    sense=filtering(_droop),
)
DRIFTING: Effect = replace(
    TIME_DELAY,
    form="drifting",
    says="a wireless sensor on a clock of its own, set at the start: it is later from posture to posture",
    source="Krishnamurthy, Fowler and Sazonov, Smart Materials and Structures 17 (2008) 055018 (wireless "
    "sensors whose clocks differ in modal tests)",
    units={"delay": "s, in the last posture"},
    draw=lambda stand, where, random: {"delay": 1.6 * TIME_DELAY.draw(stand, where, random)["delay"]},
    sense=_drift,
)
LOOSENING: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="loosening",
    says="a sensor whose stud comes loose: from posture to posture it has turned farther on its link",
    source="ISO 5348, on torque and studs; Junker, SAE Transactions 78 (1969) 314 (fasteners that vibration "
    "loosens)",
    units={"angle": "rad, in the last posture", "ax": "", "ay": "", "az": "axis of the stud, on the link"},
    draw=_draw_loosening,
    sense=_loosen,
)

FORMS = (IN_SETS, DROOP, DRIFTING, LOOSENING)

"""Sixth forms of what sensors do: pads on every point, a weak battery, a late start, play in a clip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model.placements import link_placements
from flexmodal.rig.effects.effect import Effect, Site, Stand, directed, each, multiplied, positive, within
from flexmodal.rig.effects.sensors import SENSOR_GAIN, SENSOR_MASS, SENSOR_MISALIGNMENT, TIME_DELAY
from flexmodal.rig.forms.sensor_mass import everywhere
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.sensing import Sensor

MOST_DROP = 0.8
"""Of a sensitivity, what a battery may take."""
GOLDEN = 0.6180339887498949
"""By which one start comes later than the one before, as a part of the longest wait and beyond that again."""


def _draw_pads(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A sensor as the rig's own, on pads that weigh a fifth to three fifths of it."""
    mass = SENSOR_MASS.draw(stand, where, random)["mass"]
    return {"mass": mass, "pad_mass": float(random.uniform(0.2, 0.6)) * mass}


def _pads(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The sensor where it is, and a pad on every point of the plan all the time."""
    assembly.add_body(point.link, np.array(point.xyz), site["mass"])
    for one in site.stand.plan.points:
        assembly.add_body(one.link, np.array(one.xyz), site["pad_mass"])


def _draw_battery(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {"drop": float(random.uniform(0.2, 0.5)), "bend": float(random.uniform(0.8, 2.5))}


def _battery(sensors: dict[str, Sensor], site: Site) -> None:
    """By `drop` too little in the last posture, before that by a power of how much of the test is over."""
    count = len(site.stand.plan.postures)

    def later(sensor: Sensor, number: int) -> None:
        sensor.gain *= 1 - site["drop"] * ((number + 1) / count) ** site["bend"]

    sensors[site.where].later.append(later)


def _draw_restarted(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = TIME_DELAY.draw(stand, where, random)
    return {"delay": 2.0 * drawn["delay"], "first": float(random.uniform(0.0, 1.0))}


def _restart(sensors: dict[str, Sensor], site: Site) -> None:
    """In each posture another part of the longest wait: `first`, then by the golden ratio more, modulo 1."""

    def later(sensor: Sensor, number: int) -> None:
        sensor.delay += site["delay"] * ((site["first"] + GOLDEN * number) % 1.0)

    sensors[site.where].later.append(later)


def _draw_clip(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """It stands out of its clip across the pin about which it has play."""
    drawn = SENSOR_MISALIGNMENT.draw(stand, where, random)
    axis = np.array([drawn["ax"], drawn["ay"], drawn["az"]])
    out = np.cross(axis, random.standard_normal(3))
    out = out / np.linalg.norm(out)
    return {
        **drawn,
        "angle": abs(drawn["angle"]),
        "ox": float(out[0]),
        "oy": float(out[1]),
        "oz": float(out[2]),
    }


def _clip(sensors: dict[str, Sensor], site: Site) -> None:
    """It lies at that end of its play, ±α, to which its weight turns it: (o × down)·a says which."""
    link, axis, out = (
        site.stand.link_of(site.where),
        site.vector("ax", "ay", "az"),
        site.vector("ox", "oy", "oz"),
    )
    turns = []
    for posture in site.stand.plan.postures:
        axes = link_placements(site.stand.robot, dict(posture.q))[link][:3, :3]
        pulled = float(np.cross(out, -axes[2]) @ axis)
        turns.append((axes, turn(axis, site["angle"] if pulled >= 0 else -site["angle"])))
    sensors[site.where].resets = tuple(turns)


PADS: Effect = replace(
    SENSOR_MASS,
    form="pads",
    says="a sensor that moves on, and pads for it that stay glued to every point",
    source="ISO 5348, on cemented studs and mounting pads; Ewins, Modal Testing, 2nd ed., section 3.5",
    units={"mass": "kg, of the sensor", "pad_mass": "kg, of each pad"},
    draw=_draw_pads,
    scaled=multiplied("mass", "pad_mass"),
    check=positive("mass", "pad_mass"),
    sense=everywhere(_pads),
)
BATTERY: Effect = replace(
    SENSOR_GAIN,
    form="battery",
    says="a sensor whose sensitivity goes with its supply, on a battery that runs down: it reads less from "
    "posture to posture, and that ever faster",
    source="Wilson, ed., Sensor Technology Handbook, Newnes 2005 (ratiometric outputs); Linden and Reddy, "
    "Handbook of Batteries, 3rd ed., McGraw-Hill 2002 (discharge curves)",
    units={"drop": "part of the sensitivity that is gone in the last posture", "bend": "power of the time"},
    draw=_draw_battery,
    scaled=multiplied("drop"),
    most=lambda parameters: MOST_DROP / max(parameters["drop"], 1e-9),
    check=within(drop=(0.0, MOST_DROP + 1e-9), bend=(0.1, 10.0)),
    sense=_battery,
)
RESTARTED: Effect = replace(
    TIME_DELAY,
    form="restarted",
    says="a wireless sensor that is started anew in each posture, each time after another wait",
    source="Lynch and Loh, Shock and Vibration Digest 38 (2006) 91 (wireless sensors, their synchronisation)",
    units={"delay": "s, the longest", "first": "part of it in the first posture"},
    draw=_draw_restarted,
    check=each(within(first=(0.0, 1.0)), TIME_DELAY.check),
    sense=_restart,
)
CLIP: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="clip",
    says="a sensor with play in its clip, which lies to whichever side is down",
    source="ISO 5348, on clips and on mountings that are not firm; Ewins, Modal Testing, 2nd ed., section "
    "3.5 (attachment and location of transducers)",
    units={
        "angle": "rad, of play to either side",
        "ax": "", "ay": "", "az": "axis of the play, on the link",
        "ox": "", "oy": "", "oz": "from there to the sensor's mass, on the link",
    },
    draw=_draw_clip,
    check=each(SENSOR_MISALIGNMENT.check, directed("ox", "oy", "oz")),
    sense=_clip,
)  # fmt: skip

FORMS = (PADS, BATTERY, RESTARTED, CLIP)

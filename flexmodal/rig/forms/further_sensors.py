"""Further forms of what sensors do: held by hand, behind a hum filter, with a delay taken out, on a tube."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    drawing,
    each,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.sensors import SENSOR_GAIN, SENSOR_MASS, SENSOR_MISALIGNMENT
from flexmodal.rig.forms.sensor_mass import everywhere
from flexmodal.rig.forms.sensors import LOW_PASS, filtering
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import across, turn
from flexmodal.rig.sensing import Filter, Sensor

DEEPEST = 0.99
"""Of a notch, as a part of what comes in."""


def _held(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The sensor moves with the surface; the hand behind it is a mass on soft, well damped flesh."""
    place = np.array(point.xyz)
    assembly.add_body(point.link, place, site["mass"])
    names, rows = [f"hand {axis}" for axis in "xyz"], assembly.motion(point.link, place)[:3]
    assembly.add_on_springs(names, rows, site["hand_mass"], site["frequency"], site["damping_ratio"])


def _draw_held(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A hand that weighs a half to twice what the sensor does."""
    drawn = drawing(SENSOR_MASS.draw, frequency=(10.0, 40.0), damping_ratio=(0.3, 0.8))(stand, where, random)
    return {**drawn, "hand_mass": float(random.uniform(0.5, 2.0)) * drawn["mass"]}


def _hum(site: Site) -> Filter:
    """1 − d · 2 ζ ω₀ s/(s² + 2 ζ ω₀ s + ω₀²): 1 − d at the mains' frequency, 1 far from it."""
    mains, wide = 2 * np.pi * site["frequency"], 2 * site["width"]

    def told(omega: np.ndarray) -> np.ndarray:
        passed = 1j * wide * mains * omega
        return np.asarray(1 - site["depth"] * passed / (mains**2 - omega**2 + passed))

    return told


def _draw_hum(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = drawing(width=(0.1, 0.4), depth=(0.3, 0.8))(stand, where, random)
    return {"frequency": float(random.choice([50.0, 60.0])), **drawn}


def _taken_out(site: Site) -> Filter:
    """e^{iωcτ}/(1 + iωτ): right for c = 1 while it is slow, early beyond."""
    time = site["time"]
    return lambda omega: np.exp(1j * omega * site["taken_out"] * time) / (1 + 1j * omega * time)


def _move_round(sensors: dict[str, Sensor], site: Site) -> None:
    """Farther round a tube than marked: the sensor looks another way, and its place moves along the arc."""
    axis, sensor = site.vector("ax", "ay", "az"), sensors[site.where]
    axis = axis / np.linalg.norm(axis)
    turned = turn(axis, site["angle"])
    outward = turn(axis, site["phase"]) @ across(axis, None)[0]
    sensor.turned = turned @ sensor.turned
    sensor.offset = sensor.offset + site["radius"] * (turned @ outward - outward)


HELD: Effect = replace(
    SENSOR_MASS,
    form="held",
    says="a sensor that is pressed on by hand: its own mass, and the hand behind it",
    source="ISO 10068, mechanical impedance of the human hand-arm system; ISO 5348, on hand-held probes",
    units={
        "mass": "kg, of the sensor",
        "frequency": "Hz, of the hand on a surface held still",
        "damping_ratio": "",
        "hand_mass": "kg, of the hand that moves along",
    },
    draw=_draw_held,
    scaled=multiplied("mass", "hand_mass"),
    check=positive("mass", "hand_mass", "frequency", "damping_ratio"),
    sense=everywhere(_held),
)
HUM: Effect = replace(
    SENSOR_GAIN,
    form="hum",
    says="a sensor on an amplifier whose hum filter was left on: it reads too little about the mains",
    source="Horowitz and Hill, The Art of Electronics, 3rd ed., Cambridge 2015, chapter 6 (notch filters)",
    units={"frequency": "Hz, of the mains", "width": "damping ratio", "depth": "part that is taken away"},
    draw=_draw_hum,
    scaled=multiplied("depth"),
    most=lambda parameters: DEEPEST / max(parameters["depth"], 1e-9),
    check=each(positive("frequency", "width"), within(depth=(0.0, DEEPEST + 1e-9))),
    sense=filtering(_hum),
)
TAKEN_OUT: Effect = replace(
    LOW_PASS,
    form="taken_out",
    says="a sensor behind a low-pass, whose delay was taken out with too large a number",
    source="Brandt, Noise and Vibration Analysis, Wiley 2011, chapter 11, on phase match of channels",
    units={"time": "s, of the low-pass", "taken_out": "delay that was taken out, over that"},
    draw=drawing(LOW_PASS.draw, taken_out=(1.6, 2.6)),
    most=lambda parameters: 0.02 / max(parameters["time"] * parameters["taken_out"], 1e-9),
    check=each(LOW_PASS.check, within(taken_out=(0.0, 4.0))),
    sense=filtering(_taken_out),
)
ROUND: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="round",
    says="a sensor that sits farther round a tube than marked: it looks and moves another way",
    source="ISO 5348, mechanical mounting of accelerometers; Ewins, Modal Testing, 2nd ed., section 3.5",
    units={
        **SENSOR_MISALIGNMENT.units,
        "radius": "m, of the tube",
        "phase": "rad, of the marked point round it",
    },
    draw=drawing(SENSOR_MISALIGNMENT.draw, radius=(0.05, 0.2), phase=(0.0, 2 * np.pi)),
    check=each(SENSOR_MISALIGNMENT.check, positive("radius")),
    sense=_move_round,
)

FORMS = (HELD, HUM, TAKEN_OUT, ROUND)

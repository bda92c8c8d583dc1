"""Fourth forms of what sensors do: a box on the cable, a tall adapter, a long line, a sensor reset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.model.placements import link_placements
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
from flexmodal.rig.forms.added_mass import GRAVITY
from flexmodal.rig.forms.sensor_mass import everywhere
from flexmodal.rig.forms.sensors import LOW_PASS, filtering
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.sensing import Filter, Sensor

MOST_ROCKING = 0.95
"""Of a reading, what an adapter that rocks may take."""


def _draw_converter(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A box that weighs a half to twice what the sensor does, on a cable that gives within the band."""
    drawn = drawing(SENSOR_MASS.draw, length=(0.2, 0.8), damping_ratio=(0.03, 0.15))(stand, where, random)
    return {
        **drawn,
        "box_mass": float(random.uniform(0.5, 2.0)) * drawn["mass"],
        "frequency": float(np.exp(random.uniform(np.log(0.1), np.log(0.5)))) * stand.plan.band[1],
    }


def _converter(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The sensor, and a box below it: up and down on its cable as a spring, sideways a pendulum."""
    place, box, ratio = np.array(point.xyz), site["box_mass"], site["damping_ratio"]
    assembly.add_body(point.link, place, site["mass"])
    moved = assembly.motion(point.link, place)[:3]
    swings = float(np.sqrt(GRAVITY / site["length"])) / (2 * np.pi)
    assembly.add_on_springs(["box x", "box y"], moved[:2], box, swings, ratio)
    assembly.add_on_springs(["box z"], moved[2:], box, site["frequency"], ratio)


def _draw_adapter(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = drawing(share=(0.2, 0.6), damping_ratio=(0.05, 0.2))(stand, where, random)
    return {**drawn, "resonance": float(random.uniform(0.3, 0.9)) * stand.plan.band[1]}


def _adapter(site: Site) -> Filter:
    """1 + ε r²/(1 − r² + 2 i ζ r), r = ω/ω₀: J θ̈ + c θ̇ + k θ = −m h a read at e."""
    own = 2 * np.pi * site["resonance"]

    def told(omega: np.ndarray) -> np.ndarray:
        over = omega / own
        return np.asarray(1 + site["share"] * over**2 / (1 - over**2 + 2j * site["damping_ratio"] * over))

    return told


def _long_line(site: Site) -> Filter:
    """1/cosh √(iω R C) of a line that is open at its end; late by τ = R C/2 while it is slow."""
    return lambda omega: 1 / np.cosh(np.sqrt(2j * omega * site["time"]))


def _draw_reset(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    angle = float(random.uniform(np.radians(8), np.radians(25)))
    return {"angle": angle, "throw": float(random.integers(1, 2**31))}


def _reset(sensors: dict[str, Sensor], site: Site) -> None:
    """In each posture a turn of its own: α n/√3 with n normal each way; α n about the normal of a plane.

    Where its link stands as it did in an earlier one, it is set as it was then.
    """
    link = site.stand.link_of(site.where)
    normal, turns = site.stand.normal_in(link), []
    for number, posture in enumerate(site.stand.plan.postures):
        thrown = np.random.default_rng([int(site["throw"]), number]).standard_normal(3)
        vector = site["angle"] * (thrown / np.sqrt(3) if normal is None else thrown[0] * normal)
        axes = link_placements(site.stand.robot, dict(posture.q))[link][:3, :3]
        turns.append((axes, turn(vector, float(np.linalg.norm(vector)))))
    sensors[site.where].resets = tuple(turns)


CONVERTER: Effect = replace(
    SENSOR_MASS,
    form="converter",
    says="a sensor from whose cable a box of electronics hangs: sideways it stays behind, upright it bounces",
    source="Serridge and Licht, Piezoelectric Accelerometers and Vibration Preamplifiers, Brüel & Kjær 1987, "
    "on charge converters in the cable; Den Hartog, Mechanical Vibrations, 4th ed., chapter 2",
    units={
        "mass": "kg, of the sensor",
        "length": "m, of cable from the sensor to the box",
        "damping_ratio": "of the box both ways",
        "box_mass": "kg",
        "frequency": "Hz, of the box up and down below a sensor held still",
    },
    draw=_draw_converter,
    scaled=multiplied("mass", "box_mass"),
    check=each(positive("mass", "box_mass", "length", "frequency"), within(damping_ratio=(0.0, 1.0))),
    sense=everywhere(_converter),
)
ADAPTER: Effect = replace(
    SENSOR_GAIN,
    form="adapter",
    says="a sensor on a tall adapter that rocks on its glue within the band: it reads more below that, less "
    "above",
    source="ISO 5348, mechanical mounting of accelerometers; Den Hartog, Mechanical Vibrations, 4th ed., "
    "chapter 2 (motion of the support)",
    units={
        "share": "m h e/J: by how much it reads less where it rocks freely",
        "resonance": "Hz, of the adapter that rocks",
        "damping_ratio": "",
    },
    draw=_draw_adapter,
    scaled=multiplied("share"),
    most=lambda parameters: MOST_ROCKING / max(parameters["share"], 1e-9),
    check=each(positive("resonance"), within(share=(0.0, MOST_ROCKING + 1e-9), damping_ratio=(0.005, 1.0))),
    sense=filtering(_adapter),
)
LONG_LINE: Effect = replace(
    LOW_PASS,
    form="long_line",
    says="a sensor at the far end of a long line, whose resistance and capacitance lie along it",
    source="Elmore, J. Applied Physics 19 (1948) 55 (delays of wide-band networks)",
    units={"time": "s, by which it lags while it is slow"},
    sense=filtering(_long_line),
)
RESET: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="reset",
    says="a sensor that is taken off and set anew in each posture, by eye: another turn each time",
    source="Ewins, Modal Testing, 2nd ed., section 3.5 (attachment and location of transducers)",
    units={"angle": "rad, root mean square", "throw": "number that the turns are drawn from"},
    draw=_draw_reset,
    check=within(angle=(0.0, 1.3), throw=(0.0, 2.0**31)),
    sense=_reset,
)

FORMS = (CONVERTER, ADAPTER, LONG_LINE, RESET)

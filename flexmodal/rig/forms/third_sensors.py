"""Third forms of what sensors do: a cable that whips, a correction too many, values between, sagging."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.rig.effects.effect import (
    Effect,
    Site,
    Stand,
    directed,
    divided,
    drawing,
    each,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.sensors import SENSOR_GAIN, SENSOR_MASS, SENSOR_MISALIGNMENT
from flexmodal.rig.forms.local_absorber import WHIP
from flexmodal.rig.forms.sensor_mass import everywhere
from flexmodal.rig.forms.sensors import LOW_PASS, filtering
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import heading
from flexmodal.rig.plant.geometry import across
from flexmodal.rig.sensing import Filter, Sensor

_NORMAL = ("nx", "ny", "nz")


def _draw_whipping(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A cable whose free end weighs a half to one and a half times what the sensor does."""
    drawn = drawing(SENSOR_MASS.draw, length=(0.05, 0.25), damping_ratio=(0.02, 0.08))(stand, where, random)
    return {
        **drawn,
        "cable_mass": float(random.uniform(0.5, 1.5)) * drawn["mass"],
        "frequency": float(np.exp(random.uniform(np.log(0.1), np.log(0.5)))) * stand.plan.band[1],
    }


def _whipping(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The sensor, and a thin beam that stands out of it along the link: two modes across, the rest stiff."""
    link, place, mass = point.link, np.array(point.xyz), site["cable_mass"]
    axes, axis = assembly.orientation(link), heading(site.stand.robot, point.link)
    normal = None if assembly.normal is None else axes.T @ assembly.normal
    assembly.add_body(link, place, site["mass"])
    left = 1 - sum(part for _, part, _ in WHIP)
    height = (0.5 - sum(part * high for _, part, high in WHIP)) / left

    def moved(over: float) -> np.ndarray:
        return assembly.motion(link, place + over * site["length"] * axis)[:3]

    assembly.add_inertia((axes @ axis) @ moved(0.0), mass)
    for number, side in enumerate(across(axis, normal), start=1):
        way = axes @ side
        assembly.add_inertia(way @ moved(height), left * mass)
        for times, part, high in WHIP:
            rows = (way @ moved(high))[None]
            frequency = times * site["frequency"]
            name = f"cable {number} of {times:g}"
            assembly.add_on_springs([name], rows, part * mass, frequency, site["damping_ratio"])


def _equalised(site: Site) -> Filter:
    """1 − r² + 2 i ζ r with r = ω/ω₀: what would straighten a sensor that resonates at ω₀."""
    own = 2 * np.pi * site["resonance"]
    return lambda omega: 1 - (omega / own) ** 2 + 2j * site["damping_ratio"] * omega / own


def _interpolated(site: Site) -> Filter:
    """(1 − d) + d e^{−iωΔ}, Δ from value to value: on the straight line through the last two; late by d Δ."""
    part = site["part"]
    step = site["time"] / part
    return lambda omega: 1 - part + part * np.exp(-1j * omega * step)


def _draw_sagging(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A sensor that stands out of its link sideways; in the plane of a planar chain."""
    link = stand.link_of(where)
    axis = heading(stand.robot, link)
    sides, angle = across(axis, stand.normal_in(link)), float(random.uniform(0.0, 2 * np.pi))
    if len(sides) == 2:
        out = np.cos(angle) * sides[0] + np.sin(angle) * sides[1]
    else:
        out = (sides[0] if sides else axis) * (1.0 if angle < np.pi else -1.0)
    sagging = {"angle": float(random.uniform(np.radians(10), np.radians(30)))}
    return sagging | dict(zip(_NORMAL, map(float, out), strict=True))


def _sag(sensors: dict[str, Sensor], site: Site) -> None:
    """The weight of its cable turns the sensor about n × g; α is how far where n is level."""
    out = site.vector(*_NORMAL)
    sensor = sensors[site.where]
    sensor.sagging = sensor.sagging + site["angle"] * out / np.linalg.norm(out)


WHIPPING: Effect = replace(
    SENSOR_MASS,
    form="whipping",
    says="a sensor whose cable leaves it as a thin beam and whips within the band",
    source="Serridge and Licht, Piezoelectric Accelerometers and Vibration Preamplifiers, Brüel & Kjær 1987, "
    "on cables that whip; Géradin and Rixen, Mechanical Vibrations, 3rd ed., section 4.3 (clamped beam)",
    units={
        "mass": "kg, of the sensor",
        "length": "m, of cable that is free",
        "damping_ratio": "",
        "cable_mass": "kg, of that length",
        "frequency": "Hz, of it on a surface held still",
    },
    draw=_draw_whipping,
    scaled=multiplied("mass", "cable_mass"),
    check=each(positive("mass", "cable_mass", "length", "frequency"), within(damping_ratio=(0.0, 1.0))),
    sense=everywhere(_whipping),
)
EQUALISED: Effect = replace(
    SENSOR_GAIN,
    form="equalised",
    says="a sensor from which a resonance was taken out that it does not have",
    source="Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., Pearson 2010, chapter 5 "
    "(inverse systems); ISO 5348 for the resonance",
    units={"resonance": "Hz", "damping_ratio": ""},
    draw=lambda stand, where, random: {
        "resonance": float(random.uniform(1.5, 4.0)) * stand.plan.band[1],
        "damping_ratio": float(random.uniform(0.02, 0.1)),
    },
    scaled=divided("resonance"),
    most=lambda parameters: 3.0,
    check=positive("resonance", "damping_ratio"),
    sense=filtering(_equalised),
)
INTERPOLATED: Effect = replace(
    LOW_PASS,
    form="interpolated",
    says="a sensor on a clock of its own: what is read lies on a straight line through its last two values",
    source="Laakso, Välimäki, Karjalainen and Laine, IEEE Signal Processing Magazine 13 (1996) 30 "
    "(fractional delays)",
    units={"time": "s, by which it lags", "part": "of the way back to the value before"},
    draw=drawing(LOW_PASS.draw, part=(0.35, 0.8)),
    check=each(LOW_PASS.check, within(part=(0.01, 1.0))),
    sense=filtering(_interpolated),
)
SAGGING: Effect = replace(
    SENSOR_MISALIGNMENT,
    form="sagging",
    says="a sensor on putty, which its cable pulls down: it turns the farther, the more level it stands out",
    source="ISO 5348, on soft mountings and cables; a weight at a lever on a spring that turns, Den Hartog, "
    "Mechanical Vibrations, 4th ed., chapter 2",
    units={
        "angle": "rad, where it stands out level",
        "nx": "", "ny": "", "nz": "how it stands out, in the frame of the link",
    },
    draw=_draw_sagging,
    check=each(directed(*_NORMAL), within(angle=(0.0, 1.3))),
    sense=_sag,
)  # fmt: skip

FORMS = (WHIPPING, EQUALISED, INTERPOLATED, SAGGING)

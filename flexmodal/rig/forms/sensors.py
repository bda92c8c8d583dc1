"""Other ways for a sensor to weigh, to read wrongly, to lag and to look askew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import (
    Draw,
    Effect,
    Parameters,
    Site,
    Stand,
    divided,
    drawing,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.sensors import SENSOR_GAIN, SENSOR_MISALIGNMENT, TIME_DELAY
from flexmodal.rig.plant.geometry import turn
from flexmodal.rig.sensing import Filter, Sensor

_AXIS = {"ax": "", "ay": "", "az": "unit vector, in the frame of the link"}


def _filtering(made: Callable[[Site], Filter]) -> Callable[[dict[str, Sensor], Site], None]:
    def sense(sensors: dict[str, Sensor], site: Site) -> None:
        sensors[site.where].filters.append(made(site))

    return sense


def _over_band(name: str, low: float, high: float, **spans: tuple[float, float]) -> Draw:
    """A frequency as a part of the band's end; other numbers as they are."""
    return drawing(
        lambda stand, where, random: {name: float(random.uniform(low, high) * stand.plan.band[1])}, **spans
    )


# a reading that is too large or too small


def _invert(sensors: dict[str, Sensor], site: Site) -> None:
    """There is no weaker inversion: it stands as high as it stands."""
    sensors[site.where].gain *= -(1 + site["error"])


def _ageing(site: Site) -> Filter:
    """(iω/ω₀)^(−n) with ω₀ at the band's end: n decades a decade, and the lag that causality asks for."""
    end = 2 * np.pi * site.stand.plan.band[1]
    return lambda omega: (1j * np.maximum(omega, 1e-9) / end) ** (-site["exponent"]) * 1j ** site["exponent"]


def _coupled(site: Site) -> Filter:
    """iω τ/(1 + iω τ): a charge amplifier or a coupling capacitor."""
    corner = 2 * np.pi * site["corner"]
    return lambda omega: 1j * omega / (corner + 1j * omega)


def _resonant(site: Site) -> Filter:
    """1/(1 − r² + 2 i ζ r): the sensor on a mount that gives."""
    own = 2 * np.pi * site["resonance"]
    return lambda omega: 1 / (1 - (omega / own) ** 2 + 2j * site["damping_ratio"] * omega / own)


INVERTED: Effect = replace(
    SENSOR_GAIN,
    form="inverted",
    says="a sensor the wrong way round, calibrated wrongly besides",
    source="ISO 7626-1, on the sense of transducers",
    scaled=lambda parameters, s: dict(parameters),
    most=lambda parameters: 1.0,
    sense=_invert,
)
AGED: Effect = replace(
    SENSOR_GAIN,
    form="aged",
    says="a sensitivity that falls with frequency as a weak power, and rises below",
    source="Serridge and Licht, Piezoelectric Accelerometers and Vibration Preamplifiers, Brüel & Kjær 1987",
    units={"exponent": "of frequency"},
    draw=drawing(exponent=(0.03, 0.12)),
    scaled=multiplied("exponent"),
    most=lambda parameters: 0.4 / max(parameters["exponent"], 1e-9),
    check=within(exponent=(0.0, 0.4)),
    sense=_filtering(_ageing),
)
AC_COUPLED: Effect = replace(
    SENSOR_GAIN,
    form="high_pass",
    says="a sensor with a high-pass in the band",
    source="Serridge and Licht (as aged), low-frequency limit of preamplifiers",
    units={"corner": "Hz"},
    draw=_over_band("corner", 0.02, 0.1),
    scaled=multiplied("corner"),
    most=lambda parameters: 20.0,
    check=positive("corner"),
    sense=_filtering(_coupled),
)
MOUNTED: Effect = replace(
    SENSOR_GAIN,
    form="resonant",
    says="a sensor on a mount whose resonance comes near the band",
    source="ISO 5348, mechanical mounting of accelerometers",
    units={"resonance": "Hz", "damping_ratio": ""},
    draw=_over_band("resonance", 1.5, 4.0, damping_ratio=(0.02, 0.1)),
    scaled=divided("resonance"),
    most=lambda parameters: 3.0,
    check=positive("resonance", "damping_ratio"),
    sense=_filtering(_resonant),
)

# a reading that comes late


def _low_pass(site: Site) -> Filter:
    return lambda omega: 1 / (1 + 1j * omega * site["time"])


def _all_pass(site: Site) -> Filter:
    return lambda omega: (1 - 0.5j * omega * site["time"]) / (1 + 0.5j * omega * site["time"])


def _bessel(site: Site) -> Filter:
    """3/(3 + 3 s τ + (s τ)²), of flat delay τ."""
    return lambda omega: 3 / (3 + 3j * omega * site["time"] - (omega * site["time"]) ** 2)


def _hold(site: Site) -> Filter:
    """A value held for τ: sin(ωτ/2)/(ωτ/2) and half of it late."""
    return lambda omega: np.sinc(omega * site["time"] / (2 * np.pi)) * np.exp(-0.5j * omega * site["time"])


def _late(form: str, says: str, source: str, made: Callable[[Site], Filter], longer: float) -> Effect:
    """A lag drawn as in the rig's own form, times what makes the delay in the band alike."""
    return replace(
        TIME_DELAY,
        form=form,
        says=says,
        source=source,
        units={"time": "s"},
        draw=lambda stand, where, random: {
            "time": float(longer * random.uniform(0.02, 0.12) / stand.plan.band[1])
        },
        scaled=multiplied("time"),
        most=lambda parameters: 0.02 / max(parameters["time"], 1e-9),
        check=within(time=(0.0, 0.021)),
        sense=_filtering(made),
    )


_FILTERS = "Zverev, Handbook of Filter Synthesis, Wiley 1967"
LOW_PASS = _late("low_pass", "a sensor behind a low-pass of first order", _FILTERS, _low_pass, 1.0)
ALL_PASS = _late("all_pass", "a sensor behind an all-pass of first order", _FILTERS, _all_pass, 1.0)
BESSEL = _late("bessel", "a sensor behind Bessel's filter of second order", _FILTERS, _bessel, 1.0)
HELD = _late(
    "hold", "a sensor whose values are held and read late",
    "Åström and Wittenmark, Computer-Controlled Systems, 3rd ed., Prentice-Hall 1997 (zero-order hold)",
    _hold, 2.0,
)  # fmt: skip

# a sensor that looks elsewhere


def _mix(sensors: dict[str, Sensor], site: Site) -> None:
    """Each axis feels a part of the one that a quarter turn brings onto it, and loses nothing."""
    axis = site.vector("ax", "ay", "az")
    quarter = turn(axis, np.pi / 2) - np.outer(axis, axis)
    sensors[site.where].turned = (np.eye(3) + site["angle"] * quarter) @ sensors[site.where].turned


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
    link = next(point.link for point in site.stand.plan.points if point.name == site.where)
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

FORMS = (
    INVERTED, AGED, AC_COUPLED, MOUNTED, LOW_PASS, ALL_PASS, BESSEL, HELD, CROSS, STAND_OFF, LEANING, SKEWED,
)  # fmt: skip

"""Other ways for a sensor to read wrongly and to lag."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import (
    Draw,
    Effect,
    Site,
    Stand,
    divided,
    drawing,
    each,
    either_sign,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.sensors import SENSOR_GAIN, TIME_DELAY
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.sensing import Filter, Sensor


def filtering(made: Callable[[Site], Filter]) -> Callable[[dict[str, Sensor], Site], None]:
    """One more filter of the sensor on a point."""

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


def _second_order(site: Site) -> Filter:
    """(1 + e) s²/(s² + √2 ω_c s + ω_c²)."""
    corner = 2 * np.pi * site["corner"]
    return lambda omega: (
        -(1 + site["error"]) * omega**2 / (corner**2 - omega**2 + 1j * np.sqrt(2) * corner * omega)
    )


def _resonant(site: Site) -> Filter:
    """1/(1 − r² + 2 i ζ r): the sensor on a mount that gives."""
    own = 2 * np.pi * site["resonance"]
    return lambda omega: 1 / (1 - (omega / own) ** 2 + 2j * site["damping_ratio"] * omega / own)


def _shelf(site: Site) -> Filter:
    """(1 + (1 + e) iω/ω_c)/(1 + iω/ω_c): right below the corner, wrong above it."""
    corner = 2 * np.pi * site["corner"]
    return lambda omega: (1 + (1 + site["error"]) * 1j * omega / corner) / (1 + 1j * omega / corner)


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
    sense=filtering(_ageing),
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
    sense=filtering(_coupled),
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
    sense=filtering(_resonant),
)
AMPLIFIER: Effect = replace(
    AC_COUPLED,
    form="amplifier",
    says="a sensor on an amplifier with a wrong gain and a high-pass of second order",
    units={"corner": "Hz", "error": "relative"},
    draw=_over_band("corner", 0.01, 0.05, error=(-0.2, 0.2)),
    scaled=multiplied("corner", "error"),
    most=lambda parameters: min(10.0, 0.7 / max(abs(parameters["error"]), 1e-9)),
    check=each(positive("corner"), within(error=(-0.9, 9.0))),
    sense=filtering(_second_order),
)

SHELF: Effect = replace(
    AC_COUPLED,
    form="shelf",
    says="a sensor whose sensitivity steps from one value to another within the band",
    source="Zverev, Handbook of Filter Synthesis, Wiley 1967: a lead or a lag, as of a cable or a bad ground",
    units={"corner": "Hz", "error": "relative, above it"},
    draw=_over_band("corner", 0.1, 0.5, error=(-0.3, 0.4)),
    scaled=multiplied("error"),
    most=lambda parameters: 0.7 / max(abs(parameters["error"]), 1e-9),
    check=each(positive("corner"), within(error=(-0.9, 9.0))),
    sense=filtering(_shelf),
)


def _seen(stand: Stand, where: str) -> np.ndarray:
    """How much of what is recorded goes along each axis of the link, and moves, over all postures."""
    point, total = next(one for one in stand.plan.points if one.name == where), np.zeros(3)
    for posture in stand.plan.postures:
        assembly = PlantAssembly(stand.robot.at(dict(posture.q)))
        axes = assembly.orientation(point.link)
        moved = axes.T @ assembly.motion(point.link, np.array(point.xyz))[:3]
        looked = axes.T @ np.array([point.way(axis, axes) for axis in stand.plan.axes]).T
        total += np.sum(moved**2, axis=1) * np.sum(looked**2, axis=1)
    return total


def _draw_one_axis(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """An axis of the three that is looked along."""
    seen = _seen(stand, where)
    axis = random.choice(np.flatnonzero(seen > 0.2 * seen.max()))
    return {"error": either_sign(random, 0.1, 0.35), "axis": float(axis)}


def _misread(sensors: dict[str, Sensor], site: Site) -> None:
    """One of three axes, which are the link's: 1 + e along it, whatever is worked out from all three."""
    sensor, along = sensors[site.where], np.eye(3)[int(site["axis"])]
    sensor.turned = (np.eye(3) + site["error"] * np.outer(along, along)) @ sensor.turned


ONE_AXIS: Effect = replace(
    SENSOR_GAIN,
    form="one_axis",
    says="a sensor one of whose three axes is calibrated wrongly",
    source="ISO 16063-21, calibration of each axis by comparison; Ewins, Modal Testing, 2nd ed., section 3.5",
    units={"error": "relative, along that axis", "axis": "number of the axis of the link"},
    draw=_draw_one_axis,
    check=within(error=(-0.9, 9.0), axis=(0.0, 2.0)),
    sense=_misread,
)

# a reading that comes late


def _low_pass(site: Site) -> Filter:
    return lambda omega: 1 / (1 + 1j * omega * site["time"])


def _all_pass(site: Site) -> Filter:
    return lambda omega: (1 - 0.5j * omega * site["time"]) / (1 + 0.5j * omega * site["time"])


def _bessel(site: Site) -> Filter:
    """3/(3 + 3 s τ + (s τ)²), of flat delay τ."""
    return lambda omega: 3 / (3 + 3j * omega * site["time"] - (omega * site["time"]) ** 2)


def _anti_alias(site: Site) -> Filter:
    """Butterworth's of order 4: its delay at low frequencies is 2 (cos π/8 + cos 3π/8)/ω_c."""
    damped = 2 * np.cos(np.pi * np.array([1, 3]) / 8)
    corner = damped.sum() / site["time"]

    def told(omega: np.ndarray) -> np.ndarray:
        s = 1j * omega / corner
        return 1 / np.prod([s**2 + part * s + 1 for part in damped], axis=0)

    return told


def _hold(site: Site) -> Filter:
    """A value held for τ: sin(ωτ/2)/(ωτ/2) and half of it late."""
    return lambda omega: np.sinc(omega * site["time"] / (2 * np.pi)) * np.exp(-0.5j * omega * site["time"])


def _decimated(site: Site) -> Filter:
    """Three running means over τ, one after the other: sinc³, 3 τ/2 late."""
    return lambda omega: (
        np.sinc(omega * site["time"] / (2 * np.pi)) ** 3 * np.exp(-1.5j * omega * site["time"])
    )


def _smoothed(site: Site) -> Filter:
    """α z⁻¹/(1 − (1 − α) z⁻¹): each value is a part of the newest and of the last one, and is sent next time.

    Late by Δ/α while it is slow, Δ the time from value to value.
    """
    part = site["newest"]
    step = site["time"] * part

    def told(omega: np.ndarray) -> np.ndarray:
        back = np.exp(-1j * omega * step)
        return part * back / (1 - (1 - part) * back)

    return told


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
        sense=filtering(made),
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
ANTI_ALIAS = _late(
    "anti_alias", "a sensor behind an anti-aliasing filter of fourth order that the others lack", _FILTERS,
    _anti_alias, 1.0,
)  # fmt: skip
DECIMATED = _late(
    "decimated", "a sensor behind the decimating filter of a converter, three running means",
    "Hogenauer, IEEE Trans. Acoustics, Speech and Signal Processing 29 (1981) 155", _decimated, 2 / 3,
)  # fmt: skip
SMOOTHED = _late(
    "smoothed", "a digital sensor that smooths its values and sends them one beat late",
    "Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., Pearson 2010 (first-order recursion)",
    _smoothed, 1.0,
)  # fmt: skip
SMOOTHED = replace(
    SMOOTHED,
    units={**SMOOTHED.units, "newest": "part of the newest value in what is sent"},
    draw=drawing(SMOOTHED.draw, newest=(0.25, 0.6)),
    check=each(SMOOTHED.check, within(newest=(0.01, 1.0))),
)

FORMS = (
    INVERTED, AGED, AC_COUPLED, MOUNTED, AMPLIFIER, SHELF,
    LOW_PASS, ALL_PASS, BESSEL, HELD, ANTI_ALIAS, DECIMATED, ONE_AXIS, SMOOTHED,
)  # fmt: skip

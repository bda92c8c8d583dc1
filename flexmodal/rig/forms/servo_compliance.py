"""Other ways for the motor side to move: by brake, two loops, late, by current, two encoders, notch, torque.

As in the rig's own form the joint's spring and damper go from link to rotor. Severity s divides the gains by
s. A loop stiffer than drawn takes its times along, by √s; a softer one keeps them, since the joint's spring
then sets how fast the rotor swings.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import Check, Draw, Effect, Parameters, Site, Stand, each, positive, within
from flexmodal.rig.effects.servo_compliance import EFFECT as OWN
from flexmodal.rig.effects.servo_compliance import free_rotor
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import Branch, Feedback

_GAINS = {"proportional_gain": -1.0, "derivative_gain": -0.5, "brake_stiffness": -1.0}
"""Powers of the severity by which they are multiplied."""
_TIMES = ("delay", "current_time", "filter_time", "relaxation_time", "notch_time")


def _scaled(parameters: Parameters, s: float) -> dict[str, float]:
    factors = {name: s**power for name, power in _GAINS.items()}
    factors |= {name: min(s, 1.0) ** 0.5 for name in _TIMES}
    return {name: float(value * factors.get(name, 1.0)) for name, value in parameters.items()}


def _drawing(damping: tuple[float, float], **spans: tuple[float, float]) -> Draw:
    """Gains and rotor as in the rig's own form, a damping ratio of the loop, times over K_D/K_P."""

    def draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
        drawn = OWN.draw(stand, where, random)
        loop, inertia = drawn["proportional_gain"], drawn["rotor_inertia"]
        derivative = float(2 * random.uniform(*damping) * np.sqrt(loop * inertia))
        found = {**drawn, "derivative_gain": derivative}
        for name, span in spans.items():
            size = derivative / loop if name.endswith(("time", "delay")) else 1.0
            found[name] = float(random.uniform(*span) * size)
        return found

    return draw


def _draw_brake(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = OWN.draw(stand, where, random)
    loop, inertia = drawn["proportional_gain"], drawn["rotor_inertia"]
    return {
        "brake_stiffness": loop,
        "rotor_inertia": inertia,
        "relaxing": float(random.uniform(0.1, 0.5)),
        "relaxation_time": float(random.uniform(0.5, 2.0) * np.sqrt(inertia / loop)),
    }


def _act_brake(assembly: PlantAssembly, site: Site) -> None:
    """The loop is off; the brake's hub is a spring with a Maxwell element beside it."""
    motor, k = free_rotor(assembly, site, site["rotor_inertia"]), site["brake_stiffness"]
    assembly.add_spring(motor, k)
    assembly.branches.append(Branch(motor, site["relaxing"] * k, site["relaxation_time"]))


def _act_cascade(assembly: PlantAssembly, site: Site) -> None:
    """P on the angle around PI on its rate, the torque through a low-pass.

    K_v (1 + 1/(T_i s)) (K + s) = K_v s + K_v (K + 1/T_i) + K_v K/(T_i s), the middle of it being the
    proportional gain; `outer` is the part of it that comes from K.
    """
    motor = free_rotor(assembly, site, site["rotor_inertia"])
    gain, rate, time = site["proportional_gain"], site["derivative_gain"], site["filter_time"]
    integral = site["outer"] * (1 - site["outer"]) * gain**2 / rate
    a = np.array([[0.0, 0.0], [integral / time, -1 / time]])
    b, b_rate = np.array([1.0, gain / time]), np.array([0.0, rate / time])
    assembly.feedbacks.append(Feedback(motor, motor, a, b, b_rate, np.array([0.0, 1.0])))


def _act_delayed(assembly: PlantAssembly, site: Site) -> None:
    """K_P + K_D s, late by T: Padé's approximant of order 2, 1 − s T/(1 + s T/2 + s² T²/12)."""
    motor, late = free_rotor(assembly, site, site["rotor_inertia"]), site["delay"]
    gain, rate = site["proportional_gain"], site["derivative_gain"]
    a = np.array([[0.0, 1.0], [-12.0, -6.0]]) / late
    b, b_rate = np.array([0.0, 12 * gain / late]), np.array([0.0, 12 * rate / late])
    c = np.array([0.0, -1.0])
    assembly.feedbacks.append(Feedback(motor, motor, a, b, b_rate, c, gain, rate))


def _act_current(assembly: PlantAssembly, site: Site) -> None:
    """The torque follows through a current loop of first order; the back-EMF brakes at once."""
    motor, time = free_rotor(assembly, site, site["rotor_inertia"]), site["current_time"]
    a, c = np.array([[-1 / time]]), np.ones(1)
    b, b_rate = np.array([site["proportional_gain"] / time]), np.array([site["derivative_gain"] / time])
    brake = site["back_emf"] * site["derivative_gain"]
    assembly.feedbacks.append(Feedback(motor, motor, a, b, b_rate, c, 0.0, brake))


def _act_link_side(assembly: PlantAssembly, site: Site) -> None:
    """A part of the proportional gain works on the angle of the link, which is read through a low-pass."""
    motor, link = free_rotor(assembly, site, site["rotor_inertia"]), assembly.row(site.where)
    time, part = site["filter_time"], site["link_side"] * site["proportional_gain"]
    assembly.add_spring(motor, site["proportional_gain"] - part, site["derivative_gain"])
    a, b = np.array([[-1 / time]]), np.array([part / time])
    assembly.feedbacks.append(Feedback(link, motor, a, b, np.zeros(1), np.ones(1)))


def _act_notched(assembly: PlantAssembly, site: Site) -> None:
    """K_P + K_D s through 1 − 2 ζ (1 − r) T s/(1 + 2 ζ T s + T² s²), r what is left at 1/T."""
    motor, time, wide = free_rotor(assembly, site, site["rotor_inertia"]), site["notch_time"], site["width"]
    gain, rate = site["proportional_gain"], site["derivative_gain"]
    a = np.array([[0.0, 1.0], [-1.0, -2 * wide * time]]) / np.array([[1.0], [time**2]])
    b, b_rate = np.array([0.0, gain]) / time**2, np.array([0.0, rate]) / time**2
    c = np.array([0.0, -2 * wide * (1 - site["left"]) * time])
    assembly.feedbacks.append(Feedback(motor, motor, a, b, b_rate, c, gain, rate))


def _draw_torque_fed(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Gains and rotor larger by what the torque that is fed back takes away while it is slow."""
    fed = {"torque_gain": (0.5, 2.0), "filter_time": (0.08, 0.25)}
    drawn = _drawing((0.4, 0.8), **fed)(stand, where, random)
    larger = 1 + drawn["torque_gain"]
    return {name: value * (1.0 if name in fed else larger) for name, value in drawn.items()}


def _act_torque_fed(assembly: PlantAssembly, site: Site) -> None:
    """The motor helps by K_T times the joint's torque, which a sensor reads through a low-pass."""
    motor = free_rotor(assembly, site, site["rotor_inertia"])
    assembly.add_spring(motor, site["proportional_gain"], site["derivative_gain"])
    k, b = site.stand.true.stiffness[site.where], site.stand.true.damping[site.where]
    a, time = np.array([[-1 / site["filter_time"]]]), site["filter_time"]
    torque, rate, c = np.array([k / time]), np.array([b / time]), np.array([-site["torque_gain"]])
    assembly.feedbacks.append(Feedback(assembly.stretch(site.where), motor, a, torque, rate, c))


def _scaled_link_side(parameters: Parameters, s: float) -> dict[str, float]:
    """However stiff, such a loop lets the rotor turn against the link: below 1 its part falls too."""
    return _scaled(parameters, s) | {"link_side": parameters["link_side"] * min(s, 1.0)}


def _checking(**most: float) -> Check:
    """Times stay below a part of T_D = K_D/K_P, beyond which the loop may ring up."""

    def check(parameters: Parameters) -> str | None:
        wrong = positive("proportional_gain", "derivative_gain", "rotor_inertia", *most)(parameters)
        if wrong:
            return wrong
        lead = parameters["derivative_gain"] / parameters["proportional_gain"]
        for name, part in most.items():
            if parameters[name] > part * lead * (1 + 1e-9):
                return f"{name} = {parameters[name]:g}, where at most {part * lead:g} is allowed"
        return None

    return check


_LOOP = OWN.units

BRAKE: Effect = replace(
    OWN,
    form="brake",
    says="the motor is held by a brake that gives",
    source="rotor after Spong, ASME J. Dyn. Sys. Meas. Control 109 (1987) 310; brake as Zener's solid",
    units={
        "brake_stiffness": "N·m/rad", "rotor_inertia": "kg·m²",
        "relaxing": "stiffness that relaxes, relative", "relaxation_time": "s",
    },
    draw=_draw_brake,
    scaled=_scaled,
    check=positive("brake_stiffness", "rotor_inertia", "relaxing", "relaxation_time"),
    act=_act_brake,
)  # fmt: skip
CASCADE: Effect = replace(
    OWN,
    form="cascade",
    says="the motor on a position loop around a velocity loop, filtered",
    source="Groß, Hamann and Wiegärtner, Electrical Feed Drives in Automation, Publicis 2001",
    units={**_LOOP, "outer": "part of the gain that comes from the position loop", "filter_time": "s"},
    draw=_drawing((0.5, 0.9), outer=(0.08, 0.25), filter_time=(0.05, 0.2)),
    scaled=_scaled,
    check=each(positive("outer"), within(outer=(0.0, 0.3)), _checking(filter_time=0.3)),
    act=_act_cascade,
    active=True,
)
DELAYED: Effect = replace(
    OWN,
    form="delayed",
    says="the motor on a loop that comes late",
    source="Åström and Murray, Feedback Systems, Princeton 2008, section 9.5 (delay, Padé)",
    units={**_LOOP, "delay": "s"},
    draw=_drawing((0.3, 0.7), delay=(0.1, 0.3)),
    scaled=_scaled,
    check=_checking(delay=0.4),
    act=_act_delayed,
    active=True,
)
CURRENT: Effect = replace(
    OWN,
    form="current",
    says="the motor on a loop behind its current loop",
    source="Leonhard, Control of Electrical Drives, 3rd ed., Springer 2001, chapter 15",
    units={**_LOOP, "current_time": "s", "back_emf": "over the derivative gain"},
    draw=_drawing((0.25, 0.6), current_time=(0.1, 0.3), back_emf=(0.02, 0.1)),
    scaled=_scaled,
    check=_checking(current_time=0.4),
    act=_act_current,
    active=True,
)

LINK_SIDE: Effect = replace(
    OWN,
    form="link_side",
    says="the motor on a loop that reads the angle of the link too",
    source="De Luca and Book, Springer Handbook of Robotics, 2nd ed. 2016, chapter 11",
    units={**_LOOP, "link_side": "part of the gain that works on the link's angle", "filter_time": "s"},
    draw=_drawing((0.5, 0.9), link_side=(0.05, 0.2), filter_time=(0.02, 0.1)),
    scaled=_scaled_link_side,
    check=each(within(link_side=(0.0, 0.5)), _checking(filter_time=0.15)),
    act=_act_link_side,
    active=True,
)
NOTCHED: Effect = replace(
    OWN,
    form="notched",
    says="the motor on a loop with a notch",
    source="Ellis, Control System Design Guide, 4th ed., Butterworth-Heinemann 2012, chapter 9 (notches)",
    units={**_LOOP, "notch_time": "s, 1/ω of the notch", "width": "damping ratio", "left": "at the notch"},
    draw=_drawing((0.5, 0.9), notch_time=(0.1, 0.3), width=(0.3, 0.7), left=(0.1, 0.4)),
    scaled=_scaled,
    check=each(positive("width"), within(left=(0.0, 1.0)), _checking(notch_time=0.4)),
    act=_act_notched,
    active=True,
)
TORQUE_FED: Effect = replace(
    OWN,
    form="torque_fed",
    says="the motor on a loop that feeds back the torque of the joint besides",
    source="Albu-Schäffer, Ott and Hirzinger, Int. J. Robotics Research 26 (2007) 23 (torque feedback)",
    units={
        **_LOOP,
        "torque_gain": "K_T, by which the rotor seems lighter",
        "filter_time": "s, of the sensor",
    },
    draw=_draw_torque_fed,
    scaled=_scaled,
    check=each(within(torque_gain=(0.0, 10.0)), _checking(filter_time=0.3)),
    act=_act_torque_fed,
    active=True,
)

FORMS = (BRAKE, CASCADE, DELAYED, CURRENT, LINK_SIDE, NOTCHED, TORQUE_FED)

"""The motor is not locked: its rotor moves on the stiffness and damping of the position loop.

One more coordinate: the rotor, reflected to the joint. The joint's own spring goes from
it to the link [Hearne 2.1, 2.2].

At the next level the loop integrates, comes late and is braked besides: its torque over the angle is

    z(s) = (K + D s)(1 + w/s)/(1 + T s) + B s = K w/s + (K' + D s)/(1 + T s) + B s,   K' = K + D w - K w T

(P around PI, its torque through a lag, and back-EMF: Leonhard, Control of Electrical Drives, Springer 2001,
chapters 7 and 15; a brake that relaxes is T and D = (1 + r) K T). The lag is a spring K' with a Maxwell
element of D/T - K' beside it, which may be negative. For w/s stands w/(s + e), a spring less a Maxwell
element, e far below the band.

And the rotor may drive a wheel by a belt, and that the joint: a spring and a damper between two inertias.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive
from flexmodal.diagnosis.effects.relaxation import add_relaxing
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

HELD = 0.05
"""What integral and lag do at the rotor's frequency, from which it is told that no file holds them."""
LEAST = 1e-3
"""Of its gain, the spring in the files at least."""
BELT = ("belt", "belt_damping_time", "wheel")
"""Stiffness of a belt, its damping over that, and the inertia of the wheel it drives over the rotor's."""
STIFF = 300.0
"""A belt's stiffness over the joint's that is none to be seen."""
BELTED = 30.0
"""Its stiffness over the loop's up to which it is told that no file holds it."""
SLOW = 0.003
"""Below which part of the lowest line the integral of the loop forgets."""


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k = float(context.robot.joints[where].stiffness)
    low, high = context.band
    return (
        positive("gain", "N·m/rad", 3 * k, 1.5, 1e-3 * k, 1e3 * k),
        positive("frequency", "Hz", float(np.sqrt(low * high)), 1.2, 0.5 * low, 10 * high),
        positive("damping_ratio", "", 0.3, 0.8, 0.01, 3.0),
    )


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    k = float(context.robot.joints[where].stiffness)
    low, high = context.band
    grid = np.geomspace(max(3 * low, 0.04 * high), 0.6 * high, 4)
    soft = [{"gain": gain * k, "frequency": float(f)} for f in grid for gain in (0.03, 0.5, 4.0)]
    return [*soft, {"gain": 40.0 * k, "frequency": 1.5 * high}]


def loop(k: float, gain: float, frequency: float, ratio: float) -> tuple[float, float]:
    """Rotor inertia [kg·m²] and derivative gain [N·m·s/rad] of a rotor between joint spring and loop.

    Args:
        k: stiffness of the joint [N·m/rad].
        gain: proportional gain of the loop [N·m/rad].
        frequency: natural frequency of the rotor between both [Hz].
        ratio: damping ratio of the rotor on the loop alone.
    """
    inertia = (gain + k) / (2 * np.pi * frequency) ** 2
    return float(inertia), float(2 * ratio * np.sqrt(gain * inertia))


def _act(assembly: Assembly, placement: Placement) -> None:
    k = float(placement.context.robot.joints[placement.where].stiffness)
    inertia, derivative = loop(k, placement["gain"], placement["frequency"], placement["damping_ratio"])
    row = assembly.row(f"{placement.where} motor")
    assembly.add_inertia(row, inertia)
    assembly.add_spring(row, placement["gain"])
    assembly.add_damper(row, derivative)


def _shape(assembly: Assembly, placement: Placement) -> None:
    link = assembly.row(placement.where)
    assembly.add_coordinates([f"{placement.where} motor"])
    wide = np.append(link, 0.0)
    assembly.stretch[placement.where] = wide - assembly.row(f"{placement.where} motor")


def _physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    k = float(context.robot.joints[where].stiffness)
    inertia, derivative = loop(k, values["gain"], values["frequency"], values["damping_ratio"])
    return {"proportional_gain": values["gain"], "derivative_gain": derivative, "rotor_inertia": inertia}


def _extend(draft: Draft, placement: Placement) -> None:
    found = _physical(placement.context, placement.where, placement.values)
    _put_in(draft, placement, found["proportional_gain"], found["derivative_gain"])


def _put_in(draft: Draft, placement: Placement, spring: float, damper: float) -> None:
    """A rotor on a spring and a damper, which is all that the files hold; what it drives turns with it."""
    if draft.robot.joints[placement.where].rotor_inertia:
        draft.notes.append(
            f"the card's rotor inertia of {placement.where} turns with the link but no longer with the motor"
        )
    rotor = _physical(placement.context, placement.where, placement.values)["rotor_inertia"]
    inertia = rotor * (1 + placement.values.get(BELT[2], 0.0))
    motor = draft.fresh(f"{placement.where}_motor")
    draft.behind(placement.where, motor)
    draft.flexible(motor, spring, damper, rotor_inertia=inertia)


def _loop_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    """Those of a rotor on a spring and a damper, and what else there is, next to nothing at first."""
    (low, high), k = context.band, float(context.robot.joints[where].stiffness)
    return (
        *_parameters(context, where),
        positive("integral", "Hz", 0.01 * low, 2.0, 1e-5 * low, high),
        positive("lag", "s", 2e-3 / high, 2.0, 1e-6 / high, 0.5 / low),
        positive("brake", "of the derivative gain", 0.01, 2.0, 1e-6, 30.0),
        positive(BELT[0], "N·m/rad", STIFF * k, 2.0, 0.03 * k, 100 * STIFF * k),
        positive(BELT[1], "s", 3e-4, 1.5, 1e-7, 0.03),
        positive(BELT[2], "of the rotor", 0.01, 1.5, 1e-4, 20.0),
    )


def _loop_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """Where a fit without these ended and where one may begin, with a belt, or late, or with an integral."""
    begun = values, *_starts(context, where)
    found: list[Mapping[str, float]] = [{**one, BELT[0]: 2 * one["gain"], BELT[2]: 0.3} for one in begun]
    for narrow, late, slow in product(begun, (0.0, 0.1, 0.4), (0.0, 0.1, 0.4)):
        more = {"lag": late / (2 * np.pi * narrow["frequency"])} if late else {}
        more |= {"integral": slow * narrow["frequency"]} if slow else {}
        found.append({**narrow, **more})
    return found


def _loop_shape(assembly: Assembly, placement: Placement) -> None:
    where = placement.where
    _shape(assembly, placement)
    assembly.add_coordinates([f"{where} lag", f"{where} integral", f"{where} belt"])
    before = assembly.stretch[where]
    wide = np.append(before, np.zeros(len(assembly.coordinates) - len(before)))
    assembly.stretch[where] = wide - assembly.row(f"{where} belt")


def _loop_act(assembly: Assembly, placement: Placement) -> None:
    context, where, gain = placement.context, placement.where, placement["gain"]
    k, (low, high) = float(context.robot.joints[where].stiffness), context.band
    inertia, derivative = loop(k, gain, placement["frequency"], placement["damping_ratio"])
    rate, lag = 2 * np.pi * placement["integral"], placement["lag"]
    row, slow = assembly.row(f"{where} motor"), 2 * np.pi * SLOW * low
    still = gain + derivative * rate - gain * rate * lag
    assembly.add_inertia(row, inertia)
    assembly.add_spring(row, still + gain * rate / slow)
    assembly.add_damper(row, placement["brake"] * derivative)
    add_relaxing(assembly, row, assembly.row(f"{where} lag"), derivative / lag - still, lag, high)
    add_relaxing(assembly, row, assembly.row(f"{where} integral"), -gain * rate / slow, 1 / slow, high)
    stretch, (belt, time, wheel) = assembly.row(f"{where} belt"), (placement[name] for name in BELT)
    assembly.add_inertia(row + stretch, wheel * inertia)
    assembly.add_spring(stretch, belt)
    assembly.add_damper(stretch, time * belt)


def loop_stiffness(context: Context, where: str, values: Mapping[str, float], frequency: float) -> complex:
    """Torque of the loop over the rotor's angle [N·m/rad].

    Args:
        context: of the diagnosis.
        where: the joint.
        values: of the parameters of the wider law.
        frequency: at which [Hz].
    """
    k, s = float(context.robot.joints[where].stiffness), 2j * np.pi * frequency
    gain = values["gain"]
    _, derivative = loop(k, gain, values["frequency"], values["damping_ratio"])
    slow = 1 + 2 * np.pi * values["integral"] / s
    lag = 1 + values["lag"] * s
    return complex((gain + derivative * s) * slow / lag + values["brake"] * derivative * s)


def _loop_extend(draft: Draft, placement: Placement) -> None:
    """A spring and a damper that do what the loop does where the rotor swings."""
    own, values = placement["frequency"], placement.values
    there = loop_stiffness(placement.context, placement.where, values, own)
    spring, damper = max(there.real, LEAST * values["gain"]), max(there.imag, 0.0) / (2 * np.pi * own)
    _put_in(draft, placement, spring, damper)
    omega = 2 * np.pi * own
    besides = (2 * np.pi * values["integral"] / omega, values["lag"] * omega)
    if max(besides) > HELD:
        draft.notes.append(
            f"the files have the loop of {placement.where} as it is at {own:.3g} Hz, and lack that it "
            f"integrates and comes late"
        )
    if values[BELT[0]] < BELTED * values["gain"]:
        draft.notes.append(f"the files lack the belt of {placement.where}, {values[BELT[0]]:.3g} N·m/rad")


LOOP = Effect(
    name="servo_compliance",
    says="the motor moves against its control loop",
    places=lambda context: context.joints,
    parameters=_loop_parameters,
    starts=_starts,
    shape=_loop_shape,
    act=_loop_act,
    physical=lambda context, where, values: {
        **_physical(context, where, values),
        **{name: values[name] for name in ("integral", "lag", "brake", *BELT)},
    },
    extend=_loop_extend,
    units={"proportional_gain": "N·m/rad", "derivative_gain": "N·m·s/rad", "rotor_inertia": "kg·m²"},
)
EFFECT = replace(
    LOOP,
    parameters=_parameters,
    shape=_shape,
    act=_act,
    physical=_physical,
    extend=_extend,
    next_level=Level(LOOP, _loop_starts),
)

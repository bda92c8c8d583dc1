"""The motor is not locked: its rotor moves on the stiffness and damping of the position loop.

One more coordinate: the rotor, reflected to the joint. The joint's own spring goes from
it to the link [Hearne 2.1, 2.2].
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly


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
    return [{"gain": gain * k, "frequency": float(f)} for f in grid for gain in (0.03, 0.5, 4.0)]


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
    if draft.robot.joints[placement.where].rotor_inertia:
        draft.notes.append(
            f"the card's rotor inertia of {placement.where} turns with the link but no longer with the motor"
        )
    found = _physical(placement.context, placement.where, placement.values)
    motor = draft.fresh(f"{placement.where}_motor")
    draft.behind(placement.where, motor)
    inertia = found["rotor_inertia"]
    draft.flexible(motor, found["proportional_gain"], found["derivative_gain"], rotor_inertia=inertia)


EFFECT = Effect(
    name="servo_compliance",
    says="the motor moves against its control loop",
    places=lambda context: context.joints,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    physical=_physical,
    extend=_extend,
    units={"proportional_gain": "N·m/rad", "derivative_gain": "N·m·s/rad", "rotor_inertia": "kg·m²"},
)

"""Joints whose stiffness or loss depends on how far they swing, by describing functions.

At an amplitude A a non-linear torque acts, in the first harmonic, as a spring and a damper (Gelb and Vander
Velde, Multiple-Input Describing Functions, 1968). A is taken for each posture, hammer point and level of
force from the believed robot's own swing; one factor on all of them is fitted along, since a swing that dies
away has no single amplitude.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.diagnosis.effects.swing import swings
from flexmodal.diagnosis.time_domain.law import Law, friction, hardening, slow_friction
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

_PHASE = (np.arange(32) + 0.5) * np.pi / 32


_STEPS, _CLOSED = 50, 1e-15
"""Most steps to where a loop closes, and what it may miss by."""
_STICKS = 1e-6
"""Of the elongation at which friction slides, up to which it is a spring."""


def _swing(placement: Placement) -> tuple[Float[np.ndarray, " system"], Float[np.ndarray, " system"]]:
    """Amplitude and frequency of the joint's swing in each system, see `Swing`."""
    found = [
        swings(placement.context, posture, (struck[0], struck[1]), level)[placement.where]
        for posture, struck, level in zip(
            placement.posture.tolist(), placement.reference.tolist(), placement.level.tolist(), strict=True
        )
    ]
    amplitude, omega = np.array([(one.amplitude, one.omega) for one in found]).T
    return amplitude * placement.values.get("reach", 1.0), omega


def _typical(context: Context, where: str) -> tuple[float, float]:
    """Swing of a joint under the blows of the campaign [rad], and its speed [rad/s], geometric means."""
    every = [
        swings(context, 0, reference, level)[where]
        for level in context.levels
        for reference in context.references
    ]
    found = [(one.amplitude, one.amplitude * one.omega) for one in every]
    size, speed = np.exp(np.mean(np.log(np.maximum(found, 1e-300)), axis=0)).tolist()
    return size, speed


def _one_level(context: Context) -> str | None:
    return "one level of force only: what depends on it cannot be told" if context.level_count < 2 else None


def dahl(
    amplitude: Float[np.ndarray, "*many"],
    torque: float | Float[np.ndarray, "*many"],
    presliding: float,
    exponent: float = 1.0,
) -> tuple[Float[np.ndarray, "*many"], Float[np.ndarray, "*many"]]:
    """Stiffness and loss (torque a radian, in and out of phase) of Dahl's friction at an amplitude.

    On the way up from −A the part of the way to sliding that is left, r = 1 − F/F_c, falls as
    dr/dq = −(σ/F_c) rⁱ; where it starts follows from that loops close. One that hardly swings
    sticks: what it does there stands for all smaller amplitudes.

    Args:
        amplitude: of the swing [rad].
        torque: F_c, at which the joint slides [N·m].
        presliding: σ, stiffness while it sticks [N·m/rad].
        exponent: i; 1 approaches sliding exponentially.
    """
    amplitude = np.maximum(amplitude, _STICKS * np.asarray(torque) / presliding)
    size = np.minimum(presliding * amplitude / torque, 300.0)
    power = 1 - exponent

    def left(start: np.ndarray, way: np.ndarray) -> np.ndarray:
        if abs(power) < 1e-9:
            return np.asarray(start * np.exp(-way))
        return np.asarray(np.maximum(start**power - power * way, 0.0) ** (1 / power))

    start = _closing(left, size, exponent)
    q = -np.cos(_PHASE)  # from −A to A
    most = np.asarray(torque)[..., None]
    force = most * (1 - left(start[..., None], size[..., None] * (q + 1)))
    stiffness = 2 / len(_PHASE) * np.sum(force * q, axis=-1) / amplitude
    loss = 2 / len(_PHASE) * np.sum(force * np.sin(_PHASE), axis=-1) / amplitude
    return stiffness, loss


def _closing(
    left: Callable[[np.ndarray, np.ndarray], np.ndarray], size: Float[np.ndarray, "*many"], exponent: float
) -> Float[np.ndarray, "*many"]:
    """Where r starts so that it ends at 2 − r: at 1 + F₀/F_c and 1 − F₀/F_c, by Newton's method in a bracket.

    With r′ = −rⁱ the derivative of the end along the start is (end / start)ⁱ.
    """
    low, high = np.ones_like(size), np.full_like(size, 2.0)
    start = np.full_like(size, 1.5)
    for _ in range(_STEPS):
        end = left(start, 2 * size)
        missed = start + end - 2
        low, high = np.where(missed < 0, start, low), np.where(missed < 0, high, start)
        nearer = start - missed / (1 + (end / start) ** exponent)
        inside = (nearer >= low) & (nearer <= high)
        start = np.where(inside, nearer, (low + high) / 2)
        if np.all(np.abs(missed) <= _CLOSED):
            break
    return start


def hardened(amplitude: Float[np.ndarray, "*many"], wound: float = 0.0) -> Float[np.ndarray, "*many"]:
    """Part of the change of stiffness that an amplitude sees: for u³/(1 + u²), amplitude over q_r.

    Args:
        amplitude: over q_r.
        wound: elongation about which it swings, likewise.
    """
    a = np.maximum(amplitude, 1e-4)
    if wound == 0.0:
        return np.asarray(1 - 2 / a**2 * (1 - 1 / np.sqrt(1 + a**2)))
    wave = np.cos(_PHASE)
    u = wound + a[..., None] * wave
    return np.asarray(2 / len(_PHASE) * np.sum(u**3 / (1 + u**2) * wave, axis=-1) / a)


_FRICTION = ("torque", "presliding_stiffness", "exponent", "stiction", "stribeck_speed")
_SLOW = ("slow_torque", "slow_speed")
_SPEED = 0.7
"""Of the largest speed of a swing, where friction takes most of its energy."""


def _rub(assembly: Assembly, placement: Placement) -> None:
    amplitude, omega = _swing(placement)
    torque, bristles, exponent, stiction, speed = (placement[name] for name in _FRICTION)
    limit = torque * (1 + stiction * np.exp(-((_SPEED * amplitude * omega / speed) ** 2)))
    stiffness, loss = dahl(amplitude, limit, bristles, exponent)
    row = assembly.stretch_of(placement.where)
    assembly.add_spring(row, stiffness)
    assembly.add_damper(row, loss / omega)
    assembly.add_damper(row, levelling(amplitude * omega, *(placement[name] for name in _SLOW)))


def levelling(speed: Float[np.ndarray, "*many"], torque: float, slow: float) -> Float[np.ndarray, "*many"]:
    """Damping that a swing feels of T tanh(v/v_t).

    Args:
        speed: largest in the swing [rad/s].
        torque: T [N·m].
        slow: v_t [rad/s].
    """
    wave, most = np.sin(_PHASE), np.maximum(speed, 1e-12 * slow)
    felt = np.tanh(most[..., None] * wave / slow)
    return np.asarray(2 / len(_PHASE) * torque * np.sum(felt * wave, axis=-1) / most)


def _rubbing(assembly: Assembly, placement: Placement) -> tuple[Law, Law]:
    row = assembly.stretch_of(placement.where)
    hysteretic = friction(row, *(placement[name] for name in _FRICTION))
    return hysteretic, slow_friction(row, *(placement[name] for name in _SLOW))


def _friction_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    k = float(context.robot.joints[where].stiffness)
    size, speed = _typical(context, where)
    torque = 0.1 * k * size
    return (
        positive("torque", "N·m", torque, 1.2, torque / 1e3, torque * 1e3),
        positive("presliding_stiffness", "N·m/rad", 5 * k, 0.7, 0.1 * k, 200 * k),
        signed("exponent", "", 0.4, 0.0, 1.6, centre=1.0),
        positive("stiction", "", 0.02, 1.5, 1e-3, 4.0),
        positive("stribeck_speed", "rad/s", 0.3 * speed, 1.2, 1e-3 * speed, 10 * speed),
        positive("slow_torque", "N·m", 0.003 * torque, 2.0, torque / 1e5, torque * 1e3),
        positive("slow_speed", "rad/s", 0.3 * speed, 1.2, 1e-3 * speed, 10 * speed),
        positive("reach", "", 1.0, 0.7, 0.05, 20.0),
    )


def _friction_starts(context: Context, where: str) -> list[Mapping[str, float]]:
    stiffness = float(context.robot.joints[where].stiffness)
    size = 0.1 * stiffness * _typical(context, where)[0]
    found = [{"torque": share * size} for share in (0.2, 1.0, 4.0)]
    found += [{"torque": share * size, "presliding_stiffness": 50 * stiffness} for share in (4.0, 16.0)]
    return [
        *found,
        {"torque": size, "stiction": 0.5},
        *({"torque": 0.01 * size, "slow_torque": share * size} for share in (0.3, 2.0)),
    ]


FRICTION = Effect(
    name="coulomb_friction",
    says="the joint has dry friction",
    places=lambda context: context.joints,
    parameters=_friction_parameters,
    starts=_friction_starts,
    act=_rub,
    law=_rubbing,
    variants=("blow",),
    untestable=_one_level,
    physical=lambda context, where, values: {name: values[name] for name in (*_FRICTION, *_SLOW)},
)


def _stiffness(placement: Placement) -> float:
    """Of the joint at small swings [N·m/rad]."""
    return placement.values.get(
        f"stiffness.{placement.where}", float(placement.context.robot.joints[placement.where].stiffness)
    )


def _spring(assembly: Assembly, placement: Placement) -> tuple[Law]:
    deflection, stiffness = placement["deflection"], _stiffness(placement)
    law = hardening(
        assembly.stretch_of(placement.where),
        placement["change"] * stiffness,
        deflection,
        placement["wound"] * deflection,
        stiffness,
    )
    return (law,)


def _stiffen(assembly: Assembly, placement: Placement) -> None:
    (law,), wound = _spring(assembly, placement), placement["wound"]
    part = hardened(_swing(placement)[0] / placement["deflection"], wound)
    top, _, _, at_rest, _ = law.parameters
    assembly.add_spring(law.row, top * part + at_rest)


def _hardening_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    size, _ = _typical(context, where)
    return (
        signed("change", "", 0.6, -0.85, 6.0),
        positive("deflection", "rad", size, 1.0, size / 100, size * 100),
        signed("wound", "of the deflection", 0.5, -4.0, 4.0),
    )


def _hardening_physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    k = values.get(f"stiffness.{where}", float(context.robot.joints[where].stiffness))
    return {
        "change": values["change"],
        "deflection": values["deflection"],
        "wound": values["wound"],
        "cubic_stiffness": values["change"] * k / values["deflection"] ** 2,
    }


NONLINEAR = Effect(
    name="nonlinear_stiffness",
    says="the joint's spring hardens or softens",
    places=lambda context: context.joints,
    parameters=_hardening_parameters,
    starts=lambda context, where: [
        {"change": change, "deflection": share * _typical(context, where)[0], "wound": wound}
        for change in (0.3, -0.3)
        for share, wound in ((0.6, 0.0), (2.0, 0.0), (1.0, 0.8))
    ],
    act=_stiffen,
    law=_spring,
    variants=("blow",),
    untestable=_one_level,
    physical=_hardening_physical,
    units={"cubic_stiffness": "N·m/rad³"},
)

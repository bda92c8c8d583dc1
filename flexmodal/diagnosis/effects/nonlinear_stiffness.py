"""Joints whose stiffness depends on how far they swing, by describing functions.

At an amplitude A a non-linear torque acts, in the first harmonic, as a spring and a damper (Gelb and Vander
Velde, Multiple-Input Describing Functions, 1968). A is taken for each posture, hammer point and level of
force from the believed robot's own swing; one factor on all of them is fitted along, since a swing that dies
away has no single amplitude.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.swing import PHASE, one_level, swing_of, typical
from flexmodal.diagnosis.time_domain.law import Law, hardening
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly


def hardened(amplitude: Float[np.ndarray, "*many"], wound: float = 0.0) -> Float[np.ndarray, "*many"]:
    """Part of the change of stiffness that an amplitude sees: for u³/(1 + u²), amplitude over q_r.

    Args:
        amplitude: over q_r.
        wound: elongation about which it swings, likewise.
    """
    a = np.maximum(amplitude, 1e-4)
    if wound == 0.0:
        return np.asarray(1 - 2 / a**2 * (1 - 1 / np.sqrt(1 + a**2)))
    wave = np.cos(PHASE)
    u = wound + a[..., None] * wave
    return np.asarray(2 / len(PHASE) * np.sum(u**3 / (1 + u**2) * wave, axis=-1) / a)


_CUBIC, _LOAD = "cubic", "load"
"""What the wider law has besides: torque of a cubic spring over that of the linear one at the deflection, and
how many deflections a load has moved it."""
FAR = 30.0
"""Deflections of a spring that is all but cubic within some of them."""


def _stiffness(placement: Placement) -> float:
    """Of the joint at small swings [N·m/rad]."""
    return placement.values.get(
        f"stiffness.{placement.where}", float(placement.context.robot.joints[placement.where].stiffness)
    )


def _spring(assembly: Assembly, placement: Placement) -> tuple[Law, ...]:
    deflection, stiffness = placement["deflection"], _stiffness(placement)
    law = hardening(
        assembly.stretch_of(placement.where),
        placement["change"] * stiffness,
        deflection,
        placement["wound"] * deflection,
        stiffness,
    )
    if _CUBIC not in placement.values:
        return (law,)
    cubic = placement[_CUBIC]  # a law is there even if it is nothing: systems have as many laws each
    far, load = FAR * deflection, placement[_LOAD] * deflection
    return law, hardening(law.row, cubic * FAR**2 * stiffness, far, load)


def _stiffen(assembly: Assembly, placement: Placement) -> None:
    swing = swing_of(placement)[0]
    for law in _spring(assembly, placement):
        top, bend, wound, at_rest, *_ = law.parameters
        assembly.add_spring(law.row, top * hardened(swing / bend, wound / bend) + at_rest)


def _hardening_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    size, _ = typical(context, where)
    return (
        signed("change", "", 0.6, -0.85, 6.0),
        positive("deflection", "rad", size, 1.0, size / 100, size * 100),
        signed("wound", "of the deflection", 0.5, -4.0, 4.0),
    )


def _curve_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    return (
        *_hardening_parameters(context, where),
        signed(_CUBIC, "", 1.0, -0.3, 10.0),
        signed(_LOAD, "of the deflection", 0.5, -4.0, 4.0),
    )


def _curve_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From where the narrower law was, and a cubic spring nearly alone."""
    size = typical(context, where)[0]
    found = [{**values, _CUBIC: cubic, _LOAD: load} for cubic in (0.02, 0.2) for load in (-0.5, 0.0, 0.5)]
    alone = {"change": 0.01, "deflection": 2 * size, "wound": 0.0}
    return [*found, *({**alone, _CUBIC: 1.0, _LOAD: load} for load in (-0.5, 0.0, 0.5))]


def _hardening_physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    k = values.get(f"stiffness.{where}", float(context.robot.joints[where].stiffness))
    told = {name: values[name] for name in ("change", "deflection", "wound", _CUBIC, _LOAD) if name in values}
    cubic = values["change"] + values.get(_CUBIC, 0.0)
    return {**told, "cubic_stiffness": cubic * k / values["deflection"] ** 2}


CURVE = Effect(
    name="nonlinear_stiffness",
    says="the joint's spring hardens or softens",
    places=lambda context: context.joints,
    parameters=_curve_parameters,
    starts=lambda context, where: [
        {"change": change, "deflection": share * typical(context, where)[0], "wound": wound}
        for change in (0.3, -0.3)
        for share, wound in ((0.6, 0.0), (2.0, 0.0), (1.0, 0.8), (1.0, -0.8))
    ],
    act=_stiffen,
    law=_spring,
    variants=("blow",),
    comes_close=True,
    untestable=one_level,
    physical=_hardening_physical,
    units={"cubic_stiffness": "N·m/rad³"},
)
EFFECT = replace(CURVE, parameters=_hardening_parameters, next_level=Level(CURVE, _curve_starts))

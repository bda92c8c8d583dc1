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

from flexmodal.diagnosis.effects.behind_spring import BEHIND
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.swing import (
    PHASE,
    bent,
    joint_stiffness,
    largest,
    one_level,
    swing_of,
    typical,
)
from flexmodal.diagnosis.effects.under_weight import UNDER_WEIGHT
from flexmodal.diagnosis.time_domain.law import KNEE, Law, hardening, knee
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


_SOFTNESS, _CUBIC, _LOAD, _FAR = "softness", "cubic", "load", "far"
"""What the wider law has besides: over how many deflections its knee is rounded; torque of a second spring,
cubic at first, over that of the linear one at the deflection, how many deflections a load has moved it, and
over how many it levels off."""
AS_NARROW = (1.10, 0.47, 0.66)
"""Change and deflection of a knee over those of the narrower law that it is nearest to, within 0.6 % of its
torque up to four of its deflections; and its softness."""
SHARP = 0.1
"""Softness of a stop."""
FAR, APART = 30.0, 4.0
"""Deflections of a spring that is all but cubic within some of them, and of one that follows the first."""


def _spring(assembly: Assembly, placement: Placement) -> tuple[Law, ...]:
    deflection, stiffness = placement["deflection"], joint_stiffness(placement)
    row, more = assembly.stretch_of(placement.where), placement["change"] * stiffness
    wound = placement["wound"] * deflection
    if _CUBIC not in placement.values:
        return (hardening(row, more, deflection, wound, stiffness),)
    cubic = placement[_CUBIC]  # a law is there even if it is nothing: systems have as many laws each
    over, load = placement[_FAR], placement[_LOAD] * deflection
    return (
        knee(row, more, deflection, placement[_SOFTNESS], wound, stiffness),
        hardening(row, cubic * over**2 * stiffness, over * deflection, load),
    )


def _stiffen(assembly: Assembly, placement: Placement) -> None:
    swing = swing_of(placement)[0]
    for law in _spring(assembly, placement):
        top, bend, wound, at_rest, over, *_ = law.parameters
        if law.kind == KNEE:
            seen = bent(swing / bend, over / bend, wound / bend)
        else:
            seen = hardened(swing / bend, wound / bend)
        assembly.add_spring(law.row, top * seen + at_rest)


def _hardening_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    size, _ = typical(context, where)
    return (
        signed("change", "", 0.6, -0.85, 6.0),
        positive("deflection", "rad", size, 1.0, size / 100, size * 100),
        signed("wound", "of the deflection", 0.5, -4.0, 4.0),
    )


def _curve_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    size, _ = typical(context, where)
    return (
        signed("change", "", 3.0, -0.85, 20.0),
        positive("deflection", "rad", size, 1.5, size / 100, size * 100),
        *_hardening_parameters(context, where)[2:],
        positive(_SOFTNESS, "of the deflection", 0.5, 1.5, 0.01, 30.0),
        signed(_CUBIC, "", 1.0, -0.3, 10.0),
        signed(_LOAD, "of the deflection", 0.5, -4.0, 4.0),
        positive(_FAR, "of the deflection", FAR, 1.0, 1.0, 100.0),
    )


def _curve_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From where the narrower law was, with a second one further out, a cubic spring alone, and stops."""
    size, (change, bend, soft) = typical(context, where)[0], AS_NARROW
    near = {
        "change": float(np.clip(values["change"] * change, -0.8, 5.5)),
        "deflection": values["deflection"] * bend,
        "wound": float(np.clip(values["wound"] / bend, -3.9, 3.9)),
        _SOFTNESS: soft,
    }
    found = [{**near, _CUBIC: cubic, _LOAD: load} for cubic in (0.005, 0.05) for load in (-0.5, 0.0, 0.5)]
    alone = {"change": 0.01, "deflection": 2 * size, "wound": 0.0, _SOFTNESS: soft}
    found += [{**alone, _CUBIC: 1.0, _LOAD: load} for load in (-0.5, 0.0, 0.5)]
    found += [{**near, _CUBIC: more / APART**2, _LOAD: 0.0, _FAR: APART} for more in (-0.2, 0.2)]
    stop = {"wound": 0.0, _SOFTNESS: SHARP, _CUBIC: 0.0, _LOAD: 0.0}
    sizes, most = (-0.6, 0.7, 2.5, 7.0), largest(context, where)
    stops = [
        {**stop, "change": c, "deflection": part * most} for c in sizes for part in (0.15, 0.3, 0.5, 0.8)
    ]
    return [*found, *stops]


def _hardening_physical(context: Context, where: str, values: Mapping[str, float]) -> dict[str, float]:
    k = values.get(f"stiffness.{where}", float(context.robot.joints[where].stiffness))
    named = ("change", "deflection", "wound", _SOFTNESS, _CUBIC, _LOAD, _FAR)
    told = {name: values[name] for name in named if name in values}
    soft, bend = values.get(_SOFTNESS), values["deflection"]
    begins = 1.0 if soft is None else soft**2 / (2 * (1 + soft**2) ** 2)
    cubic = values["change"] * begins + values.get(_CUBIC, 0.0)
    return {**told, "cubic_stiffness": cubic * k / bend**2}


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
    next_level=Level.anew(replace(UNDER_WEIGHT, next_level=Level.anew(BEHIND))),
    untestable=one_level,
    physical=_hardening_physical,
    units={"cubic_stiffness": "N·m/rad³"},
)
EFFECT = replace(CURVE, parameters=_hardening_parameters, next_level=Level(CURVE, _curve_starts))

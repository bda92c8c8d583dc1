"""Loss in the joints that is not viscous: K (1 + iη) and a part of K that relaxes.

Each joint has so many times the common loss, stiffening included, which is that of so many times the loss
factor but for terms of second order; by a wider law some may have next to none, and the weight that a joint
carries may press on what rubs in it so that it loses more, or less. What relaxes is the same part
of all; by the wider law it may do so faster from posture to posture, and beyond that in times spread as a
bell. The viscous part is free to be less or more than the card's, where all of it may be another law's.
What relaxes is a Maxwell element beside each joint's spring, a standard linear solid's (Zener, Elasticity and
Anelasticity of Metals, 1948): K (1 + r iωτ/(1 + iωτ)). The constant loss comes with the stiffening that
causality asks for (see `identification.structure`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.diagnosis.effects.relaxation import HELD, add_relaxing, relaxation
from flexmodal.diagnosis.effects.relaxation import PART as RELAXATION_PART
from flexmodal.diagnosis.effects.weight import carried
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

UNEVEN, LEAST = 1.6, 1e-3
"""Standard deviation of ln of a joint's loss over the common one by the wider law, and the least: some joints
have gears and others run directly."""

BY_LOAD, BY_LOADS = "by_load", (-10.0, -2.0, 1.0)
"""How much more a joint loses that carries the largest weight, or over how much less; where fits start."""
WARMING, WARMINGS = "warming", (0.3, 3.0)
"""How many times as fast a part relaxes in the last posture as in the first; where fits start."""
WIDTH, WIDTHS = "relaxation_width", (0.7, 1.4)
"""Standard deviation of ln of the times in which it relaxes, as a bell; where fits start."""
BELL = np.array([-(3**0.5), 0.0, 3**0.5]), np.array([1, 4, 1]) / 6
"""Places and weights of three elements for a bell: Gauss's and Hermite's rule."""


def _ratio(joint: str) -> str:
    return f"loss_ratio_{joint}"


def _pressed(placement: Placement, joint: str) -> float | Float[np.ndarray, " system"]:
    """What becomes of a joint's loss by the weight that it carries: more of it, or less."""
    by = placement.values.get(BY_LOAD, 0.0)
    if not by:
        return 1.0
    load = carried(placement.context)[joint][placement.posture]
    return np.asarray(1 + by * load if by > 0 else 1 / (1 - by * load))


def _time(placement: Placement) -> float | Float[np.ndarray, " system"]:
    """In which a part relaxes, in each system where grease warms in the course of the test [s]."""
    quicker = placement.values.get(WARMING, 1.0)
    if quicker == 1.0:
        return placement["relaxation_time"]
    return np.asarray(placement["relaxation_time"] / quicker**placement.progress)


def _ends(placement: Placement, joint: str) -> list[tuple[str, float, float]]:
    """What relaxes in a joint: coordinates, their part of it, and ln of their time over the middle one."""
    width = placement.values.get(WIDTH)
    if width is None:
        return [(f"{joint} relaxing", 1.0, 0.0)]
    return [
        (f"{joint} relaxing {number}", part, at * width)
        for number, (at, part) in enumerate(zip(*BELL, strict=True), start=1)
    ]


def _shape(assembly: Assembly, placement: Placement) -> None:
    joints = placement.context.robot.joints
    assembly.add_coordinates([name for joint in joints for name, *_ in _ends(placement, joint)])


def _act(assembly: Assembly, placement: Placement) -> None:
    assembly.loss_factor = placement["loss_factor"]
    part, time = placement["relaxing"], _time(placement)
    for joint, card in placement.context.robot.joints.items():
        name, stretch = f"stiffness.{joint}", assembly.stretch_of(joint)
        viscous = placement.values.get(f"damping.{joint}", float(card.damping))
        stiffness = placement.values.get(name, float(card.stiffness))
        assembly.add_damper(stretch, (placement["viscous"] - 1.0) * viscous, f"damping.{joint}")
        loss = placement.values.get(_ratio(joint), 1.0) * _pressed(placement, joint)
        assembly.add_loss(stretch, loss * stiffness, name)
        for end, share, later in _ends(placement, joint):
            relaxes, then = share * part * stiffness, time * float(np.exp(later))
            high = placement.context.band[1]
            add_relaxing(assembly, stretch, assembly.row(end), relaxes, then, high, name)


def _starts(context: Context, where: str) -> list[Mapping[str, float]]:
    low, high = (2 * np.pi * edge for edge in context.band)
    times = (1 / np.geomspace(2 * low, high / 2, 3)).tolist()
    return [
        *({"loss_factor": loss} for loss in (0.01, 0.06)),
        *({"loss_factor": 1e-3, "relaxing": 0.2, "relaxation_time": time} for time in times),
    ]


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    return _with_ratios(context, 0.5, 0.05)


def _uneven(context: Context, where: str) -> tuple[Parameter, ...]:
    return (
        *_with_ratios(context, UNEVEN, LEAST),
        signed(BY_LOAD, "at the largest load", 1.0, -50.0, 20.0),
        positive(WARMING, "of its rate in the first posture", 1.0, 1.0, 0.02, 50.0),
    )


def _wider_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    warming = [
        {**values, **one, WARMING: times}
        for one in _starts(context, where)
        if "relaxing" in one
        for times in WARMINGS
    ]
    return [values, *({**values, BY_LOAD: by} for by in BY_LOADS), *warming]


def _bell(context: Context, where: str) -> tuple[Parameter, ...]:
    return (*_uneven(context, where), positive(WIDTH, "", 0.7, 0.7, 0.01, 4.0))


def _bell_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From where one time did best; with all that is lost in what relaxes too."""
    alone = {**values, "loss_factor": 1e-3, "relaxing": 2 * values["relaxing"]}
    return [{**one, WIDTH: width} for one in (values, alone) for width in WIDTHS]


def _with_ratios(context: Context, deviation: float, least: float) -> tuple[Parameter, ...]:
    return (
        positive("loss_factor", "", 0.05, 1.0, 1e-5, 2.0),
        positive("viscous", "", 1.0, 0.7, 1e-3, 10.0),
        *relaxation(context),
        *(
            positive(_ratio(joint), "of the loss factor", 1.0, deviation, least, 20.0)
            for joint in context.robot.joints
        ),
    )


def _extend(draft: Draft, placement: Placement) -> None:
    for joint in placement.context.robot.joints:
        ratio = placement.values.get(_ratio(joint), 1.0) * float(np.ravel(_pressed(placement, joint))[0])
        draft.loses(joint, placement["loss_factor"] * ratio)
        draft.damp(joint, placement["viscous"])
    draft.loss_frequency = placement.context.middle
    if placement.values.get(BY_LOAD):
        draft.notes.append(
            "the files have the loss of the joints as the weight they carry in the first posture has it"
        )
    if placement["relaxing"] > HELD:
        part, time = placement["relaxing"], placement["relaxation_time"]
        draft.notes.append(
            f"the files have the constant loss of the joints and lack what relaxes: {part:.3g} of their "
            f"stiffness within {time:.3g} s"
        )


WIDE = Effect(
    name="structural_damping",
    says="the joints lose energy by hysteresis",
    places=lambda context: ("joints",),
    parameters=_uneven,
    starts=_starts,
    shape=_shape,
    act=_act,
    extend=_extend,
    hides_in=("damping.",),
    parts=(RELAXATION_PART,),
)
IN_BELLS = replace(WIDE, parameters=_bell)
EFFECT = replace(
    WIDE,
    parameters=_parameters,
    next_level=Level(replace(WIDE, next_level=Level(IN_BELLS, _bell_starts)), _wider_starts),
)

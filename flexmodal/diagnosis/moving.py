"""How a robot with effects moves: its motions with the card's own terms, and the rows of points on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification.layout import Part
from flexmodal.structure import ParameterSpace
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.frame import Frame
from flexmodal.structure.robot_terms import put_together

Placements = Sequence[tuple[Effect, Placement]]


def built(context: Context, base: ParameterSpace, part: Part, placements: Placements) -> Frame:
    """Motions of the effects, and the card's own terms on them.

    Args:
        context: of the diagnosis.
        base: parameters of the robot.
        part: of the layout of some observations.
        placements: every effect, with its own values on the robot of the card.
    """
    card = {parameter.name: parameter.card for parameter in base}
    _, first, posture = np.unique(part.posture, return_index=True, return_inverse=True)
    assembly = _moving(context, part.posture, placements)
    apart = assembly
    if len(first) < len(part.posture):
        placements = [(effect, placement.of_systems(first)) for effect, placement in placements]
        apart = _moving(context, part.posture[first], placements)
    bodies = apart.arm.bodies
    taken = {
        link
        for link in bodies
        if any(
            effect.bodies(apart, placement, bodies, link) for effect, placement in placements if effect.bodies
        )
    }
    put_together(apart, card, {link: body for link, body in bodies.items() if link not in taken})
    seen, hit = (assembly.rows(context.places(table, assembly)) for table in (part.where, part.struck))
    return Frame(
        assembly=assembly,
        apart=apart,
        posture=np.arange(len(posture)) if apart is assembly else posture.ravel(),
        names=base.names,
        card=np.array([parameter.card for parameter in base]),
        response=part.seen(seen),
        reference=part.hit(hit),
        is_cut=bool(taken),
    )


def _moving(context: Context, posture: Int[np.ndarray, " system"], placements: Placements) -> Assembly:
    """The robot in some postures, with the motions of the effects."""
    assembly = Assembly(context.stacked.take(posture))
    for effect, placement in placements:
        if effect.shape is not None:
            effect.shape(assembly.owned(Placed(effect, placement.where).label), placement)
    return assembly


def turned(
    frame: Frame, part: Part, turning: Placements
) -> tuple[Float[np.ndarray, "system response dof"], Float[np.ndarray, "system reference dof"]]:
    """Rows of responses and references, sensors turned and put aside by effects.

    Args:
        frame: of the part.
        part: of the layout of some observations.
        turning: effects that do so.
    """
    if not turning:
        return frame.response, frame.reference
    context = turning[0][1].context
    names = [context.point(number).name for number in part.where[:, 0].tolist()]
    measured = context.places(part.where, frame.assembly)
    for effect, placement in turning:
        assert effect.turn is not None
        aside = effect.aside or (lambda placement, name: np.zeros(3))
        measured = [
            (link, place + aside(placement, name), effect.turn(frame.assembly, placement, name, way))
            for (link, place, way), name in zip(measured, names, strict=True)
        ]
    return part.seen(frame.assembly.rows(measured)), frame.reference

"""Hysteretic loss in the joints: K (1 + iη) beside the viscous damping, one loss factor for all.

The viscous part is free to be less or more than the card's, where all of it may be hysteresis.
With the stiffening that causality asks for (see `identification.structure`).
"""

from __future__ import annotations

from flexmodal.diagnosis.effects.effect import Effect, Placement, positive
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.structure.assembly import Assembly


def _act(assembly: Assembly, placement: Placement) -> None:
    assembly.loss_factor = placement["loss_factor"]
    for joint, card in placement.context.robot.joints.items():
        name = f"stiffness.{joint}"
        viscous = placement.values.get(f"damping.{joint}", float(card.damping))
        more = (placement["viscous"] - 1.0) * viscous
        assembly.add_damper(assembly.stretch_of(joint), more, f"damping.{joint}")
        assembly.add_loss(assembly.stretch_of(joint), placement.values.get(name, float(card.stiffness)), name)


def _extend(draft: Draft, placement: Placement) -> None:
    for joint in placement.context.robot.joints:
        draft.loses(joint, placement["loss_factor"])
        draft.damp(joint, placement["viscous"])
    draft.loss_frequency = placement.context.middle


EFFECT = Effect(
    name="structural_damping",
    says="the joints lose energy by hysteresis",
    looks_like="damping that does not grow with frequency as viscous damping does",
    places=lambda context: ("joints",),
    parameters=lambda context, where: (
        positive("loss_factor", "", 0.05, 1.0, 1e-5, 2.0),
        positive("viscous", "", 1.0, 0.7, 1e-3, 10.0),
    ),
    starts=lambda context, where: [{"loss_factor": 0.01}, {"loss_factor": 0.06}],
    act=_act,
    extend=_extend,
)

"""Hysteretic loss in the joints: K (1 + iη) beside the viscous damping, one loss factor for all.

With the stiffening that causality asks for (see `identification.structure`).
"""

from __future__ import annotations

from flexmodal.diagnosis.draft import Draft
from flexmodal.diagnosis.effects.effect import Effect, Site, positive
from flexmodal.structure.assembly import Assembly


def _act(assembly: Assembly, site: Site) -> None:
    assembly.loss_factor = site["loss_factor"]
    for joint, card in site.scene.robot.joints.items():
        name = f"stiffness.{joint}"
        assembly.add_loss(assembly.stretch_of(joint), site.values.get(name, float(card.stiffness)), name)


def _extend(draft: Draft, site: Site) -> None:
    for joint in site.scene.robot.joints:
        draft.loses(joint, site["loss_factor"])
    draft.loss_frequency = float(site.scene.observations.axis.middle)


EFFECT = Effect(
    name="structural_damping",
    says="the joints lose energy by hysteresis",
    looks_like="damping that does not grow with frequency as viscous damping does",
    places=lambda scene: ("joints",),
    parameters=lambda scene, where: (positive("loss_factor", "", 0.05, 1.0, 1e-5, 2.0),),
    starts=lambda scene, where: [{"loss_factor": 0.01}, {"loss_factor": 0.06}],
    act=_act,
    extend=_extend,
)

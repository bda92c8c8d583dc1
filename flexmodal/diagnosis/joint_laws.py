"""What was found in joints whose torque depends on how far they swing, told as physics.

Torque over deflection, and stiffness and loss over amplitude.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.swing import largest, typical
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.time_domain.swung import Swung, swung
from flexmodal.structure.assembly import Assembly

AMPLITUDES = 40
"""From a hundredth of the largest swing under a blow of the campaign to that."""


def joint_laws(diagnosis: Diagnosis) -> Iterator[tuple[tuple[str, str], Swung]]:
    """Each effect of the final model that has a law: name and place, and the joint swung to and fro.

    Of a spring behind the joint's own that spring alone, as far as the hardest blow swings it. One that a
    load winds up otherwise in each posture is that of the first posture.

    Args:
        diagnosis: of a campaign of FRFs or of modes.
    """
    model = diagnosis.model
    values = model.space.values(diagnosis.x)
    for one in model.placed:
        if one.effect.law is None or one.where not in model.context.robot.joints:
            continue
        context, own = model.context, model.values_of(one, values)
        assembly = Assembly(context.arms[0])
        placement, share = Placement.still(context, one.where, own), 1.0
        if one.effect.shape is not None:
            one.effect.shape(assembly, placement)
        laws = [law.of_system(0) for law in one.effect.law(assembly, placement)]
        card = context.robot.joints[one.where]
        stiffness = float(values.get(f"stiffness.{one.where}", card.stiffness))
        if one.effect.behind is not None:
            stiffness, share = one.effect.behind(placement)
        size, speed = typical(context, one.where)
        most = share * largest(context, one.where)
        if size > 0 and most > 0:
            yield one.key, swung(laws, stiffness, np.geomspace(0.01, 1.0, AMPLITUDES) * most, speed / size)

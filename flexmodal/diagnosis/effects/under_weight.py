"""A spring that is not straight and that the robot's weight winds up, otherwise in each posture.

Gears stiffen with the torque that they carry (Tuttle and Seering, IEEE Trans. Robotics and Automation 12,
1996, 368): where the weight pulls they have been wound up before the blow comes, and one way more than the
other. The joint's own stiffness is that at no load then.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.behind_spring import CHANGE, DEFLECTION, SOFTNESS, WOUND
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.diagnosis.effects.swing import bent, joint_stiffness, largest, one_level, swing_of, typical
from flexmodal.diagnosis.effects.weight import moments
from flexmodal.diagnosis.time_domain.law import Law, loaded_knee
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

BY_WEIGHT = "by_weight"
"""How far the weight has wound it up, where it pulls most."""
NO_WEIGHT = 1e-6
"""Mass times lever that counts as nothing [kg·m]."""
GRID = ((0.7, 2.0, -0.5), (0.3, 0.8), (-1.0, -0.3, 0.3, 1.0))
"""Change, deflection over the largest, and how far the weight winds it up, from which fits set out."""


def _places(context: Context) -> tuple[str, ...]:
    """Joints that hold some of the weight."""
    return tuple(joint for joint in context.joints if np.abs(moments(context)[joint]).max() > NO_WEIGHT)


def _wound(placement: Placement) -> Float[np.ndarray, " system"]:
    """How far it is wound up in each system, over the deflection."""
    held = moments(placement.context)[placement.where]
    pulled = held / max(float(np.abs(held).max()), NO_WEIGHT)
    return np.asarray(placement[WOUND] + placement[BY_WEIGHT] * pulled[placement.posture])


def _law(assembly: Assembly, placement: Placement) -> tuple[Law, ...]:
    bend, row = placement[DEFLECTION], assembly.stretch_of(placement.where)
    more = placement[CHANGE] * joint_stiffness(placement)
    return (loaded_knee(row, more, bend, placement[SOFTNESS], bend * _wound(placement)),)


def _act(assembly: Assembly, placement: Placement) -> None:
    (law,) = _law(assembly, placement)
    top, bend, _, linear, over, *_ = law.parameters
    seen = bent(swing_of(placement)[0] / bend, over / bend, _wound(placement))
    assembly.add_spring(law.row, top * seen + linear)


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    size = typical(context, where)[0]
    return (
        signed(CHANGE, "", 2.0, -0.9, 20.0),
        positive(DEFLECTION, "rad", size, 1.5, size / 100, size * 100),
        signed(WOUND, "of the deflection", 0.3, -4.0, 4.0),
        positive(SOFTNESS, "of the deflection", 0.5, 1.0, 0.01, 30.0),
        signed(BY_WEIGHT, "of the deflection", 1.0, -6.0, 6.0),
    )


def _starts(context: Context, where: str) -> Sequence[Mapping[str, float]]:
    most = largest(context, where)
    return [
        {CHANGE: change, DEFLECTION: part * most, BY_WEIGHT: pulled, SOFTNESS: 0.6}
        for change, part, pulled in product(*GRID)
    ]


UNDER_WEIGHT = Effect(
    name="nonlinear_stiffness",
    says="the joint's spring hardens or softens",
    places=_places,
    parameters=_parameters,
    starts=_starts,
    act=_act,
    law=_law,
    variants=("blow",),
    comes_close=True,
    untestable=one_level,
)

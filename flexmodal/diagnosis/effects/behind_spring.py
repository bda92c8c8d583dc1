"""A spring behind a joint's own that is not straight: a belt, a flange or a spider, and the hub before it.

In series with the joint's spring and damper there is another one of each, with the inertia of what turns
between both. Where their dampers differ no spring and damper of the joint alone do as they do. The law is
that of the spring behind alone, as a function of what it is stretched by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement, positive, signed
from flexmodal.diagnosis.effects.swing import bent, largest, one_level, swing_of, typical
from flexmodal.diagnosis.improved.draft import Draft
from flexmodal.diagnosis.time_domain.law import Law, knee
from flexmodal.structure import Parameter
from flexmodal.structure.assembly import Assembly

SOFTER, TIME, FREQUENCY = "behind_softer", "behind_time", "behind_frequency"
"""Compliance of the spring behind over that of the joint's, its damping over its stiffness, and where the hub
swings between both."""
CHANGE, DEFLECTION, WOUND, SOFTNESS = "change", "deflection", "wound", "softness"
"""Of the knee of the spring behind: part of its stiffness that comes on top, and where."""
GRID = ((0.2, 0.8, 2.0), (-0.75, -0.45, 1.0), (0.2, 0.5))
"""Compliance, change, and deflection over the largest, from which fits set out."""


def _own(placement: Placement) -> tuple[float, float]:
    """Stiffness of the spring behind and of the joint's own, by the card [N·m/rad]."""
    k = float(placement.context.robot.joints[placement.where].stiffness)
    return k / placement[SOFTER], k


def _hub(assembly: Assembly, placement: Placement) -> np.ndarray:
    return assembly.row(f"{placement.where} hub")


def _shape(assembly: Assembly, placement: Placement) -> None:
    """What stretches the joint's spring is less by what the one behind gives."""
    assembly.add_coordinates([f"{placement.where} hub"])
    assembly.stretch[placement.where] = assembly.stretch_of(placement.where) - _hub(assembly, placement)


def _inertia(placement: Placement) -> float:
    """Of the hub [kg·m²]."""
    return float(sum(_own(placement)) / (2 * np.pi * placement[FREQUENCY]) ** 2)


def _besides(assembly: Assembly, placement: Placement) -> None:
    """The hub, on what does not depend on the swing."""
    behind, hub = _own(placement)[0], _hub(assembly, placement)
    assembly.add_inertia(hub, _inertia(placement))
    assembly.add_spring(hub, behind)
    assembly.add_damper(hub, placement[TIME] * behind)


def _share(placement: Placement) -> float:
    """What of the joint's swing the spring behind takes, by the two compliances."""
    return placement[SOFTER] / (1 + placement[SOFTER])


def _law(assembly: Assembly, placement: Placement) -> tuple[Law, ...]:
    behind, bend = _own(placement)[0], placement[DEFLECTION]
    more, wound = placement[CHANGE] * behind, placement[WOUND] * bend
    return (knee(_hub(assembly, placement), more, bend, placement[SOFTNESS], wound, behind),)


def _act(assembly: Assembly, placement: Placement) -> None:
    """With the spring as a swing sees it that gives it its share."""
    _besides(assembly, placement)
    (law,) = _law(assembly, placement)
    top, bend, wound, at_rest, over, *_ = law.parameters
    seen = bent(_share(placement) * swing_of(placement)[0] / bend, over / bend, wound / bend)
    assembly.add_spring(law.row, top * seen + at_rest)


def _parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    size, high = typical(context, where)[0], context.band[1]
    return (
        positive(SOFTER, "of the joint's compliance", 0.5, 1.0, 1e-3, 20.0),
        positive(TIME, "s", 3e-4, 1.5, 1e-7, 0.03),
        positive(FREQUENCY, "Hz", 3 * high, 0.7, 0.5 * high, 100 * high),
        signed(CHANGE, "", 3.0, -0.97, 20.0),
        positive(DEFLECTION, "rad", size, 1.5, size / 100, size * 100),
        signed(WOUND, "of the deflection", 0.5, -4.0, 4.0),
        positive(SOFTNESS, "of the deflection", 0.5, 1.5, 0.01, 30.0),
    )


def _starts(context: Context, where: str) -> Sequence[Mapping[str, float]]:
    """From the joint as the card has it, whatever a fit without another spring made of it."""
    card, most = context.robot.joints[where], largest(context, where)
    own = {f"stiffness.{where}": float(card.stiffness), f"damping.{where}": float(card.damping)}
    return [
        {**own, SOFTER: softer, CHANGE: change, DEFLECTION: part * most, SOFTNESS: 0.2}
        for softer, change, part in product(*GRID)
    ]


def _extend(draft: Draft, placement: Placement) -> None:
    """What it is where it hardly swings."""
    behind, where = _own(placement)[0], placement.where
    hub = draft.fresh(f"{where}_hub")
    draft.behind(where, hub)
    draft.flexible(hub, behind, placement[TIME] * behind, rotor_inertia=_inertia(placement))
    draft.notes.append(
        f"the files have the spring behind that of {where} as it is for small swings; "
        "it depends on the force of the blow"
    )


BEHIND = Effect(
    name="nonlinear_stiffness",
    says="the joint's spring hardens or softens",
    places=lambda context: context.joints,
    parameters=_parameters,
    starts=_starts,
    shape=_shape,
    act=_act,
    behind=lambda placement: (_own(placement)[0], _share(placement) * np.sqrt(1 + placement[SOFTER])),
    besides=_besides,
    extend=_extend,
    law=_law,
    variants=("blow",),
    comes_close=True,
    untestable=one_level,
)

"""What stands for something without a name in the improved robot: a grey box.

Effects of the catalogue at the places that the law-free look points to, one after the other, as long as they
bring the postures nearer that no fit has seen. None of them is named: together they only move as what is
there does. Each is made of masses, springs and dampers, so that the box is passive as they are; where a
coupling pushes instead of holding it is refused.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.search.explanations import explanations
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_thresholds import FLOOR_REACHED
from flexmodal.diagnosis.setup import Setup

MOST = 2
"""Effects that stand for what has no name."""
NEARER = 0.9
"""Of the distance of the postures held out that an effect may leave to be taken."""

Starts = Callable[[FittedFrfs], SetOut]


def stand_in(
    setup: Setup, look: Findings, model: FittedFrfs, starts: Starts, *, with_force: bool
) -> FittedFrfs | None:
    """A model that predicts postures held out better than a diagnosis' last, or None.

    Args:
        setup: what the diagnosis works with.
        look: what was found without a law.
        model: the last model, some of whose effects may be named.
        starts: where a search beside a model sets out.
        with_force: whether FRFs change with the force of the blow.
    """
    if not setup.held.any():
        return None
    places = {where for one in look.found for _, where in ((one.port, one.where), *one.alike)}
    best, far = model, over_noise(setup, model, setup.held)
    for number in range(MOST):
        found = explanations(
            setup,
            best,
            starts(best),
            with_force=with_force,
            enough=FLOOR_REACHED,
            advance=partial(_advance, setup, number),
            allowed=lambda effect, where: where in places,
            one_is_enough=False,
        )
        found = [one for one in found if is_passive(one)]
        if not found or (nearer := over_noise(setup, found[0], setup.held)) > NEARER * far:
            break
        best, far = found[0], nearer
        if over_noise(setup, best) <= FLOOR_REACHED:
            break
    return None if best is model else best


def stands_in(setup: Setup, model: FittedFrfs, further: FittedFrfs) -> bool:
    """Whether a model has the effects of a diagnosis' last and more, and predicts postures held out better.

    Args:
        setup: what the diagnosis works with.
        model: the last model.
        further: the other one.
    """
    if not setup.held.any() or not set(model.hypothesis.keys) < set(further.hypothesis.keys):
        return False
    far, nearer = (over_noise(setup, one, setup.held) for one in (model, further))
    return nearer <= NEARER * far and is_passive(further)


def _advance(setup: Setup, done: int, part: float) -> None:
    setup.advance("looking for a stand-in", (done + part) / MOST)


def is_passive(model: FittedFrfs) -> bool:
    """Whether mass, damping and stiffness of a model hold in every posture: nothing in it pushes.

    Args:
        model: with its effects.
    """
    for group in model.hypothesis.groups(model.x, model.fitted.misfit.observations, slopes=False):
        for matrix in (group.structures.mass, group.structures.stiffness, group.structures.damping):
            value = np.linalg.eigvalsh(matrix)
            if np.any(value[..., 0] < -1e-9 * np.abs(value).max(axis=-1)):
                return False
    return True

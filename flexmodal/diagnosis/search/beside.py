"""How a search beside a model looks at what was measured."""

from __future__ import annotations

from dataclasses import replace

from flexmodal.diagnosis.search.coarse import Look, look_at
from flexmodal.diagnosis.search.lines import worst_lines
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.diagnosis.time_domain.straightened import straightened
from flexmodal.identification.frf_fit import FrfMisfit, Weighting

MODEL_ERROR = 0.05
"""At which it is asked whether straightened measurements are nearer to a model."""
NEARER = 0.98
"""Part of the sum of squares that these leave at most. Of eight masses on a link, beside springs that soften,
two of 0.3 kg left 0.76 and 0.97 of it and were met better so; of 1 to 6 kg, 0.988 and more, they were not."""


def seen_beside(setup: Setup, model: FittedFrfs, *, by_force: bool = False) -> Look:
    """Coarse looks at what a model leaves.

    Where it has torques that are integrated in time, what is linear is looked for beside their stand-ins: a
    step of a coarse fit takes a hundredth of one with integrations. The last fits integrate. What the torques
    do beyond their stand-ins is taken out of the measurements, but where much else is missing: it lies at
    resonances that are elsewhere then.

    Args:
        setup: what the diagnosis works with.
        model: that something is added to.
        by_force: whether what is looked for depends on the force of the blow.
    """
    observations, predicted = setup.fitted, model.predicted[~setup.held]
    lines = worst_lines(observations, predicted)
    if by_force or not has_law(model.hypothesis):
        return look_at(observations, lines)
    beyond = replace(look_at(observations, lines), straight=True)
    straight = straightened(observations, model.hypothesis, model.x, predicted)
    within = replace(look_at(straight, lines), straight=True)
    return within if _left(within, model) < NEARER * _left(beyond, model) else beyond


def both_beside(setup: Setup, model: FittedFrfs) -> tuple[Look, Look]:
    """The looks for what is linear and for what depends on the blow; one where they are the same.

    Args:
        setup: what the diagnosis works with.
        model: that something is added to.
    """
    plain = seen_beside(setup, model)
    return plain, seen_beside(setup, model, by_force=True) if plain.straight else plain


def _left(look: Look, model: FittedFrfs) -> float:
    """Sum of squares of a model with stand-ins."""
    return FrfMisfit(model.hypothesis, look.apart, Weighting(MODEL_ERROR, look.lines)).cost(model.x)

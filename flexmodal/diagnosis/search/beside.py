"""How a search beside a model looks at what was measured."""

from __future__ import annotations

from dataclasses import replace

from flexmodal.diagnosis.search.coarse import Look, look_at
from flexmodal.diagnosis.search.lines import worst_lines
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.diagnosis.time_domain.straightened import straightened


def seen_beside(setup: Setup, model: FittedFrfs, *, by_force: bool = False) -> Look:
    """Coarse looks at what a model leaves.

    Where it has torques that are integrated in time, what is linear is looked for beside their stand-ins: a
    step of a coarse fit takes a hundredth of one with integrations. The last fits integrate.

    Args:
        setup: what the diagnosis works with.
        model: that something is added to.
        by_force: whether what is looked for depends on the force of the blow.
    """
    observations, predicted = setup.fitted, model.predicted[~setup.held]
    lines = worst_lines(observations, predicted)
    if by_force or not has_law(model.hypothesis):
        return look_at(observations, lines)
    straight = straightened(observations, model.hypothesis, model.x, predicted)
    return replace(look_at(straight, lines), straight=True)

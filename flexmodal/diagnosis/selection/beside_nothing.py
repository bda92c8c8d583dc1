"""What needs no model, beside a diagnosis' last model on the postures that no fit has seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.search.lines import COARSE, some_lines
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.identification import fit, gap, predict
from flexmodal.identification.baselines import Baselines, baselines, shuffled

FLOORS = (0.2, 0.05)
"""Model errors of the fit to shuffled postures: it is a control, a few per cent do not count."""
STEPS = 6


def beside_nothing(setup: Setup, model: FittedFrfs) -> Baselines | None:
    """Held-out gap of a model beside the mean of the others, the nearest posture, and shuffled postures.

    Args:
        setup: what the diagnosis works with.
        model: fitted to the postures that were not held out.

    Returns:
        None where no posture was held out, or none whose places were measured in others too.
    """
    if not setup.held.any():
        return None
    seen = setup.observations
    names = [seen.postures[k].name for k in np.unique(seen.posture[setup.held]).tolist()]
    found = baselines(seen, model.predicted, names)
    if found is None:
        return None
    fitted = gap(seen, model.predicted, ~setup.held).value
    return replace(found, fitted=fitted, shuffled=_shuffled(setup, model))


def _shuffled(setup: Setup, model: FittedFrfs) -> float | None:
    """Gap of the same hypothesis fitted while every posture bears another's angles, on what was fitted."""
    wrong = shuffled(setup.fitted)
    if has_law(model.hypothesis) or len(np.unique(wrong.posture)) < 2:
        return None
    other = Hypothesis(Context.of(setup.context.robot, wrong), setup.base)
    for placed in model.hypothesis.placed:
        other = other.and_also(placed)
    found = fit(other, wrong, model.x, floors=FLOORS, lines=some_lines(wrong, COARSE), steps=STEPS)
    return gap(wrong, predict(other, found.x, wrong)).value

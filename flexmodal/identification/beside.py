"""Baselines beside an identification: what was held out, and a fit while postures bear others' angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Shaped

from flexmodal.identification.baselines import Baselines, baselines, shuffled
from flexmodal.identification.evidence.both import Both
from flexmodal.identification.evidence.evidence import Evidence
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.gap import Gap
from flexmodal.identification.problem import IdentificationProblem


def baselines_beside(
    problem: IdentificationProblem, predicted: Shaped[np.ndarray, "observation *entry"] | None, fitted: Gap
) -> Baselines | None:
    """What needs no model, on the postures that were held out.

    Args:
        problem: what was identified, and from what.
        predicted: of each observation by a fit that had not seen its posture; None where none was held out.
        fitted: of the fit to everything that was not held out.

    Returns:
        None where modes alone were fitted, or where no posture was held out whose places others have too.
    """
    whole, seen = _frfs(problem.whole), _frfs(problem.evidence)
    if predicted is None or whole is None or seen is None:
        return None
    count, lines = whole.observations.value.shape
    receptances = np.array(list(predicted[:count])).reshape(count, lines)
    held = [name for kind, name in problem.held_out if kind == "posture"]
    found = baselines(whole.observations, receptances, held)
    if found is None:
        return None
    return replace(found, fitted=fitted.value, shuffled=shuffled_gap(seen))


def shuffled_gap(evidence: FrfEvidence) -> float | None:
    """Gap of a fit while every posture bears another's angles; None with fewer than two postures.

    Args:
        evidence: as it is fitted.
    """
    if len(np.unique(evidence.observations.posture)) < 2:
        return None
    wrong = replace(evidence, observations=shuffled(evidence.observations))
    return wrong.gap(wrong.predicted(wrong.fit(quick=True).x)).value


def _frfs(evidence: Evidence) -> FrfEvidence | None:
    """The FRFs among the data."""
    if isinstance(evidence, Both):
        return evidence.frfs
    return evidence if isinstance(evidence, FrfEvidence) else None

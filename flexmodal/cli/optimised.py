"""What `flexmodal optimise --json` prints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from flexmodal.cli.clearing import clearance_json
from flexmodal.cli.sources import band_json

if TYPE_CHECKING:
    from flexmodal.optimisation import Outcome, Start


def outcome_json(outcome: Outcome) -> dict[str, Any]:
    """The object that is printed.

    Args:
        outcome: of the search.
    """
    chosen = chosen_frequency(outcome)
    return ({} if chosen is None else {"frequency": chosen}) | {
        "posture": dict(outcome.best.posture.values),
        "objective": outcome.best.objective,
        "start": None if outcome.start is None or math.isinf(outcome.start) else outcome.start,
        "start_as_given": None if outcome.compared is None else _start(outcome.compared),
        "unit": outcome.problem.objective.unit,
        "tool": list(outcome.tool),
        "collisions": clearance_json(outcome.problem.clearance, outcome.nearest),
        "converged": outcome.converged,
        "starts": outcome.starts,
        "optima": [
            {
                "posture": dict(optimum.posture.values),
                "objective": optimum.objective,
                "hits": optimum.hits,
                "equals": [dict(other.values) for other in optimum.equals],
            }
            for optimum in outcome.optima
        ],
    }


def band_of(outcome: Outcome) -> dict[str, Any]:
    """How far the best posture's predicted receptances may be off.

    Args:
        outcome: of a search by predicted receptances.
    """
    from flexmodal.optimisation import ReceptanceObjective
    from flexmodal.prediction import PredictedReceptances

    judge = outcome.problem.objective
    assert isinstance(judge, ReceptanceObjective)
    assert isinstance(judge.source, PredictedReceptances)
    pairs = [(row, column) for row in judge.directions for column in judge.directions]
    posed = outcome.problem.robot.at(outcome.best.posture)
    return band_json(judge.source, posed, pairs, judge.frequency)


def _start(compared: Start) -> dict[str, Any]:
    """Where the start was, and where it was brought to be compared."""
    return {
        "objective": None if math.isinf(compared.objective) else compared.objective,
        "away": compared.away,
        "brought_to": None if compared.held is None else dict(compared.held.values),
    }


def chosen_frequency(outcome: Outcome) -> float | None:
    """The frequency that was chosen with the posture, if it was [Hz].

    Args:
        outcome: of the search.
    """
    from flexmodal.optimisation import TunedObjective

    objective = outcome.problem.objective
    if not isinstance(objective, TunedObjective):
        return None
    return objective.frequency_at(outcome.problem.robot.at(outcome.best.posture))

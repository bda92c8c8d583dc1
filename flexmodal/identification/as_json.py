"""An outcome as the object that `flexmodal identify --json` prints."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from flexmodal.identification.baselines import Baselines
from flexmodal.identification.outcome import Identification


def as_json(outcome: Identification) -> dict[str, Any]:
    """Parameters, correlated pairs and gaps as documented; held-out gaps, verdict and origin besides."""
    parameters = {
        one.name: {
            "value": one.value,
            "unit": one.unit,
            "standard_error": _finite(one.standard_error),
            "card": one.card,
            "at_bound": one.at_bound,
            "interval": list(one.interval) if np.all(np.isfinite(one.interval)) else None,
            "identified": one.identified,
        }
        for one in outcome.estimates
    }
    return {
        "parameters": parameters,
        "correlated": [list(pair) for pair in outcome.correlated],
        "gap": {name: _finite(value) for name, value in asdict(outcome.gap).items()},
        "held_out": [{key: _finite(value) for key, value in asdict(one).items()} for one in outcome.held_out],
        "baselines": None if outcome.baselines is None else baselines_json(outcome.baselines),
        "stages": [{key: _finite(value) for key, value in asdict(one).items()} for one in outcome.stages],
        "before_fit": outcome.before_fit.verdict,
        "not_identified": [
            {"parts": dict(one.parts), "left": one.left, "exact": one.exact, "says": one.says}
            for one in outcome.not_identified
        ],
        "optima": [{"cost": one.cost, "hits": one.hits} for one in outcome.optima],
        "over_noise": _finite(outcome.over_noise),
        "shared_misfit": _finite(outcome.shared_misfit),
        "converged": outcome.fitted.converged,
        "verdict": outcome.verdict,
        "warnings": list(outcome.problem.warnings),
        "provenance": dict(outcome.provenance),
    }


def baselines_json(found: Baselines) -> dict[str, Any]:
    """What needs no model beside what a model predicts, with the sentence on both.

    Args:
        found: on the postures that were held out.
    """
    whole = {key: _finite(value) for key, value in asdict(found).items() if key != "each"}
    each = [{key: _finite(value) for key, value in asdict(one).items()} for one in found.each]
    flags = {name: getattr(found, name) for name in ("beats_mean", "beats_nearest", "tells_postures")}
    return {**whole, **flags, "each": each, "verdict": found.verdict}


def _finite(value: Any) -> Any:
    """None for what is no number."""
    return None if isinstance(value, float) and not np.isfinite(value) else value

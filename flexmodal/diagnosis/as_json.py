"""A diagnosis as the object of `diagnosis.json` (file formats, section 3)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from flexmodal.diagnosis.joint_laws import joint_laws
from flexmodal.diagnosis.lawfree.as_json import look_json
from flexmodal.diagnosis.outcome import Diagnosis, Gaps, NextMeasurement, Region, Remaining, Step
from flexmodal.diagnosis.time_domain.swung import Swung
from flexmodal.errors import FlexmodalError
from flexmodal.identification.as_json import baselines_json

FORMAT = 1
_EVERY = 4
"""Step of a swing, of which so many are told."""


def as_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """The object that `diagnose --json` prints: plain numbers, none of them NaN or infinite.

    A held-out gap that there is not is None; a standard error that is not finite is left out.

    Raises:
        FlexmodalError: a number that has to be there is not finite.
    """
    swings = dict(joint_laws(diagnosis))
    return {
        "format": FORMAT,
        "campaign": diagnosis.campaign,
        "robot": diagnosis.robot,
        "gap": {"believed": _known(diagnosis.gaps.believed), **_gap(diagnosis.gaps)},
        "disagreement": [_region(rank, one) for rank, one in enumerate(diagnosis.disagreement, start=1)],
        "steps": [_step(step, swings.get((step.effect, step.where))) for step in diagnosis.steps],
        "verdict": {
            "effects": [list(key) for key in diagnosis.verdict.effects],
            "explained": bool(diagnosis.verdict.explained),
            "says": diagnosis.verdict.says,
            "share": _known(diagnosis.verdict.share),
            "undecided": list(diagnosis.verdict.undecided),
            "remaining": _remaining(diagnosis.verdict.remaining),
        },
        "law_free": None if diagnosis.look is None else look_json(diagnosis.look),
        "baselines": None if diagnosis.baselines is None else baselines_json(diagnosis.baselines),
        "stand_in": [list(key) for key in diagnosis.stand_in],
        "next_measurement": _next(diagnosis.next_measurement),
        "set_up": [
            {
                "what": one.nuisance.says,
                "value": _number("set_up", one.value),
                "deviation": _known(one.deviation),
                "tolerance": _number("set_up", one.nuisance.deviation),
                "unit": one.nuisance.unit,
            }
            for one in diagnosis.moved
        ],
        "warnings": list(diagnosis.warnings),
    }


def _remaining(left: Remaining | None) -> dict[str, Any] | None:
    if left is None:
        return None
    return {"over_noise": _known(left.over_noise), "where": left.where, "kind": left.kind}


def _gap(gaps: Gaps) -> dict[str, float | None]:
    return {
        "before": _number("gap before", gaps.before),
        "after": _number("gap after", gaps.after),
        "held_out_before": _known(gaps.held_out_before),
        "held_out_after": _known(gaps.held_out_after),
        "noise_floor": _number("noise floor", gaps.noise_floor),
    }


def _region(rank: int, region: Region) -> dict[str, Any]:
    low, high = region.band
    return {
        "rank": rank,
        "posture": int(region.posture),
        "response": [int(number) for number in region.response],
        "reference": [int(number) for number in region.reference],
        "trial": int(region.trial),
        "band": [_number("band", low), _number("band", high)],
        "share": _number("share", region.share),
        "kind": region.kind,
        "says": region.says,
    }


def _step(step: Step, swing: Swung | None) -> dict[str, Any]:
    return {
        "effect": step.effect,
        "where": step.where,
        "parameters": _numbers(step.parameters),
        "uncertainty": {
            name: float(value) for name, value in step.uncertainty.items() if math.isfinite(value)
        },
        "confidence": _number("confidence", step.confidence),
        "share": _known(step.share),
        "alternatives": [
            {
                "effect": one.effect,
                "where": one.where,
                "confidence": _number("confidence", one.confidence),
            }
            for one in step.alternatives
        ],
        "gap": _gap(step.gaps),
        "swing": None if swing is None else _swing(swing),
    }


def _swing(swing: Swung) -> dict[str, list[float]]:
    """A joint swung to and fro: stiffness and loss by amplitude, and the torque in the largest swing."""
    found = {
        "amplitude": swing.amplitude,
        "stiffness": swing.stiffness,
        "loss_factor": swing.loss_factor,
        "deflection": swing.deflection[-1, ::_EVERY],
        "torque": swing.torque[-1, ::_EVERY],
    }
    return {name: [_number(name, value) for value in values.tolist()] for name, values in found.items()}


def _next(measurement: NextMeasurement | None) -> dict[str, Any] | None:
    if measurement is None:
        return None
    return {
        "posture": _numbers(measurement.posture),
        "response": [int(number) for number in measurement.response],
        "reference": [int(number) for number in measurement.reference],
        "separates": separated(measurement),
        "gain": _known(measurement.gain),
        "force_peak": _known(measurement.force_peak or None),
        "new_points": {str(number): name for number, name in measurement.new_points.items()},
        "locked": list(measurement.locked),
        "masses": _numbers(measurement.masses),
    }


def separated(measurement: NextMeasurement) -> list[str]:
    """Names of the two effects; with their places where it is one effect in two places."""
    names = [explanation.partition("@")[0] for explanation in measurement.separates]
    return names if len(set(names)) == len(names) else list(measurement.separates)


def _numbers(values: Mapping[str, float]) -> dict[str, float]:
    return {name: _number(name, value) for name, value in values.items()}


def _known(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _number(name: str, value: float) -> float:
    if not math.isfinite(value):
        raise FlexmodalError(f"the diagnosis is not finite: its {name} is {value}")
    return float(value)

"""Which measurement would separate two explanations best.

Over the robot's own postures and random ones within the limits, every response and hammer point of the
campaign and every level of force, the two fitted models' receptances are compared: root mean square of
|ln(α₁/α₂)| over the noise of the campaign, which is taken to be as it was.

Where modes alone were measured, the difference of the two predictions is weighed by all that could hide it:
the noise of the FRF and what is unsure of both models' parameters, to first order,

    d² = Δᵀ (J₁C₁J₁ᵀ + J₂C₂J₂ᵀ + σ²)⁻¹ Δ,    Δ = ln(α₁/α₂),

over real and imaginary parts of all lines. A point that hardly moves has a noisier FRF: σ² grows with the
square of what points move typically over what it moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import Campaign, CampaignPosture
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import NextMeasurement
from flexmodal.identification import Observations, predict
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.gap import Gap, gap
from flexmodal.structure.structure import Axis, receptance

RANDOM = 24
"""Random postures that are tried beside the card's."""
LINES = 80
NOISE = 0.05
"""Relative noise of a line of the FRF at a point that moves as points typically do; with modes alone."""
FEW_LINES = 64
"""Of such an FRF."""
_WIDEST = np.radians(150)


def next_measurement(
    observations: Observations,
    one: tuple[Hypothesis, Float[np.ndarray, " parameter"]],
    other: tuple[Hypothesis, Float[np.ndarray, " parameter"]],
    seed: int = 0,
) -> NextMeasurement:
    """The posture, response, hammer point and level at which two fitted models differ most.

    Args:
        observations: the campaign's.
        one: a hypothesis and its coordinates.
        other: the one it is tied with.
        seed: of the random postures.
    """
    context = one[0].context
    planned = _planned(observations, postures_to_try(context, seed))
    there = replace(context, postures=planned.postures)
    stride = max(1, len(planned.axis) // LINES)
    lines = slice(stride // 2, None, stride)
    values = []
    for hypothesis, x in (one, other):
        moved = Hypothesis(there, hypothesis.base, hypothesis.placed)
        values.append(predict(moved, x, planned, lines))
    apart = np.sqrt(np.mean(np.minimum(np.abs(residual(*values)) ** 2, 4.0), axis=1))
    best = int(np.argmax(apart))
    floor = gap(observations, observations.value).noise_floor
    response, reference = planned.response[best].tolist(), planned.reference[best].tolist()
    return NextMeasurement(
        posture=dict(planned.postures[int(planned.posture[best])].q),
        response=(response[0], response[1]),
        reference=(reference[0], reference[1]),
        separates=(_label(one[0]), _label(other[0])),
        expected=float(Gap(float(apart[best]), floor).over_floor),
        force_peak=planned.peak(int(planned.level[best])),
    )


@dataclass(frozen=True, eq=False)
class Sure:
    """A fitted hypothesis and how sure its parameters are."""

    hypothesis: Hypothesis
    x: Float[np.ndarray, " parameter"]
    covariance: Float[np.ndarray, "parameter parameter"]


def next_frf(campaign: Campaign, direction: int, one: Sure, other: Sure, seed: int = 0) -> NextMeasurement:
    """Look through the card's and random postures, every point as sensor and every point as hammer point.

    Args:
        campaign: of modes, whose points there are.
        direction: of sensor and hammer, 1, 2 or 3.
        one: a fitted hypothesis.
        other: the one it is tied with.
        seed: of the random postures.
    """
    context = one.hypothesis.context
    places = [(point.id, direction) for point in context.points]
    pairs = np.array([(u, v) for v in range(len(places)) for u in range(len(places))])
    axis = Axis(np.linspace(*context.band, FEW_LINES), context.middle)
    best = (-np.inf, {}, 0)  # type: tuple[float, Mapping[str, float], int]
    for number, q in enumerate(postures_to_try(context, seed), start=1):
        there = replace(context, postures=(CampaignPosture(number, f"planned_{number}", q),))
        values = []
        for fit in (one, other):
            moved = Hypothesis(there, fit.hypothesis.base, fit.hypothesis.placed)
            (structure,) = moved.structures(fit.x, places, places, slopes=True)
            value, slopes = receptance(structure, axis, pairs, moved.space.names)
            values.append((value, slopes / np.where(value == 0, 1e-300, value), fit.covariance))
        apart = _worth(values)
        row = int(np.argmax(apart))
        best = max(best, (float(apart[row]), q, row), key=lambda found: found[0])
    expected, q, row = best
    response, reference = (places[k] for k in pairs[row].tolist())
    peaks = [trial.force_peak for trial in campaign.trials]
    return NextMeasurement(
        posture=dict(q),
        response=response,
        reference=reference,
        separates=(_label(one.hypothesis), _label(other.hypothesis)),
        expected=expected,
        force_peak=float(np.mean(peaks)) if peaks else 0.0,
    )


def _worth(values: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> np.ndarray:
    """D of every response and hammer point, a line: how many times what could hide it."""
    away = residual(values[0][0], values[1][0])
    size = np.minimum(*(np.abs(value) for value, _, _ in values))
    typical = np.median(size, axis=0)
    found = np.zeros(len(away))
    for row in range(len(away)):
        if not np.isfinite(away[row]).all() or size[row].min() == 0:
            continue  # a point that stands still
        delta = np.concatenate([away[row].real, away[row].imag])
        noise = NOISE**2 / 2 * (1 + (typical / size[row]) ** 2)
        spread = np.diag(np.concatenate([noise, noise]))
        for _, slopes, covariance in values:
            j = np.concatenate([slopes[:, row].real, slopes[:, row].imag], axis=1)
            spread += j.T @ covariance @ j
        found[row] = np.sqrt(float(delta @ np.linalg.solve(spread, delta)) / len(delta))
    return found


def _label(hypothesis: Hypothesis) -> str:
    return "@".join(hypothesis.keys[-1]) if hypothesis.placed else NONE


def postures_to_try(context: Context, seed: int) -> list[Mapping[str, float]]:
    """The card's postures, those of the campaign, and random ones."""
    robot, random = context.robot, np.random.default_rng(seed)
    found: list[Mapping[str, float]] = [dict(q) for q in robot.postures.values()]
    found += [dict(p.q) for p in context.postures]
    for _ in range(RANDOM):
        values = {}
        for name, joint in robot.commanded.items():
            wide = _WIDEST if not joint.is_prismatic else 0.5
            low, high = max(joint.lower, -wide), min(joint.upper, wide)
            values[name] = float(random.uniform(low, high)) if low < high else float(joint.lower)
        found.append(values)
    return found


def _planned(observations: Observations, postures: list[Mapping[str, float]]) -> Observations:
    """Every response, hammer point and level of the campaign in other postures; nothing measured yet."""
    key = np.unique(
        np.column_stack([observations.response, observations.reference, observations.level]), axis=0
    )
    count, lines = len(postures), observations.value.shape[1]
    table = np.tile(key, (count, 1))
    return replace(
        observations,
        postures=tuple(CampaignPosture(k + 1, f"planned_{k + 1}", q) for k, q in enumerate(postures)),
        posture=np.repeat(np.arange(count), len(key)),
        response=table[:, :2],
        reference=table[:, 2:4],
        level=table[:, 4],
        value=np.ones((len(table), lines), dtype=complex),
        variance=np.zeros((len(table), lines)),
        used=np.ones((len(table), lines), dtype=bool),
    )

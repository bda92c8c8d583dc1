"""Which FRF would tell two explanations apart best: the one that brings most information.

Over the robot's own postures and random ones within its limits, every place of sensor and hammer, and every
level of force, the two fitted models predict ln α with what is unsure of their parameters, to first order. If
the first is right, the difference Δ of the two is measured under the errors of both and the noise σ,

    I = ½ Δᵀ (J₁C₁J₁ᵀ + J₂C₂J₂ᵀ + σ²)⁻¹ Δ  [nat],

over real and imaginary parts of all lines: the expected logarithm of the odds between them (Kullback and
Leibler's divergence of two normal densities of one covariance). A point that hardly moves has a noisier FRF:
σ² grows with the square of what points move typically over what it moves.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import Campaign, CampaignPosture
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import NextMeasurement
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.gap import gap
from flexmodal.identification.model import evaluated
from flexmodal.structure.structure import Axis, receptance

RANDOM = 24
"""Random postures that are tried beside the card's."""
NOISE = 0.05
"""Relative noise of a line at a point that moves as points typically do, where no FRF was measured."""
LINES = 64
"""Of the FRF."""
_WIDEST = np.radians(150)

Place = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Sure:
    """A fitted hypothesis and how sure its parameters are."""

    hypothesis: Hypothesis
    x: Float[np.ndarray, " parameter"]
    covariance: Float[np.ndarray, "parameter parameter"]


@dataclass(frozen=True, eq=False)
class Predicted:
    """What a fitted model predicts for several measurements."""

    value: Complex[np.ndarray, "row line"]
    slopes: Complex[np.ndarray, "parameter row line"]
    """Of ln(value)."""
    covariance: Float[np.ndarray, "parameter parameter"]


@dataclass(frozen=True, eq=False)
class Plan:
    """Measurements in one posture, and what two models predict for them."""

    q: Mapping[str, float]
    rows: Sequence[tuple[Place, Place, float]]
    """Response, reference, peak of the force [N]."""
    predicted: tuple[Predicted, Predicted]


def next_among_records(observations: Observations, one: Sure, other: Sure, seed: int = 0) -> NextMeasurement:
    """The best of the campaign's own places and levels of force, in other postures; noise as it was.

    Args:
        observations: the campaign's.
        one: a fitted hypothesis.
        other: the one it is tied with.
        seed: of the random postures.
    """
    context = one.hypothesis.context
    stride = max(1, len(observations.axis) // LINES)
    lines = slice(stride // 2, None, stride)

    def plans() -> Iterator[Plan]:
        for q in postures_to_try(context, seed):
            planned = _planned(observations, q)
            there = replace(context, postures=planned.postures)
            rows = [
                (_place(response), _place(reference), planned.peak(int(level)))
                for response, reference, level in zip(
                    planned.response, planned.reference, planned.level, strict=True
                )
            ]
            yield Plan(q, rows, (_seen(one, there, planned, lines), _seen(other, there, planned, lines)))

    floor = gap(observations, observations.value).noise_floor
    return _best(plans(), floor if floor > 0 else NOISE, one, other)


def next_frf(campaign: Campaign, direction: int, one: Sure, other: Sure, seed: int = 0) -> NextMeasurement:
    """The best FRF where modes alone were measured, every point as sensor and every point as hammer point.

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
    axis = Axis(np.linspace(*context.band, LINES), context.middle)
    peaks = [trial.force_peak for trial in campaign.trials]
    peak = float(np.mean(peaks)) if peaks else 0.0
    rows = [(places[u], places[v], peak) for u, v in pairs.tolist()]

    def seen(fit: Sure, there: Context) -> Predicted:
        moved = Hypothesis(there, fit.hypothesis.base, fit.hypothesis.placed)
        (structure,) = moved.structures(fit.x, places, places, slopes=True)
        value, slopes = receptance(structure, axis, pairs, moved.space.names)
        return Predicted(value, slopes / np.where(value == 0, 1e-300, value), fit.covariance)

    def plans() -> Iterator[Plan]:
        for number, q in enumerate(postures_to_try(context, seed), start=1):
            there = replace(context, postures=(CampaignPosture(number, f"planned_{number}", q),))
            yield Plan(q, rows, (seen(one, there), seen(other, there)))

    return _best(plans(), NOISE, one, other)


def information(one: Predicted, other: Predicted, noise: float) -> Float[np.ndarray, " row"]:
    """Expected logarithm of the odds between two models by each measurement [nat]; 0 where nothing moves.

    Args:
        one: predictions of a model.
        other: of another.
        noise: relative, of a line at a point that moves as points typically do.
    """
    away = residual(one.value, other.value)
    size = np.minimum(np.abs(one.value), np.abs(other.value))
    typical = np.median(size, axis=0)
    found = np.zeros(len(away))
    for row in range(len(away)):
        if not np.isfinite(away[row]).all() or size[row].min() == 0:
            continue  # a point that stands still
        delta = np.concatenate([away[row].real, away[row].imag])
        spread = np.diag(np.tile(noise**2 / 2 * (1 + (typical / size[row]) ** 2), 2))
        for model in (one, other):
            j = np.concatenate([model.slopes[:, row].real, model.slopes[:, row].imag], axis=1)
            spread += j.T @ model.covariance @ j
        found[row] = 0.5 * float(delta @ np.linalg.solve(spread, delta))
    return found


def _best(plans: Iterable[Plan], noise: float, one: Sure, other: Sure) -> NextMeasurement:
    """The measurement that brings most."""
    gained, q, (response, reference, peak), lines = -1.0, dict[str, float](), ((0, 0), (0, 0), 0.0), 1
    for plan in plans:
        gain = information(*plan.predicted, noise)
        row = int(np.argmax(gain))
        if gain[row] > gained:
            gained, q, lines = float(gain[row]), dict(plan.q), plan.predicted[0].value.shape[1]
            response, reference, peak = plan.rows[row]
    return NextMeasurement(
        posture=q,
        response=response,
        reference=reference,
        separates=(_label(one.hypothesis), _label(other.hypothesis)),
        expected=float(np.sqrt(gained / lines)),
        force_peak=peak,
        gain=gained,
    )


def _seen(fit: Sure, there: Context, planned: Observations, lines: slice) -> Predicted:
    moved = Hypothesis(there, fit.hypothesis.base, fit.hypothesis.placed)
    count = len(planned.axis.take(lines))
    value = np.zeros((len(planned), count), dtype=complex)
    slopes = np.zeros((len(moved.space), len(planned), count), dtype=complex)
    for some, seen, changes in evaluated(moved, fit.x, planned, lines, slopes=True):
        value[some], slopes[:, some] = seen, changes
    return Predicted(value, slopes / np.where(value == 0, 1e-300, value), fit.covariance)


def _place(row: np.ndarray) -> Place:
    point, direction = row.tolist()
    return point, direction


def _label(hypothesis: Hypothesis) -> str:
    return "@".join(hypothesis.keys[-1]) if hypothesis.placed else NONE


def postures_to_try(context: Context, seed: int) -> list[Mapping[str, float]]:
    """The card's postures, those of the campaign, and random ones.

    Args:
        context: whose robot and campaign.
        seed: of the random ones.
    """
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


def _planned(observations: Observations, q: Mapping[str, float]) -> Observations:
    """Every response, hammer point and level of the campaign in another posture; nothing measured yet."""
    table = np.unique(
        np.column_stack([observations.response, observations.reference, observations.level]), axis=0
    )
    shape = len(table), observations.value.shape[1]
    return replace(
        observations,
        postures=(CampaignPosture(1, "planned", q),),
        posture=np.zeros(len(table), dtype=int),
        response=table[:, :2],
        reference=table[:, 2:4],
        level=table[:, 4],
        value=np.ones(shape, dtype=complex),
        variance=np.zeros(shape),
        used=np.ones(shape, dtype=bool),
    )

"""Which FRF would tell two fitted explanations apart best: posture, response and hammer point.

The difference of the two predictions is weighed by all that could hide it: the noise of the FRF and what is
unsure of both models' parameters, to first order,

    d² = Δᵀ (J₁C₁J₁ᵀ + J₂C₂J₂ᵀ + σ²)⁻¹ Δ,    Δ = ln(α₁/α₂),

over real and imaginary parts of all lines. A point that hardly moves has a noisier FRF: σ² grows with the
square of what points move typically over what it moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPosture
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.modes.evidence import ModalFit
from flexmodal.diagnosis.modes.stand_in import stand_in
from flexmodal.diagnosis.next_measurement import postures_to_try
from flexmodal.diagnosis.outcome import NextMeasurement
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.model import evaluated

NOISE = 0.05
"""Relative noise of a line of the FRF at a point that moves as points typically do."""


def next_frf(one: ModalFit, other: ModalFit, seed: int = 0) -> NextMeasurement:
    """Look through the card's and random postures, every point as sensor and every point as hammer point.

    Args:
        one: a fitted explanation with structure.
        other: the one it is tied with.
        seed: of the random postures.
    """
    scene, campaign = one.explanation.hypothesis.context, one.measured.campaign
    direction = one.measured.places[0][1]
    places = [(point.id, direction) for point in campaign.points]
    best: tuple[float, Mapping[str, float], np.ndarray, np.ndarray] | None = None
    for number, q in enumerate(postures_to_try(scene, seed)):
        planned = stand_in(campaign, [CampaignPosture(1, f"planned_{number}", q)], places, places)
        values = [_predicted(fit, scene, planned) for fit in (one, other)]
        for row, worth in enumerate(_worth(values)):
            if best is None or worth > best[0]:
                best = (worth, q, planned.response[row], planned.reference[row])
    assert best is not None
    worth, q, response, reference = best
    return NextMeasurement(
        posture=dict(q),
        response=(int(response[0]), int(response[1])),
        reference=(int(reference[0]), int(reference[1])),
        separates=("@".join(one.explanation.key), "@".join(other.explanation.key)),
        expected=float(worth),
        force_peak=float(np.mean([trial.force_peak for trial in campaign.trials]))
        if campaign.trials
        else 0.0,
    )


def _predicted(
    fit: ModalFit, scene: Context, planned: Observations
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Receptances, slopes of their logarithm, covariance of the parameters."""
    old = fit.explanation.hypothesis
    moved = Hypothesis(replace(scene, postures=planned.postures), old.base, old.placed)
    size, lines = len(moved.space), slice(None)
    value = np.zeros((len(planned), len(planned.axis.take(lines))), dtype=complex)
    slopes = np.zeros((size, *value.shape), dtype=complex)
    for rows, found, turned in evaluated(moved, fit.x[:size], planned, lines, slopes=True):
        value[rows], slopes[:, rows] = found, turned
    safe = np.where(value == 0, 1e-300, value)
    return value, slopes / safe, fit.covariance[:size, :size]


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

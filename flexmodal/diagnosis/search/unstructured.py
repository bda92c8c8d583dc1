"""A mode with no structure: what one more resonance, of any shape, would explain.

    α = α₀ + R/(ω_r² − ω² + 2iζ_r ω_r ω)

with α₀ the model as it is, ω_r and ζ_r of each posture, and a residue R of each pair of response and hammer
point in it, all free. No effect stands behind it, so that it foretells nothing for a posture it was not
fitted to but the mean of the others. An explanation worth its name does better with fewer parameters; this
one is compared beside the others and never added. The residues follow from ω_r and ζ_r by linear least
squares (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float, Int
from scipy.optimize import minimize

from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs, cluster_costs
from flexmodal.diagnosis.setup import Setup
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import Weighting

_FREQUENCIES, _RATIOS = 60, (0.01, 0.04, 0.15)
"""Of the grid on which the search begins."""
_LEAST = 1e-3
"""Damping ratio at least."""


@dataclass(frozen=True, eq=False)
class _Mode:
    """The mode of one posture."""

    x: Float[np.ndarray, " 2"]
    """ln ω_r [rad/s], ln ζ_r."""
    pairs: Int[np.ndarray, "pair 4"]
    residue: Float[np.ndarray, " pair"]
    """[1/kg]"""
    occam: float
    """½ ln of what its parameters are known better after the fit than before."""


def unstructured_mode(setup: Setup, before: FittedFrfs) -> FittedFrfs:
    """One more mode in each posture, on top of a model.

    Args:
        setup: what the diagnosis works with; the postures held out get the mean of the modes of the others.
        before: the model.
    """
    observations = setup.observations
    modes = {
        k: _fitted(observations, before, np.flatnonzero(observations.posture == k))
        for k in np.unique(observations.posture[~setup.held]).tolist()
    }
    predicted = before.predicted.copy()
    for k in np.unique(observations.posture).tolist():
        rows = np.flatnonzero(observations.posture == k)
        predicted[rows] += _added(observations, rows, modes.get(k) or _mean(list(modes.values())))
    parameters = sum(2 + len(one.residue) for one in modes.values())
    return replace(
        before,
        key=(UNSTRUCTURED, ""),
        costs=cluster_costs(observations, predicted, before.fitted.weighing.floor),
        occam=before.occam + sum(one.occam for one in modes.values()),
        strong=before.strong + parameters,
        parameters=before.parameters + parameters,
        predicted=predicted,
    )


def _pairs(observations: Observations, rows: Int[np.ndarray, " row"]) -> Int[np.ndarray, "row 4"]:
    return np.hstack([observations.response[rows], observations.reference[rows]])


def _resonance(omega: Float[np.ndarray, " line"], x: Float[np.ndarray, " 2"]) -> Complex[np.ndarray, " line"]:
    at, ratio = np.exp(x)
    return 1 / (at**2 - omega**2 + 2j * ratio * at * omega)


def _fitted(observations: Observations, before: FittedFrfs, rows: Int[np.ndarray, " row"]) -> _Mode:
    """The mode of a posture that takes most of the sum of squares away."""
    omega = 2 * np.pi * observations.axis.frequency
    every = Weighting(before.fitted.weighing.floor, np.arange(len(omega)))
    size = np.maximum(np.abs(observations.value[rows]), 1e-300)
    weight = every.weight(observations)[rows] / size**2
    rest = observations.value[rows] - before.predicted[rows]
    pairs, owner = np.unique(_pairs(observations, rows), axis=0, return_inverse=True)

    def solved(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residues, and how well the data know them."""
        shape = _resonance(omega, x)
        onto = (weight * (rest * shape.conj()).real).sum(axis=1)
        known = (weight * np.abs(shape) ** 2).sum(axis=1)
        onto, known = (np.bincount(owner.ravel(), one, len(pairs)) for one in (onto, known))
        return onto / np.maximum(known, 1e-300), known

    def taken(x: np.ndarray) -> float:
        residue, known = solved(x)
        return -float(np.sum(known * residue**2))

    low, high = np.log(max(omega[0], omega[1] / 2)), np.log(omega[-1])
    grid = [np.array([at, np.log(ratio)]) for at in np.linspace(low, high, _FREQUENCIES) for ratio in _RATIOS]
    bounds = [(low, high), (np.log(_LEAST), 0.0)]
    x = minimize(taken, min(grid, key=taken), method="Nelder-Mead", bounds=bounds).x
    residue, known = solved(x)
    bend = [_bend(taken, x, k) for k in range(2)]
    occam = 0.5 * float(np.sum(np.log1p(known * residue**2)) + np.sum(np.log1p(bend)))
    return _Mode(x, pairs, residue, occam)


def _bend(function: Callable[[np.ndarray], float], x: Float[np.ndarray, " 2"], k: int) -> float:
    """Half the second derivative along one coordinate, 0 where it bends downwards."""
    step = np.where(np.arange(2) == k, 1e-3, 0.0)
    return max((function(x + step) + function(x - step) - 2 * function(x)) / 2e-6, 0.0)


def _mean(modes: list[_Mode]) -> _Mode:
    """The mean of several postures' modes; of a pair's residues where it was measured."""
    pairs, owner = np.unique(np.vstack([one.pairs for one in modes]), axis=0, return_inverse=True)
    every = np.concatenate([one.residue for one in modes])
    mean = np.bincount(owner.ravel(), every) / np.bincount(owner.ravel())
    return _Mode(np.mean([one.x for one in modes], axis=0), pairs, mean, 0.0)


def _added(
    observations: Observations, rows: Int[np.ndarray, " row"], mode: _Mode
) -> Complex[np.ndarray, "row line"]:
    omega = 2 * np.pi * observations.axis.frequency
    residues = {tuple(pair): value for pair, value in zip(mode.pairs.tolist(), mode.residue, strict=True)}
    each = np.array([residues.get(tuple(pair), 0.0) for pair in _pairs(observations, rows).tolist()])
    return each[:, None] * _resonance(omega, mode.x)

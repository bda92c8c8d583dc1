"""Why shapes decide between two explanations, or cannot.

Two fitted explanations predict shapes at the measured places. Where these agree, no measurement there tells
the explanations apart; where measured shapes scatter more than the predictions differ, these do not. What
they say for one explanation against the other is the difference of their log-likelihoods; what shapes that
follow one of them would say, measured with the concentration κ of the Watson density, is κ (1 − MAC) nats,
MAC being that of the two predictions.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.scatter import SHAPE, log_watson_constant
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.modal.mac import mac_with

CLEAN = 100.0
"""κ of a carefully measured shape: at six places its MAC with the true one is 0.95."""


@dataclass(frozen=True)
class ModeShapes:
    """One measured mode, by number."""

    number: int
    frequency: float
    """Median [Hz]."""
    measured: float
    """Mean MAC of the measured shapes of two postures; NaN with one."""
    model: tuple[float, float]
    """The same of what the two explanations predict for these postures."""
    met: tuple[float, float]
    """Mean MAC of each prediction with the measured shape."""
    alike: float
    """Mean MAC of one prediction with the other."""
    says: float
    """What the measured shapes say for the first and against the second [nat]."""
    clean: float
    """What shapes that follow one of the two would say, measured carefully [nat]."""


def compare_shapes(one: ModalFit, other: ModalFit) -> tuple[ModeShapes, ...]:
    """Every measured mode that both explanations have, by frequency.

    Args:
        one: an explanation.
        other: another, of the same modes.
    """
    measured, found = one.measured, []
    for number in measured.numbers:
        entries = []
        for k, mode in enumerate(measured.modes):
            partners = one.pairs[k], other.pairs[k]
            if mode.number != number or min(partners) < 0 or not mode.shapes:
                continue
            shape = max(mode.shapes, key=lambda s: len(s.places))
            rows = measured.rows(shape.places)
            seen = [
                fit.forecasts[mode.posture].shape[rows, m]
                for fit, m in zip((one, other), partners, strict=True)
            ]
            if len(rows) > 1 and not any(np.isnan(s).any() for s in seen):
                entries.append((mode, dict(zip(rows, zip(shape.residue, *seen, strict=True), strict=True))))
        if entries:
            found.append(
                _mode_shapes(number, entries, [fit.scales[f"{SHAPE}.{number}"] for fit in (one, other)])
            )
    return tuple(sorted(found, key=lambda m: m.frequency))


def _mode_shapes(number: int, entries: list, log_kappa: list[float]) -> ModeShapes:  # type: ignore[type-arg]
    columns = [np.array(list(rows.values())).T for _, rows in entries]
    alike = [mac_with(c[1], c[2]) for c in columns]
    return ModeShapes(
        number,
        float(np.median([mode.frequency for mode, _ in entries])),
        _between(entries, 0),
        (_between(entries, 1), _between(entries, 2)),
        (
            float(np.mean([mac_with(c[0], c[1]) for c in columns])),
            float(np.mean([mac_with(c[0], c[2]) for c in columns])),
        ),
        float(np.mean(alike)),
        _likely(columns, 1, log_kappa[0]) - _likely(columns, 2, log_kappa[1]),
        float(CLEAN * np.sum(1 - np.array(alike))),
    )


def _likely(columns: list[np.ndarray], which: int, log_kappa: float) -> float:
    """Ln likelihood of the measured shapes under one explanation."""
    kappa = float(np.exp(log_kappa))
    return sum(kappa * mac_with(c[0], c[which]) - log_watson_constant(len(c[0]), kappa) for c in columns)


def _between(entries: list, column: int) -> float:  # type: ignore[type-arg]
    """Mean MAC between postures, at the places that they share."""
    found = []
    for (_, a), (_, b) in combinations(entries, 2):
        shared = sorted(set(a) & set(b))
        if len(shared) > 1:
            found.append(
                mac_with(np.array([a[r][column] for r in shared]), np.array([b[r][column] for r in shared]))
            )
    return float(np.mean(found)) if found else float("nan")


def shapes_of(measured: ModeObservations, number: int) -> dict[int, tuple[list[int], np.ndarray]]:
    """Measured shapes of one mode by posture number: rows in `measured.responses`, residues of unit size.

    Args:
        measured: the modes that were measured.
        number: of the mode.
    """
    found = {}
    for mode in measured.modes:
        if mode.number == number and mode.shapes:
            shape = max(mode.shapes, key=lambda s: len(s.places))
            found[mode.posture] = (measured.rows(shape.places), shape.residue / np.linalg.norm(shape.residue))
    return found

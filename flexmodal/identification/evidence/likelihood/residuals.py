"""How far a model's modes are off the measured ones they are paired with, kind by kind."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidSystem
from flexmodal.identification.evidence.likelihood.forecast import Forecast
from flexmodal.identification.evidence.likelihood.likelihood import DAMPING_GRANT, Likelihood, Pairs
from flexmodal.identification.evidence.likelihood.scatter import DAMPING, FREQUENCY, SHAPE
from flexmodal.modal.mac import mac_with, shape_residual


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of the pairs: how far off, their slopes, the variance that the measurement has."""

    kind: tuple[str, ...]
    """Of each entry: frequency, damping or `shape.NUMBER`."""
    away: Float[np.ndarray, " entry"]
    slopes: Float[np.ndarray, "parameter entry"]
    variance: Float[np.ndarray, " entry"]
    dimension: tuple[tuple[str, int, float], ...]
    """Of each shape: its scale, how many places, MAC."""

    def weights(self, scales: Mapping[str, float], grant: float) -> Float[np.ndarray, " entry"]:
        """Of each squared residual in minus twice the log-likelihood."""
        granted = {FREQUENCY: grant, DAMPING: DAMPING_GRANT * grant}
        return np.array(
            [
                2 * np.exp(scales[kind]) / (1 + 2 * np.exp(scales[kind]) * (DAMPING_GRANT * grant) ** 2)
                if kind.startswith(SHAPE)
                else 1 / (v + np.exp(2 * scales[kind]) + granted[kind] ** 2)
                for kind, v in zip(self.kind, self.variance, strict=True)
            ]
        )


@dataclass(frozen=True, eq=False)
class _Part:
    """Entries of one kind of one pair."""

    kind: str
    away: Float[np.ndarray, " entry"]
    slopes: Float[np.ndarray, "entry parameter"]
    variance: float
    alike: tuple[str, int, float] | None = None


def residuals(likelihood: Likelihood, seen: Sequence[Forecast], pairs: Pairs) -> Residuals:
    """Residuals of all pairs.

    Args:
        likelihood: of the measured modes.
        seen: what the model predicts in each posture, with slopes or without.
        pairs: which mode is which.

    Raises:
        InvalidSystem: a pair with a mode that no longer oscillates.
    """
    parts = [
        part
        for here, one in zip(likelihood.measured.here, seen, strict=True)
        for k in here
        if pairs[k] >= 0
        for part in _parts(likelihood, k, one, pairs[k])
    ]
    count = len(seen[0].frequency_slope) if seen else 0
    return Residuals(
        tuple(part.kind for part in parts for _ in part.away),
        np.concatenate([np.zeros(0), *(part.away for part in parts)]),
        np.concatenate([np.zeros((0, count)), *(part.slopes for part in parts)]).T,
        np.array([part.variance for part in parts for _ in part.away]),
        tuple(part.alike for part in parts if part.alike is not None),
    )


def _parts(likelihood: Likelihood, k: int, seen: Forecast, m: int) -> Iterator[_Part]:
    """Of measured mode k as the model's mode m."""
    mode = likelihood.measured.modes[k]
    if m >= len(seen.log_frequency):
        raise InvalidSystem(Fault("model", f"mode {m + 1}", "overdamped", "one that oscillates"))
    away = seen.log_frequency[[m]] - np.log(mode.frequency)
    yield _Part(FREQUENCY, away, seen.frequency_slope[:, [m]].T, mode.frequency_error**2)
    if np.isfinite(mode.damping_ratio):
        away = seen.log_damping[[m]] - np.log(mode.damping_ratio)
        yield _Part(DAMPING, away, seen.damping_slope[:, [m]].T, mode.damping_error**2)
    if not likelihood.beliefs.shapes or np.isnan(seen.shape[0, m]):
        return
    for rows, a in likelihood.shapes[k]:
        if len(rows) > 1:
            name, model = f"{SHAPE}.{mode.number}", seen.shape[rows, m]
            away, slopes = shape_residual(a, model, seen.shape_slope[:, rows, m])
            yield _Part(name, away, slopes.T, 0.0, (name, len(rows), mac_with(a, model)))

"""How far a model's modes are off the measured ones they are paired with, kind by kind.

For a measured mode with the partner p in the model (λ_p, u_p):

    frequency      ln |λ_p| − ln ω
    damping        ln ζ_p − ln ζ, or (ζ_p − ζ)/ζ
    shape          a − P a, a the measured residues, P onto the model's shape: |·|² = 1 − MAC
    residue        ln (φ_u φ_v / A), phase wrapped

Frequency and the relative error of damping are the eigenvalue error [Hearne 2.54]; shapes beside them [2.53].
Derivatives are exact (`structure.poles`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from flexmodal.errors import Fault, InvalidSystem
from flexmodal.identification.evidence.likelihood.forecast import Forecast
from flexmodal.identification.evidence.likelihood.likelihood import DAMPING_GRANT, Likelihood, Pairs
from flexmodal.identification.evidence.likelihood.scatter import DAMPING, FREQUENCY, RESIDUE, SHAPE
from flexmodal.identification.evidence.measured_modes import MeasuredShape
from flexmodal.modal.mac import mac_with, shape_residual

TENTH = 10.0
"""How many times the model error of a frequency those of damping, shapes and residues are."""


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of the pairs: how far off, their slopes, the variance that the measurement has."""

    owner: Int[np.ndarray, " entry"]
    """Number of the mode or antiresonance that each is of."""
    kind: tuple[str, ...]
    """Of each entry: frequency, damping, `shape.NUMBER`, residue or antiresonance."""
    away: Float[np.ndarray, " entry"]
    slopes: Float[np.ndarray, "parameter entry"]
    variance: Float[np.ndarray, " entry"]
    coarse: Float[np.ndarray, " entry"]
    """Multiple of the model error of a frequency that each is granted."""
    dimension: tuple[tuple[str, int, float], ...]
    """Of each shape: its scale, how many places, MAC."""

    def weights(self, scales: Mapping[str, float], grant: float) -> Float[np.ndarray, " entry"]:
        """Of each squared residual in minus twice the log-likelihood, the scatter being inferred.

        Args:
            scales: logarithms of the scales of the scatter.
            grant: relative error of frequencies that is granted besides.
        """
        granted = {FREQUENCY: grant, DAMPING: DAMPING_GRANT * grant}
        return np.array(
            [
                2 * np.exp(scales[kind]) / (1 + 2 * np.exp(scales[kind]) * (DAMPING_GRANT * grant) ** 2)
                if kind.startswith(SHAPE)
                else 1 / (v + np.exp(2 * scales[kind]) + granted[kind] ** 2)
                for kind, v in zip(self.kind, self.variance, strict=True)
            ]
        )

    def relative(self) -> Residuals:
        """The same with the relative error of damping ratios in the place of the logarithm's."""
        damped = np.array([kind == DAMPING for kind in self.kind], dtype=bool)
        away = np.where(damped, np.expm1(self.away), self.away)
        return replace(self, away=away, slopes=self.slopes * np.where(damped, 1 + away, 1.0))

    def granting(self, floor: float) -> Float[np.ndarray, " entry"]:
        """Of each squared residual where the model is granted an error of frequencies that is given."""
        return 1 / (self.variance + (floor * self.coarse) ** 2)


@dataclass(frozen=True, eq=False)
class Part:
    """Entries of one kind of one pair."""

    owner: int
    kind: str
    away: Float[np.ndarray, " entry"]
    slopes: Float[np.ndarray, "entry parameter"]
    variance: Float[np.ndarray, " entry"]
    coarse: float
    alike: tuple[str, int, float] | None = None


def residuals(
    likelihood: Likelihood, seen: Sequence[Forecast], pairs: Pairs, more: Iterable[Part] = ()
) -> Residuals:
    """Residuals of all pairs.

    Args:
        likelihood: of the measured modes.
        seen: what the model predicts in each posture, with slopes or without.
        pairs: which mode is which.
        more: residuals of what is no mode.

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
    parts += more
    count, none = len(seen[0].frequency_slope) if seen else 0, np.zeros(0)
    return Residuals(
        np.array([part.owner for part in parts for _ in part.away], dtype=int),
        tuple(part.kind for part in parts for _ in part.away),
        np.concatenate([none, *(part.away for part in parts)]),
        np.concatenate([np.zeros((0, count)), *(part.slopes for part in parts)]).T,
        np.concatenate([none, *(part.variance for part in parts)]),
        np.array([part.coarse for part in parts for _ in part.away], dtype=float),
        tuple(part.alike for part in parts if part.alike is not None),
    )


def _parts(likelihood: Likelihood, k: int, seen: Forecast, m: int) -> Iterator[Part]:
    """Of measured mode k as the model's mode m."""
    mode, use = likelihood.measured.modes[k], likelihood.use
    if m >= len(seen.log_frequency):
        raise InvalidSystem(Fault("model", f"mode {m + 1}", "overdamped", "one that oscillates"))
    if FREQUENCY in use:
        away, variance = seen.log_frequency[[m]] - np.log(mode.frequency), np.array([mode.frequency_error**2])
        yield Part(k, FREQUENCY, away, seen.frequency_slope[:, [m]].T, variance, 1.0)
    if DAMPING in use and np.isfinite(mode.damping_ratio):
        away, variance = seen.log_damping[[m]] - np.log(mode.damping_ratio), np.array([mode.damping_error**2])
        yield Part(k, DAMPING, away, seen.damping_slope[:, [m]].T, variance, TENTH)
    if np.isnan(seen.shape[0, m]):
        return
    for shape, (rows, a) in zip(mode.shapes, likelihood.shapes[k], strict=True):
        if SHAPE in use and likelihood.beliefs.shapes and len(rows) > 1:
            name, model = f"{SHAPE}.{mode.number}", seen.shape[rows, m]
            away, slopes = shape_residual(a, model, seen.shape_slope[:, rows, m])
            variance = np.tile((np.abs(a) * shape.error) ** 2, 2) / 2  # each part has half of it
            alike = name, len(rows), mac_with(a, model)
            yield Part(k, name, away, slopes.T, variance, TENTH / np.sqrt(2 * len(a)), alike)
        if RESIDUE in use:
            yield _residue(k, shape, seen, m, rows, likelihood.measured.places.index(shape.reference))


def _residue(k: int, shape: MeasuredShape, seen: Forecast, m: int, rows: list[int], struck: int) -> Part:
    """ln(φ_u φ_v / A): size and phase."""
    u, v = seen.shape[rows, m], seen.shape[struck, m]
    model, turned = u * v, seen.shape_slope[:, rows, m] * v + np.outer(seen.shape_slope[:, struck, m], u)
    kept = np.where(model == 0, 1e-300, model)
    away, slopes = np.log(kept / shape.residue), turned / kept
    return Part(
        k, RESIDUE, np.concatenate([away.real, away.imag]),
        np.concatenate([slopes.real, slopes.imag], axis=1).T, np.tile(shape.error**2, 2) / 2, TENTH,
    )  # fmt: skip

"""Fit an explanation to the modes of several postures, and reckon its evidence.

Which mode is which, the parameters and the scales of the scatter are improved in turn: pairs by the
likelihood (`scipy.optimize.linear_sum_assignment`), parameters by Gauss and Newton, scales one by one. The
evidence is Laplace's, over parameters and scales together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.modes.forecast import Explanation, Forecast
from flexmodal.diagnosis.modes.scatter import (
    DAMPING,
    FREQUENCY,
    LEAST,
    MOST,
    SHAPE,
    Beliefs,
    log_anywhere,
    log_normal,
    log_watson_constant,
)
from flexmodal.diagnosis.modes.stand_in import band_of, places_of_modes, stand_in
from flexmodal.errors import Fault, InvalidSystem
from flexmodal.identification import Observations
from flexmodal.identification.descent import Normal, descend, prior_cost
from flexmodal.identification.mode_data import MeasuredMode, ModeObservations

COARSE = (0.12, 0.03)
"""Relative errors of frequencies that the first rounds grant a model, so that pairs can find each other."""
ROUNDS = 8
SETTLED = 1e-6
NOT = -1e9


@dataclass(frozen=True, eq=False)
class MeasuredModes:
    """Measured modes with what a fit needs besides."""

    observed: ModeObservations

    @property
    def campaign(self) -> Campaign:
        """Where they come from."""
        return self.observed.campaign

    @cached_property
    def band(self) -> tuple[float, float]:
        """Where peaks were looked for [Hz]."""
        return band_of(self.campaign)

    @cached_property
    def places(self) -> tuple[tuple[int, int], ...]:
        """Responses of the shapes; the first point, upwards, where there are no shapes."""
        return places_of_modes(self.observed)[0] or ((self.campaign.points[0].id, 3),)

    @cached_property
    def stand_in(self) -> Observations:
        """For hypotheses: nothing measured."""
        references = places_of_modes(self.observed)[1]
        return stand_in(self.campaign, self.observed.postures, self.places, references)

    @cached_property
    def numbers(self) -> tuple[int, ...]:
        """Modes as the measurement counts."""
        return tuple(sorted({mode.number for mode in self.observed.modes}))

    @cached_property
    def here(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of the modes of each posture."""
        return tuple(self.observed.in_posture(k) for k in range(len(self.observed.postures)))

    def keeping(self, keep: Bool[np.ndarray, " mode"]) -> MeasuredModes:
        """Some of the modes."""
        return MeasuredModes(self.observed.keeping(keep))

    def rows(self, places: np.ndarray) -> list[int]:
        """Where places stand among `places`."""
        return [self.places.index((int(p), int(d))) for p, d in places]


Pairs = tuple[int, ...]
"""For each measured mode the number of the model's mode in its posture; −1 for none."""


@dataclass(frozen=True, eq=False)
class ModalFit:
    """An explanation at its best."""

    explanation: Explanation
    measured: MeasuredModes
    beliefs: Beliefs
    x: Float[np.ndarray, " parameter"]
    scales: Mapping[str, float]
    """Logarithms of the scales: frequency, damping, `shape.NUMBER`."""
    pairs: Pairs
    log_posterior: float
    evidence: float
    """ln of the evidence [nat]."""
    covariance: Float[np.ndarray, "parameter parameter"]
    """Of x, scales at their best."""
    forecasts: tuple[Forecast, ...]
    """Of each posture, with slopes."""


def fit_modes(
    explanation: Explanation,
    measured: MeasuredModes,
    start: Float[np.ndarray, " parameter"],
    beliefs: Beliefs,
    *,
    pairs: Pairs | None = None,
    scales: Mapping[str, float] | None = None,
    quick: bool = False,
) -> ModalFit:
    """Fit from one start.

    Args:
        explanation: what is fitted.
        measured: to what.
        start: coordinates to begin at.
        beliefs: priors of the scatter.
        pairs: keep to these while the model is still far off.
        scales: begin with these, and with pairs that fit them: `start` is near.
        quick: a first look only.

    Raises:
        InvalidSystem: no model at the start.
    """
    task = _Task(explanation, measured, beliefs)
    x = np.array(start, dtype=float)
    given = dict(scales) if scales else task.usual()
    if scales is None:
        for grant in COARSE:
            held = task.pair(x, given, grant) if pairs is None else pairs
            x = task.improve(x, given, held, grant, 5 if quick else 12)
    pairs = task.pair(x, given, 0.0)
    last = -np.inf
    for _ in range(2 if quick else ROUNDS):
        x = task.improve(x, given, pairs, 0.0, 5 if quick else 20)
        given = task.rescale(x, given, pairs)
        pairs = task.pair(x, given, 0.0)
        value = task.log_posterior(x, given, pairs)
        if value - last < SETTLED:
            break
        last = value
    return task.finish(x, given, pairs)


@dataclass(frozen=True, eq=False)
class _Residuals:
    """Residuals of the pairs by kind: how far off, their slopes, the variance that the measurement has."""

    kind: tuple[str, ...]
    """Of each entry: frequency, damping or `shape.NUMBER`."""
    away: Float[np.ndarray, " entry"]
    slopes: Float[np.ndarray, "parameter entry"]
    variance: Float[np.ndarray, " entry"]
    dimension: tuple[tuple[str, int, float], ...]
    """Of each shape: its scale, how many places, MAC."""


class _Task:
    """One explanation, one set of modes, one set of beliefs."""

    def __init__(self, explanation: Explanation, measured: MeasuredModes, beliefs: Beliefs) -> None:
        self.explanation, self.measured, self.beliefs = explanation, measured, beliefs
        self.space = explanation.space
        self.shapes = {
            k: [(measured.rows(s.places), s.residue / np.linalg.norm(s.residue)) for s in mode.shapes]
            for k, mode in enumerate(measured.observed.modes)
        }

    def usual(self) -> dict[str, float]:
        means = self.beliefs.scales
        found = {FREQUENCY: means[FREQUENCY][0], DAMPING: means[DAMPING][0]}
        return found | {f"{SHAPE}.{number}": float(means[SHAPE][0]) for number in self.measured.numbers}

    def see(self, x: np.ndarray, *, slopes: bool) -> list[Forecast]:
        return self.explanation.forecasts(x, self.measured.stand_in, self.measured.places, slopes=slopes)

    # which mode is which

    def pair(self, x: np.ndarray, scales: Mapping[str, float], grant: float) -> Pairs:
        return self.pair_seen(self.see(x, slopes=False), scales, grant)

    def pair_seen(self, seen: Sequence[Forecast], scales: Mapping[str, float], grant: float) -> Pairs:
        from scipy.optimize import linear_sum_assignment

        pairs = [-1] * len(self.measured.observed.modes)
        for number, here in enumerate(self.measured.here):
            if not here:
                continue
            gain = np.array([self.gains(k, seen[number], scales, grant) for k in here])
            padded = np.concatenate([gain, np.zeros((len(here), len(here)))], axis=1)
            for row, column in zip(*linear_sum_assignment(-padded), strict=True):
                if column < gain.shape[1] and gain[row, column] > NOT / 2:
                    pairs[here[row]] = int(column)
        return tuple(pairs)

    def gains(
        self,
        k: int,
        seen: Forecast,
        scales: Mapping[str, float],
        grant: float,
        spread: np.ndarray | None = None,
    ) -> Float[np.ndarray, " mode"]:
        """Ln likelihood of a measured mode as each of the model's, over that of a peak from anywhere."""
        mode = self.measured.observed.modes[k]
        found = np.full(len(seen.log_frequency), NOT)
        for m in range(len(found)):
            more = (0.0, 0.0) if spread is None else (spread[0, m], spread[1, m])
            found[m] = self.as_mode(k, mode, seen, m, scales, grant, more) - self.anywhere(mode)
            found[m] -= self.overlooked(seen, m)
        return found

    def as_mode(
        self,
        k: int,
        mode: MeasuredMode,
        seen: Forecast,
        m: int,
        scales: Mapping[str, float],
        grant: float,
        more: tuple[float, float] = (0.0, 0.0),
    ) -> float:
        """Ln likelihood of a measured mode that is the model's mode m."""
        s, z = np.exp(2 * scales[FREQUENCY]), np.exp(2 * scales[DAMPING])
        variance = mode.frequency_error**2 + s + grant**2 + more[0]
        total = float(np.log(self.beliefs.seen)) + log_normal(
            float(seen.log_frequency[m] - np.log(mode.frequency)), variance
        )
        if np.isfinite(mode.damping_ratio):
            variance = mode.damping_error**2 + z + (5 * grant) ** 2 + more[1]
            total += log_normal(float(seen.log_damping[m] - np.log(mode.damping_ratio)), variance)
        if self.beliefs.shapes and not np.isnan(seen.shape[0, m]):
            kappa = float(np.exp(scales[f"{SHAPE}.{mode.number}"]))
            for rows, a in self.shapes[k]:
                if len(rows) > 1:
                    total += kappa * mac(a, seen.shape[rows, m]) - log_watson_constant(len(rows), kappa)
        return total

    def anywhere(self, mode: MeasuredMode) -> float:
        ratio = mode.damping_ratio
        damping = float(np.log(ratio)) if np.isfinite(ratio) and ratio > 0 else float("nan")
        return log_anywhere(self.measured.band, self.beliefs, damping)

    def overlooked(self, seen: Forecast, m: int) -> float:
        """Ln probability of not having found the model's mode m."""
        low, high = self.measured.band
        inside = np.log(low) <= seen.log_frequency[m] <= np.log(high)
        if not inside or seen.log_damping[m] > np.log(self.beliefs.damped):
            return 0.0
        return float(np.log1p(-self.beliefs.seen))

    def log_likelihood(self, seen: Sequence[Forecast], scales: Mapping[str, float], pairs: Pairs) -> float:
        total = 0.0
        for number, here in enumerate(self.measured.here):
            if not here:
                continue
            taken = {pairs[k] for k in here if pairs[k] >= 0}
            for k in here:
                mode = self.measured.observed.modes[k]
                total += (
                    self.as_mode(k, mode, seen[number], pairs[k], scales, 0.0)
                    if pairs[k] >= 0
                    else self.anywhere(mode)
                )
            total += sum(
                self.overlooked(seen[number], m)
                for m in range(len(seen[number].log_frequency))
                if m not in taken
            )
        return total

    def log_posterior(self, x: np.ndarray, scales: Mapping[str, float], pairs: Pairs) -> float:
        seen = self.see(x, slopes=False)
        return self.log_likelihood(seen, scales, pairs) + self.log_prior(x, scales)

    def log_prior(self, x: np.ndarray, scales: Mapping[str, float]) -> float:
        p = self.space.precision
        known = p > 0
        total = -0.5 * prior_cost(self.space, x) + 0.5 * float(np.sum(np.log(p[known] / (2 * np.pi))))
        for name, value in scales.items():
            mean, deviation = self.beliefs.scales[name.partition(".")[0]]
            total += log_normal(value - mean, deviation**2)
        return total

    # parameters

    def residuals(self, x: np.ndarray, pairs: Pairs, *, slopes: bool) -> _Residuals:
        return self.residuals_seen(self.see(x, slopes=slopes), pairs, slopes=slopes)

    def residuals_seen(self, seen: Sequence[Forecast], pairs: Pairs, *, slopes: bool) -> _Residuals:
        count = len(self.space) if slopes else 0
        kind: list[str] = []
        away: list[float] = []
        turned: list[np.ndarray] = []
        variance: list[float] = []
        dimension: list[tuple[str, int, float]] = []
        for number, here in enumerate(self.measured.here):
            for k in here:
                m = pairs[k]
                if m < 0:
                    continue
                mode, one = self.measured.observed.modes[k], seen[number]
                if m >= len(one.log_frequency):
                    raise InvalidSystem(Fault("model", f"mode {m + 1}", "overdamped", "one that oscillates"))
                kind.append(FREQUENCY)
                away.append(float(one.log_frequency[m] - np.log(mode.frequency)))
                turned.append(one.frequency_slope[:, m])
                variance.append(mode.frequency_error**2)
                if np.isfinite(mode.damping_ratio):
                    kind.append(DAMPING)
                    away.append(float(one.log_damping[m] - np.log(mode.damping_ratio)))
                    turned.append(one.damping_slope[:, m])
                    variance.append(mode.damping_error**2)
                if not self.beliefs.shapes or np.isnan(one.shape[0, m]):
                    continue
                for rows, a in self.shapes[k]:
                    if len(rows) < 2:
                        continue
                    name = f"{SHAPE}.{mode.number}"
                    left, slope = off_shape(a, one.shape[rows, m], one.shape_slope[:, rows, m])
                    kind += [name] * len(left)
                    away += left.tolist()
                    turned += list(slope.T)
                    variance += [0.0] * len(left)
                    dimension.append((name, len(rows), mac(a, one.shape[rows, m])))
        table = np.array(turned).T.reshape(count, len(away))
        return _Residuals(tuple(kind), np.array(away), table, np.array(variance), tuple(dimension))

    def weights(self, found: _Residuals, scales: Mapping[str, float], grant: float) -> np.ndarray:
        """Of each squared residual in minus twice the log-likelihood."""
        granted = {FREQUENCY: grant, DAMPING: 5 * grant}
        return np.array(
            [
                2 * np.exp(scales[kind]) / (1 + 2 * np.exp(scales[kind]) * (5 * grant) ** 2)
                if kind.startswith(SHAPE)
                else 1 / (v + np.exp(2 * scales[kind]) + granted[kind] ** 2)
                for kind, v in zip(found.kind, found.variance, strict=True)
            ]
        )

    def improve(
        self, x: np.ndarray, scales: Mapping[str, float], pairs: Pairs, grant: float, most: int
    ) -> np.ndarray:
        def cost(at: np.ndarray) -> float:
            try:
                found = self.residuals(at, pairs, slopes=False)
            except (InvalidSystem, np.linalg.LinAlgError):
                return float("inf")
            return float(self.weights(found, scales, grant) @ found.away**2) + prior_cost(self.space, at)

        def equations(at: np.ndarray) -> Normal:
            found = self.residuals(at, pairs, slopes=True)
            w = self.weights(found, scales, grant)
            data, none = float(w @ found.away**2), np.zeros((0, len(at)))
            gradient = found.slopes @ (w * found.away) + self.space.precision * at
            return Normal(
                data + prior_cost(self.space, at), data, gradient, (found.slopes * w) @ found.slopes.T,
                none, none[:, 0], None,
            )  # fmt: skip

        return descend(self.space, equations, cost, x, most=most, settled=1e-7).x

    # scales

    def rescale(self, x: np.ndarray, scales: Mapping[str, float], pairs: Pairs) -> dict[str, float]:
        from scipy.optimize import minimize_scalar

        found = self.residuals(x, pairs, slopes=False)
        return {
            name: float(
                minimize_scalar(
                    lambda value, name=name: -self.scale_term(found, name, value),
                    bounds=(LEAST, MOST), method="bounded", options={"xatol": 1e-5},
                ).x
            )
            for name in scales
        }  # fmt: skip

    def scale_term(self, found: _Residuals, name: str, value: float) -> float:
        """What one scale adds to the log-posterior."""
        mean, deviation = self.beliefs.scales[name.partition(".")[0]]
        total = log_normal(value - mean, deviation**2)
        if name.startswith(SHAPE):
            kappa = float(np.exp(value))
            return total + sum(
                kappa * alike - log_watson_constant(n, kappa)
                for which, n, alike in found.dimension
                if which == name
            )
        own = [k for k, kind in enumerate(found.kind) if kind == name]
        variance = found.variance[own] + np.exp(2 * value)
        return total - 0.5 * float(np.sum(found.away[own] ** 2 / variance + np.log(2 * np.pi * variance)))

    # evidence

    def finish(self, x: np.ndarray, scales: Mapping[str, float], pairs: Pairs) -> ModalFit:
        seen = self.see(x, slopes=True)
        found = self.residuals_seen(seen, pairs, slopes=True)
        hessian = self.hessian(found, scales)
        posterior = self.log_likelihood(seen, scales, pairs) + self.log_prior(x, scales)
        known = np.concatenate([self.space.precision > 0, np.ones(len(scales), dtype=bool)])
        block = hessian[np.ix_(known, known)]
        values = np.maximum(np.linalg.eigvalsh(block), 1e-9)
        evidence = posterior - 0.5 * float(np.sum(np.log(values / (2 * np.pi))))
        size = len(self.space)
        return ModalFit(
            self.explanation, self.measured, self.beliefs, x, dict(scales), pairs, posterior, evidence,
            np.linalg.pinv(hessian[:size, :size], hermitian=True), tuple(seen),
        )  # fmt: skip

    def hessian(self, found: _Residuals, scales: Mapping[str, float]) -> np.ndarray:
        """Of minus the log-posterior over parameters and scales, Gauss–Newton in the parameters."""
        size, names, step = len(self.space), list(scales), 1e-4
        w = self.weights(found, scales, 0.0)
        total = np.zeros((size + len(names), size + len(names)))
        total[:size, :size] = (found.slopes * w) @ found.slopes.T + np.diag(self.space.precision)
        for k, name in enumerate(names, start=size):
            at = scales[name]
            around = [self.scale_term(found, name, at + d) for d in (-0.05, 0.0, 0.05)]
            total[k, k] = max(-(around[0] - 2 * around[1] + around[2]) / 0.05**2, 1e-3)
            moved = self.weights(found, {**scales, name: at + step}, 0.0)
            total[k, :size] = total[:size, k] = found.slopes @ ((moved - w) / step * found.away)
        return total


def granted(explanation: Explanation, measured: MeasuredModes, x: Float[np.ndarray, " parameter"]) -> float:
    """Ln likelihood over that of peaks from anywhere, of a model that is granted to be far off.

    Raises:
        InvalidSystem: no model there.
    """
    task = _Task(explanation, measured, Beliefs(shapes=False))
    seen, scales = task.see(x, slopes=False), task.usual()
    pairs = task.pair_seen(seen, scales, COARSE[0])
    total = 0.0
    for number, here in enumerate(measured.here):
        for k in here:
            if pairs[k] >= 0:
                total += float(task.gains(k, seen[number], scales, COARSE[0])[pairs[k]])
    return total


def predictive(fit: ModalFit) -> float:
    """Ln of the density of modes that a fit did not see, over that of peaks from anywhere.

    What is unsure of its parameters is included; they enter by their covariance, to first order.
    """
    task = _Task(fit.explanation, fit.measured, fit.beliefs)
    spread = [
        np.array(
            [np.einsum("km,kl,lm->m", s, fit.covariance, s) for s in (one.frequency_slope, one.damping_slope)]
        )
        for one in fit.forecasts
    ]
    total = 0.0
    for number, here in enumerate(fit.measured.here):
        seen = fit.forecasts[number]
        if here:
            total += sum(task.overlooked(seen, m) for m in range(len(seen.log_frequency)))
            total += sum(
                float(task.gains(k, seen, fit.scales, 0.0, spread[number])[fit.pairs[k]])
                for k in here
                if fit.pairs[k] >= 0
            )
    return total


def mac(one: np.ndarray, other: np.ndarray) -> float:
    """Modal assurance criterion of two shapes."""
    size = float(np.sum(np.abs(one) ** 2) * np.sum(np.abs(other) ** 2))
    return float(np.abs(np.vdot(one, other)) ** 2) / size if size > 0 else 0.0


def off_shape(a: np.ndarray, model: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A − P a with a of unit length, |·|² = 1 − MAC, and its derivatives (Kaufman, BIT 15, 1975)."""
    length = max(float(np.linalg.norm(model)), 1e-300)
    unit = model / length
    factor = unit.conj() @ a
    away = a - factor * unit
    turned = slopes / length
    turned = -factor * (turned - np.outer(turned @ unit.conj(), unit))
    return np.concatenate([away.real, away.imag]), np.concatenate([turned.real, turned.imag], axis=1)


def restricted(fit: ModalFit, measured: MeasuredModes, grant: float = 0.0) -> ModalFit:
    """The same parameters and scales looked at with other modes; pairs may be off by `grant` besides."""
    task = _Task(fit.explanation, measured, fit.beliefs)
    seen = task.see(fit.x, slopes=True)
    return replace(
        fit, measured=measured, pairs=task.pair_seen(seen, fit.scales, grant), forecasts=tuple(seen)
    )

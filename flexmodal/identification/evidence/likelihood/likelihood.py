"""Likelihood of measured modes under an explanation, and its prior: what a fit makes as large as it can."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.identification.descent import prior_cost
from flexmodal.identification.evidence.likelihood.forecast import Forecast, ModeModel
from flexmodal.identification.evidence.likelihood.scatter import (
    DAMPING,
    FREQUENCY,
    RESIDUE,
    SHAPE,
    Beliefs,
    log_anywhere,
    log_normal,
    log_watson_constant,
)
from flexmodal.identification.evidence.measured_modes import MeasuredMode, ModeObservations
from flexmodal.modal.mac import mac_with
from flexmodal.structure import ParameterSpace

Pairs = tuple[int, ...]
"""For each measured mode the number of the model's mode in its posture; −1 for none."""
DAMPING_GRANT = 5
"""How many times more error is granted to a damping ratio or a shape than to a frequency."""


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Of one set of measured modes, under one explanation and one set of beliefs."""

    model: ModeModel
    measured: ModeObservations
    beliefs: Beliefs
    use: tuple[str, ...] = (FREQUENCY, DAMPING, SHAPE)
    """What of the modes counts."""

    @cached_property
    def space(self) -> ParameterSpace:
        """Parameters of the explanation."""
        return self.model.space

    @cached_property
    def shapes(self) -> tuple[tuple[tuple[list[int], np.ndarray], ...], ...]:
        """Of each measured mode its shapes, of unit length, and where their places stand."""
        return tuple(
            tuple((self.measured.rows(s.places), s.residue / np.linalg.norm(s.residue)) for s in mode.shapes)
            for mode in self.measured.modes
        )

    def usual(self) -> dict[str, float]:
        """Scales as they are believed to be."""
        means = self.beliefs.scales
        found = {FREQUENCY: means[FREQUENCY][0], DAMPING: means[DAMPING][0]}
        return found | {f"{SHAPE}.{number}": float(means[SHAPE][0]) for number in self.measured.numbers}

    def see(self, x: Float[np.ndarray, " parameter"], *, slopes: bool) -> list[Forecast]:
        """What the model predicts in each posture.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            slopes: whether derivatives are wanted.
        """
        places = self.measured.places if RESIDUE in self.use else self.measured.responses
        return self.model.forecasts(x, places, slopes=slopes)

    def gains(
        self,
        k: int,
        seen: Forecast,
        scales: Mapping[str, float],
        grant: float,
        spread: Float[np.ndarray, "2 mode"] | None = None,
    ) -> Float[np.ndarray, " mode"]:
        """Ln likelihood of measured mode k as each of the model's, over that of a peak from anywhere.

        Args:
            k: number of the measured mode.
            seen: the model's modes in its posture.
            scales: logarithms of the scales of the scatter.
            grant: relative error of frequencies that is granted besides.
            spread: variances of the model's logarithms of frequency and damping ratio.
        """
        elsewhere = self.anywhere(self.measured.modes[k])
        return np.array(
            [
                self.as_mode(k, seen, m, scales, grant, spread) - elsewhere - self.overlooked(seen, m)
                for m in range(len(seen.log_frequency))
            ]
        )

    def as_mode(
        self,
        k: int,
        seen: Forecast,
        m: int,
        scales: Mapping[str, float],
        grant: float,
        spread: Float[np.ndarray, "2 mode"] | None = None,
    ) -> float:
        """Ln likelihood of measured mode k that is the model's mode m; see `gains` for the arguments."""
        mode = self.measured.modes[k]
        more = np.zeros(2) if spread is None else spread[:, m]
        s, z = np.exp(2 * scales[FREQUENCY]), np.exp(2 * scales[DAMPING])
        variance = mode.frequency_error**2 + s + grant**2 + more[0]
        total = float(np.log(self.beliefs.seen)) + log_normal(
            float(seen.log_frequency[m] - np.log(mode.frequency)), variance
        )
        if DAMPING in self.use and np.isfinite(mode.damping_ratio):
            variance = mode.damping_error**2 + z + (DAMPING_GRANT * grant) ** 2 + more[1]
            total += log_normal(float(seen.log_damping[m] - np.log(mode.damping_ratio)), variance)
        if self.beliefs.shapes and not np.isnan(seen.shape[0, m]):
            kappa = float(np.exp(scales[f"{SHAPE}.{mode.number}"]))
            for rows, a in self.shapes[k]:
                if len(rows) > 1:
                    total += kappa * mac_with(a, seen.shape[rows, m]) - log_watson_constant(len(rows), kappa)
        return total

    def anywhere(self, mode: MeasuredMode) -> float:
        """Ln likelihood of a measured mode that is none of the model's."""
        ratio = mode.damping_ratio
        known = DAMPING in self.use and np.isfinite(ratio) and ratio > 0
        damping = float(np.log(ratio)) if known else float("nan")
        return log_anywhere(self.measured.band, self.beliefs, damping)

    def overlooked(self, seen: Forecast, m: int) -> float:
        """Ln probability of not having found the model's mode m.

        Args:
            seen: the model's modes in its posture.
            m: number of the mode.
        """
        low, high = self.measured.band
        inside = np.log(low) <= seen.log_frequency[m] <= np.log(high)
        if not inside or seen.log_damping[m] > np.log(self.beliefs.damped):
            return 0.0
        return float(np.log1p(-self.beliefs.seen))

    def log_likelihood(self, seen: Sequence[Forecast], scales: Mapping[str, float], pairs: Pairs) -> float:
        """Of all measured modes, with these pairs.

        Args:
            seen: the model's modes in each posture.
            scales: logarithms of the scales of the scatter.
            pairs: number of the model's mode for each measured one, −1 for none.
        """
        total = 0.0
        for here, one in zip(self.measured.here, seen, strict=True):
            if not here:
                continue
            for k in here:
                mode = self.measured.modes[k]
                total += self.as_mode(k, one, pairs[k], scales, 0.0) if pairs[k] >= 0 else self.anywhere(mode)
            taken = {pairs[k] for k in here if pairs[k] >= 0}
            total += sum(self.overlooked(one, m) for m in range(len(one.log_frequency)) if m not in taken)
        return total

    def log_prior(self, x: Float[np.ndarray, " parameter"], scales: Mapping[str, float]) -> float:
        """Of parameters and scales.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            scales: logarithms of the scales of the scatter.
        """
        p = self.space.precision
        known = p > 0
        total = -0.5 * prior_cost(self.space, x) + 0.5 * float(np.sum(np.log(p[known] / (2 * np.pi))))
        return total + self.log_prior_of_scales(scales)

    def log_prior_of_scales(self, scales: Mapping[str, float]) -> float:
        """Of the scales alone."""
        priors = ((value, self.beliefs.scales[name.partition(".")[0]]) for name, value in scales.items())
        return sum(log_normal(value - mean, deviation**2) for value, (mean, deviation) in priors)

    def log_posterior(
        self, x: Float[np.ndarray, " parameter"], scales: Mapping[str, float], pairs: Pairs
    ) -> float:
        """Likelihood and prior together.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            scales: logarithms of the scales of the scatter.
            pairs: number of the model's mode for each measured one, −1 for none.
        """
        return self.log_likelihood(self.see(x, slopes=False), scales, pairs) + self.log_prior(x, scales)

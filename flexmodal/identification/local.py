"""Parameters that vary over the workspace: locally weighted models, and models for each load level.

For a posture the data of the others are weighed by exp(−d²/2h²), d the distance in joint angles over their
spread in the campaign [Hearne 4.3.2]. The width h is chosen by prediction: every posture is left out in turn
and predicted by the model weighted around it. One global set is the limit of a large h, and what the local
models have to beat on the same held-out lines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.evidence.evidence import Fitted
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.outcome import Identification
from flexmodal.identification.uncertainty import Uncertainty

WIDTHS = (0.4, 0.7, 1.2, 2.0)
"""Of the weights, in units of the postures' spread."""
BETTER = 0.97
"""Held-out gap over the global one below which local models are worth their number."""
LEAST = 1e-3
"""Weights below this are nothing."""
APART = 0.999
"""Confidence, by Student's t, from which a parameter differs between load levels."""


@dataclass(frozen=True, eq=False)
class LocalModels:
    """One model for each posture of the campaign, and how they predict beside one global model."""

    outcome: Identification
    width: float
    """h of the best."""
    values: Mapping[str, Mapping[str, float]]
    """By posture, by parameter."""
    held_out: Mapping[float, float]
    """Gap on postures left out, by width; infinity is the global model."""

    @property
    def worth_it(self) -> bool:
        """Whether local models predict better than one for all."""
        return self.held_out[self.width] < BETTER * self.held_out[np.inf]

    @property
    def verdict(self) -> str:
        """One sentence."""
        here, all_ = self.held_out[self.width], self.held_out[np.inf]
        told = f"held out, local models leave {here:.3g} and one for all {all_:.3g}"
        if self.worth_it:
            return f"{told}: the parameters vary over the workspace (width {self.width:g})"
        return f"{told}: one set of parameters serves all postures"


def local_models(outcome: Identification, widths: Sequence[float] = WIDTHS) -> LocalModels:
    """Fit models weighted around each posture, and compare them with one for all.

    Args:
        outcome: of an identification from FRFs in three postures or more.
        widths: to choose from.

    Raises:
        InvalidRequest: another evidence, fewer postures, or widths that are not above 0.
    """
    evidence = _frfs(outcome)
    names = [posture.name for posture in evidence.observations.postures]
    if len(names) < 3 or not widths or min(widths) <= 0:
        found = f"{len(names)} postures, widths {list(widths)}"
        raise InvalidRequest(Fault("call", "local_models", found, "three postures, widths above 0"))
    weights = {width: _weights(evidence, width) for width in widths}
    weights[np.inf] = np.ones((len(names), len(names)))
    held_out = {width: _apart(evidence, outcome.fitted, weight) for width, weight in weights.items()}
    best = min(widths, key=lambda width: held_out[width])
    values = {}
    for place, name in enumerate(names):
        near = replace(evidence, share=weights[best][place][evidence.observations.posture])
        values[name] = evidence.space.values(near.fit(outcome.at, warm=True).x)
    return LocalModels(outcome, best, values, held_out)


def _frfs(outcome: Identification) -> FrfEvidence:
    evidence = outcome.problem.evidence
    if not isinstance(evidence, FrfEvidence):
        raise InvalidRequest(Fault("call", "outcome", "an identification from modes", "one from FRFs"))
    return evidence


def _weights(evidence: FrfEvidence, width: float) -> Float[np.ndarray, "posture posture"]:
    """Of every posture's data in the model around another; rows are what is predicted."""
    joints = list(evidence.model.robot.commanded) if hasattr(evidence.model, "robot") else []
    q = np.array(
        [[posture.q.get(name, 0.0) for name in joints] for posture in evidence.observations.postures]
    )
    spread = q.std(axis=0)
    q = q[:, spread > 0] / spread[spread > 0]
    away = ((q[:, None] - q[None]) ** 2).sum(axis=2) / max(q.shape[1], 1)
    found = np.exp(-away / (2 * width**2))
    return np.where(found < LEAST, 0.0, found)


def _apart(evidence: FrfEvidence, fitted: Fitted, weight: np.ndarray) -> float:
    """Gap over all postures, each predicted by a fit to the others weighted around it."""
    seen = evidence.observations
    predicted = evidence.predicted(fitted.x).copy()
    for place in range(len(seen.postures)):
        here = seen.posture == place
        share = weight[place][seen.posture]
        rest = replace(evidence, share=share).keeping(~here & (share > 0))
        x = fitted.x if rest.faults() else rest.fit(fitted.x, warm=True).x
        predicted[here] = evidence.keeping(here).predicted(x)
    return evidence.gap(predicted).value


@dataclass(frozen=True, eq=False)
class LevelModels:
    """One model for each kind of blow."""

    peaks: tuple[float, ...]
    """Typical force of each [N]."""
    at: tuple[Float[np.ndarray, " parameter"], ...]
    uncertainty: tuple[Uncertainty, ...]
    together: float
    """Gap with one set for all levels."""
    each: float
    """Gap with a set for each."""

    @property
    def different(self) -> tuple[str, ...]:
        """Parameters that move with the force for sure, the clearest first."""
        from scipy.special import stdtrit

        found = []
        for k, name in enumerate(self.uncertainty[0].space.names):
            for a in range(len(self.at)):
                for b in range(a):
                    one, other = self.uncertainty[a], self.uncertainty[b]
                    spread = float(np.hypot(one.deviation[k], other.deviation[k]))
                    freedom = min(float(one.freedom[k]), float(other.freedom[k]), 1e9)
                    reach = spread * float(stdtrit(freedom, (1 + APART) / 2))
                    found.append((abs(float(self.at[a][k] - self.at[b][k])) / max(reach, 1e-300), name))
        return tuple(dict.fromkeys(name for score, name in sorted(found, reverse=True) if score > 1))

    @property
    def verdict(self) -> str:
        """One sentence."""
        if not self.different:
            return "the same parameters serve every force level"
        return f"with the force change: {', '.join(self.different)}; the joints are not linear"


def level_models(outcome: Identification) -> LevelModels:
    """Fit every kind of blow by itself.

    Raises:
        InvalidRequest: another evidence, or one level only.
    """
    evidence = _frfs(outcome)
    seen = evidence.observations
    levels = np.unique(seen.level).tolist()
    if len(levels) < 2:
        raise InvalidRequest(Fault("call", "outcome", "one force level", "a campaign with two or more"))
    predicted = evidence.predicted(outcome.at).copy()
    together = evidence.gap(predicted).value
    at, sure = [], []
    for level in levels:
        here = seen.level == level
        part = evidence.keeping(here)
        fitted = part.fit(outcome.at, warm=True)
        at.append(fitted.x)
        sure.append(part.uncertainty(fitted))
        predicted[here] = part.predicted(fitted.x)
    peaks = tuple(seen.peak(level) for level in levels)
    return LevelModels(peaks, tuple(at), tuple(sure), together, evidence.gap(predicted).value)

"""Errors of labelling and scaling as hypotheses, and how much nearer to the model each brings the records.

A hypothesis changes what some records are compared with (another place, other angles) or multiplies them. The
misfit of a record is the mean over its lines of |ln(model / record)|², cut at `CUT`² so that a record that is
wholly wrong counts once. The hypothesis that takes most off the sum is accepted where it leaves less than
`LEFT` of the misfit of the records it is about, and these were farther than `FAR` from the model; then the
next is looked for, the accepted ones in force.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Complex, Float, Int, Shaped

from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.soundness.finding import FindingKind

CUT = 2.0
FAR = 0.2
"""Root mean square of |ln| from which records are suspected."""
LEFT = 0.4
"""Part of the misfit of its records that a hypothesis may leave."""
EVERYWHERE = "all postures"
MOST = 12
"""Hypotheses that are accepted, one after the other."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One error, and the records it is about."""

    kind: FindingKind
    where: str
    rows: Int[np.ndarray, " some"]
    """Observations."""
    compared: Int[np.ndarray, " some"] | None = None
    """Observation whose model each is compared with instead of its own; None for its own."""
    angles: str | Shaped[np.ndarray, " some"] | None = None
    """Name of the angles that the model takes instead, or one for each record; None for those stated."""
    factor: float = 1.0
    """That the records are multiplied by."""


@dataclass(frozen=True, eq=False)
class Accepted:
    """A hypothesis that explains its records."""

    hypothesis: Hypothesis
    before: float
    """Root mean square of |ln(model / record)|, cut, over its records."""
    after: float


@dataclass(eq=False)
class _State:
    """What each record is compared with, and multiplied by."""

    compared: np.ndarray
    angles: np.ndarray
    factor: np.ndarray

    def changed(self, one: Hypothesis) -> _State:
        """With a hypothesis in force."""
        state = _State(self.compared.copy(), self.angles.copy(), self.factor.copy())
        if one.compared is not None:
            state.compared[one.rows] = self.compared[one.compared]
        if one.angles is not None:
            state.angles[one.rows] = one.angles
        state.factor[one.rows] *= one.factor
        return state


def accepted(
    observations: Observations,
    models: Mapping[str, Complex[np.ndarray, "observation line"]],
    hypotheses: Sequence[Hypothesis],
) -> tuple[list[Accepted], Complex[np.ndarray, "observation line"]]:
    """Find the errors that explain most, one after the other.

    Args:
        observations: what was measured.
        models: receptances of every observation by name of the angles; "" for those stated [m/N].
        hypotheses: those to look at; of two that explain as much the first counts.

    Returns:
        The errors, and what the model says of every record as it was recorded, these errors made [m/N].
    """
    count = len(observations)
    state = _State(np.arange(count), np.full(count, "", dtype=object), np.ones(count))
    every = np.arange(count)
    misfit = _misfit(observations, models, state, every)
    found: list[Accepted] = []
    for _ in range(MOST):
        best, gain = None, 0.0
        for one in hypotheses:
            before = misfit[one.rows]
            if not len(one.rows) or np.mean(before) < FAR**2:
                continue
            after = _misfit(observations, models, state.changed(one), one.rows)
            if np.mean(after) < LEFT * np.mean(before) and np.sum(before - after) > gain * (1 + 1e-6) + 1e-9:
                best, gain = (one, after), float(np.sum(before - after))
        if best is None:
            break
        one, after = best
        found.append(Accepted(one, float(np.sqrt(np.mean(misfit[one.rows]))), float(np.sqrt(np.mean(after)))))
        state = state.changed(one)
        misfit = _misfit(observations, models, state, every)
    return found, _predicted(models, state, every) / state.factor[:, None]


def _misfit(
    observations: Observations,
    models: Mapping[str, Complex[np.ndarray, "observation line"]],
    state: _State,
    rows: Int[np.ndarray, " some"],
) -> Float[np.ndarray, " some"]:
    """Of some observations; 0 of one without a usable line."""
    predicted = _predicted(models, state, rows)
    used: Bool[np.ndarray, "some line"] = observations.used[rows]
    away = residual(predicted, state.factor[rows][:, None] * observations.value[rows])
    square = np.minimum(np.abs(away) ** 2, CUT**2)
    return np.where(used, square, 0).sum(axis=1) / np.maximum(used.sum(axis=1), 1)


def _predicted(
    models: Mapping[str, Complex[np.ndarray, "observation line"]],
    state: _State,
    rows: Int[np.ndarray, " some"],
) -> Complex[np.ndarray, "some line"]:
    return np.array([models[str(state.angles[row])][state.compared[row]] for row in rows.tolist()])


def with_angles(observations: Observations, angles: Sequence[Mapping[str, float]]) -> Observations:
    """The same records in other postures.

    Args:
        observations: whose postures are changed.
        angles: of each posture [rad, m].
    """
    pairs = zip(observations.postures, angles, strict=True)
    return replace(observations, postures=tuple(replace(one, q=dict(q)) for one, q in pairs))


def scopes(observations: Observations) -> Iterator[tuple[str, Bool[np.ndarray, " observation"]]]:
    """All postures together, then each by itself: words and rows."""
    yield EVERYWHERE, np.ones(len(observations), bool)
    if len(observations.postures) > 1:
        for number, posture in enumerate(observations.postures):
            yield f"posture {posture.name}", observations.posture == number

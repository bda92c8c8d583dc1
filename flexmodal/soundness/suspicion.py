"""Errors of labelling and scaling as hypotheses, and how much nearer to the model each brings the records.

A hypothesis changes what some records are compared with (another place, other angles) or multiplies them. The
misfit of a record is the mean over its lines of |ln(model / record)|², cut at `CUT`² so that a record that is
wholly wrong counts once. The hypothesis that takes most off the sum is accepted where it leaves less than
`LEFT` of the misfit of the records it is about, and these were farther than `FAR` from the model; then the
next is looked for, the accepted ones in force. Where no single one is left, or one takes little off, two at
once are tried, then three.

One joint's angle may come nearer to a card that is a little off by chance, since its sign changes little
where it stands near 0. Another label, factor or frame, or another posture's angles, do not: they move whole
resonances or turn all phases. So less is asked of these, `LABEL_LEFT` and `LABEL_FAR`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.soundness.finding import FindingKind
from flexmodal.soundness.readings import STATED, Framed, Models

CUT = 2.0
FAR = 0.2
"""Root mean square of |ln| from which records are suspected."""
LEFT = 0.4
"""Part of the misfit of its records that a hypothesis may leave."""
LABEL_FAR, LABEL_LEFT = 0.05, 0.6
"""The same of labels. On 120 clean campaigns with cards 5 % off none of them took anything off;
on 60 with cards off by half, none left less than 0.72 of one posture or 0.97 of all."""
LABELS: frozenset[FindingKind] = frozenset(
    {
        "sign",
        "scale",
        "axes swapped",
        "points swapped",
        "hammer positions swapped",
        "postures exchanged",
        "axes in another frame",
    }
)
PAIR_FAR, PAIR_LEFT, TRIPLE_LEFT = 0.5, 0.2, 0.15
"""The same of two hypotheses at once, of which there are many more, and of three."""
PIECE, MORE = 0.5, 1.5
"""Part of what is suspected that one hypothesis takes off and is believed at once; of one that takes less,
the multiple that several at once have to take off to be believed instead."""
FIRSTS = 10
"""Hypotheses, or pairs of them, that one more is tried with: those that take most off."""
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
    offset: Int[np.ndarray, " some"] | None = None
    """So many postures further on stand the angles that each record is of; None for its own posture's."""
    turned: str = ""
    """Joint that counts the other way."""
    in_degrees: bool = False
    """Whether the angles are degrees."""
    framed: tuple[Framed, ...] = ()
    """Points, and what of theirs, whose axes are fixed to the other frame."""
    factor: float = 1.0
    """That the records are multiplied by."""

    def explains(self, before: float, after: float) -> bool:
        """Whether a misfit of its records was far enough, and is small enough with it.

        Args:
            before: mean |ln|² without it.
            after: mean |ln|² with it.
        """
        far, left = (LABEL_FAR, LABEL_LEFT) if self.kind in LABELS else (FAR, LEFT)
        return before >= far**2 and after < left * before


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
    reading: np.ndarray
    factor: np.ndarray

    def changed(self, one: Hypothesis) -> _State:
        """With a hypothesis in force, beside those that are."""
        state = _State(self.compared.copy(), self.reading.copy(), self.factor.copy())
        if one.compared is not None:
            state.compared[one.rows] = self.compared[one.compared]
        for place, row in enumerate(one.rows.tolist()):
            was = self.reading[row]
            if one.offset is not None:
                was = replace(was, offset=int(one.offset[place]))
            if one.turned:
                was = replace(was, turned=was.turned ^ {one.turned})
            if one.framed:
                was = replace(was, framed=was.framed ^ set(one.framed))
            state.reading[row] = replace(was, in_degrees=True) if one.in_degrees else was
        state.factor[one.rows] *= one.factor
        return state


def accepted(
    observations: Observations,
    models: Models,
    hypotheses: Sequence[Hypothesis],
) -> tuple[list[Accepted], Complex[np.ndarray, "observation line"]]:
    """Find the errors that explain most, one after the other.

    Args:
        observations: what was measured.
        models: receptances of every observation by how the angles are read [m/N].
        hypotheses: those to look at; of two that explain as much the first counts.

    Returns:
        The errors, and what the model says of every record as it was recorded, these errors made [m/N].
    """
    count = len(observations)
    state = _State(np.arange(count), np.full(count, STATED, dtype=object), np.ones(count))
    every = np.arange(count)
    misfit = _misfit(observations, models, state, every)
    found: list[Accepted] = []
    for _ in range(MOST):
        best = _best(observations, models, state, misfit, hypotheses)
        if best is None:
            break
        for one in best:
            state = state.changed(one)
        after = _misfit(observations, models, state, every)
        for one in best:
            sizes = (float(np.sqrt(np.mean(each[one.rows]))) for each in (misfit, after))
            found.append(Accepted(one, *sizes))
        misfit = after
    return found, _predicted(models, state, every) / state.factor[:, None]


def _best(
    observations: Observations,
    models: Models,
    state: _State,
    misfit: Float[np.ndarray, " observation"],
    hypotheses: Sequence[Hypothesis],
) -> tuple[Hypothesis, ...] | None:
    """One, or several at once where one leaves most of what is suspected and several take more off.

    Two errors in every record would otherwise be explained piece by piece, each piece by another one.
    """
    single = _best_single(observations, models, state, misfit, hypotheses)
    taken = 0.0
    if single is not None:
        rows = single[0].rows
        after = _misfit(observations, models, state.changed(single[0]), rows)
        taken = float(np.sum(misfit[rows] - after))
        if taken > PIECE * float(np.sum(misfit[misfit > PAIR_FAR**2])):
            return single
    several = _best_several(observations, models, state, misfit, hypotheses)
    if several is None or (single is not None and several.gain(misfit) < MORE * taken):
        return single
    return several.parts


def _best_single(
    observations: Observations,
    models: Models,
    state: _State,
    misfit: Float[np.ndarray, " observation"],
    hypotheses: Sequence[Hypothesis],
) -> tuple[Hypothesis, ...] | None:
    """The one that takes most off, among those that explain their records."""
    best, gain = None, 0.0
    for one in hypotheses:
        before = misfit[one.rows]
        if not len(one.rows) or np.mean(before) < LABEL_FAR**2:
            continue
        after = _misfit(observations, models, state.changed(one), one.rows)
        taken = float(np.sum(before - after))
        if one.explains(float(np.mean(before)), float(np.mean(after))) and taken > gain * (1 + 1e-6) + 1e-9:
            best, gain = (one,), taken
    return best


def _best_several(
    observations: Observations,
    models: Models,
    state: _State,
    misfit: Float[np.ndarray, " observation"],
    hypotheses: Sequence[Hypothesis],
) -> _Several | None:
    """Two errors in the same records, else three, none of which explains them alone.

    Of each number those go on that take most off.
    """
    suspected = [one for one in hypotheses if len(one.rows) and np.mean(misfit[one.rows]) > PAIR_FAR**2]
    tried = [_Several((one,), one.rows, _misfit(observations, models, state.changed(one), one.rows))
             for one in suspected]  # fmt: skip
    for left in (PAIR_LEFT, TRIPLE_LEFT):
        begun = sorted(tried, key=lambda one: one.gain(misfit), reverse=True)[:FIRSTS]
        tried = []
        for one in begun:
            reached = state
            for part in one.parts:
                reached = reached.changed(part)
            for more in suspected:
                if more in one.parts or not np.isin(more.rows, one.rows).any():
                    continue
                rows = np.union1d(one.rows, more.rows)
                after = _misfit(observations, models, reached.changed(more), rows)
                tried.append(_Several((*one.parts, more), rows, after))
        explained = [one for one in tried if np.mean(one.after) < left * np.mean(misfit[one.rows])]
        if explained:
            return max(explained, key=lambda one: one.gain(misfit))
    return None


@dataclass(frozen=True, eq=False)
class _Several:
    """Hypotheses together, the records they are about, and what they leave of these."""

    parts: tuple[Hypothesis, ...]
    rows: Int[np.ndarray, " some"]
    after: Float[np.ndarray, " some"]

    def gain(self, misfit: Float[np.ndarray, " observation"]) -> float:
        """What they take off."""
        return float(np.sum(misfit[self.rows] - self.after))


def _misfit(
    observations: Observations,
    models: Models,
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
    models: Models,
    state: _State,
    rows: Int[np.ndarray, " some"],
) -> Complex[np.ndarray, "some line"]:
    return np.array([models[state.reading[row]][state.compared[row]] for row in rows.tolist()])


def scopes(observations: Observations) -> Iterator[tuple[str, Bool[np.ndarray, " observation"]]]:
    """All postures together, then each by itself: words and rows, those with a line that is used."""
    there: Bool[np.ndarray, " observation"] = np.asarray(observations.used.any(axis=1))
    yield EVERYWHERE, there
    if len(observations.postures) > 1:
        for number, posture in enumerate(observations.postures):
            yield f"posture {posture.name}", there & (observations.posture == number)

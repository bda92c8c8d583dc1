"""A hypothesis whose non-linear torques are marched in time, as a model that a fit can take.

Everything but those torques is the hypothesis' own: effects with a `law` lose their stand-in at one amplitude
and are marched under every blow. Derivatives are forward differences.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis, Placed
from flexmodal.diagnosis.law import Law
from flexmodal.diagnosis.march import FINENESS, March, Steps, Struck, march
from flexmodal.diagnosis.record import record_receptance
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification import Observations, ParameterSpace
from flexmodal.identification.model import Group

STEP = 1e-5
"""Of the differences."""


@dataclass(frozen=True, eq=False)
class MarchedModel:
    """A model of observations (`identification.ReceptanceModel`).

    Raises:
        InvalidRequest: no effect of the hypothesis has a law.
    """

    hypothesis: Hypothesis
    fineness: float = FINENESS
    """Steps in a period of the highest line."""
    compiled: bool | None = None
    """Whether by the compiled loop; by default, if numba is installed."""

    def __post_init__(self) -> None:
        if not has_law(self.hypothesis):
            found = ", ".join(placed.label for placed in self.hypothesis.placed) or "no effect"
            raise InvalidRequest(Fault("call", "hypothesis", found, "an effect with a law"))

    @property
    def space(self) -> ParameterSpace:
        """Of the hypothesis."""
        return self.hypothesis.space

    @cached_property
    def _linear(self) -> Hypothesis:
        placed = tuple(_without_stand_in(one) for one in self.hypothesis.placed)
        return Hypothesis(self.hypothesis.scene, self.hypothesis.base, placed)

    def receptances(
        self,
        x: Float[np.ndarray, " parameter"],
        observations: Observations,
        lines: slice | Int[np.ndarray, " line"],
        *,
        slopes: bool,
    ) -> tuple[Complex[np.ndarray, "observation line"], Complex[np.ndarray, "parameter observation line"]]:
        """See `identification.ReceptanceModel`."""
        _, high = self.space.bounds
        sizes = np.where(x + STEP <= high, STEP, -STEP) if slopes else np.zeros(0)
        tried = [self._look(x, observations, lines)]
        tried += [
            self._look(x + size * unit, observations, lines) for size, unit in zip(sizes, np.eye(len(x)))
        ]
        steps = self._steps(observations)
        marched = iter(march([look.struck for one in tried for look in one], steps, compiled=self.compiled))
        form = _form(observations)
        value, *moved = (
            _gathered(len(observations), ((look, look.read(next(marched), steps, form)) for look in one))
            for one in tried
        )
        return value, np.array([(one - value) / size for one, size in zip(moved, sizes, strict=True)])

    def _steps(self, observations: Observations) -> Steps:
        known = [observations.campaign.trial(level[0]).record_length for level in observations.levels]
        return Steps.behind(
            observations.axis.frequency, max((one for one in known if one), default=None), self.fineness
        )

    def _look(self, x: np.ndarray, observations: Observations, lines: slice | np.ndarray) -> list[_Look]:
        values = self.space.values(x)
        found = []
        laws: dict[int, tuple[Law, ...]] = {}
        for group in self._linear.groups(x, observations, slopes=False):
            posture = int(observations.posture[group.observations[0]])
            if posture not in laws:
                laws[posture] = self._linear.laws(posture, values)
            found.append(_look(self._linear, group, laws[posture], observations, lines))
        return found


@dataclass(frozen=True, eq=False)
class _Look:
    """Observations that share a structure, as blows on it."""

    group: Group
    struck: Struck
    wanted: np.ndarray
    """[observation, 2]: row of the response and number of the blow."""

    def read(self, marched: March, steps: Steps, form: str) -> np.ndarray:
        """What the sensors make of it."""
        value = record_receptance(self.struck, marched, steps, form, self.wanted)
        if self.group.reading is not None:
            value = value * np.exp(self.group.reading(self.struck.axis)[0])
        return value


def has_law(hypothesis: Hypothesis) -> bool:
    """Whether an effect of it has a torque that can be marched."""
    return any(placed.effect.law is not None for placed in hypothesis.placed)


def _without_stand_in(placed: Placed) -> Placed:
    if placed.effect.law is None:
        return placed
    return Placed(replace(placed.effect, act=None, variants=()), placed.where)


def _look(
    linear: Hypothesis, group: Group, laws: tuple[Law, ...], observations: Observations,
    lines: slice | np.ndarray,
) -> _Look:  # fmt: skip
    level = observations.level[group.observations]
    table = np.stack([group.pairs[:, 1], level], axis=1)
    blows, number = np.unique(table, axis=0, return_inverse=True)
    struck = Struck(
        group.structure,
        laws,
        observations.axis_of(group.level).take(lines),
        tuple((int(row), linear.scene.pulses[int(kind)]) for row, kind in blows),
    )
    return _Look(group, struck, np.stack([group.pairs[:, 0], number.ravel()], axis=1))


def _gathered(count: int, parts: Iterable[tuple[_Look, np.ndarray]]) -> np.ndarray:
    done = [(look.group.observations, value) for look, value in parts]
    total = np.zeros((count, done[0][1].shape[1]), dtype=complex)
    for rows, value in done:
        total[rows] = value
    return total


def _form(observations: Observations) -> str:
    """What the sensors measured: the form of the campaign's FRFs."""
    campaign = observations.campaign
    if campaign.frfs is not None:
        return campaign.frfs.form
    return {"displacement": "receptance", "velocity": "mobility"}.get(campaign.blows[0].quantity, "inertance")

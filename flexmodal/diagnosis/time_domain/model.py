"""A hypothesis whose non-linear torques are integrated in time, as a model that a fit can take.

Everything but those torques is the hypothesis' own: effects with a `law` lose their stand-in at one amplitude
and are integrated under every blow. Derivatives are forward differences; where they need not be exact, those
along what no law depends on are those of the stand-ins: one integration for each parameter of a law, instead
of one for each of the robot's too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.time_domain.integration import FINENESS, Steps, Struck, TimeResponse, integrate
from flexmodal.diagnosis.time_domain.record import record_receptance, struck_by
from flexmodal.errors import Fault, InvalidRequest, SingularResponse
from flexmodal.identification import Observations
from flexmodal.identification.model import evaluated
from flexmodal.structure import ParameterSpace
from flexmodal.structure.solution import back_solved
from flexmodal.structure.stack import Structures

STEP = 1e-4
"""Of the differences: across the kinks that a reversal of friction makes where it crosses a step of time."""


@dataclass(frozen=True, eq=False)
class TimeDomainModel:
    """A model of observations (`identification.ReceptanceModel`).

    Raises:
        InvalidRequest: no effect of the hypothesis has a law.
    """

    hypothesis: Hypothesis
    fineness: float = FINENESS
    """Steps in a period of the highest line."""
    compiled: bool | None = None
    """Whether by the compiled loop; by default, if numba is installed."""
    rough: bool = False
    """Whether derivatives along parameters of no law are those of the stand-ins, relative to the value."""

    def __post_init__(self) -> None:
        if not has_law(self.hypothesis):
            found = ", ".join(placed.label for placed in self.hypothesis.placed) or "no effect"
            raise InvalidRequest(Fault("call", "hypothesis", found, "an effect with a law"))

    @property
    def space(self) -> ParameterSpace:
        """Of the hypothesis."""
        return self.hypothesis.space

    @cached_property
    def linear(self) -> Hypothesis:
        """Without the stand-ins."""
        placed = tuple(_without_stand_in(one) for one in self.hypothesis.placed)
        return Hypothesis(self.hypothesis.context, self.hypothesis.base, placed)

    def receptances(
        self,
        x: Float[np.ndarray, " parameter"],
        observations: Observations,
        lines: slice | Int[np.ndarray, " line"],
        *,
        slopes: bool,
    ) -> tuple[Complex[np.ndarray, "observation line"], Complex[np.ndarray, "slope observation line"]]:
        """All at once what is integrated; see `identification.ReceptanceModel` for the arguments.

        Raises:
            SingularResponse: what is struck is not stable, and outgrows every number.
        """
        _, high = self.space.bounds
        apart = np.flatnonzero(self._by_differences) if slopes else np.zeros(0, dtype=int)
        sizes = np.where(x + STEP <= high, STEP, -STEP)[apart]
        tried = [
            x,
            *(x + np.where(np.arange(len(x)) == k, size, 0.0) for k, size in zip(apart, sizes, strict=True)),
        ]
        known: dict[tuple[object, ...], np.ndarray] = {}
        looks = [self._look(one, observations, lines, known) for one in tried]
        steps = self._steps(observations)
        found = np.zeros((len(tried), len(observations), len(observations.axis.take(lines))), dtype=complex)
        every, number = [one.struck for look in looks for one in look], 0
        with np.errstate(over="ignore", invalid="ignore"):
            integrated = integrate(every, steps, compiled=self.compiled)
            for value, look in zip(found, looks, strict=True):
                for one in look:
                    value[one.observations] = one.read(integrated[number], steps)
                    number += 1
        if not np.isfinite(found[0]).all():
            raise SingularResponse("the robot with its effects is not stable: the integration has no end")
        changes = np.nan_to_num((found[1:] - found[0]) / sizes[:, None, None])
        if len(apart) == len(x) or not slopes:
            return found[0], changes
        every = self._of_stand_ins(x, observations, lines) * found[0]
        every[apart] = changes
        return found[0], every

    @cached_property
    def _by_differences(self) -> Bool[np.ndarray, " parameter"]:
        """Along which parameters derivatives are differences."""
        laws = tuple(f"{one.label}." for one in self.hypothesis.placed if one.effect.law is not None)
        return np.array([not self.rough or name.startswith(laws) for name in self.space.names])

    def _of_stand_ins(
        self, x: np.ndarray, observations: Observations, lines: slice | np.ndarray
    ) -> Complex[np.ndarray, "parameter observation line"]:
        """Derivatives of ln α along all parameters, of the stand-ins; 0 where these have no receptance.

        A spring that pushes may have none at its amplitude, and a motion all the same.
        """
        shape = len(x), len(observations), len(observations.axis.take(lines))
        found = np.zeros(shape, dtype=complex)
        for some, value, changes in evaluated(self.hypothesis, x, observations, lines, slopes=True):
            known = np.isfinite(value) & (value != 0)
            found[:, some] = np.where(known, changes, 0.0) / np.where(known, value, 1.0)
        return found

    def _steps(self, observations: Observations) -> Steps:
        length = max(observations.lengths)
        if length > 0:  # from the middle of the pulse
            length += float(np.mean([pulse.length for pulse in self.hypothesis.context.pulses])) / 2
        return Steps.behind(observations.axis.frequency, length, self.fineness)

    def _look(
        self,
        x: np.ndarray,
        observations: Observations,
        lines: slice | np.ndarray,
        known: dict[tuple[object, ...], np.ndarray],
    ) -> Sequence[_Look]:
        """Blows on every system; what is known of linear parts, which laws may have alike, is added to."""
        values, pulses = self.space.values(x), self.hypothesis.context.pulses
        found = []
        for group in self.linear.groups(x, observations, slopes=False):
            part, axis = group.part, observations.recorded(group.part.level).take(lines)
            log = None if group.reading is None else group.reading(axis)[0]
            key = part.level, *_bytes_of(group.structures)
            if key not in known:
                known[key] = back_solved(group.structures, axis)
            laws = self.linear.laws(part, values)
            for k, members in enumerate(part.members):
                struck, wanted = struck_by(
                    group.structures[k], part, members, observations, pulses, axis, laws[k]
                )
                factor = None if log is None else np.exp(log[part.entry[members]])
                found.append(_Look(part.observations[members], struck, wanted, known[key][k], factor))
        return found


@dataclass(frozen=True, eq=False)
class _Look:
    """Observations that share a structure, as blows on it."""

    observations: Int[np.ndarray, " observation"]
    struck: Struck
    wanted: Int[np.ndarray, "observation 2"]
    back: Complex[np.ndarray, "response dof line"]
    """Z⁻¹ of the response rows."""
    factor: Complex[np.ndarray, "observation line"] | None
    """What the sensors make of the motion."""

    def read(self, integrated: TimeResponse, steps: Steps) -> Complex[np.ndarray, "observation line"]:
        """As the sensors read it."""
        value = record_receptance(self.struck, integrated, steps, self.wanted, self.back)
        return value if self.factor is None else value * self.factor


def _bytes_of(many: Structures) -> tuple[object, ...]:
    """What the linear parts of structures depend on."""
    arrays = (many.mass, many.damping, many.stiffness, many.loss, many.response)
    return (*(one.tobytes() for one in arrays), many.loss_factor)


def has_law(hypothesis: Hypothesis) -> bool:
    """Whether an effect of it has a torque that can be integrated."""
    return any(placed.effect.law is not None for placed in hypothesis.placed)


def _without_stand_in(placed: Placed) -> Placed:
    if placed.effect.law is None:
        return placed
    return Placed(replace(placed.effect, act=placed.effect.besides, variants=()), placed.where)

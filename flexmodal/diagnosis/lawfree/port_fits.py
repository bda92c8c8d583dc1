"""Ports fitted well beside a robot, and judged on postures that the fit has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree import screening
from flexmodal.diagnosis.lawfree.kinds import NOTHING
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.ported_fit import FLOORS, finished, profiled
from flexmodal.diagnosis.lawfree.profile import SETTLED, Profile, State
from flexmodal.diagnosis.lawfree.sighting import Sighting, Start, carried_over, noise_of
from flexmodal.diagnosis.search.coarse import Look
from flexmodal.identification import Observations

LATE = 3.0
"""Misfit of what is believed up to which ports begin at a small model error: at a large one nothing of what
is missing is to be seen, and every port goes on."""
STEPS = 20
"""Most at each model error, for those that go on."""
PATIENT_STEPS, PATIENT = 100, 5e-5
"""The same for those that are fitted once more, and what they still have to gain by a step: a foundation in
space needs some hundred steps."""
ROUGHLY = 5e-3
"""What a step still has to gain of those that are fitted well at first. On two campaigns with several effects
that were looked at, misfits came to within 1.6 % of those of ends."""


@dataclass(frozen=True, eq=False)
class PortFits:
    """What is looked at: observations to fit and to judge, and the ports that might be in them."""

    root: Hypothesis
    fitted: Float[np.ndarray, " parameter"] | None
    """Its coordinates, re-tuned; None where fits set out at the card."""
    seen: Look
    away: Look | None
    ports: tuple[Port, ...]
    rare: tuple[Port, ...]
    """Those that are tried where none of these leads on."""
    torques: tuple[Port, ...]
    """Those that depend on the blow."""

    @cached_property
    def bare(self) -> float:
        """Misfit without any port: a reading that is nothing."""
        return self.sighted((Port.at(NOTHING, "", self.root.context),)).judged

    @cached_property
    def _floors(self) -> tuple[float, ...]:
        """Model errors of the first round: all of them, or a small one where little is missing."""
        if not self._late:
            return screening.FLOORS
        noise = noise_of(self.seen.merged, self.seen.lines)
        return (min(screening.LATE_FLOOR, screening.LATE_OVER_NOISE * noise),)

    @cached_property
    def _late(self) -> bool:
        return self.bare <= LATE

    def _model(
        self, ports: Sequence[Port], observations: Observations, lines: Int[np.ndarray, " line"]
    ) -> PortedModel:
        return PortedModel.of(ports, self.root, observations, lines, self.fitted)

    def _seen(self, ports: Sequence[Port], merged: Observations, apart: Observations) -> Observations:
        return apart if any(port.kind.by_blow for port in ports) else merged

    def sighted(
        self,
        ports: tuple[Port, ...],
        before: Sighting | None = None,
        start: Start | None = None,
        *,
        patient: bool = False,
        roughly: bool = False,
    ) -> Sighting:
        """Ports fitted well and judged.

        Args:
            ports: which; one after the other where there are several.
            before: others that are there already.
            start: parameters and functions of all of these to begin with.
            patient: whether a descent goes on as long as anything is gained.
            roughly: whether it ends as soon as little is gained, to be brought to its end or not.
        """
        *first, port = ports
        if first:
            before = self.sighted(tuple(first), before)
        every = (*(before.ports if before else ()), port)
        observations, lines = self._seen(every, self.seen.merged, self.seen.apart), self.seen.lines
        model = self._model(every, observations, lines)
        noise = noise_of(observations, lines)
        steps, settled = (PATIENT_STEPS, PATIENT) if patient else (STEPS, ROUGHLY if roughly else SETTLED)
        floors = (*FLOORS[port.kind is not NOTHING and self._late :], noise)
        if start is not None and len(start[1]) == model.cells:  # some blows may lack in a part of the data
            begin = Profile(model, screening.FLOORS[-1], settled=settled)
            profile, state = finished(begin, begin.state(*start), floors=floors[1:], steps=steps)
        else:
            known = None if before is None else carried_over(before, model)
            profile, state = profiled(model, known, floors=floors, steps=steps, settled=settled)
        dropped = len(observations) - len(model.observations)
        unknowns = max(len(model.names), dropped) + len(model.space) - len(self.root.space)
        return Sighting(every, *self._misfits(every, profile, state), unknowns, profile, state)

    def ended(self, one: Sighting) -> Sighting:
        """Ports that were fitted roughly, brought to their end and judged.

        Args:
            one: where they have come to.
        """
        begin = replace(one.profile, settled=SETTLED)
        profile, state = finished(begin, one.state, floors=(begin.floor,), steps=STEPS)
        misfit, apart = self._misfits(one.ports, profile, state)
        return replace(one, misfit=misfit, apart=apart, profile=profile, state=state)

    def _misfits(self, ports: Sequence[Port], profile: Profile, state: State) -> tuple[float, float | None]:
        """On the postures fitted, and on those held out."""
        apart = None
        if self.away is not None and profile.model.cells == 1:
            other = Profile(self._model(ports, self.away.merged, self.seen.lines), profile.floor)
            residual = other.state(state.x, state.z).residual
            apart = float(np.sqrt(other.mean(residual)))
        return float(np.sqrt(profile.reduced(state.residual))), apart

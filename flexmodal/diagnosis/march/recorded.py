"""A linear hypothesis as its records show it: with what they cut off.

Models with marched torques have it (`record`); one that is weighed against them should have it too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.march.integrate import Steps
from flexmodal.diagnosis.march.record import coast, measured_form, record_receptance, steps_behind, struck_by
from flexmodal.identification import Observations, ParameterSpace
from flexmodal.identification.model import Group
from flexmodal.identification.structure import Axis, receptance


@dataclass(frozen=True, eq=False)
class RecordedModel:
    """A model of observations (`identification.FrfModel`), exact but for derivatives of what is cut off."""

    hypothesis: Hypothesis

    @property
    def space(self) -> ParameterSpace:
        """Of the hypothesis."""
        return self.hypothesis.space

    def groups(
        self, x: Float[np.ndarray, " parameter"], observations: Observations, *, slopes: bool
    ) -> Sequence[Group]:
        """See `identification.FrfModel`."""
        steps = steps_behind(observations, self.hypothesis.scene.pulses)
        return [
            replace(group, reading=_Cut(group, observations, self.hypothesis, steps))
            for group in self.hypothesis.groups(x, observations, slopes=slopes)
        ]


@dataclass(frozen=True, eq=False)
class _Cut:
    """ln(as recorded / as it is), beside what the sensors make of it."""

    group: Group
    observations: Observations
    hypothesis: Hypothesis
    steps: Steps

    def __call__(
        self, axis: Axis
    ) -> tuple[Complex[np.ndarray, "observation line"], Mapping[str, np.ndarray]]:
        """See `Group.reading`."""
        struck, wanted = struck_by(self.group, self.observations, self.hypothesis.scene.pulses, slice(None))
        struck = replace(struck, axis=axis)
        form = measured_form(self.observations)
        recorded = record_receptance(struck, coast(struck, self.steps), self.steps, form, wanted)
        plain, _ = receptance(self.group.structure, axis, self.group.pairs)
        with np.errstate(divide="ignore", invalid="ignore"):
            log = np.where(plain == 0, 0.0, np.log(recorded / plain))
        if self.group.reading is None:
            return log, {}
        more, changes = self.group.reading(axis)
        return log + more, changes

"""The believed robot with ports whose functions are free: what is unknown, and of which observations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import Observations
from flexmodal.structure import ParameterSpace

Unknown = Complex[np.ndarray, "cell function line"]
"""The functions in units of their sizes; a cell for all postures, or one for each posture and blow."""


@dataclass(frozen=True, eq=False)
class PortedModel:
    """Of some observations on some lines."""

    ports: tuple[Port, ...]
    """Whose functions are free, one after the other."""
    root: Hypothesis
    """What is believed, perhaps with effects that are named already."""
    observations: Observations
    lines: Int[np.ndarray, " line"]
    fitted: Float[np.ndarray, " known"] | None = None
    """Coordinates of what is believed, where a fit of it alone ended; None for those of the card."""

    @classmethod
    def of(
        cls,
        ports: Sequence[Port],
        root: Hypothesis,
        observations: Observations,
        lines: Int[np.ndarray, " line"],
        fitted: Float[np.ndarray, " known"] | None = None,
    ) -> PortedModel:
        """Of the observations that the ports leave in.

        Args:
            ports: which.
            root: what is believed.
            observations: all of them.
            lines: numbers of those that are looked at.
            fitted: coordinates of what is believed, as fitted alone.
        """
        for port in ports:
            if port.kind.drops and port.kind.reads is not None:
                observations = observations.keeping(~port.kind.reads(observations, root.context, port.where))
        return cls(tuple(ports), root, observations, lines, fitted)

    @cached_property
    def hypothesis(self) -> Hypothesis:
        """With the coordinates of the ports."""
        found = self.root
        for port in self.ports:
            found = found.and_also(Placed(port.kind.motions, port.where))
        return found

    @cached_property
    def size(self) -> Float[np.ndarray, "function line"]:
        """Scale of the functions."""
        frequency = self.observations.axis.frequency[self.lines]
        context = self.root.context
        return np.concatenate([port.kind.sizes(context, port.where, frequency) for port in self.ports])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the functions."""
        return tuple(name for port in self.ports for name in port.names)

    @cached_property
    def spans(self) -> tuple[slice, ...]:
        """The functions of each port."""
        ends = np.cumsum([len(port.names) for port in self.ports]).tolist()
        return tuple(slice(end - len(port.names), end) for end, port in zip(ends, self.ports, strict=True))

    @cached_property
    def common(self) -> Bool[np.ndarray, " function"]:
        """Functions that all cells share, where there are several: those of ports that no blow changes."""
        several = self.cells > 1
        each = [np.full(len(port.names), several and not port.kind.by_blow) for port in self.ports]
        return np.concatenate(each)

    @cached_property
    def _keyed(self) -> tuple[Int[np.ndarray, "cell key"], Int[np.ndarray, " observation"]]:
        seen = self.observations
        if not any(port.kind.by_blow for port in self.ports):
            return np.zeros((1, 0), dtype=int), np.zeros(len(seen), dtype=int)
        key = np.column_stack([seen.posture, seen.level, seen.reference])
        keys, cell = np.unique(key, axis=0, return_inverse=True)
        return keys, np.asarray(cell).ravel()

    @property
    def cell(self) -> Int[np.ndarray, " observation"]:
        """The cell of each observation."""
        return self._keyed[1]

    def in_cells(self, z: Complex[np.ndarray, "other function line"], model: PortedModel) -> Unknown:
        """Functions of another model's cells as those of this one's, which may have left observations out.

        Args:
            z: of the other model.
            model: with the same postures and blows, and perhaps more.
        """
        if len(z) == 1:
            return z
        number = {tuple(key): k for k, key in enumerate(model._keyed[0].tolist())}
        return z[[number[tuple(key)] for key in self._keyed[0].tolist()]]

    @property
    def space(self) -> ParameterSpace:
        """The robot's parameters, those of effects that are named already, and the geometry of the ports."""
        return self.hypothesis.space

    @property
    def cells(self) -> int:
        """How many different functions of a kind there are."""
        return int(self.cell.max(initial=0)) + 1

    def zero(self) -> Unknown:
        """Nothing is missing."""
        return np.zeros((self.cells, len(self.names), len(self.lines)), dtype=complex)

    @cached_property
    def geometry(self) -> list[Int[np.ndarray, " parameter"]]:
        """Numbers of the parameters of each port."""
        context, begin, found = self.root.context, len(self.root.space), []
        for port in self.ports:
            count = len(port.kind.motions.parameters(context, port.where))
            found.append(np.arange(begin, begin + count))
            begin += count
        return found

    @cached_property
    def readings(self) -> list[tuple[np.ndarray, int]]:
        """Observations whose reading a function multiplies, and its number."""
        return [
            (port.kind.reads(self.observations, self.root.context, port.where), span.start)
            for port, span in zip(self.ports, self.spans, strict=True)
            if port.kind.reads is not None and not port.kind.drops
        ]

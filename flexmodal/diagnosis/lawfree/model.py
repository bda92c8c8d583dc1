"""The believed robot with a port, as residuals of its FRFs and their derivatives line by line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.port import Patterns, Port
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.model import Group
from flexmodal.structure import ParameterSpace
from flexmodal.structure.ports import CompliancePort, Ported, StiffnessPort, solved_with
from flexmodal.structure.ports import Port as StructurePort

_STEP = 1e-4
"""Of the central differences along the geometry of a port."""

Unknown = Complex[np.ndarray, "cell function line"]
"""The functions in units of their sizes; a cell for all postures, or one for each posture and blow."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """Residuals with their derivatives."""

    residual: Complex[np.ndarray, "observation line"]
    along: Complex[np.ndarray, "observation line function"]
    """Along the unknown functions of the observation's own cell; holomorphic."""
    parameters: Complex[np.ndarray, "parameter observation line"]


@dataclass(frozen=True, eq=False)
class PortedModel:
    """Residuals ln(model / measurement) of some observations on some lines."""

    port: Port
    root: Hypothesis
    """What is believed, perhaps with effects that are named already."""
    observations: Observations
    lines: Int[np.ndarray, " line"]

    @classmethod
    def of(
        cls, port: Port, root: Hypothesis, observations: Observations, lines: Int[np.ndarray, " line"]
    ) -> PortedModel:
        """Of the observations that the port leaves in.

        Args:
            port: which.
            root: what is believed.
            observations: all of them.
            lines: numbers of those that are looked at.
        """
        if port.kind.drops and port.kind.reads is not None:
            observations = observations.keeping(~port.kind.reads(observations, root.context, port.where))
        return cls(port, root, observations, lines)

    @cached_property
    def hypothesis(self) -> Hypothesis:
        """With the coordinates of the port."""
        return self.root.and_also(Placed(self.port.kind.shape, self.port.where))

    @cached_property
    def size(self) -> Float[np.ndarray, "function line"]:
        """Scale of the functions."""
        frequency = self.observations.axis.frequency[self.lines]
        return self.port.kind.sizes(self.root.context, self.port.where, frequency)

    @cached_property
    def cell(self) -> Int[np.ndarray, " observation"]:
        """The cell of each observation."""
        seen = self.observations
        if not self.port.kind.by_blow:
            return np.zeros(len(seen), dtype=int)
        key = np.column_stack([seen.posture, seen.level, seen.reference])
        return np.asarray(np.unique(key, axis=0, return_inverse=True)[1]).ravel()

    @property
    def space(self) -> ParameterSpace:
        """The robot's parameters, those of effects that are named already, and the port's geometry."""
        return self.hypothesis.space

    @property
    def cells(self) -> int:
        """How many different functions of a kind there are."""
        return int(self.cell.max(initial=0)) + 1

    def zero(self) -> Unknown:
        """Nothing is missing."""
        return np.zeros((self.cells, len(self.port.names), len(self.lines)), dtype=complex)

    def residual(
        self, x: Float[np.ndarray, " parameter"], z: Unknown
    ) -> Complex[np.ndarray, "observation line"]:
        """The residuals alone."""
        found = np.zeros((len(self.observations), len(self.lines)), dtype=complex)
        for group in self.hypothesis.groups(x, self.observations, slopes=False):
            ported, log, _ = self._solved(group, x, z, slopes=False)
            part = group.part
            value = ported.solved.value * np.exp(log)
            measured = self.observations.value[part.observations][:, self.lines]
            found[part.observations] = residual(value[part.entry], measured)
        return self._read(found, z)

    def slopes(self, x: Float[np.ndarray, " parameter"], z: Unknown) -> Slopes:
        """Residuals with derivatives."""
        shape = len(self.observations), len(self.lines)
        found = np.zeros(shape, dtype=complex)
        along = np.zeros((*shape, len(self.port.names)), dtype=complex)
        parameters = np.zeros((len(self.space), *shape), dtype=complex)
        for group in self.hypothesis.groups(x, self.observations, slopes=True):
            ported, log, more = self._solved(group, x, z, slopes=True)
            part, rows = group.part, group.part.observations
            plain = ported.solved.value
            safe = np.where(plain == 0, np.inf, plain)
            measured = self.observations.value[rows][:, self.lines]
            found[rows] = residual((plain * np.exp(log))[part.entry], measured)
            if self.port.kind.patterns is not None:
                along[rows] = (self._along(group, x, ported) / safe[:, :, None])[part.entry]
            flat = ported.slopes(1 / safe)
            relative = flat[:, :, 0] + 1j * flat[:, :, 1]
            for number, slope in more.items():
                relative[number] += slope
            parameters[:, rows] = relative[:, part.entry]
        if self.port.kind.reads is not None and not self.port.kind.drops:
            along[self._seen(), :, 0] = self.size[0]
        return Slopes(self._read(found, z), along, parameters)

    # the unknown in the structure

    def _solved(
        self, group: Group, x: np.ndarray, z: Unknown, *, slopes: bool
    ) -> tuple[Ported, np.ndarray, dict[int, np.ndarray]]:
        axis = self.observations.axis_of(group.part.level).take(self.lines)
        ports = self._ports(group, x, z, slopes=slopes)
        ported = solved_with(group.structures, axis, group.part.entries, ports)
        if group.reading is None:
            return ported, np.zeros((1, 1)), {}
        log, more = group.reading(axis)
        return ported, log, dict(more)

    def _patterns(self, group: Group, x: np.ndarray) -> Patterns:
        assert self.port.kind.patterns is not None
        return self.port.kind.patterns(*self.hypothesis.placed_in(group.part, x)[-1])

    def _ports(self, group: Group, x: np.ndarray, z: Unknown, *, slopes: bool) -> Sequence[StructurePort]:
        if self.port.kind.patterns is None:
            return []
        patterns = self._patterns(group, x)
        value = z[self._of_systems(group)] * self.size  # system, function, line
        if patterns.compliance is not None:
            return [
                CompliancePort(i, np.einsum("f,sfl->sl", patterns.compliance[:, i, j], value), j)
                for i, j in _pairs(patterns.compliance)
            ]
        assert patterns.stiffness is not None
        moved = self._moved(group, x) if slopes else None
        return [
            StiffnessPort(pattern, value[:, k], None if moved is None else (moved[0], moved[1][:, k]))
            for k, pattern in enumerate(patterns.stiffness)
        ]

    def _moved(self, group: Group, x: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Derivatives of the patterns along the port's geometry [parameter function system dof dof]."""
        numbers = np.arange(len(self.root.space), len(self.space))
        if not numbers.size:
            return None
        found = []
        for number in numbers.tolist():
            step = np.where(np.arange(len(x)) == number, _STEP, 0.0)
            ahead, behind = (self._patterns(group, x + way * step).stiffness for way in (1, -1))
            assert ahead is not None
            assert behind is not None
            found.append((ahead - behind) / (2 * _STEP))
        return numbers, np.array(found)

    def _along(
        self, group: Group, x: np.ndarray, ported: Ported
    ) -> Complex[np.ndarray, "entry line function"]:
        """Derivatives of the receptances along the functions in their sizes."""
        patterns = self._patterns(group, x)
        each = np.stack([ported.along(k) for k in range(len(ported.ports))], axis=-1)  # entry line port
        if patterns.compliance is not None:
            each = each @ np.array([patterns.compliance[:, i, j] for i, j in _pairs(patterns.compliance)])
        return np.asarray(each * self.size.T)

    def _of_systems(self, group: Group) -> Int[np.ndarray, " system"]:
        """The cell of each system of a part."""
        found = np.zeros(len(group.structures), dtype=int)
        system = group.part.entries.table[group.part.entry, 0]
        found[system] = self.cell[group.part.observations]
        return found

    # the unknown in a reading

    def _seen(self) -> np.ndarray:
        assert self.port.kind.reads is not None
        return self.port.kind.reads(self.observations, self.root.context, self.port.where)

    def _read(self, found: np.ndarray, z: Unknown) -> np.ndarray:
        if self.port.kind.reads is None or self.port.kind.drops:
            return found
        seen = self._seen()
        found[seen] += z[self.cell[seen], 0] * self.size[0]
        found.imag[seen] = (found.imag[seen] + np.pi) % (2 * np.pi) - np.pi
        return found


def _pairs(compliance: Float[np.ndarray, "function dof dof"]) -> list[tuple[int, int]]:
    """Coordinates that have a compliance, by themselves or between two."""
    first, second = np.nonzero(np.triu(np.any(compliance, axis=0)))
    return list(zip(first.tolist(), second.tolist(), strict=True))

"""The believed robot with ports, as residuals of its FRFs and their derivatives line by line."""

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
        along = np.zeros((*shape, len(self.names)), dtype=complex)
        parameters = np.zeros((len(self.space), *shape), dtype=complex)
        for group in self.hypothesis.groups(x, self.observations, slopes=True):
            ported, log, more = self._solved(group, x, z, slopes=True)
            part, rows = group.part, group.part.observations
            plain = ported.solved.value
            safe = np.where(plain == 0, np.inf, plain)
            measured = self.observations.value[rows][:, self.lines]
            found[rows] = residual((plain * np.exp(log))[part.entry], measured)
            along[rows] = (self._along(group, x, ported) / safe[:, :, None])[part.entry]
            flat = ported.slopes(1 / safe)
            relative = flat[:, :, 0] + 1j * flat[:, :, 1]
            for number, slope in more.items():
                relative[number] += slope
            parameters[:, rows] = relative[:, part.entry]
        for seen, number in self._readings:
            along[seen, :, number] = self.size[number]
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

    def _patterns(self, group: Group, x: np.ndarray) -> list[Patterns | None]:
        """Of each port; None of one in a reading."""
        placed = self.hypothesis.placed_in(group.part, x)[len(self.root.placed) :]
        return [
            None if port.kind.patterns is None else port.kind.patterns(*here)
            for port, here in zip(self.ports, placed, strict=True)
        ]

    def _ports(self, group: Group, x: np.ndarray, z: Unknown, *, slopes: bool) -> Sequence[StructurePort]:
        value = z[self._of_systems(group)] * self.size  # system, function, line
        moved = self._moved(group, x) if slopes else {}
        found: list[StructurePort] = []
        for number, (patterns, span) in enumerate(zip(self._patterns(group, x), self.spans, strict=True)):
            own = value[:, span]
            if patterns is None:
                continue
            if patterns.compliance is not None:
                found += [
                    CompliancePort(i, np.einsum("f,sfl->sl", patterns.compliance[:, i, j], own), j)
                    for i, j in _pairs(patterns.compliance)
                ]
            if patterns.stiffness is not None:
                of_port = moved.get(number)
                found += [
                    StiffnessPort(
                        pattern, own[:, k], None if of_port is None else (of_port[0], of_port[1][:, k])
                    )
                    for k, pattern in enumerate(patterns.stiffness)
                ]
        return found

    def _moved(self, group: Group, x: np.ndarray) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """Derivatives of the patterns of ports along their geometry [parameter function system dof dof]."""
        found = {}
        for port, numbers in enumerate(self._geometry):
            changes = []
            for number in numbers.tolist():
                step = np.where(np.arange(len(x)) == number, _STEP, 0.0)
                ahead, behind = (self._patterns(group, x + way * step)[port] for way in (1, -1))
                assert ahead is not None
                assert behind is not None
                assert ahead.stiffness is not None
                assert behind.stiffness is not None
                changes.append((ahead.stiffness - behind.stiffness) / (2 * _STEP))
            if changes:
                found[port] = numbers, np.array(changes)
        return found

    @cached_property
    def _geometry(self) -> list[Int[np.ndarray, " parameter"]]:
        """Numbers of the parameters of each port."""
        context, begin, found = self.root.context, len(self.root.space), []
        for port in self.ports:
            count = len(port.kind.motions.parameters(context, port.where))
            found.append(np.arange(begin, begin + count))
            begin += count
        return found

    def _along(
        self, group: Group, x: np.ndarray, ported: Ported
    ) -> Complex[np.ndarray, "entry line function"]:
        """Derivatives of the receptances along the functions in their sizes; 0 along those of readings."""
        found = np.zeros((len(group.part.entries.table), len(self.lines), len(self.names)), dtype=complex)
        taken = 0
        for patterns, span in zip(self._patterns(group, x), self.spans, strict=True):
            if patterns is None:
                continue
            pairs = [] if patterns.compliance is None else _pairs(patterns.compliance)
            count = len(pairs) if patterns.stiffness is None else len(patterns.stiffness)
            each = np.stack([ported.along(taken + k) for k in range(count)], axis=-1)  # entry line port
            if patterns.compliance is not None:
                each = each @ np.array([patterns.compliance[:, i, j] for i, j in pairs])
            found[..., span] = each * self.size[span].T
            taken += count
        return found

    def _of_systems(self, group: Group) -> Int[np.ndarray, " system"]:
        """The cell of each system of a part."""
        found = np.zeros(len(group.structures), dtype=int)
        system = group.part.entries.table[group.part.entry, 0]
        found[system] = self.cell[group.part.observations]
        return found

    # the unknown in a reading

    @cached_property
    def _readings(self) -> list[tuple[np.ndarray, int]]:
        """Observations that a function multiplies, and its number."""
        return [
            (port.kind.reads(self.observations, self.root.context, port.where), span.start)
            for port, span in zip(self.ports, self.spans, strict=True)
            if port.kind.reads is not None and not port.kind.drops
        ]

    def _read(self, found: np.ndarray, z: Unknown) -> np.ndarray:
        for seen, number in self._readings:
            found[seen] += z[self.cell[seen], number] * self.size[number]
            found.imag[seen] = (found.imag[seen] + np.pi) % (2 * np.pi) - np.pi
        return found


def _pairs(compliance: Float[np.ndarray, "function dof dof"]) -> list[tuple[int, int]]:
    """Coordinates that have a compliance, by themselves or between two."""
    first, second = np.nonzero(np.triu(np.any(compliance, axis=0)))
    return list(zip(first.tolist(), second.tolist(), strict=True))

"""A ported model at some parameters: residuals of its FRFs and their derivatives line by line.

The structures are solved once there; functions of any value follow from that, see `structure.ports`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.lawfree.model import PortedModel, Unknown
from flexmodal.diagnosis.lawfree.port import Patterns
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.layout import Part
from flexmodal.identification.model import Group
from flexmodal.structure.port import CompliancePort, StiffnessPort
from flexmodal.structure.port import Port as StructurePort
from flexmodal.structure.ports import Moved, Ported, PortedStructures
from flexmodal.structure.with_ports import with_ports

_STEP = 1e-4
"""Of the central differences along the geometry of a port."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """Derivatives of residuals."""

    along: Complex[np.ndarray, "observation line function"]
    """Along the unknown functions of the observation's own cell; holomorphic."""
    parameters: Float[np.ndarray, "parameter observation 2 line"]
    """By real and imaginary part; of no parameter where these are held."""


@dataclass(frozen=True, eq=False)
class PortedGroup:
    """Structures of a group of observations, solved for any functions of the ports."""

    group: Group
    patterns: Sequence[Patterns | None]
    """Of each port; None of one in a reading."""
    ported: PortedStructures
    reading: Complex[np.ndarray, "#entry #line"] | None
    """Reading over motion of what is believed; None where they are the same."""
    measured: Complex[np.ndarray, "observation line"]
    """On the lines that are looked at [m/N]."""
    cell: Int[np.ndarray, " system"]
    """The cell of each system."""


@dataclass(frozen=True, eq=False)
class AtParameters:
    """Residuals ln(model / measurement) as they depend on the functions."""

    model: PortedModel
    x: Float[np.ndarray, " parameter"]
    """Coordinates of the parameters."""

    @cached_property
    def groups(self) -> list[PortedGroup]:
        """Solved.

        Raises:
            SingularResponse: there is no receptance on some line.
        """
        model = self.model
        return [
            self._solved(one) for one in model.hypothesis.groups(self.x, model.observations, slopes=False)
        ]

    def residual(self, z: Unknown) -> Complex[np.ndarray, "observation line"]:
        """The residuals.

        Args:
            z: the functions in their sizes.

        Raises:
            SingularResponse: there is no receptance on some line.
        """
        return self._residual(z, [self._ported(one, z).value for one in self.groups])

    def residuals_with(
        self, z: Unknown, functions: Sequence[int], constants: Sequence[float]
    ) -> Iterator[tuple[int, float, Complex[np.ndarray, "observation line"]]]:
        """The residuals with one more constant in one function of the last port, each in turn.

        Args:
            z: the functions in their sizes.
            functions: numbers, within the port, of stiffnesses on patterns of rank one.
            constants: in the sizes of these.

        Yields:
            The function, the constant, and the residuals with it.
        """
        model, before = self.model, 0
        ported = [self._ported(one, z) for one in self.groups]
        for patterns in self.groups[0].patterns[:-1]:
            before += 0 if patterns is None else len(_structure_ports(patterns))
        for number in functions:
            size = model.size[model.spans[-1].start + number]
            for constant in constants:
                values = [one.with_more(before + number, constant * size) for one in ported]
                yield number, constant, self._residual(z, values)

    def _residual(
        self, z: Unknown, values: Sequence[Complex[np.ndarray, "entry line"]]
    ) -> Complex[np.ndarray, "observation line"]:
        model = self.model
        found = np.zeros((len(model.observations), len(model.lines)), dtype=complex)
        for one, value in zip(self.groups, values, strict=True):
            part = one.group.part
            read = value if one.reading is None else value * one.reading
            found[part.observations] = residual(read[part.entry], one.measured)
        for seen, number in model.readings:
            found[seen] += z[model.cell[seen], number] * model.size[number]
            found.imag[seen] = (found.imag[seen] + np.pi) % (2 * np.pi) - np.pi
        return found

    def slopes(self, z: Unknown, *, held: bool = False) -> Slopes:
        """Derivatives of the residuals.

        Args:
            z: the functions in their sizes.
            held: whether the parameters stay as they are.

        Raises:
            SingularResponse: there is no receptance on some line.
        """
        model = self.model
        observations, lines = len(model.observations), len(model.lines)
        along = np.zeros((observations, lines, len(model.names)), dtype=complex)
        parameters = np.zeros((0 if held else len(model.space), observations, 2, lines))
        for one in self.groups:
            part = one.group.part
            ported = self._ported(one, z)
            scale = 1 / np.where(ported.value == 0, np.inf, ported.value)
            along[part.observations] = (self._along(one, ported) * scale[:, :, None])[part.entry]
            if not held:
                parameters[:, part.observations] = self._relative(one, ported, scale)[:, part.entry]
        for seen, number in model.readings:
            along[seen, :, number] = model.size[number]
        return Slopes(along, parameters)

    def _solved(self, group: Group) -> PortedGroup:
        model = self.model
        axis = model.observations.axis_of(group.part.level).take(model.lines)
        patterns = self._patterns(group.part, self.x)
        ports = [one for own in patterns if own is not None for one in _structure_ports(own)]
        ported = with_ports(group.structures, axis, group.part.entries, ports)
        reading = None if group.reading is None else np.exp(np.asarray(group.reading(axis)[0], dtype=complex))
        measured = model.observations.value[group.part.observations][:, model.lines]
        cell = np.zeros(len(group.structures), dtype=int)
        cell[group.part.entries.table[group.part.entry, 0]] = model.cell[group.part.observations]
        return PortedGroup(group, patterns, ported, reading, measured, cell)

    def _patterns(self, part: Part, x: np.ndarray) -> list[Patterns | None]:
        model = self.model
        placed = model.hypothesis.placed_in(part, x)[len(model.root.placed) :]
        return [
            None if port.kind.patterns is None else port.kind.patterns(*here)
            for port, here in zip(model.ports, placed, strict=True)
        ]

    def _ported(self, one: PortedGroup, z: Unknown) -> Ported:
        """The structures of a group with the functions in them."""
        value = np.swapaxes(z[one.cell] * self.model.size, 0, 1)  # function, system, line
        found = []
        for patterns, span in zip(one.patterns, self.model.spans, strict=True):
            if patterns is None:
                continue
            own = value[span]
            if patterns.compliance is not None:
                found.append(np.einsum("fp,fsl->psl", _shares(patterns.compliance), own))
            if patterns.stiffness is not None:
                found.append(own[: len(patterns.stiffness)])
        return one.ported.at(np.concatenate(found) if found else value[:0])

    def _along(self, one: PortedGroup, ported: Ported) -> Complex[np.ndarray, "entry line function"]:
        """Derivatives of the receptances along the functions in their sizes; 0 along those of readings."""
        model = self.model
        shape = len(one.group.part.entries.table), len(model.lines), len(model.names)
        found, taken = np.zeros(shape, dtype=complex), 0
        for patterns, span in zip(one.patterns, model.spans, strict=True):
            if patterns is None:
                continue
            count = len(_structure_ports(patterns))
            each = ported.along[..., taken : taken + count]
            if patterns.compliance is not None:
                each = each @ _shares(patterns.compliance).T
            found[..., span] = each * model.size[span].T
            taken += count
        return found

    def _relative(
        self, one: PortedGroup, ported: Ported, scale: np.ndarray
    ) -> Float[np.ndarray, "parameter entry 2 line"]:
        """Derivatives of ln α along the parameters, by real and imaginary part."""
        group = one.group if one.group.sloped is None else one.group.sloped()
        found = ported.slopes(scale, group.structures, self._moved(one))
        if group.reading is not None:
            for number, slope in group.reading(one.ported.solved.axis)[1].items():
                found[number] += np.stack([slope.real, slope.imag], axis=1)
        return found

    def _moved(self, one: PortedGroup) -> Moved:
        """Derivatives of the patterns of stiffness along their geometry, by the ports of the structures."""
        found, taken = {}, 0
        for port, (patterns, numbers) in enumerate(zip(one.patterns, self.model.geometry, strict=True)):
            if patterns is None:
                continue
            if patterns.stiffness is not None and len(numbers):
                changes = np.array([self._turned(one.group.part, port, k) for k in numbers.tolist()])
                found.update({taken + k: (numbers, changes[:, k]) for k in range(len(patterns.stiffness))})
            taken += len(_structure_ports(patterns))
        return found

    def _turned(self, part: Part, port: int, number: int) -> Float[np.ndarray, "function system dof dof"]:
        """The derivative of a port's stiffness patterns along one parameter."""
        step = np.where(np.arange(len(self.x)) == number, _STEP, 0.0)
        ahead, behind = (self._patterns(part, self.x + way * step)[port] for way in (1, -1))
        assert ahead is not None
        assert behind is not None
        assert ahead.stiffness is not None
        assert behind.stiffness is not None
        return np.asarray((ahead.stiffness - behind.stiffness) / (2 * _STEP))


def _structure_ports(patterns: Patterns) -> list[StructurePort]:
    """What the functions of a port do to a structure, compliances first."""
    pairs = [] if patterns.compliance is None else _pairs(patterns.compliance)
    found: list[StructurePort] = [CompliancePort(i, j if j != i else None) for i, j in pairs]
    if patterns.stiffness is not None:
        found += [StiffnessPort(pattern) for pattern in patterns.stiffness]
    return found


def _shares(compliance: Float[np.ndarray, "function dof dof"]) -> Float[np.ndarray, "function pair"]:
    """What each function adds to the compliance of each pair."""
    return compliance[:, *np.array(_pairs(compliance)).T]


def _pairs(compliance: Float[np.ndarray, "function dof dof"]) -> list[tuple[int, int]]:
    """Coordinates that have a compliance, by themselves or between two."""
    first, second = np.nonzero(np.triu(np.any(compliance, axis=0)))
    return list(zip(first.tolist(), second.tolist(), strict=True))

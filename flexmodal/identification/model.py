"""What a model predicts for observations: a structure for each posture, and how it is struck and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.campaign import Campaign, CampaignPoint
from flexmodal.identification.observations import Observations
from flexmodal.model import Robot
from flexmodal.structure.arm import Arm
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.structure.shape import KINDS, assembled, with_slopes
from flexmodal.structure.structure import Axis, Structure, receptance
from flexmodal.structure.truncation import missing

AXES = np.eye(3)


@dataclass(frozen=True, eq=False)
class Group:
    """Observations of one posture that share a structure."""

    structure: Structure
    observations: Int[np.ndarray, " observation"]
    """Their numbers."""
    pairs: Int[np.ndarray, "observation 2"]
    """Rows of each in `structure.response` and `structure.reference`."""
    level: int
    """Whose axis they are measured on."""
    reading: Callable[[Axis], tuple[np.ndarray, Mapping[str, np.ndarray]]] | None = None
    """What the sensors make of it: ln(reading / motion) [observation line], and its derivatives by name."""


@runtime_checkable
class FrfModel(Protocol):
    """Anything that predicts the FRFs of a campaign from the coordinates of a parameter space."""

    @property
    def space(self) -> ParameterSpace:
        """What it depends on."""
        ...

    def groups(
        self, x: Float[np.ndarray, " parameter"], observations: Observations, *, slopes: bool
    ) -> Sequence[Group]:
        """Structures at coordinates x, for every observation one; with derivatives if asked."""
        ...


@runtime_checkable
class ReceptanceModel(Protocol):
    """Anything that predicts the FRFs of a campaign without a structure to show for them."""

    @property
    def space(self) -> ParameterSpace:
        """What it depends on."""
        ...

    def receptances(
        self,
        x: Float[np.ndarray, " parameter"],
        observations: Observations,
        lines: slice | Int[np.ndarray, " line"],
        *,
        slopes: bool,
    ) -> tuple[Complex[np.ndarray, "observation line"], Complex[np.ndarray, "slope observation line"]]:
        """Receptances of every observation on some lines, and their derivatives; none unless asked."""
        ...


Model = FrfModel | ReceptanceModel


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A robot as its card says, with other numbers."""

    robot: Robot
    space: ParameterSpace
    _arms: dict[tuple[tuple[str, float], ...], Arm] = field(default_factory=dict, repr=False)

    def arm(self, q: Mapping[str, float]) -> Arm:
        """The robot in a posture; made once."""
        key = tuple(sorted(q.items()))
        if key not in self._arms:
            self._arms[key] = Arm(self.robot, dict(q))
        return self._arms[key]

    def groups(
        self, x: Float[np.ndarray, " parameter"], observations: Observations, *, slopes: bool
    ) -> Sequence[Group]:
        """See `FrfModel`; every term is its own derivative."""
        made = []
        for number, posture in enumerate(observations.postures):
            rows = np.flatnonzero(observations.posture == number)
            if not rows.size:
                continue
            made += self._groups(x, self.arm(posture.q), observations, rows, slopes)
        return made

    def _groups(
        self,
        x: Float[np.ndarray, " parameter"],
        arm: Arm,
        observations: Observations,
        rows: Int[np.ndarray, " some"],
        slopes: bool,
    ) -> list[Group]:
        """Of one posture."""
        found = close(assembled(arm, self.space.values(x)), observations, rows)
        if not slopes or not self._of_shape:
            return found
        structure = with_slopes(
            lambda values: close(assembled(arm, values), observations, rows)[0].structure, self.space, x
        )
        return [replace(group, structure=structure) for group in found]

    @cached_property
    def _of_shape(self) -> bool:
        return any(name.partition(".")[0] in KINDS for name in self.space.names)

    def structure_at(
        self,
        x: Float[np.ndarray, " parameter"],
        q: Mapping[str, float],
        responses: Sequence[tuple[str, np.ndarray, np.ndarray]],
        references: Sequence[tuple[str, np.ndarray, np.ndarray]],
    ) -> Structure:
        """The robot in one posture, seen at any places: link, place in its frame [m], world direction."""
        arm = self.arm(q)

        def make(values: Mapping[str, float]) -> Structure:
            assembly = assembled(arm, values)
            return assembly.close(assembly.rows(responses), assembly.rows(references))

        return with_slopes(make, self.space, x)


def close(
    assembly: Assembly, observations: Observations, rows: Int[np.ndarray, " observation"]
) -> list[Group]:
    """Close an assembly for some observations of its posture: a group for each decay of the window."""
    where, response = np.unique(observations.response[rows], axis=0, return_inverse=True)
    struck, reference = np.unique(observations.reference[rows], axis=0, return_inverse=True)
    structure = assembly.close(
        assembly.rows(places(observations, where)), assembly.rows(places(observations, struck))
    )
    pairs = np.stack([response.ravel(), reference.ravel()], axis=1)
    level = observations.level[rows]
    decay = np.array(observations.decays)[level]
    return [
        Group(structure, rows[decay == d], pairs[decay == d], int(level[decay == d][0]))
        for d in np.unique(decay)
    ]


def places_of(
    campaign: Campaign, given: Iterable[tuple[int, int]]
) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Link, place and world direction of point ids and directions."""
    found = []
    for number, direction in given:
        point: CampaignPoint = campaign.point(int(number))
        found.append((point.link, np.array(point.xyz), AXES[abs(direction) - 1] * np.sign(direction)))
    return found


def places(
    observations: Observations, given: Int[np.ndarray, "place 2"]
) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Link, place and world direction of point ids and directions."""
    return places_of(observations.campaign, [(int(n), int(d)) for n, d in given])


def predict(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations,
    lines: slice | np.ndarray = slice(None),
) -> Complex[np.ndarray, "observation line"]:  # fmt: skip
    """Receptances that the model gives for every observation [m/N]."""
    count = len(observations.axis.take(lines))
    value = np.zeros((len(observations), count), dtype=complex)
    for rows, found, _ in evaluated(model, x, observations, lines, slopes=False):
        value[rows] = found
    return value


def evaluated(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations, lines: slice | np.ndarray,
    *, slopes: bool,
) -> Iterator[tuple[Int[np.ndarray, " some"], np.ndarray, np.ndarray]]:  # fmt: skip
    """Numbers of some observations, their receptances [some line] and derivatives [parameter some line]."""
    if isinstance(model, ReceptanceModel):
        yield np.arange(len(observations)), *model.receptances(x, observations, lines, slopes=slopes)
        return
    names = model.space.names if slopes else ()
    for group in model.groups(x, observations, slopes=slopes):
        axis = observations.axis_of(group.level).take(lines)
        yield group.observations, *group_receptance(group, axis, names)


def group_receptance(
    group: Group, axis: Axis, names: tuple[str, ...]
) -> tuple[Complex[np.ndarray, "observation line"], Complex[np.ndarray, "name observation line"]]:
    """Receptances of a group as the sensors read them, and their derivatives.

    Pairs that occur twice, at several levels, are computed once.
    """
    distinct, back = np.unique(group.pairs, axis=0, return_inverse=True)
    value, slopes = receptance(group.structure, axis, distinct, names)
    looked = names if axis.cut_slopes else ()
    if axis.length > 0 and (cut := missing(group.structure, axis, distinct, looked)) is not None:
        value = value + cut[0]
        slopes = slopes + cut[1] if looked else slopes
    value, slopes = value[back.ravel()], slopes[:, back.ravel()]
    if group.reading is not None:
        log, changes = group.reading(axis)
        factor = np.exp(log)
        value, slopes = value * factor, slopes * factor
        for number, name in enumerate(names):
            if name in changes:
                slopes[number] += value * changes[name]
    return value, slopes

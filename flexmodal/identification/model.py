"""What a model predicts for observations: a structure for each posture, and how it is struck and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.identification.layout import Part
from flexmodal.identification.observations import Observations
from flexmodal.identification.spot import Spot, in_world, places_of
from flexmodal.model import Robot
from flexmodal.structure.arm import Arm, Arms
from flexmodal.structure.fixtures import arm_in
from flexmodal.structure.frame import Frame, Frames
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.structure.shape import KINDS, STEPS, assembled
from flexmodal.structure.solution import solved
from flexmodal.structure.stack import Structures, joined
from flexmodal.structure.structure import Axis, Structure
from flexmodal.structure.truncation import missing_of, missing_with_slopes

Reading = Callable[[Axis], tuple[np.ndarray, Mapping[int, np.ndarray]]]
"""What sensors make of motion: ln(reading / motion) [entry line], and its derivatives by parameter number."""


@dataclass(frozen=True, eq=False)
class Group:
    """Observations on one axis, and the structures they are of."""

    structures: Structures
    part: Part
    reading: Reading | None = None
    sloped: Callable[[], Group] | None = None
    """The same with derivatives; None where they are in it."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What a model predicts of some observations."""

    observations: Int[np.ndarray, " observation"]
    """Their numbers."""
    entry: Int[np.ndarray, " observation"]
    """The receptance of each."""
    value: Complex[np.ndarray, "entry line"]
    """[m/N]"""
    slopes: Callable[[np.ndarray], np.ndarray]
    """Derivatives times a scale [entry line] as real and imaginary parts [parameter entry 2 line]."""


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
        """Structures at coordinates x, for every observation one; with derivatives if asked.

        Args:
            x: coordinates of the parameters, 0 at the card's values.
            observations: what was measured.
            slopes: whether derivatives are wanted.
        """
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
        """Receptances of every observation on some lines, and their derivatives; none unless asked.

        Args:
            x: see `FrfModel.groups`.
            observations: see there.
            lines: of the axis.
            slopes: see `FrfModel.groups`.
        """
        ...


Model = FrfModel | ReceptanceModel


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A robot as its card says, with other numbers."""

    robot: Robot
    space: ParameterSpace

    def groups(
        self, x: Float[np.ndarray, " parameter"], observations: Observations, *, slopes: bool
    ) -> Sequence[Group]:
        """See `FrfModel`; every term is its own derivative."""
        made = []
        for part in observations.layout.parts():
            rows = [places_of(observations.campaign, table.tolist()) for table in (part.where, part.struck)]
            points, stood = observations.campaign.points, observations.postures
            arms = [arm_in(self.robot, stood[k], points) for k in part.posture.tolist()]
            sloped = partial(self._group, x, part, arms, rows)
            made.append(sloped() if slopes else self._group(x, part, arms, rows, sloped))
        return made

    def _group(
        self,
        x: Float[np.ndarray, " parameter"],
        part: Part,
        arms: Sequence[Arm],
        rows: Sequence[Sequence[Spot]],
        sloped: Callable[[], Group] | None = None,
    ) -> Group:
        """With derivatives, unless they are left to `sloped`."""
        found = self._structures(x, arms, rows[0], rows[1], slopes=sloped is None)
        return Group(found, part, sloped=sloped)

    def structure_at(
        self,
        x: Float[np.ndarray, " parameter"],
        q: Mapping[str, float],
        responses: Sequence[Spot],
        references: Sequence[Spot],
    ) -> Structure:
        """The robot in one posture with its derivatives; see `PosedModel` for the arguments."""
        return self._structures(x, [Arm(self.robot, dict(q))], responses, references, slopes=True)[0]

    def _structures(
        self,
        x: Float[np.ndarray, " parameter"],
        arms: Sequence[Arm],
        responses: Sequence[Spot],
        references: Sequence[Spot],
        *,
        slopes: bool,
    ) -> Structures:
        values = self.space.values(x)
        names = [name for name in self.space.names if name.partition(".")[0] not in KINDS]
        card = {name: self.space.parameters[self.space.index[name]].card for name in names}
        where = tuple(
            (one.link, one.in_link, *one.place.tolist(), *one.way.tolist())
            for one in (*responses, *references)
        )
        key = (tuple((*sorted(a.q.items()), a.locked, a.bolted) for a in arms), len(responses), where)

        def frame_at(shape: Mapping[str, float]) -> Frame:
            def build() -> Frame:
                assembly = assembled(Arms.of(arms), {**card, **shape})
                rows = (
                    assembly.rows(in_world(responses, assembly)),
                    assembly.rows(in_world(references, assembly)),
                )
                every = np.arange(len(arms))
                return Frame(assembly, assembly, every, tuple(names), np.array(list(card.values())), *rows)

            return self._frames.get((*key, tuple(shape.values())), build)

        shape = {name: value for name, value in values.items() if name not in card}
        frame = frame_at(shape)
        total, found = frame.scaled(values)
        place = np.array([self.space.index[name] for name in names], dtype=int)
        own = {kind: (place[numbers], matrices) for kind, (numbers, matrices) in found.items()}
        turned: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        for name in shape if slopes else ():
            number = self.space.index[name]
            step = STEPS[name.partition(".")[0]]
            up, down = (frame_at({**shape, name: shape[name] + side * step}) for side in (1, -1))
            scale = self.space.parameters[number].slope(float(x[number])) / (2 * step)
            mass = (up.scaled(values)[0]["mass"] - down.scaled(values)[0]["mass"]) * scale
            own = joined([own, {"mass": (np.array([number]), mass[None])}])
            turned[number] = (
                (up.response - down.response) * scale,
                (up.reference - down.reference) * scale,
            )
        return Structures(
            tuple(frame.assembly.coordinates), mass=total["mass"], damping=total["damping"],
            stiffness=total["stiffness"], loss=total["loss"], response=frame.response,
            reference=frame.reference, names=self.space.names, slopes=own, turned=turned,
        )  # fmt: skip

    @cached_property
    def _frames(self) -> Frames:
        return Frames()


def predict(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations,
    lines: slice | np.ndarray = slice(None),
) -> Complex[np.ndarray, "observation line"]:  # fmt: skip
    """Receptances that the model gives for every observation [m/N].

    See `predictions` for the arguments and the errors; all lines if none are named.
    """
    count = len(observations.axis.take(lines))
    value = np.zeros((len(observations), count), dtype=complex)
    for seen in predictions(model, x, observations, lines, slopes=False):
        value[seen.observations] = seen.value[seen.entry]
    return value


def evaluated(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations, lines: slice | np.ndarray,
    *, slopes: bool,
) -> Iterator[tuple[Int[np.ndarray, " some"], np.ndarray, np.ndarray]]:  # fmt: skip
    """Numbers of some observations, their receptances [some line] and derivatives [parameter some line].

    See `predictions` for the arguments and the errors.
    """
    for seen in predictions(model, x, observations, lines, slopes=slopes):
        changes = np.zeros((0, len(seen.observations), seen.value.shape[1]), dtype=complex)
        if slopes:
            found = seen.slopes(np.ones_like(seen.value))[:, seen.entry]
            changes = found[:, :, 0] + 1j * found[:, :, 1]
        yield seen.observations, seen.value[seen.entry], changes


def predictions(
    model: Model, x: Float[np.ndarray, " parameter"], observations: Observations, lines: slice | np.ndarray,
    *, slopes: bool,
) -> Iterator[Seen]:  # fmt: skip
    """What a model predicts, group by group; with derivatives if asked.

    Args:
        model: the model.
        x: coordinates of the parameters, 0 at the card's values.
        observations: for which it predicts.
        lines: of the axis.
        slopes: whether derivatives are wanted.

    Raises:
        SingularResponse: an undamped mode is driven at its natural frequency.
        InaccurateModes: stiffness and damping range over too many decades for a double.
    """
    if isinstance(model, ReceptanceModel):
        value, changes = model.receptances(x, observations, lines, slopes=slopes)
        every = np.arange(len(observations))
        yield Seen(every, every, value, lambda scale: _parts_of(changes * scale))
        return
    for group in model.groups(x, observations, slopes=slopes):
        yield seen_in(group, observations.axis_of(group.part.level).take(lines))


def _parts_of(value: np.ndarray) -> np.ndarray:
    return np.stack([value.real, value.imag], axis=-2)


def seen_in(group: Group, axis: Axis) -> Seen:
    """Receptances of a group as the sensors read them, and their derivatives once they are asked for.

    Args:
        group: structures and what was measured on them.
        axis: frequencies.
    """
    part = group.part
    found = solved(group.structures, axis, part.entries)
    value, factor = found.value, None
    lost = missing_of(found) if axis.length > 0 else None
    if lost is not None:
        value = value + lost
    if group.reading is not None:
        factor = np.exp(group.reading(axis)[0])
        value = value * factor

    def slopes(scale: np.ndarray) -> np.ndarray:
        full = group if group.sloped is None else group.sloped()
        sloped = replace(found, structures=full.structures)
        inner = scale if factor is None else scale * factor
        made = sloped.slopes(inner)
        if lost is not None and axis.cut_slopes:
            both = missing_with_slopes(sloped, full.structures.names)
            if both is not None:
                made += _parts_of(both[1] * inner)
        for number, change in ({} if full.reading is None else full.reading(axis)[1]).items():
            made[number] += _parts_of(value * change * scale)
        return made

    return Seen(part.observations, part.entry, value, slopes)

"""A hypothesis: the robot with some effects in some places, as a model of the campaign's FRFs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context, Place
from flexmodal.diagnosis.effects.effect import Effect, Placement
from flexmodal.diagnosis.frame import KINDS, Frame
from flexmodal.diagnosis.march.law import Law
from flexmodal.diagnosis.reader import Reader
from flexmodal.diagnosis.slices import Slice, slices
from flexmodal.identification import Observations
from flexmodal.identification.model import Group
from flexmodal.structure import ParameterSpace
from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly, put_together
from flexmodal.structure.structure import Change, Structure, changed

STEP = 1e-6
"""Of the forward differences along an effect's own parameters."""
_FRAMES = 64
"""Frames kept at most."""


@dataclass(frozen=True, eq=False)
class Placed:
    """An effect in a place."""

    effect: Effect
    where: str

    @property
    def label(self) -> str:
        """Prefix of its parameters."""
        return f"{self.effect.name}@{self.where}"

    @property
    def key(self) -> tuple[str, str]:
        """Name and place."""
        return self.effect.name, self.where


@dataclass(frozen=True, eq=False)
class _Shift:
    """The parameters a step further along one of an effect's own."""

    name: str
    label: str
    step: float
    values: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model of observations (`identification.FrfModel`)."""

    context: Context
    base: ParameterSpace
    """Of the robot itself."""
    placed: tuple[Placed, ...] = ()
    _slices: dict[int, list[Slice]] = field(default_factory=dict, repr=False)
    _frames: dict[tuple[object, ...], Frame] = field(default_factory=dict, repr=False)

    @cached_property
    def space(self) -> ParameterSpace:
        """The robot's parameters, then those of each effect, `EFFECT@PLACE.PARAMETER`."""
        more = [
            replace(parameter, name=f"{one.label}.{parameter.name}")
            for one in self.placed
            for parameter in one.effect.parameters(self.context, one.where)
        ]
        return self.base.and_also(more)

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Name and place of each effect."""
        return tuple(one.key for one in self.placed)

    @property
    def by_force(self) -> bool:
        """Whether one of its effects depends on the blow."""
        return any(placed.effect.by_force for placed in self.placed)

    def and_also(self, placed: Placed) -> Hypothesis:
        """With one more effect."""
        return Hypothesis(self.context, self.base, (*self.placed, placed))

    def without(self, key: tuple[str, str]) -> Hypothesis:
        """With one effect less."""
        return Hypothesis(self.context, self.base, tuple(one for one in self.placed if one.key != key))

    def values_of(self, placed: Placed, values: Mapping[str, float]) -> dict[str, float]:
        """An effect's own parameters without prefix, among the robot's."""
        prefix = f"{placed.label}."
        own = {k.removeprefix(prefix): v for k, v in values.items() if k.startswith(prefix)}
        return {**{name: values[name] for name in self.base.names}, **own}

    def start(
        self, placed: Placed, given: Mapping[str, float], x: Float[np.ndarray, " before"]
    ) -> Float[np.ndarray, " parameter"]:
        """Coordinates x of the hypothesis without its last effect, and that effect started somewhere."""
        prefix = f"{placed.label}."
        tail = []
        for parameter in self.space.parameters[len(x) :]:
            short = parameter.name.removeprefix(prefix)
            inside = min(max(given.get(short, parameter.card), parameter.lower), parameter.upper)
            tail.append(parameter.coordinate(inside))
        return np.concatenate([x, tail])

    def groups(
        self, x: Float[np.ndarray, " parameter"], observations: Observations, *, slopes: bool
    ) -> Sequence[Group]:
        """See `identification.FrfModel`."""
        values = self.space.values(x)
        shifts = self._shifts(x) if slopes else []
        return [
            Group(
                self._structure(one, values, shifts),
                one.rows,
                one.pairs,
                one.level,
                self._reader(one, values, shifts),
            )
            for one in self._sliced(observations)
        ]

    def structures(
        self,
        x: Float[np.ndarray, " parameter"],
        responses: Sequence[Place],
        references: Sequence[Place],
        *,
        slopes: bool,
    ) -> list[Structure]:
        """The structure in each posture of the context, seen and struck anywhere.

        Args:
            x: coordinates.
            responses: point ids and directions of the response rows.
            references: likewise, of the reference rows.
            slopes: with derivatives.
        """
        values = self.space.values(x)
        shifts = self._shifts(x) if slopes else []
        where, struck = (np.array(list(table), dtype=int).reshape(-1, 2) for table in (responses, references))
        names = tuple(self.context.point(number).name for number, _ in responses)
        found = []
        for posture in range(len(self.context.postures)):
            one = Slice(
                posture, np.zeros(0, dtype=int), where, struck, np.zeros((0, 2), dtype=int), names, (), 0,
                (0, 0), (0, 0),
            )  # fmt: skip
            found.append(self._structure(one, values, shifts))
        return found

    def laws(self, posture: int, values: Mapping[str, float]) -> tuple[Law, ...]:
        """Torques of the effects that have a law, in a posture (by number) at these parameter values."""
        frame = self._frame(posture, values)
        return tuple(
            one.effect.law(
                frame.assembly, Placement(self.context, one.where, self.values_of(one, values), posture)
            )
            for one in self.placed
            if one.effect.law is not None
        )

    def _shifts(self, x: np.ndarray) -> list[_Shift]:
        _, high = self.space.bounds
        found = []
        for k, name in enumerate(self.space.names[len(self.base) :], start=len(self.base)):
            step = STEP if x[k] + STEP <= high[k] else -STEP
            moved = x.copy()
            moved[k] += step
            label = next(one.label for one in self.placed if name.startswith(f"{one.label}."))
            found.append(_Shift(name, label, step, self.space.values(moved)))
        return found

    def _sliced(self, observations: Observations) -> list[Slice]:
        key = id(observations)
        if key not in self._slices:
            wanted = {variant for one in self.placed for variant in one.effect.variants}
            self._slices[key] = slices(observations, wanted)
        return self._slices[key]

    # structures

    def _structure(self, one: Slice, values: Mapping[str, float], shifts: Sequence[_Shift]) -> Structure:
        frame = self._frame(one.posture, values)
        total, changes = frame.scaled(values)
        added = self._act(frame, one, values)
        for kind, matrix, names in added.terms:
            total[kind] = total[kind] + matrix
            for name in names:
                changes[name] = changes.get(name, Change()) + changed({kind: matrix})
        rows = self._rows(frame, one, values)
        bare = _summed(added)
        loss = added.loss_factor
        for shift in shifts:
            change = self._change(frame, one, values, shift, bare, loss, rows)
            if change is not None:
                changes[shift.name] = change
        return Structure(
            coordinates=tuple(frame.assembly.coordinates),
            mass=total["mass"],
            damping=total["damping"],
            stiffness=total["stiffness"],
            loss=total["loss"],
            response=rows[0],
            reference=rows[1],
            changes=changes,
            loss_factor=loss,
        )

    def _change(
        self,
        frame: Frame,
        one: Slice,
        values: Mapping[str, float],
        shift: _Shift,
        bare: Mapping[str, np.ndarray],
        bare_loss: float,
        rows: tuple[np.ndarray, np.ndarray],
    ) -> Change | None:
        """Derivative along one of an effect's own parameters, by differences of what depends on it."""
        effect = next(placed.effect for placed in self.placed if placed.label == shift.label)
        slots: dict[str, np.ndarray] = {}
        loss = 0.0
        moved = self._frame(one.posture, shift.values)
        if effect.act is not None or moved is not frame:
            acted = self._act(moved, one, shift.values)
            other = _summed(acted)
            loss = (acted.loss_factor - bare_loss) / shift.step
            for kind in KINDS:
                slots[kind] = other[kind] - bare[kind]
        if moved is not frame:
            was, _ = frame.scaled(values)
            now, _ = moved.scaled(shift.values)
            for kind in KINDS:
                slots[kind] = slots[kind] + now[kind] - was[kind]
        if moved is not frame or effect.turn is not None:
            others = self._rows(moved, one, shift.values)
            slots["response"], slots["reference"] = others[0] - rows[0], others[1] - rows[1]
        kept = {name: slot / shift.step for name, slot in slots.items() if slot.any()}
        return changed(kept, loss or None) if kept or loss else None

    def _frame(self, posture: int, values: Mapping[str, float]) -> Frame:
        geometry = tuple(values[f"{one.label}.{name}"] for one in self.placed for name in one.effect.geometry)
        key = (posture, geometry)
        if key not in self._frames:
            if len(self._frames) >= _FRAMES:
                self._frames.clear()
            self._frames[key] = self._build(posture, values)
        return self._frames[key]

    def _build(self, posture: int, values: Mapping[str, float]) -> Frame:
        """Motions of the effects, and the card's own terms on them."""
        card = {parameter.name: parameter.card for parameter in self.base}
        assembly = Assembly(self.context.arms[posture])
        placements = [
            (one.effect, Placement(self.context, one.where, {**self.values_of(one, values), **card}, posture))
            for one in self.placed
        ]
        for effect, placement in placements:
            if effect.shape is not None:
                effect.shape(assembly, placement)
        bodies = assembly.arm.bodies
        taken = {
            link
            for link in bodies
            if any(
                effect.bodies(assembly, placement, bodies, link)
                for effect, placement in placements
                if effect.bodies
            )
        }
        left: dict[str, Body] = {link: body for link, body in bodies.items() if link not in taken}
        put_together(assembly, card, left)
        return Frame(assembly, self.base.names, np.array([p.card for p in self.base]), {})

    def _act(self, frame: Frame, one: Slice, values: Mapping[str, float]) -> Assembly:
        """What the effects put on the motions, by itself."""
        assembly = frame.assembly.alike()
        for effect, placement in self._placements(one, values):
            if effect.act is not None:
                effect.act(assembly, placement)
        return assembly

    def _placements(self, one: Slice, values: Mapping[str, float]) -> list[tuple[Effect, Placement]]:
        return [
            (
                placed.effect,
                Placement(
                    self.context,
                    placed.where,
                    self.values_of(placed, values),
                    one.posture,
                    one.level,
                    one.reference,
                    one.response,
                ),
            )
            for placed in self.placed
        ]

    def _rows(self, frame: Frame, one: Slice, values: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Rows of responses and references."""
        turning = [
            (effect, placement)
            for effect, placement in self._placements(one, values)
            if effect.turn is not None
        ]
        if turning:
            measured = self.context.places(one.where)
            for effect, placement in turning:
                assert effect.turn is not None
                measured = [
                    (link, place, effect.turn(self.context, placement, one.posture, name, way))
                    for (link, place, way), name in zip(measured, one.points, strict=True)
                ]
            response = frame.assembly.rows(measured)
        else:
            response = self._kept(frame, one.where)
        return response, self._kept(frame, one.struck)

    def _kept(self, frame: Frame, wanted: np.ndarray) -> np.ndarray:
        key = wanted.tobytes()
        if key not in frame.rows:
            frame.rows[key] = frame.assembly.rows(self.context.places(wanted))
        return frame.rows[key]

    def _reader(self, one: Slice, values: Mapping[str, float], shifts: Sequence[_Shift]) -> Reader | None:
        labels = {placed.label for placed in self.placed if placed.effect.read is not None}
        if not labels:
            return None
        moved = [
            (shift.name, shift.step, self._placements(one, shift.values))
            for shift in shifts
            if shift.label in labels
        ]
        return Reader(one.read, self._placements(one, values), moved)


def _summed(assembly: Assembly) -> dict[str, np.ndarray]:
    """Sum of an assembly's terms by kind."""
    n = len(assembly.coordinates)
    total = {kind: np.zeros((n, n)) for kind in KINDS}
    for kind, matrix, _ in assembly.terms:
        total[kind] += matrix
    return total

"""A hypothesis: the robot with some effects in some places, as a model of the campaign's FRFs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects.context import Context, Place
from flexmodal.diagnosis.effects.effect import Effect, Placement
from flexmodal.diagnosis.moving import built, turned
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.reader import Reader
from flexmodal.diagnosis.shift import Shift, Still, differences
from flexmodal.diagnosis.time_domain.law import Law
from flexmodal.identification import Observations
from flexmodal.identification.layout import Part, unmeasured
from flexmodal.identification.model import Group
from flexmodal.structure import ParameterSpace
from flexmodal.structure.assembly import KINDS, Assembly
from flexmodal.structure.frame import Frame, proportional
from flexmodal.structure.stack import Structures, joined
from flexmodal.structure.structure import Structure

STEP = 1e-6
"""Of the forward differences along an effect's own parameters."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model of observations (`identification.FrfModel`)."""

    context: Context
    base: ParameterSpace
    """Of the robot itself."""
    placed: tuple[Placed, ...] = ()

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
        """An effect's own parameters without prefix, among the robot's.

        Args:
            placed: the effect.
            values: of all parameters, by name.
        """
        found = {name: values[name] for name in self.base.names}
        return found | {short: values[name] for short, name in self._names[placed.label] if name in values}

    @cached_property
    def _names(self) -> Mapping[str, Sequence[tuple[str, str]]]:
        """Of the parameters of each effect, without and with its prefix."""
        own = self.space.names[len(self.base) :]
        return {
            label: [(name.removeprefix(f"{label}."), name) for name in own if name.startswith(f"{label}.")]
            for label in (one.label for one in self.placed)
        }

    @cached_property
    def _geometry(self) -> tuple[str, ...]:
        """Names of the parameters that what moves depends on."""
        every = [
            f"{one.label}.{name}"
            for one in self.placed
            for name in one.effect.geometry
            if name not in one.effect.held(self.context, one.where)
        ]
        return tuple(name for name in every if name in self.space.index)

    def start(
        self, placed: Placed, given: Mapping[str, float], x: Float[np.ndarray, " before"]
    ) -> Float[np.ndarray, " parameter"]:
        """Coordinates x of the hypothesis without its last effect, and that effect started somewhere.

        Args:
            placed: that last effect.
            given: where it starts, by name without prefix, else at the middle of its prior; and the robot's.
            x: without the effect.
        """
        begun = np.concatenate([x, np.zeros(len(self.space) - len(x))])
        for number, parameter in enumerate(self.space):
            short = parameter.name.removeprefix(f"{placed.label}.")
            if number >= len(x) or short in given:
                inside = min(max(given.get(short, parameter.card), parameter.lower), parameter.upper)
                begun[number] = parameter.coordinate(inside)
        return begun

    def groups(
        self, x: Float[np.ndarray, " parameter"], observations: Observations, *, slopes: bool
    ) -> Sequence[Group]:
        """See `identification.FrfModel` for the arguments."""
        values = self.space.values(x)
        shifts = cache(lambda: self._shifts(x, values))
        wanted = {variant for one in self.placed for variant in one.effect.variants}
        return [
            self._group(part, values, shifts, slopes=slopes) for part in observations.layout.parts(wanted)
        ]

    def _group(
        self, part: Part, values: Mapping[str, float], shifts: Callable[[], Sequence[Shift]], *, slopes: bool
    ) -> Group:
        still = self._still(part, values)

        def sloped() -> Group:
            moved = self._reader(part, values, shifts())
            return Group(self._structures(still, part, values, shifts()), part, moved)

        if slopes:
            return sloped()
        plain = self._structures(still, part, values, None)
        return Group(plain, part, self._reader(part, values, None), sloped)

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
        where, struck = (np.array(list(table), dtype=int).reshape(-1, 2) for table in (responses, references))
        part = unmeasured(len(self.context.postures), where, struck)
        shifts = self._shifts(x, values) if slopes else None
        found = self._structures(self._still(part, values), part, values, shifts)
        return [found[k] for k in range(len(found))]

    def laws(self, part: Part, values: Mapping[str, float]) -> list[tuple[Law, ...]]:
        """Torques of the effects that have a law, in each system of a part.

        Args:
            part: of the layout of some observations.
            values: of all parameters, by name.
        """
        assembly = self._frame(part, values).assembly
        found = [
            law
            for one in self.placed
            if one.effect.law is not None
            for law in one.effect.law(assembly.owned(one.label), self._placement(one, part, values))
        ]
        return [tuple(law.of_system(k) for law in found) for k in range(len(part.posture))]

    def placed_in(self, part: Part, x: Float[np.ndarray, " parameter"]) -> list[tuple[Assembly, Placement]]:
        """The motions and the placement of each effect in the systems of a part.

        Args:
            part: of the layout of some observations.
            x: coordinates.
        """
        values = self.space.values(x)
        assembly = self._frame(part, values).assembly
        return [(assembly.owned(one.label), self._placement(one, part, values)) for one in self.placed]

    def _shifts(self, x: np.ndarray, values: Mapping[str, float]) -> list[Shift]:
        _, high = self.space.bounds
        found = []
        for k, parameter in enumerate(self.space.parameters[len(self.base) :], start=len(self.base)):
            step = STEP if x[k] + STEP <= high[k] else -STEP
            placed = next(one for one in self.placed if parameter.name.startswith(f"{one.label}."))
            moved = {**values, parameter.name: parameter.value(float(x[k]) + step)}
            found.append(Shift(k, placed, step, moved))
        return found

    # structures

    def _still(self, part: Part, values: Mapping[str, float]) -> Still:
        frame = self._frame(part, values)
        acted = {
            one: self._act(frame, one, part, values) for one in self.placed if one.effect.act is not None
        }
        sums = {one: assembly.summed() for one, assembly in acted.items()}
        return Still(frame, *frame.scaled(values), acted, sums, self._rows(frame, part, values))

    def _structures(
        self, still: Still, part: Part, values: Mapping[str, float], shifts: Sequence[Shift] | None
    ) -> Structures:
        frame, total, rows = still.frame, dict(still.total), still.rows
        acted, sums = still.acted, still.sums
        found = [] if shifts is None else [still.slopes]
        for one, assembly in acted.items():
            for kind in KINDS:
                total[kind] = total[kind] + sums[one][kind]
            if found:
                found.append(proportional(assembly, self.space.index, total["mass"].shape))
        turned: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        loss: dict[int, float] = {}
        for shift in shifts or ():
            shifted = self.space.names[shift.number] in self._geometry
            moved = self._frame(part, shift.values) if shifted else frame
            change = dict.fromkeys(KINDS, np.zeros(total["mass"].shape))
            if shift.placed in acted:
                other = self._act(moved, shift.placed, part, shift.values)
                summed = other.summed()
                change = {kind: summed[kind] - sums[shift.placed][kind] for kind in KINDS}
                loss[shift.number] = (other.loss_factor - acted[shift.placed].loss_factor) / shift.step
            if moved is not frame:
                was, now = still.total, moved.scaled(shift.values)[0]
                change = {kind: change[kind] + now[kind] - was[kind] for kind in KINDS}
            if moved is not frame or shift.placed.effect.turn is not None:
                others = self._rows(moved, part, shift.values)
                turned[shift.number] = (others[0] - rows[0]) / shift.step, (others[1] - rows[1]) / shift.step
            found.append(differences(shift, change, total["mass"].shape))
        return Structures(
            coordinates=tuple(frame.assembly.coordinates),
            mass=total["mass"],
            damping=total["damping"],
            stiffness=total["stiffness"],
            loss=total["loss"],
            response=rows[0],
            reference=rows[1],
            names=self.space.names,
            slopes=joined(found),
            turned=turned,
            loss_factor=float(sum(assembly.loss_factor for assembly in acted.values())),
            loss_slopes={number: slope for number, slope in loss.items() if slope},
        )

    def _frame(self, part: Part, values: Mapping[str, float]) -> Frame:
        geometry = tuple(values[name] for name in self._geometry)
        effects = tuple((one.effect, one.where) for one in self.placed)
        key = (self.base, effects, part.key, geometry)
        return self.context.frames.get(
            key, lambda: built(self.context, self.base, part, self._at_card(part, values))
        )

    def _at_card(self, part: Part, values: Mapping[str, float]) -> list[tuple[Effect, Placement]]:
        """Effects with values of their own, on the robot of the card."""
        card = {parameter.name: parameter.card for parameter in self.base}
        return [(one.effect, self._placement(one, part, {**values, **card})) for one in self.placed]

    def _act(self, frame: Frame, one: Placed, part: Part, values: Mapping[str, float]) -> Assembly:
        """What an effect puts on the motions, by itself."""
        assembly = frame.assembly.alike().owned(one.label)
        assert one.effect.act is not None
        one.effect.act(assembly, self._placement(one, part, values))
        return assembly

    def _placement(self, one: Placed, part: Part, values: Mapping[str, float]) -> Placement:
        own = self.values_of(one, values)
        return Placement(self.context, one.where, own, part.posture, part.blow, part.reference, part.response)

    def _rows(
        self, frame: Frame, part: Part, values: Mapping[str, float]
    ) -> tuple[Float[np.ndarray, "system response dof"], Float[np.ndarray, "system reference dof"]]:
        """Rows of responses and references."""
        turning = [one for one in self.placed if one.effect.turn is not None]
        return turned(frame, part, [(one.effect, self._placement(one, part, values)) for one in turning])

    def _reader(
        self, part: Part, values: Mapping[str, float], shifts: Sequence[Shift] | None
    ) -> Reader | None:
        reading = [one for one in self.placed if one.effect.read is not None]
        if not reading:
            return None
        moved = [
            (shift.number, shift.step, shift.placed.effect, self._placement(shift.placed, part, shift.values))
            for shift in shifts or ()
            if shift.placed in reading
        ]
        placements = [(one.effect, self._placement(one, part, values)) for one in reading]
        return Reader(part.read, part.entries.table[:, 0], placements, moved)

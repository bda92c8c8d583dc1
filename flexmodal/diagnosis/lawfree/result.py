"""What a law-free look says: places with their misfits, the curve, its class, effects that it could be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float
from scipy.optimize import linear_sum_assignment

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.lawfree.effects_at import CLASSES_OF, PORT_OF, holds
from flexmodal.diagnosis.search.set_out import Start

NEAR = 2.5
"""Times the misfit of the best port, up to which an effect at another one is still fitted; but none at one
that leaves more than nothing does, if any leaves less."""
TELLS = 1.25
"""Times by which a place lowers the misfit at least to tell where a law's fits set out, where another one is
found and does not explain all; not tuned, 1.5 for the one foundation that was looked at."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Free functions of a port as they were found; one posture and blow, if they differ."""

    frequency: Float[np.ndarray, " line"]
    """[Hz]"""
    names: tuple[str, ...]
    unit: str
    value: Complex[np.ndarray, "function line"]
    deviation: Float[np.ndarray, "function line"]
    """Standard deviation of the real and of the imaginary part."""


@dataclass(frozen=True)
class Class:
    """A class of physics laid beside the curve."""

    name: str
    says: str
    """In words with its numbers."""
    coefficients: tuple[tuple[float, ...], ...]
    """Of the terms of each function."""
    misfit: float
    """Root of the reduced χ² of the template; about 1 where the curve is of this class."""
    share: float
    """Part of the curve's own χ², against nothing at all, that the template takes."""
    score: float
    """χ², tempered by that of the best class, and ln(number of values) for each parameter."""


@dataclass(frozen=True)
class Loss:
    """How far the free torque of a joint takes energy."""

    share: float
    """Mean of the imaginary part over that of the size, of all blows."""
    weaker: float
    """The same of what a weak blow has more than a hard one."""


@dataclass(frozen=True)
class PlaceTried:
    """A port, fitted and judged."""

    port: str
    """Kind."""
    where: str
    says: str
    """What it would be, for people."""
    misfit: float
    """In units of the noise, on the postures fitted; about 0.6 if perfect."""
    held_out: float | None
    """The same on postures that judged."""
    unknowns: int
    """Functions and parameters of its geometry."""
    free: FreeFunction | None = None
    """What was found; None where it differs by posture."""

    @property
    def judged(self) -> float:
        """The larger of both misfits."""
        return self.misfit if self.held_out is None else max(self.misfit, self.held_out)


@dataclass(frozen=True, eq=False)
class Found:
    """One of the ports that together explain what they can."""

    port: str
    """Kind."""
    where: str
    says: str
    """What it would be, for people."""
    without: float
    """Misfit of the others alone; of the re-tuned robot where there are none."""
    alike: tuple[tuple[str, str], ...]
    """Kind and place of what cannot be told from it, itself among them; the simplest first."""
    curve: Curve | None
    """None where it has no function in common to all postures."""
    classes: tuple[Class, ...]
    """Those that its curve may be of, the likeliest first; empty where it is of none."""
    loss: Loss | None = None
    """Of a torque with a function of its own for every blow."""
    free: FreeFunction | None = None
    """What was found; None where it differs by posture."""
    tells: str | None = None
    """Name of the effect that its function alone tells, if all places together explain everything."""
    changes: str | None = None
    """Of a sensor that reads something else in each posture: name of the effect that it is in each."""

    def has(self, effect: str, where: str) -> bool:
        """Whether it can do what an effect of the catalogue does, at its place.

        Args:
            effect: its name.
            where: its place.
        """
        port = PORT_OF.get(effect)
        return port is not None and any(one[1] == where and holds(one, (port, where)) for one in self.alike)

    def bears(self, effect: str, where: str) -> bool:
        """Whether an effect acts along the joint whose torque was found free for every blow.

        Args:
            effect: its name.
            where: its place.
        """
        return self.port == "torque" and PORT_OF.get(effect) == "joint" and self.where == where

    def could_be(self, effect: str, where: str) -> bool:
        """Whether the place and the class allow for an effect of the catalogue, or its function tells it.

        A curve of no class that is known here speaks for nothing, and against nothing: templates are narrower
        than the effects.

        Args:
            effect: its name.
            where: its place.
        """
        if (effect, where) == (self.tells, self.where):
            return True
        here = self.has(effect, where)
        if not here or self.curve is None or effect not in CLASSES_OF or self.where != where:
            return here  # a function of its own in each posture and blow has no curve
        return not self.classes or any(one.name in CLASSES_OF[effect] for one in self.classes)

    def surely(self, effect: str) -> bool:
        """Whether nothing else can be in its place and its curve tells the class of an effect.

        Args:
            effect: its name.
        """
        return self.curve is not None and bool(self.classes) and effect in CLASSES_OF and self.is_apart

    @property
    def is_apart(self) -> bool:
        """Whether every other place can be told from it, but for ports that can do all that it can."""
        return all(holds(key, (self.port, self.where)) for key in self.alike)


@dataclass(frozen=True, eq=False)
class Findings:
    """A law-free look in short."""

    alone: float
    """Misfit of the re-tuned robot without any port."""
    left: float
    """With all that were found: the larger of those on postures fitted and held out."""
    places: tuple[PlaceTried, ...]
    """Each for itself, the best first."""
    found: tuple[Found, ...]
    """Those that are needed, in the order in which they were found."""
    explains: bool
    """Whether they take what is missing down to the noise."""
    needed: bool
    """Whether anything is gained by one."""
    says: str
    fitted: Float[np.ndarray, " known"] | None = None
    """Coordinates of what is believed, as fitted beside the ports that are needed."""

    @property
    def place(self) -> str:
        """Where the first one is."""
        return self.found[0].where

    @property
    def lone(self) -> Found | None:
        """The only place that explains everything, which others can be told from; None if there is none."""
        alone = self.explains and len(self.found) == 1 and self.found[0].is_apart
        return self.found[0] if alone else None

    def worth_trying(self, effect: str, where: str) -> bool:
        """Whether an effect is to be fitted at a place; if none explains all, those held out do not bar it.

        Args:
            effect: its name; those that no port stands for are tried always.
            where: its place.
        """
        port = PORT_OF.get(effect)
        if port is None or any(one.has(effect, where) or one.bears(effect, where) for one in self.found):
            return True
        return len(self.found) == 1 and self.is_near(port, where)

    def is_near(self, port: str, where: str) -> bool:
        """Whether a place does about as well as the best, or as well on the postures fitted.

        Args:
            port: its kind.
            where: the place.
        """
        best, key = self.places[0].judged, (port, where)
        limit = min(NEAR * best, self.alone) if best < self.alone else NEAR * best
        here = [one for one in self.places if (one.port, one.where) == key]
        return any(one.judged <= limit or (not self.explains and one.misfit <= best) for one in here)

    def is_at(self, keys: Sequence[tuple[str, str]]) -> bool:
        """Whether it points to the place of one of some effects, as far as it can tell places apart.

        Args:
            keys: names and places of the effects.
        """
        return any(one.has(*key) for one in self.found for key in keys)

    def told(self, effect: Effect, where: str, context: Context) -> list[Start]:
        """Where a fit of an effect may set out, by the functions at its place if these gain by themselves.

        Args:
            effect: of the catalogue.
            where: its place.
            context: of the diagnosis.

        Returns:
            Values of the effect, and coordinates of what is believed beside it.
        """
        met = any(one.has(effect.name, where) for one in self.found)
        most = np.inf if met else 0.0 if self.explains else self.alone / TELLS
        return [
            (values, one.free.fitted)
            for one in self.places
            if one.judged <= most and one.free is not None
            for values in told_at(one, effect, where, context)
        ]

    def in_order(self, known: Sequence[str], wanted: Sequence[str]) -> Findings:
        """The same for other orders of the coordinates of what is believed.

        Args:
            known: names of the coordinates, as it has them.
            wanted: the same names in another order.
        """
        if tuple(known) == tuple(wanted):
            return self
        index = np.array([known.index(name) for name in wanted])
        places = tuple(
            replace(one, free=None if one.free is None else replace(one.free, fitted=one.free.fitted[index]))
            for one in self.places
        )
        return replace(self, places=places, fitted=None if self.fitted is None else self.fitted[index])

    def met(self, keys: Sequence[tuple[str, str]]) -> Mapping[tuple[str, str], Found]:
        """Which ports some effects sit at, each at one of its own; those that can be at none are left out.

        Args:
            keys: names and places of the effects.
        """
        can = np.array([[one.could_be(*key) for one in self.found] for key in keys], dtype=float)
        if not can.size:
            return {}
        rows, columns = linear_sum_assignment(-can)
        return {
            keys[k]: self.found[m]
            for k, m in zip(rows.tolist(), columns.tolist(), strict=True)
            if can[k, m] > 0
        }


def told_at(
    place: PlaceTried | Found, effect: Effect, where: str, context: Context
) -> Sequence[Mapping[str, float]]:
    """Values of an effect that the function of a place tells; none where it cannot, or there is no function.

    Args:
        place: its port has to do what the effect's does.
        effect: of the catalogue.
        where: the effect's place.
        context: of the diagnosis.
    """
    if effect.told is None or place.free is None:
        return []
    able = holds((place.port, place.where), (PORT_OF[effect.name], where))
    return effect.told(context, where, place.free) if able else []

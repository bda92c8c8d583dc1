"""What an effect is: where it can sit, what it adds to a structure, what it makes of the readings.

An effect is one file with one `Effect`. Others add theirs through the entry point group `flexmodal.effects`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.time_domain.law import Law
from flexmodal.structure import Parameter
from flexmodal.structure.arm import Body, crossed
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.structure import Axis

if TYPE_CHECKING:
    from flexmodal.diagnosis.improved.draft import Draft

KEPT = 256
"""Links whose axes are kept; every evaluation of an effect asks for them."""


@dataclass(frozen=True, eq=False)
class Placement:
    """An effect's place, its parameters' values, and the postures and blows it is looked at under."""

    context: Context
    where: str
    values: Mapping[str, float]
    posture: Int[np.ndarray, " system"]
    """Number of the posture of each system."""
    level: Int[np.ndarray, " system"]
    """Number of the kind of blow; of the first of the group for effects that do not depend on it."""
    reference: Int[np.ndarray, "system 2"]
    response: Int[np.ndarray, "system 2"]
    """Point id and direction, likewise."""

    @classmethod
    def still(cls, context: Context, where: str, values: Mapping[str, float]) -> Placement:
        """In the first posture, whatever the blow.

        Args:
            context: of the diagnosis.
            where: place of the effect.
            values: of its parameters, by name.
        """
        none, blank = np.zeros(1, dtype=int), np.zeros((1, 2), dtype=int)
        return cls(context, where, values, none, none, blank, blank)

    def of_systems(self, some: Int[np.ndarray, " some"]) -> Placement:
        """In some of the systems only."""
        tables = self.posture[some], self.level[some], self.reference[some], self.response[some]
        return Placement(self.context, self.where, self.values, *tables)

    @property
    def progress(self) -> Float[np.ndarray, " system"]:
        """How far through the campaign each was measured: 0 in the first posture and 1 in the last."""
        return np.asarray(self.posture / max(len(self.context.postures) - 1, 1))

    def __getitem__(self, name: str) -> float:
        """A parameter."""
        return self.values[name]


Bodies = Mapping[str, Body]
Reading = tuple[np.ndarray, Mapping[str, np.ndarray]]


@dataclass(frozen=True, eq=False)
class Level:
    """An effect with a law that holds another one's as a limit, for where that one is not enough."""

    effect: Effect
    starts: Callable[[Context, str, Mapping[str, float]], Sequence[Mapping[str, float]]]
    """Values to start a fit from at a place, from those that the narrower law was fitted with there."""

    @classmethod
    def anew(cls, effect: Effect) -> Level:
        """That sets out where its law does, whatever the narrower one was fitted with."""
        return cls(effect, lambda context, where, values: effect.starts(context, where))


@dataclass(frozen=True, eq=False)
class Effect:
    """One way in which a robot or its measurement differs from the card. Hooks that do not apply are None."""

    name: str
    says: str
    """What it is, for people; completes "the data speak for …"."""
    places: Callable[[Context], tuple[str, ...]]
    """Where it can sit."""
    parameters: Callable[[Context, str], tuple[Parameter, ...]]
    """At a place, with priors; names without prefix."""
    starts: Callable[[Context, str], Sequence[Mapping[str, float]]]
    """Values to start a fit from; what is left out starts at the prior's centre."""
    told: Callable[[Context, str, FreeFunction], Sequence[Mapping[str, float]]] | None = None
    """Values that come near to free functions of its port, to start from beside those."""
    shape: Callable[[Assembly, Placement], None] | None = None
    """New coordinates and motions. Sees of its own parameters those in `geometry` only."""
    geometry: tuple[str, ...] = ()
    """Parameters that motions and bodies depend on; those of them that the effect has in a context."""
    held: Callable[[Context, str], Sequence[str]] = lambda context, where: ()
    """Those of them that neither depends on at a place."""
    bodies: Callable[[Assembly, Placement, Bodies, str], bool] | None = None
    """Takes over a link's body, whose name is last; says whether it did."""
    act: Callable[[Assembly, Placement], None] | None = None
    """Masses, springs, dampers."""
    law: Callable[[Assembly, Placement], Sequence[Law]] | None = None
    """The torques themselves where they depend on the swing; `act` is then their stand-in at one amplitude,
    for the search, and they take its place where blows are integrated in time (`time_domain`)."""
    behind: Callable[[Placement], tuple[float, float]] | None = None
    """Where the law is that of another spring than the joint's: the stiffness that is linear beside it, and
    how far it swings over how far the joint alone would under the same blow. With the same energy both
    together swing farther, by the root of what their compliance is over the joint's."""
    besides: Callable[[Assembly, Placement], None] | None = None
    """What of `act` stays there then, as it depends on no swing."""
    turn: Callable[[Assembly, Placement, str, np.ndarray], np.ndarray] | None = None
    """World directions that a sensor truly measures: name of its point, the recorded direction."""
    aside: Callable[[Placement, str], np.ndarray] | None = None
    """How far off its recorded place a sensor sits, by its point's name [m, in the frame of the link]."""
    read: Callable[[Placement, Axis], complex | np.ndarray] | None = None
    """ln(reading / motion) of the sensor at `where`; the same for all that it read, or for each, whose point
    and direction the placement has here."""
    simpler: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Effects that it comes down to in a limit, in the same place, and the parameters that they share."""
    limit: str = ""
    """The parameter at whose upper bound it comes down to these, if there is one."""
    made_by: Sequence[str] = ()
    """What is reported of it, one of which has to differ from nothing, for it to be this effect at all."""
    hides_in: tuple[str, ...] = ()
    """What the names of the robot's own parameters begin with that may take it over, beside others."""
    sticks: bool = False
    """Whether it is linear, though it depends on the blow, where blows are too weak for it to slide."""
    parts: Sequence[Sequence[str]] = ()
    """Parameters of parts of it that are next to nothing at the middle of their priors: there they are told
    where the data gain hardly anything by a part, for then they have many minima that nothing tells apart."""
    unlike: Callable[[Context, Mapping[str, float]], float] | None = None
    """By its parameters, how far it goes beyond what bears its name: from 0 on it is something else, whatever
    its law explains."""
    unlike_says: str = ""
    """What it does then, for people."""
    comes_close: bool = False
    """Whether its law follows all that bears its name so closely that what it leaves is something else."""
    next_level: Level | None = None
    """A wider law under the same name, fitted where this one leaves something at its place."""
    variants: Sequence[str] = ()
    """What the structure depends on besides the posture: "blow" (level and hammer point) or "response"."""
    untestable: Callable[[Context], str | None] = lambda context: None
    """Why these data cannot tell of it, if they cannot."""
    physical: Callable[[Context, str, Mapping[str, float]], dict[str, float]] = (
        lambda context, where, values: dict(values)
    )
    """What a report gives as its parameters, from the parameters of the fit."""
    extend: Callable[[Draft, Placement], None] | None = None
    """What it changes in the robot's URDF and card. Without it, a note says that the files do not hold it."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Units of what `physical` gives beyond the parameters of the fit."""

    @property
    def by_force(self) -> bool:
        """Whether it depends on the blow."""
        return "blow" in self.variants


def positive(name: str, unit: str, centre: float, deviation: float, lower: float, upper: float) -> Parameter:
    """A parameter on a logarithmic scale with a wide prior around `centre`.

    Args:
        name: short, without effect and place.
        unit: of the value; empty if it has none.
        centre: middle of the prior, and where the parameter begins.
        deviation: standard deviation of ln(value / centre).
        lower: bound of the value, above 0.
        upper: likewise.
    """
    return Parameter(name, unit, centre, deviation, lower, upper)


def signed(
    name: str, unit: str, deviation: float, lower: float, upper: float, centre: float = 0.0
) -> Parameter:
    """A parameter on a linear scale.

    Args:
        name: short, without effect and place.
        unit: of the value; empty if it has none.
        deviation: standard deviation of the prior, in that unit.
        lower: bound of the value.
        upper: likewise.
        centre: middle of the prior, and where the parameter begins.
    """
    return Parameter(name, unit, centre, deviation, lower, upper, log=False)


def sides(context: Context, link: str, axis: np.ndarray) -> list[np.ndarray]:
    """Unit vectors across a link's axis, in its frame: one in the plane of a planar chain, or two.

    Args:
        context: whose robot.
        link: which.
        axis: unit vector along the link, in its frame.
    """
    return list(_sides(context, link, tuple(axis.tolist())))


@lru_cache(maxsize=KEPT)
def _sides(context: Context, link: str, along: tuple[float, ...]) -> tuple[np.ndarray, ...]:
    axis = np.array(along)
    if context.normal is not None:
        side = crossed(context.axes(link).T @ context.normal, axis)
        size = float(np.linalg.norm(side))
        return (side / size,) if size > 1e-9 else ()
    return across(axis)


def across(axis: Float[np.ndarray, "3"]) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Two unit vectors across a unit vector."""
    first = crossed(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    return first, crossed(axis, first)


@lru_cache(maxsize=KEPT)
def along(context: Context, link: str) -> tuple[float, np.ndarray]:
    """Length of a link and the unit vector along it, in its frame; x where it has no length.

    Args:
        context: of the diagnosis.
        link: its name.
    """
    end = context.reach(link)
    length = float(np.linalg.norm(end))
    return length, (end / length if length > 1e-6 else np.array([1.0, 0.0, 0.0]))

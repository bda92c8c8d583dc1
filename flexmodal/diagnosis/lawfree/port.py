"""A port: where something is missing, with the dynamic stiffness or compliance there left free at every line.

A port adds to the believed robot, or to its measurement, unknown complex functions of frequency and nothing
else. Stiffness functions stand on patterns of the coordinates, compliance functions behind coordinates that
are rigid without them, readings multiply what a sensor or a hammer says (Frequency-based substructuring: de
Klerk, Rixen and Voormeeren, AIAA Journal 46, 2008; one function shared by all postures is what makes place
and law identifiable from a few points).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Placement
from flexmodal.identification import Observations
from flexmodal.structure.assembly import Assembly


@dataclass(frozen=True, eq=False)
class Patterns:
    """What unknown functions act on, in the systems of one part of the observations."""

    stiffness: Float[np.ndarray, "function system dof dof"] | None = None
    """Symmetric; the functions are dynamic stiffnesses [N/m, N·m/rad]."""
    compliance: Float[np.ndarray, "function dof dof"] | None = None
    """Share of each function in the compliance of each coordinate, and between two [m/N, rad/(N·m)]."""


BETWEEN = " × "
"""Stands between the names of two motions that a function is of."""
STILL = Effect("port", "", lambda context: (), lambda c, w: (), lambda c, w: ())
"""A port without coordinates of its own."""


@dataclass(frozen=True, eq=False)
class PortKind:
    """Ports of one sort."""

    name: str
    says: str
    """For people; completes "the data point to …"."""
    places: Callable[[Context], tuple[str, ...]]
    functions: Callable[[Context, str], tuple[str, ...]]
    """Names of the unknown functions."""
    sizes: Callable[[Context, str, Float[np.ndarray, " line"]], Float[np.ndarray, "function line"]]
    """Scale of each at frequencies [Hz], about as large as it might be."""
    starts: Callable[[Context, str], tuple[tuple[float, ...], ...]] = lambda context, where: ()
    """Constants, in sizes, that a search tries to begin with beside none at all; one for each function."""
    geometries: Callable[[Context, str], Sequence[Mapping[str, float]]] = lambda context, where: ()
    """Where the geometry of a port of one stiffness may set out, beside the middle of its prior."""
    unit: str = "N·m/rad"
    shape: Effect = STILL
    """Motions that the port needs, and parameters of its geometry."""
    patterns: Callable[[Assembly, Placement], Patterns] | None = None
    """None for readings."""
    reads: Callable[[Observations, Context, str], Bool[np.ndarray, " observation"]] | None = None
    """Observations whose reading the function multiplies."""
    turns: bool = False
    """Whether the functions are of turns too, see `FreeFunction`."""
    drops: bool = False
    """Whether these are left out instead, as if each had a function of its own."""
    by_blow: bool = False
    """Whether the function is another one in each posture and under each kind of blow."""
    informs: bool = False
    """Whether it is told how well its functions are known, for fits of laws to set out from them."""
    wider: tuple[Wider, ...] = ()
    """The same with more functions, where it comes near and is not enough: each is tried."""
    parts: Callable[[str], Sequence[tuple[PortKind, str, int]]] = lambda where: ()
    """Narrower ports that one in a place holds: kind, place, and which of its functions is that one's."""

    @cached_property
    def motions(self) -> Effect:
        """Its shape by the name of its kind, so that ports of several kinds can be in one place."""
        return replace(self.shape, name=self.name)


@dataclass(frozen=True, eq=False)
class Wider:
    """A kind of port that can do whatever another can, and more, with the same names for its geometry."""

    kind: PortKind
    begin: Callable[
        [Context, str, Mapping[str, float], Complex[np.ndarray, "function line"]],
        Complex[np.ndarray, "more line"],
    ]
    """Its functions where they do what those of the narrower one do at a place, at values of its geometry."""


@dataclass(frozen=True, eq=False)
class Port:
    """A kind of port in a place."""

    kind: PortKind
    where: str
    names: tuple[str, ...] = field(default=())
    """Of its functions."""

    @classmethod
    def at(cls, kind: PortKind, where: str, context: Context) -> Port:
        """With the names of its functions.

        Args:
            kind: of the port.
            where: one of the places of its kind.
            context: of the diagnosis.
        """
        return cls(kind, where, kind.functions(context, where))

    @property
    def key(self) -> tuple[str, str]:
        """Kind and place."""
        return self.kind.name, self.where

    @property
    def label(self) -> str:
        """Kind and place as text, such as joint@q2."""
        return f"{self.kind.name}@{self.where}"


def outer(row: np.ndarray, other: np.ndarray, count: int) -> Float[np.ndarray, "system dof dof"]:
    """The symmetric pattern of two rows in so many systems.

    Args:
        row: of one motion, the same in all systems or one for each.
        other: of the other; the same object for a pattern of one motion.
        count: number of systems.
    """
    product = row[..., :, None] * other[..., None, :]
    pattern = product if row is other else product + np.swapaxes(product, -1, -2)
    return np.broadcast_to(pattern, (count, *pattern.shape[-2:]))


def constant(size: list[float], frequency: np.ndarray) -> Float[np.ndarray, "function line"]:
    """Sizes that are the same at every frequency.

    Args:
        size: of each function.
        frequency: lines.
    """
    return np.repeat(np.array(size)[:, None], len(frequency), axis=1)


def tensor(rows: Sequence[np.ndarray], count: int) -> Float[np.ndarray, "function system dof dof"]:
    """Patterns of a symmetric matrix of functions between some motions.

    Args:
        rows: of the motions.
        count: number of systems.
    """
    return np.stack([outer(a, b, count) for a, b in combinations_with_replacement(rows, 2)])


def tensor_names(names: Sequence[str]) -> tuple[str, ...]:
    """What these functions are called, by the names of the motions."""
    return tuple(a if a == b else f"{a}{BETWEEN}{b}" for a, b in combinations_with_replacement(names, 2))

"""A foundation's compliance and its derivatives, line by line, without a structure.

Each body that the root stands on has a dynamic stiffness Z = Σ f v r rᵀ over springs, dampers and inertias: a
value v along a motion r, f = 1, iω or −ω². Bodies on top of each other are in series, C = Σ E Z⁻¹ Eᵀ. With
w = E Z⁻¹ r

    ∂C = −Σ f (∂v w wᵀ + v ∂w wᵀ + v w ∂wᵀ),    ∂w = E Z⁻¹ ∂r  at Z as it is.

Values are products of parameters on a logarithmic scale and motions depend on the others, so that ∂ ln v is
the same everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.foundation import (
    Spring,
    centre_of,
    inertias,
    mass_centre,
    motions,
    springs,
)
from flexmodal.structure import ParameterSpace
from flexmodal.structure.arm import carried

_STEP = 1e-6
"""Along parameters of the motions, which are linear or nearly so over it."""


@dataclass(frozen=True, eq=False)
class Terms:
    """A dynamic stiffness as a sum."""

    motion: Float[np.ndarray, "term coordinate"]
    value: Float[np.ndarray, " term"]
    kind: Int[np.ndarray, " term"]
    """Power of iω that it is multiplied by."""


@dataclass(frozen=True, eq=False)
class _Solved:
    """One body's terms at some parameters."""

    terms: Terms
    factor: Complex[np.ndarray, "line term"]
    inverse: Complex[np.ndarray, "line way coordinate"]
    """E Z⁻¹."""

    def moved(self, motion: Float[np.ndarray, "term coordinate"]) -> Complex[np.ndarray, "line way term"]:
        """E Z⁻¹ rᵀ."""
        return np.asarray(self.inverse @ motion.T)


class FoundationLaw:
    """Compliances of a law of foundations as its port has them."""

    def __init__(
        self,
        context: Context,
        space: ParameterSpace,
        bolts: Callable[[Placement], Sequence[Spring]] | None,
        omega: Float[np.ndarray, " line"],
        back: Float[np.ndarray, "way coordinate"],
        pairs: Int[np.ndarray, "2 function"],
    ) -> None:
        """Lay it out.

        Args:
            context: of the diagnosis.
            space: parameters of the law.
            bolts: springs between the foundation and the root, if there are any.
            omega: lines [rad/s].
            back: E, from the coordinates at the root's origin to those of the port.
            pairs: ways of moving that each function stands between.
        """
        self.context, self.space, self.bolts = context, space, bolts
        self.powers = np.stack([np.ones_like(omega) + 0j, 1j * omega, -(omega**2) + 0j])
        self.back, self.pairs = back, pairs
        self.motion = motions(context.normal)[1]
        self._moving = [k for k, one in enumerate(space) if not one.log]

    @cached_property
    def _shares(self) -> list[Float[np.ndarray, "term parameter"]]:
        """Derivatives of the logarithms of each body's values."""
        count = len(self.space)
        known = self.bodies(np.zeros(count))
        shares = [np.zeros((len(one.value), count)) for one in known]
        for k in range(count):
            if k not in self._moving:
                for share, here, there in zip(shares, known, self.bodies(_unit(k, count)), strict=True):
                    share[:, k] = np.log(there.value / here.value)
        return shares

    def bodies(self, x: Float[np.ndarray, " parameter"]) -> list[Terms]:
        """The foundation, and what is bolted to it.

        Args:
            x: coordinates of the parameters.
        """
        placement = Placement.still(self.context, "base", self.space.values(x))
        below = carried(self.motion, centre_of(placement))
        body = (self.motion.T @ carried(self.motion, mass_centre(placement)), inertias(placement))
        found = [_terms(springs(placement), below, body)]
        return found if self.bolts is None else [*found, _terms(self.bolts(placement), self.motion, None)]

    def compliance(self, x: Float[np.ndarray, " parameter"]) -> Complex[np.ndarray, "line function"]:
        """Of the law.

        Args:
            x: coordinates of the parameters.
        """
        first, second = self.pairs
        full = sum(one.inverse @ self.back.T for one in self._solved(x))
        return np.asarray(full)[:, first, second]

    def slopes(self, x: Float[np.ndarray, " parameter"]) -> Complex[np.ndarray, "line function parameter"]:
        """Its derivatives along the coordinates.

        Args:
            x: coordinates of the parameters.
        """
        first, second = self.pairs
        found = np.zeros((self.powers.shape[1], len(first), len(self.space)), dtype=complex)
        solved = self._solved(x)
        ways = [one.moved(one.terms.motion) for one in solved]
        for one, way, share in zip(solved, ways, self._shares, strict=True):
            found -= (way[:, first] * way[:, second] * one.factor[:, None]) @ share
        for k in self._moving:
            there = self.bodies(x + _STEP * _unit(k, len(x)))
            for one, way, moved in zip(solved, ways, there, strict=True):
                turned = one.moved((moved.motion - one.terms.motion) / _STEP)
                both = turned[:, first] * way[:, second] + way[:, first] * turned[:, second]
                found[:, :, k] -= np.einsum("lft,lt->lf", both, one.factor)
        return found

    def _solved(self, x: np.ndarray) -> list[_Solved]:
        found = []
        for terms in self.bodies(x):
            factor = self.powers[terms.kind].T * terms.value
            z = (factor[:, None, :] * terms.motion.T) @ terms.motion.astype(complex)
            found.append(_Solved(terms, factor, self.back @ np.linalg.inv(z)))
        return found


def _unit(number: int, count: int) -> Float[np.ndarray, " parameter"]:
    return np.where(np.arange(count) == number, 1.0, 0.0)


def _terms(some: Sequence[Spring], motion: np.ndarray, body: tuple[np.ndarray, np.ndarray] | None) -> Terms:
    """Springs and dampers on what moves so, and a body: its motions, and its inertias along them."""
    rows = np.array([way for _, way, _, _ in some]) @ motion
    stiffness, damping = np.array([one[2:] for one in some]).T
    every = [(rows, stiffness), (rows, damping), *([] if body is None else [body])]
    kinds = np.concatenate([np.full(len(value), kind) for kind, (_, value) in enumerate(every)])
    return Terms(np.concatenate([a for a, _ in every]), np.concatenate([b for _, b in every]), kinds)

"""What a campaign can tell, before anything is fitted: the Fisher information against the priors.

Scaled by the prior's standard deviations, an eigenvalue λ of the information says that the data leave a part
1/√(1 + λ) of what the prior left open along its eigenvector. Directions with less than nothing to
speak of are the null space: combinations that no fit of such data can find.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.identification.uncertainty import KNOWN
from flexmodal.structure.parameter import ParameterSpace

BLIND = 1e-11
"""Eigenvalue, relative to the largest, from which nothing at all is told."""
UNBOUNDED = 2.0
"""Standard deviation that stands for no prior: a factor of seven."""
PARTS = 0.2
"""Parts of a direction below this share of its largest are left out of the words."""
ALIKE = 0.05
"""How far a direction may be from a pattern to be named after it."""


@dataclass(frozen=True)
class Combination:
    """A direction of the parameter space that the data do not tell."""

    parts: Mapping[str, float]
    """Coordinates (logarithms, as a rule) by parameter, the largest 1 or −1."""
    left: float
    """Part of the prior's standard deviation that the data leave, 0 to 1."""
    exact: bool
    """Whether the data do not depend on it at all."""
    says: str


@dataclass(frozen=True, eq=False)
class Identifiability:
    """Information of data against the priors of a space."""

    space: ParameterSpace
    information: Float[np.ndarray, "parameter parameter"]
    what: str = "these data"

    @cached_property
    def _scale(self) -> np.ndarray:
        return np.array([min(p.deviation, UNBOUNDED) for p in self.space])

    @cached_property
    def _spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        scaled = self.information * np.outer(self._scale, self._scale)
        values, vectors = np.linalg.eigh((scaled + scaled.T) / 2)
        return np.maximum(values, 0.0), vectors

    @cached_property
    def expected(self) -> Mapping[str, float]:
        """Standard error of each coordinate after a fit of such data; the prior's where nothing tells."""
        values, vectors = self._spectrum
        spread = np.sqrt(np.sum(vectors**2 / (1 + values), axis=1))
        return dict(zip(self.space.names, (spread * self._scale).tolist(), strict=True))

    @cached_property
    def identifiable(self) -> tuple[str, ...]:
        """Parameters that such data tell: half of the prior's standard deviation or less is left."""
        return tuple(
            name
            for name, scale in zip(self.space.names, self._scale, strict=True)
            if self.expected[name] < KNOWN * scale
        )

    @property
    def rank(self) -> int:
        """How many directions the data tell anything about."""
        values, _ = self._spectrum
        return int(np.sum(values > BLIND * max(float(values[-1]), 1e-300)))

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """Directions that are not told, the exact ones first, by name where they have one."""
        values, vectors = self._spectrum
        blind = values <= BLIND * max(float(values[-1]), 1e-300)
        weak = ~blind & (1 / (1 + values) > KNOWN**2)
        return (*self._named(vectors[:, blind], np.zeros(blind.sum()), True),
                *self._named(vectors[:, weak], values[weak], False))  # fmt: skip

    @property
    def verdict(self) -> str:
        """One sentence, said before the fit."""
        unknown = [name for name in self.space.names if name not in self.identifiable]
        if not unknown:
            return f"{self.what} can tell all {len(self.space)} parameters"
        exact = [one.says for one in self.combinations if one.exact]
        told = f"{self.what} can tell {len(self.identifiable)} of {len(self.space)} parameters, not "
        return told + ", ".join(unknown) + (f"; {'; '.join(exact)}" if exact else "")

    def _named(self, basis: np.ndarray, values: np.ndarray, exact: bool) -> list[Combination]:
        """Known patterns first, then the rest of the span by as few parameters as possible."""
        found, taken = [], np.zeros((len(self.space), 0))  # in units of the prior's deviations
        weakest = float(1 / np.sqrt(1 + values.min())) if len(values) else 1.0
        for frame, says in patterns(self.space, self.what, exact):
            direction = _within(basis, frame / self._scale[:, None])
            if direction is None or taken.shape[1] == basis.shape[1]:
                continue
            more = np.column_stack([taken, direction])
            if np.linalg.svd(more, compute_uv=False)[-1] < ALIKE:
                continue  # said already
            taken = more
            found.append(self._combination(direction * self._scale, weakest, exact, says))
        for direction in _sparse(_beyond(basis, taken)):
            found.append(self._combination(direction * self._scale, weakest, exact, ""))
        return found

    def _combination(self, direction: np.ndarray, left: float, exact: bool, says: str) -> Combination:
        size = float(np.max(np.abs(direction)))
        parts = {
            name: float(part / size)
            for name, part in zip(self.space.names, direction, strict=True)
            if abs(part) >= PARTS * size
        }
        return Combination(parts, left, exact, says or _words(parts, self.what, exact))


def patterns(
    space: ParameterSpace, what: str, exact: bool
) -> list[tuple[Float[np.ndarray, "parameter basis"], str]]:
    """Sets of directions, and what it means if one of them is not told.

    Args:
        space: the parameters.
        what: is measured, in words.
        exact: whether they are not told at all, or hardly.
    """
    kinds = [name.split(".")[0] for name in space.names]
    unit = np.eye(len(space))

    def all_of(*chosen: str) -> np.ndarray:
        return np.array([[1.0 if kind in chosen else 0.0] for kind in kinds])

    effect = "has no effect on" if exact else "has too little effect on"
    tell = "tell" if exact else "hardly tell more than"
    found = [(unit[:, [k]], f"{name} {effect} {what}") for k, name in enumerate(space.names)]
    for name, k in space.index.items():
        other = space.index.get(f"inertia.{name.partition('.')[2]}")
        if name.startswith("mass.") and other is not None:
            link = name.partition(".")[2]
            says = f"mass and inertia of {link} trade off: {what} {tell} one moment of the two together"
            found.append((unit[:, [k, other]], says))
    scaling = [kind for kind in ("stiffness", "damping", "mass") if kind in kinds]
    if {"stiffness", "mass"} <= set(scaling):
        listed = " and ".join([", ".join(scaling[:-1]), scaling[-1]])
        found.append((all_of(*scaling), f"{listed} scale together: {what} {tell} their ratios"))
    return found


def _within(
    span: Float[np.ndarray, "parameter basis"], frame: Float[np.ndarray, "parameter frame"]
) -> Float[np.ndarray, " parameter"] | None:
    """The unit direction of `frame` that lies in `span`; None where there is none.

    The smallest principal angle between the two (Björck and Golub, Math. Comp. 27, 1973).
    """
    if span.shape[1] == 0:
        return None
    one, other = np.linalg.qr(span)[0], np.linalg.qr(frame)[0]
    left, cosine, _ = np.linalg.svd(other.T @ one)
    return other @ left[:, 0] if cosine[0] >= np.cos(ALIKE) else None


def _beyond(
    span: Float[np.ndarray, "parameter basis"], taken: Float[np.ndarray, "parameter some"]
) -> Float[np.ndarray, "parameter rest"]:
    """What is left of a span orthogonal to some of its directions."""
    if not taken.shape[1]:
        return span
    weight = span.T @ taken  # the span's basis is orthonormal
    turn = np.linalg.svd(weight)[0]
    return span @ turn[:, taken.shape[1] :]


def _words(parts: Mapping[str, float], what: str, exact: bool) -> str:
    if len(parts) == 1:
        effect = "has no effect" if exact else "has too little effect"
        return f"{next(iter(parts))} {effect} on {what} where others move a little with it"
    text = " ".join(f"{part:+.2g}·{name}" for name, part in parts.items())
    return f"{what} leave a combination open: {text}"


def _sparse(basis: Float[np.ndarray, "parameter basis"]) -> Sequence[np.ndarray]:
    """A basis of the same span with as many zeros as elimination gives."""
    from scipy.linalg import qr

    if basis.shape[1] == 0:
        return []
    _, _, order = qr(basis.T, pivoting=True)
    reduced = basis @ np.linalg.inv(basis[order[: basis.shape[1]]])
    reduced[np.abs(reduced) < 1e-6] = 0.0
    return list(reduced.T)

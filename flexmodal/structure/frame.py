"""The part of structures that a fit changes only by factors: the robot's own bodies, springs and dampers.

Every such term is proportional to parameters on a logarithmic scale, so that a frame is built once for some
postures and a geometry (where a hinge sits), and afterwards only scaled.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.structure.assembly import KINDS, Assembly
from flexmodal.structure.definite import with_inertia
from flexmodal.structure.stack import Slopes, joined

MOST_KEPT = 256e6
"""Bytes of frames kept at most."""


@dataclass(frozen=True, eq=False)
class Terms:
    """Matrices of one kind, each proportional to some parameters."""

    matrices: Float[np.ndarray, "term system dof dof"]
    """At the card."""
    share: Float[np.ndarray, "parameter term"]
    """1 where the term is proportional to the parameter."""
    moved: np.ndarray
    """Numbers of the parameters that any of them is proportional to."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A robot in some postures, one system each, with the motions of some effects."""

    assembly: Assembly
    """With every motion, of every system."""
    apart: Assembly
    """The same in each posture once, with the card's own terms: systems may differ by more than postures."""
    posture: Int[np.ndarray, " system"]
    """Which of these a system stands in."""
    names: tuple[str, ...]
    """Parameters of the robot."""
    card: Float[np.ndarray, " parameter"]
    """Their values there."""
    response: Float[np.ndarray, "system response dof"]
    reference: Float[np.ndarray, "system reference dof"]
    is_cut: bool = False
    """Whether the body of a link is shared out between several parts, whose inertia may come out negative."""

    @cached_property
    def size(self) -> int:
        """Bytes that its matrices take, about: each term's in full, before and after they are added up."""
        matrices = (self.posture.max() + 1) * len(self.apart.terms)
        rows = self.response.nbytes + self.reference.nbytes
        return int(16 * matrices * len(self.apart.coordinates) ** 2 + rows)

    @cached_property
    def terms(self) -> Mapping[str, Terms]:
        """By kind."""
        index = {name: k for k, name in enumerate(self.names)}
        count, n = int(self.posture.max()) + 1, len(self.apart.coordinates)
        found = {}
        for kind in KINDS:
            merged: dict[tuple[str, ...], np.ndarray] = {}
            for what, matrix, names in self.apart.terms:
                if what == kind:
                    own = tuple(name for name in names if name in index)
                    merged[own] = merged.get(own, np.zeros((count, n, n))) + self.apart.full(matrix)
            share = np.zeros((len(index), len(merged)))
            for column, own in enumerate(merged):
                share[[index[name] for name in own], column] = 1.0
            matrices = np.array(list(merged.values())).reshape(-1, count, n, n)
            found[kind] = Terms(matrices, share, np.flatnonzero(share.any(axis=1)))
        return found

    def scaled(self, values: Mapping[str, float]) -> tuple[dict[str, np.ndarray], Slopes]:
        """Matrices [system dof dof] by kind at these values; derivatives along the parameters' logarithms."""
        log = np.log(np.array([values[name] for name in self.names]) / self.card)
        total: dict[str, np.ndarray] = {}
        slopes: Slopes = {}
        for kind, terms in self.terms.items():
            grown, shape = np.exp(log @ terms.share), terms.matrices.shape[1:]
            flat = terms.matrices.reshape(len(grown), int(np.prod(shape)))
            found = (grown @ flat).reshape(shape)
            total[kind] = (with_inertia(found) if self.is_cut and kind == "mass" else found)[self.posture]
            if terms.moved.size:
                along = (terms.share[terms.moved] * grown) @ flat
                slopes[kind] = (terms.moved, along.reshape(-1, *shape)[:, self.posture])
        return total, slopes


def proportional(assembly: Assembly, index: Mapping[str, int], shape: tuple[int, ...]) -> Slopes:
    """Derivatives along the logarithms of the parameters that the terms of an assembly are named after.

    Args:
        assembly: with terms.
        index: number of each parameter.
        shape: of the matrices [system dof dof].
    """
    return joined(
        [
            {kind: (np.array([index[name]]), np.broadcast_to(assembly.full(matrix), shape)[None])}
            for kind, matrix, names in assembly.terms
            for name in names
            if name in index
        ]
    )


class Frames:
    """Keeps the frames that were used last, by values of what they depend on, up to a size."""

    def __init__(self, most: float = MOST_KEPT) -> None:
        """Nothing is kept yet.

        Args:
            most: bytes; the last one is kept in any case.
        """
        self.kept = OrderedDict[Hashable, Frame]()
        """Those used last at the end."""
        self._room = most

    def get(self, key: Hashable, build: Callable[[], Frame]) -> Frame:
        """The frame of a key, built unless it is kept.

        Args:
            key: values of what the frame depends on.
            build: makes it; called only where it is not kept.
        """
        if key in self.kept:
            self.kept.move_to_end(key)
            return self.kept[key]
        found = build()
        self._room -= found.size
        while self.kept and self._room < 0:
            self._room += self.kept.popitem(last=False)[1].size
        self.kept[key] = found
        return found

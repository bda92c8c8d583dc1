"""The part of structures that a fit changes only by factors: the robot's own bodies, springs and dampers.

Every such term is proportional to parameters on a logarithmic scale, so that a frame is built once for some
postures and a geometry (where a hinge sits), and afterwards only scaled.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float

from flexmodal.structure.assembly import KINDS, Assembly
from flexmodal.structure.stack import Slopes, joined

_KEPT = 64
"""Frames kept at most."""


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
    """With every motion and the card's own terms."""
    names: tuple[str, ...]
    """Parameters of the robot."""
    card: Float[np.ndarray, " parameter"]
    """Their values there."""
    response: Float[np.ndarray, "system response dof"]
    reference: Float[np.ndarray, "system reference dof"]

    @cached_property
    def terms(self) -> Mapping[str, Terms]:
        """By kind."""
        index = {name: k for k, name in enumerate(self.names)}
        count, n = len(self.response), len(self.assembly.coordinates)
        found = {}
        for kind in KINDS:
            merged: dict[tuple[str, ...], np.ndarray] = {}
            for what, matrix, names in self.assembly.terms:
                if what == kind:
                    own = tuple(name for name in names if name in index)
                    merged[own] = merged.get(own, np.zeros((count, n, n))) + self.assembly.full(matrix)
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
            total[kind] = (grown @ flat).reshape(shape)
            if terms.moved.size:
                along = (terms.share[terms.moved] * grown) @ flat
                slopes[kind] = (terms.moved, along.reshape(-1, *shape))
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


@dataclass(frozen=True, eq=False)
class Frames:
    """Keeps the frames that were built last, by values of what they depend on."""

    kept: dict[Hashable, Frame] = field(default_factory=dict)

    def get(self, key: Hashable, build: Callable[[], Frame]) -> Frame:
        """The frame of a key, built unless it is kept.

        Args:
            key: values of what the frame depends on.
            build: makes it; called only where it is not kept.
        """
        if key not in self.kept:
            if len(self.kept) >= _KEPT:
                self.kept.clear()
            self.kept[key] = build()
        return self.kept[key]

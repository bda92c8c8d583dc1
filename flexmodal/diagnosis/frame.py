"""The part of a structure that a fit changes only by factors: the robot's own bodies, springs and dampers.

Every such term is proportional to parameters on a logarithmic scale, so that a frame is built once for a
posture and a geometry (where a hinge sits), and afterwards only scaled.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmodal.structure.assembly import Assembly
from flexmodal.structure.structure import Change, changed

KINDS = ("mass", "damping", "stiffness", "loss")


@dataclass(frozen=True, eq=False)
class Terms:
    """Matrices of one kind, each proportional to some parameters."""

    matrices: np.ndarray
    """[term, dof, dof] at the card."""
    share: np.ndarray
    """[parameter, term]: 1 where the term is proportional to the parameter."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A robot in a posture with the motions of some effects."""

    assembly: Assembly
    """With every motion and the card's own terms."""
    names: tuple[str, ...]
    """Parameters of the robot."""
    card: np.ndarray
    """Their values there."""
    rows: dict[bytes, np.ndarray]
    """Rows of places, once computed."""

    @cached_property
    def terms(self) -> dict[str, Terms]:
        """By kind."""
        n = len(self.assembly.coordinates)
        index = {name: k for k, name in enumerate(self.names)}
        found = {}
        for kind in KINDS:
            some = [(matrix, names) for what, matrix, names in self.assembly.terms if what == kind]
            merged: dict[tuple[str, ...], np.ndarray] = {}
            for matrix, names in some:
                own = tuple(name for name in names if name in index)
                size = len(matrix)
                merged.setdefault(own, np.zeros((n, n)))[:size, :size] += matrix
            share = np.zeros((len(index), len(merged)))
            for column, own in enumerate(merged):
                share[[index[name] for name in own], column] = 1.0
            found[kind] = Terms(np.array(list(merged.values())).reshape(-1, n, n), share)
        return found

    def scaled(self, values: Mapping[str, float]) -> tuple[dict[str, np.ndarray], dict[str, Change]]:
        """Matrices by kind at these values, and their derivatives along the logarithm of each parameter."""
        log = np.log(np.array([values[name] for name in self.names]) / self.card)
        total: dict[str, np.ndarray] = {}
        slopes: dict[str, dict[str, np.ndarray]] = {}
        for kind, terms in self.terms.items():
            grown = np.exp(log @ terms.share)
            n = terms.matrices.shape[-1]
            flat = terms.matrices.reshape(-1, n * n)
            total[kind] = (grown @ flat).reshape(n, n)
            along = ((terms.share * grown) @ flat).reshape(-1, n, n)
            for k in np.flatnonzero(terms.share.any(axis=1)).tolist():
                slopes.setdefault(self.names[k], {})[kind] = along[k]
        return total, {name: changed(slot) for name, slot in slopes.items()}

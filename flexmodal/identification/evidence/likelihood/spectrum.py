"""Poles and shapes of several structures of one size at once, with derivatives.

All postures of a campaign go through one eigenvalue problem, since matrices this small cost more in calls
than in arithmetic; a test holds it against `structure.poles`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex

from flexmodal.errors import Fault, InvalidSystem
from flexmodal.structure.poles import eigen_slopes, slopes_of
from flexmodal.structure.structure import Structure

REAL = 1e-9
"""Imaginary part, relative to the pole, below which a pole does not oscillate."""

LIGHT = 1e-7
"""Part of each diagonal that is added to a mass matrix in which something weighs nothing, a base without
inertia, say: its modes lie some 3000 times higher than those of the arm."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """All 2n poles of each structure: first those that oscillate upwards, by size, then the others."""

    pole: Complex[np.ndarray, "posture pole"]
    """λ [rad/s]"""
    seen: Complex[np.ndarray, "posture place pole"]
    """What the response rows see of shapes scaled to uᵀ(2λM + C)u = 1."""
    pole_slope: Complex[np.ndarray, "posture name pole"]
    seen_slope: Complex[np.ndarray, "posture name place pole"]
    count: Sequence[int]
    """How many of each structure's poles oscillate."""


def spectrum(structures: Sequence[Structure], names: tuple[str, ...]) -> Spectrum:
    """Solve.

    Args:
        structures: one for each posture, all with the same coordinates; hysteresis is left out.
        names: parameters to differentiate along.

    Raises:
        InvalidSystem: a mass matrix that is not positive definite.
    """
    mass, damping, stiffness = (
        np.array([getattr(s, kind) for s in structures]) for kind in ("mass", "damping", "stiffness")
    )
    pole, shape = _solve(mass, damping, stiffness)
    response = np.array([s.response for s in structures])
    slopes = {kind: slopes_of(structures, names, kind) for kind in ("mass", "damping", "stiffness")}
    turned_rows = np.zeros((len(structures), len(names), *response.shape[1:]))
    for p, one in enumerate(structures):
        for k, name in enumerate(names):
            change = one.changes.get(name)
            if change is not None and change.response is not None:
                turned_rows[p, k] = change.response
    pole_slope, shape_slope = eigen_slopes(pole, shape, **slopes)
    seen_slope = response[:, None] @ shape_slope + turned_rows @ shape[:, None]
    count = [int(np.sum(one.imag > REAL * np.abs(one))) for one in pole]
    return Spectrum(pole, response @ shape, pole_slope, seen_slope, count)


def _solve(mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poles and scaled shapes, by the companion form in coordinates that make the mass the identity."""
    count, n = mass.shape[:2]
    size = np.sqrt(np.maximum(np.diagonal(mass, axis1=1, axis2=2), 1e-300))
    scaled = mass / size[:, :, None] / size[:, None, :]
    least = float(np.linalg.eigvalsh(scaled)[:, 0].min())
    if least < -LIGHT:
        raise InvalidSystem(Fault("system", "mass", "not positive definite", "a positive definite matrix"))
    if least < LIGHT:
        mass = mass + LIGHT * np.eye(n) * size[:, None, :] ** 2
    root = np.linalg.inv(np.linalg.cholesky(mass))
    k = root @ stiffness @ np.swapaxes(root, 1, 2)
    c = root @ damping @ np.swapaxes(root, 1, 2)
    unit = np.sqrt(np.maximum(np.abs(k).max(axis=(1, 2)), 1e-300))
    companion = np.zeros((count, 2 * n, 2 * n))
    companion[:, :n, n:] = np.eye(n)
    companion[:, n:, :n] = -k / unit[:, None, None] ** 2
    companion[:, n:, n:] = -c / unit[:, None, None]
    value, vector = np.linalg.eig(companion)
    pole, shape = value.astype(complex) * unit[:, None], vector[:, :n].astype(complex)
    still = pole.imag <= REAL * np.abs(pole)
    order = np.lexsort((pole.real, np.abs(pole), still), axis=-1)
    pole = np.take_along_axis(pole, order, axis=1)
    shape = np.swapaxes(root, 1, 2) @ np.take_along_axis(shape, order[:, None, :], axis=2)
    scale = np.einsum("pim,pij,pjm->pm", shape, mass, shape) * 2 * pole
    scale += np.einsum("pim,pij,pjm->pm", shape, damping, shape)
    return pole, shape / np.sqrt(np.where(scale == 0, 1.0, scale))[:, None, :]

"""What a change of the free functions costs, once the robot's own parameters have followed it.

    |d|² = Σ dᴴ A d − gᵀ (A_pp + prior)⁻¹ g,   g = Re Σ Pᴴ d,

A and P from the normal equations with the functions of other ports eliminated, line by line. With A = Wᴴ W on
every line and e = W d this is |e|² less the little that p parameters take, so that its root and its inverse
follow from small matrices: for N = Re (W⁻ᴴ P) and N C^(−1/2) = U S Vᵀ

    R = (1 − U (1 − √(1 − S²)) Uᵀ) W,   (RᵀR)⁻¹ = W⁻¹ (1 + U S² / (1 − S²) Uᵀ) W⁻ᴴ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.lawfree.profile import Profile, State

_RIDGE = 1e-9
"""On the precision of the parameters."""
_KNOWN = 1e-14
"""Of what is known best, known at least of every combination: of functions of a line, of parameters."""
_TAKEN = 1e-12
"""Part of a change that is left at least when parameters have followed it."""


@dataclass(frozen=True, eq=False)
class Metric:
    """On changes of a port's functions, in their sizes; d by real and imaginary part."""

    root: Complex[np.ndarray, "line function function"]
    """W of every line."""
    back: Complex[np.ndarray, "line function function"]
    """Its inverse."""
    followed: Float[np.ndarray, "value direction"]
    """U: what parameters can follow, over e line by line and function by function, real parts first."""
    taken: Float[np.ndarray, " direction"]
    """S²."""

    @classmethod
    def of_port(cls, profile: Profile, state: State, span: slice) -> Metric:
        """Of the functions of one port, those of the others and the parameters eliminated.

        Args:
            profile: of ports whose functions are the same in all postures.
            state: where.
            span: functions of the port.
        """
        equations = profile.equations(state)
        zz, zp, pp = equations.zz[0], equations.zp[0], equations.pp
        prior = profile.temper(state.residual) * profile.model.space.precision
        own = np.zeros(zz.shape[1], dtype=bool)
        own[span] = True
        if not own.all():
            between, beside = zz[:, ~own][:, :, own], zp[:, ~own]
            rest = np.linalg.pinv(zz[:, ~own][:, :, ~own], rcond=1e-12, hermitian=True)
            turned = np.conj(np.swapaxes(between, 1, 2)) @ rest
            pp = pp - np.einsum("lfp,lfg,lgq->pq", beside.conj(), rest, beside, optimize=True).real
            zz, zp = zz[:, own][:, :, own] - turned @ between, zp[:, own] - turned @ beside
        known, way = np.linalg.eigh((zz + np.conj(np.swapaxes(zz, 1, 2))) / 2)
        size = np.sqrt(np.maximum(known, _KNOWN * np.maximum(known[:, -1:], np.finfo(float).tiny)))
        root = size[:, :, None] * np.conj(np.swapaxes(way, 1, 2))
        back = way / size[:, None, :]
        pull = np.conj(np.swapaxes(back, 1, 2)) @ zp
        flat = pull.reshape(-1, zp.shape[-1])
        trusted, turn = np.linalg.eigh(pp + np.diag(prior + _RIDGE))  # below 0 where rounding is all there is
        trusted = np.maximum(trusted, _KNOWN * np.abs(trusted).max(initial=np.finfo(float).tiny))
        slopes = np.concatenate([flat.real, flat.imag]) @ (turn / np.sqrt(trusted))
        followed, taken, _ = np.linalg.svd(slopes, full_matrices=False)
        return cls(root, back, followed, np.minimum(taken**2, 1 - _TAKEN))

    def of(self, change: Complex[np.ndarray, "function line"]) -> Float[np.ndarray, " value"]:
        """R d.

        Args:
            change: d.
        """
        flat = (self.root @ change.T[:, :, None]).ravel()
        return self._less(np.concatenate([flat.real, flat.imag]))

    def of_each(
        self, terms: Complex[np.ndarray, "term line"], size: Float[np.ndarray, "function line"]
    ) -> Float[np.ndarray, "value column"]:
        """R d of changes of one function each, by function and term; all others stay as they are.

        Args:
            terms: changes, each of every function in turn.
            size: of the functions, in which d counts.
        """
        each = terms.T[:, None] / size.T[:, :, None]  # line function term
        flat = (self.root[..., None] * each[:, None]).reshape(self.root.shape[0] * self.root.shape[1], -1)
        return self._less(np.concatenate([flat.real, flat.imag]))

    def _less(self, e: Float[np.ndarray, "value *column"]) -> Float[np.ndarray, "value *column"]:
        """E without what parameters take of it."""
        along = self.followed.T @ e
        return np.asarray(e - self.followed @ ((1 - np.sqrt(1 - self.taken)) * along.T).T)

    @property
    def variance(self) -> Float[np.ndarray, "function line"]:
        """Of the functions, the mean of that of real and imaginary part, where the noise is 1."""
        lines, functions = self.root.shape[:2]
        real, imaginary = self.followed.reshape(2, lines, functions, -1)
        more = np.abs(self.back @ (real + 1j * imaginary)) ** 2 @ (self.taken / (1 - self.taken))
        return np.asarray((np.sum(np.abs(self.back) ** 2, axis=2) + more / 2).T)

"""Modes of a damped second-order system by the symmetric pencil [Hearne 2.28–2.40].

With `S = [[C, M], [M, 0]]` and `T = [[K, 0], [0, −M]]` the modes solve `(λ S + T) φ = 0` and are scaled
to `φᵀ S φ = 1`, which for the displacement half `u` of `φ = [u, λu]` reads `uᵀ(2λM + C)u = 1`. The
residue of mode p between two rows is then the product of what the rows see of `u`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.errors import InaccurateModes, InvalidSystem
from flexmodal.modal.graded import RANGE, check_digits, graded_squares, mended
from flexmodal.modal.hysteretic import with_hysteresis
from flexmodal.modal.system import SecondOrderSystem
from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown, several

NO_MODES = (InvalidSystem, InaccurateModes, np.linalg.LinAlgError)
"""What is raised where a system has no modes, or none with digits left."""
DEFECTIVE = 1e4
"""Pole condition above which a modal sum has lost half its digits: it loses twice as many as the pole."""

_DEPENDENT = 1e-7
"""Smallest singular value of the unit shapes of a repeated pole below which they are too few."""

_REPEATED = 1e-9
"""Distance of two eigenvalues, relative to the larger, below which they count as one."""


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Shown):
    """Modes in the order of |pole|: one entry for each conjugate pair, one for each real pole."""

    pole: Complex[np.ndarray, " mode"]
    """λ [rad/s]; of a conjugate pair the one with the positive imaginary part."""
    shape: Complex[np.ndarray, "dof mode"]
    """Displacement shapes u, scaled to uᵀ(2λM + C)u = 1; of unit length where that cannot be."""
    condition: Float[np.ndarray, " mode"]
    """How much a relative change of the matrices is amplified in the pole; infinite if defective."""
    coordinates: tuple[str, ...]
    """Names of the rows of `shape`."""

    def _facts(self) -> Mapping[str, object]:
        return {
            "": f"{len(self.pole)} modes",
            "at [Hz]": several(f"{value:.4g}" for value in self.frequency),
            "damping ratios": several(f"{value:.3g}" for value in self.damping_ratio),
            "coordinates": several(self.coordinates),
        }

    def to_pandas(self) -> Any:
        """A table of frequency [Hz], damping ratio, pole [rad/s] and shape by mode, numbered from 1.

        Raises:
            MissingExtra: pandas is not installed.
        """
        pandas = extra("pandas", "pandas", "to_pandas")
        columns = {
            "frequency": self.frequency,
            "damping_ratio": self.damping_ratio,
            "pole": self.pole,
            "overdamped": self.overdamped,
        }
        shapes = {f"shape_{name}": self.shape[row] for row, name in enumerate(self.coordinates)}
        index = pandas.RangeIndex(1, len(self.pole) + 1, name="mode")
        return pandas.DataFrame(columns | shapes, index=index)

    def to_xarray(self) -> Any:
        """Pole, frequency, damping ratio and shape as a data set over mode and coordinate.

        Raises:
            MissingExtra: xarray is not installed.
        """
        xarray = extra("xarray", "xarray", "to_xarray")
        return xarray.Dataset(
            {
                "frequency": ("mode", self.frequency, {"units": "Hz"}),
                "damping_ratio": ("mode", self.damping_ratio),
                "pole": ("mode", self.pole, {"units": "rad/s"}),
                "shape": (("coordinate", "mode"), self.shape),
            },
            coords={"mode": np.arange(1, len(self.pole) + 1), "coordinate": list(self.coordinates)},
        )

    @property
    def frequency(self) -> Float[np.ndarray, " mode"]:
        """Natural frequency |λ|/2π [Hz]."""
        return np.abs(self.pole) / (2 * np.pi)

    @property
    def damping_ratio(self) -> Float[np.ndarray, " mode"]:
        """−Re λ / |λ|; 1 for a real pole."""
        size = np.abs(self.pole)
        return np.divide(0.0 - self.pole.real, size, out=np.ones_like(size), where=size > 0)

    @property
    def overdamped(self) -> Bool[np.ndarray, " mode"]:
        """Whether the pole is real and so has no conjugate partner."""
        return self.pole.imag == 0

    @property
    def is_defective(self) -> bool:
        """Whether some pole has no full set of modes, so that the modal sum cannot be trusted."""
        return bool(np.any(self.condition > DEFECTIVE))

    def expanded(self) -> tuple[Complex[np.ndarray, " poles"], Complex[np.ndarray, "dof poles"]]:
        """All 2n poles and shapes: each complex one with its conjugate, each real one once."""
        pairs = ~self.overdamped
        poles = np.concatenate([self.pole, self.pole[pairs].conj()])
        return poles, np.concatenate([self.shape, self.shape[:, pairs].conj()], axis=1)


def solve_modes(system: SecondOrderSystem) -> Modes:
    """Find the modes of a system.

    Undamped and proportionally damped systems (those whose `M⁻¹C` and `M⁻¹K` commute) are solved by a
    real symmetric eigenproblem, exact for repeated frequencies, and for those that range widely to their own
    digits; all others by the companion form in coordinates that make the mass matrix the identity. Hysteretic
    loss comes on top, pole by pole.

    Args:
        system: mass, damping and stiffness, and hysteresis if it has any.

    Returns:
        The modes, ordered by |pole|.

    Raises:
        InaccurateModes: stiffness and damping range over too many decades for a double.
    """
    root = np.linalg.inv(np.linalg.cholesky(system.mass))  # x = rootᵀ y makes M the identity
    stiffness = root @ system.stiffness @ root.T
    damping = root @ system.damping @ root.T
    square, vectors = np.linalg.eigh((stiffness + stiffness.T) / 2)
    if square[0] < RANGE * square[-1]:
        square, vectors = graded_squares(system.stiffness, root) or (square, vectors)
    unit = float(np.sqrt(np.max(np.abs(square)))) or 1.0  # a frequency near the others, for balance
    square = np.maximum(square, 0.0) / unit**2
    damping = vectors.T @ ((damping + damping.T) / 2 / unit) @ vectors
    turn = _diagonalise_within_clusters(square, damping)
    damping = turn.T @ damping @ turn
    spill = damping - np.diag(np.diag(damping))
    if np.max(np.abs(spill), initial=0.0) <= 1e-12 * np.max(np.abs(damping), initial=0.0):
        poles, shapes = _decoupled(square, np.diag(damping))
        shapes, condition = _scale(poles, shapes, damping)
    else:
        poles, shapes = mended(*_coupled(square, damping), square, damping)
        shapes, condition = _scale(poles, shapes, damping)
        shapes = _straighten(poles, shapes, damping, np.isfinite(condition))
    keep = poles.imag >= 0
    order = np.lexsort((poles[keep].real, np.abs(poles[keep])))
    poles, shapes = poles[keep][order] * unit, (root.T @ vectors @ turn @ shapes)[:, keep][:, order]
    check_digits(system, poles, shapes)
    pole, shape, condition = with_hysteresis(system, poles, shapes / np.sqrt(unit), condition[keep][order])
    return Modes(pole, _signed(shape), condition, system.coordinates)


def _signed(shape: np.ndarray) -> np.ndarray:
    """Shapes with a sign that does not hang on rounding: φᵀSφ = 1 leaves it open, and LAPACKs differ.

    The largest component (the first of those that are equal but for rounding) points towards −30°: shapes of
    underdamped modes lie near −45°, of overdamped ones at 0° or −90°, well away from where the sign turns.
    """
    size = np.abs(shape)
    largest = np.argmax(size >= (1 - 1e-6) * size.max(axis=0), axis=0)
    towards = shape[largest, np.arange(shape.shape[1])] * np.exp(1j * np.pi / 6)
    return np.where(towards.real < 0, -shape, shape)


def _diagonalise_within_clusters(square: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Rotate inside groups of equal stiffness so that damping is diagonal there as far as it can be."""
    turn = np.eye(len(square))
    for cluster in _clusters(square):
        if len(cluster) > 1:
            block = np.ix_(cluster, cluster)
            turn[block] = np.linalg.eigh(damping[block])[1]
    return turn


def _clusters(values: np.ndarray) -> list[np.ndarray]:
    """Group the indices of values that lie within `_REPEATED` of one another."""
    left = list(np.argsort(np.abs(values), kind="stable"))
    groups = []
    while left:
        near = [i for i in left if abs(values[i] - values[left[0]]) <= _REPEATED * abs(values[left[0]])]
        groups.append(np.array(near or [left[0]]))
        left = [i for i in left if i not in set(groups[-1].tolist())]
    return groups


def _decoupled(square: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both poles of each oscillator λ² + cλ + ω² = 0, the small real one without cancellation."""
    half = damping / 2
    root = np.sqrt((half**2 - square).astype(complex))
    first = -half - root
    real = (half**2 >= square) & (first != 0)
    second = np.where(real, square / np.where(first == 0, 1, first), -half + root)
    identity = np.eye(len(square), dtype=complex)
    return np.concatenate([first, second]), np.concatenate([identity, identity], axis=1)


def _coupled(square: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenpairs of the companion matrix [[0, I], [−K, −C]]; displacement halves only."""
    count = len(square)
    companion = np.block([[np.zeros((count, count)), np.eye(count)], [-np.diag(square), -damping]])
    poles, vectors = np.linalg.eig(companion)
    poles, vectors = poles.astype(complex), vectors.astype(complex)
    for one in np.flatnonzero((poles.imag > 0) & (poles.imag <= _REPEATED * np.abs(poles))):
        # Rounding moves equal real poles off the axis, one up and one down; their shapes span a real plane.
        plane = np.stack([vectors[:, one].real, vectors[:, one].imag], axis=1)
        if np.linalg.svd(plane, compute_uv=False)[-1] >= _DEPENDENT:
            poles[one : one + 2] = poles[one].real
            vectors[:, one : one + 2] = plane
    # The velocity half is λ times the displacement half; of the two the larger is the better known.
    fast = np.abs(poles) > 1
    safe = np.where(poles == 0, 1, poles)
    return poles, np.where(fast, vectors[count:] / safe, vectors[:count])


def _scale(poles: np.ndarray, shapes: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scale to uᵀ(2λ + C)u = 1, orthogonally within groups of repeated poles; judge each pole."""
    scaled = shapes / np.linalg.norm(shapes, axis=0)
    condition = np.full(len(poles), np.inf)
    rounding = 8 * len(damping) * np.finfo(float).eps
    for cluster in _clusters(poles):
        basis = scaled[:, cluster]
        pole = poles[cluster]
        if len(cluster) > len(basis) or np.linalg.svd(basis, compute_uv=False)[-1] < _DEPENDENT:
            continue  # fewer shapes than poles
        if len(cluster) > 1:
            basis = np.linalg.qr(basis)[0]
        gram = _gram(pole, basis, damping)
        smallest = np.linalg.svd(gram, compute_uv=False)[-1]
        # Only the damping that this shape feels: a stiff or slow neighbour must not make it look defective.
        felt = np.einsum("ip,ij,jp->p", np.abs(basis), np.abs(damping), np.abs(basis))
        size = np.max(felt) + 2 * np.max(np.abs(pole))
        if smallest <= rounding * (np.linalg.norm(damping) + 2 * np.max(np.abs(pole))):
            continue
        condition[cluster] = size / smallest
        scaled[:, cluster] = basis @ _inverse_root(gram)
    return scaled, condition


def _straighten(poles: np.ndarray, shapes: np.ndarray, damping: np.ndarray, sound: np.ndarray) -> np.ndarray:
    """One Newton step towards φᵀSφ = I: shapes of nearly repeated poles come out of `eig` askew."""
    gram = np.where(np.outer(sound, sound), _gram(poles, shapes, damping), np.eye(len(poles)))
    return shapes @ (1.5 * np.eye(len(poles)) - gram / 2)


def _gram(poles: np.ndarray, shapes: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """ΦᵀSΦ written in displacement halves: uᵢᵀ(C + λᵢ + λⱼ)uⱼ."""
    return shapes.T @ damping @ shapes + (shapes.T @ shapes) * (poles[:, None] + poles[None, :])


def _inverse_root(gram: np.ndarray) -> np.ndarray:
    """W with Wᵀ G W = 1 for a small complex symmetric G."""
    if gram.shape == (1, 1):
        return 1 / np.sqrt(gram)
    from scipy.linalg import sqrtm

    # Overdamped fast poles have G < 0, on the branch cut of the root: turn it to where no eigenvalue is.
    angles = np.sort(np.angle(np.linalg.eigvals(gram)))
    gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
    widest = int(np.argmax(gaps))
    turn = -np.exp(1j * (angles[widest] + gaps[widest] / 2))
    root = np.asarray(sqrtm(gram / turn), dtype=complex)  # older SciPy gives more digits than inv takes
    return np.linalg.inv(root * np.sqrt(turn))

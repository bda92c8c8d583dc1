"""A link as a beam: Euler-Bernoulli elements, clamped at one end, condensed to its far end.

Each element of length h has the cubic shape functions of Hermite. Their stiffness and mass matrices are
those of any text on finite elements (Géradin and Rixen, Mechanical Vibrations, 3rd ed., section 5.3):

    k = EI/h³ [[12, 6h, −12, 6h], …],     m = μh/420 [[156, 22h, 54, −13h], …].

The nodes between the ends are condensed by the method of Craig and Bampton (AIAA Journal 6, 1968): the static
shapes of the far end, exact for any load there, and the lowest modes with the far end held.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

ELEMENTS = 8
"""Elements along a link."""
INNER_MODES = 8
"""Modes with the far end held that are kept beside its deflection and slope: fewer are too
stiff where a hammer or a sensor sits between the ends."""


@dataclass(frozen=True, eq=False)
class Beam:
    """A beam in one plane, clamped at 0; uniform unless it tapers, without shear unless it has any."""

    length: float
    """[m]"""
    bending_stiffness: float
    """EI [N·m²]"""
    line_mass: float
    """μ [kg/m], 0 or more"""
    taper: float = 0.0
    """By how much EI falls from the clamp to the far end, relative; in steps, one an element."""
    step: tuple[float, float] = (1.0, 1.0)
    """From which part of the length on EI is how many times that before; at the end of an element."""
    shear: float = 0.0
    """12 EI/(κ G A) [m²]: Timoshenko's beam, the elements of Przemieniecki (Theory of Matrix Structural
    Analysis, section 5.6) with Φ = shear/h²."""

    @property
    def _phi(self) -> float:
        return self.shear * (ELEMENTS / self.length) ** 2

    @property
    def _rigidities(self) -> Float[np.ndarray, " element"]:
        """EI of each element over that at the clamp."""
        middle = (np.arange(ELEMENTS) + 0.5) / ELEMENTS
        place, ratio = self.step
        return (1 - self.taper * middle) * np.where(middle > place, ratio, 1.0)

    @cached_property
    def stiffness(self) -> Float[np.ndarray, "node node"]:
        """Over deflection and slope of every free node [N/m, N, N·m]."""
        h, phi = self.length / ELEMENTS, self._phi
        near, far = (4 + phi) * h * h, (2 - phi) * h * h
        element = np.array(
            [
                [12.0, 6 * h, -12, 6 * h],
                [6 * h, near, -6 * h, far],
                [-12, -6 * h, 12, -6 * h],
                [6 * h, far, -6 * h, near],
            ]
        )
        return _assembled(self.bending_stiffness / h**3 / (1 + phi) * element, self._rigidities)

    @cached_property
    def mass(self) -> Float[np.ndarray, "node node"]:
        """Over deflection and slope of every free node [kg, kg·m, kg·m²]."""
        h = self.length / ELEMENTS
        element = np.array(
            [
                [156.0, 22 * h, 54, -13 * h],
                [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                [54, 13 * h, 156, -22 * h],
                [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
            ]
        )
        return _assembled(self.line_mass * h / 420 * element, np.ones(ELEMENTS))

    @cached_property
    def condensation(self) -> Float[np.ndarray, "node kept"]:
        """Node motions by the kept coordinates: deflection and slope of the far end, then inner modes."""
        count = 2 * ELEMENTS
        inner, end = np.arange(count - 2), np.arange(count - 2, count)
        k = self.stiffness
        shapes = np.zeros((count, 2 + INNER_MODES))
        shapes[end, [0, 1]] = 1.0
        shapes[inner, :2] = -np.linalg.solve(k[np.ix_(inner, inner)], k[np.ix_(inner, end)])
        unit = replace(self, line_mass=1.0)  # the shapes do not depend on the line mass
        root = np.linalg.cholesky(unit.mass[np.ix_(inner, inner)])
        scaled = np.linalg.solve(root, np.linalg.solve(root, k[np.ix_(inner, inner)]).T)
        _, vectors = np.linalg.eigh((scaled + scaled.T) / 2)
        modes = np.linalg.solve(root.T, vectors[:, :INNER_MODES])
        shapes[inner, 2:] = modes * np.sqrt(self.length)  # dimensionless
        return shapes

    @cached_property
    def condensed_stiffness(self) -> Float[np.ndarray, "kept kept"]:
        """Stiffness over the kept coordinates."""
        return self.condensation.T @ self.stiffness @ self.condensation

    def shape(self, place: float) -> tuple[Float[np.ndarray, " kept"], Float[np.ndarray, " kept"]]:
        """Deflection and slope at a distance from the clamp [m], each a row over the kept coordinates."""
        h = self.length / ELEMENTS
        s = min(max(place, 0.0), self.length)
        element = min(int(s / h), ELEMENTS - 1)
        u = s / h - element
        phi = self._phi
        lean, bow = phi * u, phi / 2 * (u - u**2)
        deflection = [
            1 - 3 * u**2 + 2 * u**3 + phi - lean,
            h * (u - 2 * u**2 + u**3 + bow),
            3 * u**2 - 2 * u**3 + lean,
            h * (u**3 - u**2 - bow),
        ]
        slope = [
            6 * (u**2 - u) / h,
            1 - 4 * u + 3 * u**2 + phi - lean,
            6 * (u - u**2) / h,
            3 * u**2 - 2 * u + lean,
        ]
        rows = np.zeros((2, 2 * ELEMENTS + 2))
        rows[:, 2 * element : 2 * element + 4] = np.array([deflection, slope]) / (1 + phi)
        kept = rows[:, 2:] @ self.condensation
        return kept[0], kept[1]


def sections() -> tuple[Float[np.ndarray, " section"], Float[np.ndarray, " section"]]:
    """Places (0 to 1 along a beam) and weights (sum 1) that integrate its mass exactly: Gauss's."""
    points, weights = np.polynomial.legendre.leggauss(4)
    starts = np.arange(ELEMENTS)[:, None]
    return ((starts + (points + 1) / 2) / ELEMENTS).ravel(), np.tile(weights / 2 / ELEMENTS, ELEMENTS)


def _assembled(element: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    full = np.zeros((2 * ELEMENTS + 2, 2 * ELEMENTS + 2))
    for number in range(ELEMENTS):
        place = slice(2 * number, 2 * number + 4)
        full[place, place] += sizes[number] * element
    return full[2:, 2:]

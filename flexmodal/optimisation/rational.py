"""A receptance as the rational function it is: poles, antiresonances, and how steep its logarithm is.

Along the imaginary axis, with x = ω² and u = −s² for each antiresonance s, v = −s² for each pole s,

    ln |α|² = const + Σ ln (x − u) − Σ ln (x − v),

where conjugate pairs give u and its conjugate and a real s gives one negative u. Its derivative is a sum of
simple fractions, each of which can be bounded over an interval exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.modal import SecondOrderSystem, solve_modes
from flexmodal.model import PosedRobot
from flexmodal.optimisation.quadratic import null_space

_SHARP = 1e-12
"""Half-width below which a fraction counts as having none, relative to its centre: no damping at all."""

_CANCELLED = 1e-9
"""Distance below which an antiresonance takes away the pole it sits on, relative to its size."""


@dataclass(frozen=True, eq=False)
class Steepness:
    """d ln|α|² / dx as Σ weight · t / (t² + width²), t = x − centre, with x = ω² [rad²/s²]."""

    centre: Float[np.ndarray, " term"]
    width: Float[np.ndarray, " term"]
    weight: Float[np.ndarray, " term"]
    """2 for a pair of antiresonances, 1 for a real one; negative for poles."""

    def at(self, x: Float[np.ndarray, " place"]) -> Float[np.ndarray, " place"]:
        """Its value [s²/rad²]."""
        t = x[:, None] - self.centre
        with np.errstate(divide="ignore", invalid="ignore"):
            return (self.weight * t / (t**2 + self.width**2)).sum(axis=1)

    def bounds(
        self, low: Float[np.ndarray, " place"], high: Float[np.ndarray, " place"]
    ) -> tuple[Float[np.ndarray, " place"], Float[np.ndarray, " place"]]:
        """Numbers that it does not leave over intervals; a fraction turns at ±width."""
        b = self.width

        def fraction(t: np.ndarray) -> np.ndarray:
            return np.divide(1.0, t + np.divide(b**2, t))

        return self._sum(low, high, fraction, (-b, b), (np.inf, -np.inf))

    def slope_bounds(
        self, low: Float[np.ndarray, " place"], high: Float[np.ndarray, " place"]
    ) -> tuple[Float[np.ndarray, " place"], Float[np.ndarray, " place"]]:
        """The same for its derivative, whose fractions turn at 0 and ±√3 width."""
        b = self.width

        def fraction(t: np.ndarray) -> np.ndarray:
            square = t**2 + b**2
            return np.divide(b**2 - t**2, square**2)

        return self._sum(low, high, fraction, (-np.sqrt(3) * b, 0 * b, np.sqrt(3) * b), (-np.inf, -np.inf))

    def _sum(
        self,
        low: np.ndarray,
        high: np.ndarray,
        fraction: Callable[[np.ndarray], np.ndarray],
        turns: tuple[np.ndarray, ...],
        sharp: tuple[float, float],
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sum of the least and greatest values of the fractions, widened by rounding.

        `sharp` is what a fraction without width tends to at its centre, from the right and from the left.
        """
        first, last = low[:, None] - self.centre, high[:, None] - self.centre
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ends = [fraction(first), fraction(last)]
            damped = np.broadcast_to(self.width > 0, first.shape)
            inside = [damped & (first < turn) & (turn < last) for turn in turns]
            values = [np.broadcast_to(fraction(turn[None]), first.shape) for turn in turns]
            ends = [np.where(np.isnan(end), side, end) for end, side in zip(ends, sharp, strict=True)]
            least, greatest = np.minimum(*ends), np.maximum(*ends)
            for there, value in zip(inside, values, strict=True):
                least = np.where(there, np.minimum(least, value), least)
                greatest = np.where(there, np.maximum(greatest, value), greatest)
            down = np.where(self.weight > 0, self.weight * least, self.weight * greatest)
            up = np.where(self.weight > 0, self.weight * greatest, self.weight * least)
            slack = 1e-14 * np.where(np.isfinite(down + up), np.abs(down) + np.abs(up), 0.0).sum(axis=1)
            return down.sum(axis=1) - slack, up.sum(axis=1) + slack


def steepness(posed: PosedRobot, response: PointDirection, reference: PointDirection) -> Steepness:
    """Poles and antiresonances of one receptance of a posed robot.

    Raises:
        InvalidRequest: the force does not move the response at any frequency.
    """
    rows = posed.rows([response, reference])
    if not np.all(np.any(np.abs(rows) > 0, axis=1)):
        found = f"{response} per {reference}, which is 0 at every frequency"
        raise InvalidRequest(Fault("call", "direction", found, "a direction in which a joint gives way"))
    poles = posed.modes().expanded()[0]
    zeros, poles = _without_pairs(antiresonances(posed.system, rows[0], rows[1]), poles)
    terms = [*_terms(zeros, 1.0), *_terms(poles, -1.0)]
    centre, width, weight = (np.array(column) for column in zip(*terms, strict=True))
    return Steepness(centre, np.where(width <= _SHARP * np.abs(centre), 0.0, width), weight)


def antiresonances(
    system: SecondOrderSystem,
    response: Float[np.ndarray, " dof"],
    reference: Float[np.ndarray, " dof"],
) -> Complex[np.ndarray, " zeros"]:
    """Where a receptance vanishes: s with Z(s) x = reference and response · x = 0 [rad/s].

    At a drive point they are the poles of the system with that point held, at most 2n − 2; between two points
    those of a pencil that need not be symmetric.
    """
    ahead, behind = null_space(response[None]), null_space(reference[None])
    if ahead.shape[1] == 0:
        return np.zeros(0, dtype=complex)
    if np.array_equal(response, reference) or np.array_equal(response, -reference):
        inertia, loss, springs = (
            _symmetric(ahead.T @ part @ ahead) for part in (system.mass, system.damping, system.stiffness)
        )
        names = tuple(f"free motion {place + 1}" for place in range(ahead.shape[1]))
        return solve_modes(SecondOrderSystem(inertia, loss, springs, names)).expanded()[0]
    from scipy.linalg import eigvals

    unit = float(np.sqrt(np.trace(system.stiffness) / np.trace(system.mass)))
    scale = np.trace(system.stiffness)
    mass, damping, stiffness = (
        behind.T @ part @ ahead * unit**power / scale
        for part, power in ((system.mass, 2), (system.damping, 1), (system.stiffness, 0))
    )
    one, none = np.eye(len(mass)), np.zeros_like(mass)
    left = np.block([[none, one], [-stiffness, -damping]])
    right = np.block([[one, none], [none, mass]])
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.asarray(eigvals(left, right)) * unit
    return np.asarray(found[np.isfinite(found)])


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    return (matrix + matrix.T) / 2


def _without_pairs(zeros: np.ndarray, poles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Take out each pole on which an antiresonance sits: a mode that this force does not shake."""
    kept, left = [], list(poles)
    for zero in zeros:
        gaps = np.abs(np.array(left) - zero) if left else np.array([np.inf])
        nearest = int(np.argmin(gaps))
        if left and gaps[nearest] <= _CANCELLED * abs(left[nearest]):
            left.pop(nearest)
        else:
            kept.append(zero)
    return np.array(kept, dtype=complex), np.array(left, dtype=complex)


def _terms(roots: np.ndarray, sign: float) -> list[tuple[float, float, float]]:
    """Centre, width and weight of the fractions of some roots, a conjugate pair as one."""
    terms = []
    for root in roots[roots.imag >= 0]:
        square = -(root**2)
        pair = root.imag > _SHARP * abs(root)
        terms.append((float(square.real), abs(float(square.imag)) * pair, sign * (2.0 if pair else 1.0)))
    return terms

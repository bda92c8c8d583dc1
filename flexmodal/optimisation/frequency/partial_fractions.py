"""A receptance as the rational function it is: poles, antiresonances, and how steep its logarithm is.

Along the imaginary axis, with x = ω² and u = −s² for each antiresonance s, v = −s² for each pole s,

    ln |α|² = const + Σ ln (x − u) − Σ ln (x − v),

where conjugate pairs give u and its conjugate and a real s gives one negative u. Its derivative is a sum of
simple fractions, each of which can be bounded over an interval exactly.

Springs K (1 + iη) make the coefficients complex and part the pairs. Then the sum is one over ω itself, and
over all roots one by one:

    ln |α|² = const + Σ ln ((ω − Im s)² + Re² s) over antiresonances, − the same over poles.

Causal springs, whose stiffness is a power of the frequency, leave no rational function at all: see
`flexmodal.optimisation.frequency.sampled`.
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

_SHARP = 1e-12
"""Half-width below which a fraction counts as having none, relative to its centre: no damping at all."""

_CANCELLED = 1e-9
"""Distance below which an antiresonance takes away the pole it sits on, relative to its size."""


@dataclass(frozen=True, eq=False)
class LogarithmicSlope:
    """d ln|α|² / dx as Σ weight · t / (t² + width²), t = x − centre, x = ω² [rad²/s²] or ω [rad/s]."""

    centre: Float[np.ndarray, " term"]
    width: Float[np.ndarray, " term"]
    weight: Float[np.ndarray, " term"]
    """Along ω² 2 for a pair of antiresonances, 1 for a real one; along ω 2 for each; negative for poles."""
    power: int = 2
    """x = ω to this."""

    def place(self, frequency: Float[np.ndarray, " place"]) -> Float[np.ndarray, " place"]:
        """X at some frequencies [Hz]."""
        return np.asarray((2 * np.pi * frequency) ** self.power)

    def frequency(self, x: Float[np.ndarray, " place"]) -> Float[np.ndarray, " place"]:
        """The frequencies of some x [Hz]."""
        return np.asarray(x ** (1 / self.power) / (2 * np.pi))

    def per_hertz(self, frequency: Float[np.ndarray, " place"]) -> Float[np.ndarray, " place"]:
        """D ln|α| / df [1/Hz]."""
        rate = self.power * (2 * np.pi * frequency) ** (self.power - 1)
        return np.asarray(np.pi * rate * self.at(self.place(frequency)))

    def at(self, x: Float[np.ndarray, " place"]) -> Float[np.ndarray, " place"]:
        """Its value [s²/rad², or s/rad]."""
        t = x[:, None] - self.centre
        with np.errstate(divide="ignore", invalid="ignore"):
            return (self.weight * t / (t**2 + self.width**2)).sum(axis=1)

    def bounds(
        self, low: Float[np.ndarray, " place"], high: Float[np.ndarray, " place"]
    ) -> tuple[Float[np.ndarray, " place"], Float[np.ndarray, " place"]]:
        """Numbers that it does not leave over intervals; a fraction turns at ±width.

        Args:
            low: lower ends, x.
            high: upper ends, x.
        """
        b = self.width

        def fraction(t: np.ndarray) -> np.ndarray:
            return np.divide(1.0, t + np.divide(b**2, t))

        return self._sum(low, high, fraction, (-b, b), (np.inf, -np.inf))

    def slope_bounds(
        self, low: Float[np.ndarray, " place"], high: Float[np.ndarray, " place"]
    ) -> tuple[Float[np.ndarray, " place"], Float[np.ndarray, " place"]]:
        """The same for its derivative, whose fractions turn at 0 and ±√3 width.

        Args:
            low: lower ends, x.
            high: upper ends, x.
        """
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


def logarithmic_slope(
    posed: PosedRobot, response: PointDirection, reference: PointDirection
) -> LogarithmicSlope:
    """Poles and antiresonances of one receptance of a posed robot.

    Args:
        posed: the robot in its posture.
        response: direction of the motion.
        reference: direction of the force.

    Raises:
        InvalidRequest: the force does not move the response at any frequency, or the robot has causal
            hysteresis, and its receptance no such form.
        InvalidSystem: the mass matrix is not positive definite.
        InaccurateModes: stiffness and damping range over too many decades for a double.
    """
    rows, system = direction_rows(posed, response, reference), posed.system
    if system.hysteresis is None:
        poles = posed.modes().expanded()[0]
        zeros, poles = _without_pairs(antiresonances(system, rows[0], rows[1]), poles)
        terms = [*_terms(zeros, 1.0), *_terms(poles, -1.0)]
    elif system.hysteresis.frequency is None:
        lag = system.hysteresis.added(np.zeros(1, dtype=complex))[0]
        zeros, poles = _without_pairs(*roots_at_fixed_loss(system, lag, rows[0], rows[1]))
        terms = [(s.imag, abs(s.real), sign) for group, sign in ((zeros, 2.0), (poles, -2.0)) for s in group]
    else:
        raise InvalidRequest(Fault("call", "robot", "a loss_frequency", "a rational receptance: none of it"))
    centre, width, weight = (np.array(column) for column in zip(*terms, strict=True))
    width = np.where(width <= _SHARP * np.abs(centre), 0.0, width)
    return LogarithmicSlope(centre, width, weight, power=2 if system.hysteresis is None else 1)


def direction_rows(
    posed: PosedRobot, response: PointDirection, reference: PointDirection
) -> Float[np.ndarray, "2 joint"]:
    """Jacobian rows of response and reference.

    Args:
        posed: the robot in its posture.
        response: direction of the motion.
        reference: direction of the force.

    Raises:
        InvalidRequest: the force does not move the response at any frequency.
    """
    rows = posed.rows([response, reference])
    if not np.all(np.any(np.abs(rows) > 0, axis=1)):
        found = f"{response} per {reference}, which is 0 at every frequency"
        raise InvalidRequest(Fault("call", "direction", found, "a direction in which a joint gives way"))
    return rows


def roots_at_fixed_loss(
    system: SecondOrderSystem,
    lag: Complex[np.ndarray, " dof"],
    response: Float[np.ndarray, " dof"],
    reference: Float[np.ndarray, " dof"],
) -> tuple[Complex[np.ndarray, " zeros"], Complex[np.ndarray, " poles"]]:
    """Antiresonances and poles with something complex added to the springs' diagonal, held at all s.

    Those at negative frequencies are not the conjugates of the others.

    Args:
        system: mass, damping, stiffness.
        lag: what is added to the springs' diagonal [N·m/rad, N/m].
        response: row of the motion.
        reference: row of the force.
    """
    springs = system.stiffness + np.diag(lag)
    ahead, behind = _across(response), _across(reference)
    whole = np.eye(system.dof)
    return _pencil(system, springs, behind, ahead), _pencil(system, springs, whole, whole)


def antiresonances(
    system: SecondOrderSystem,
    response: Float[np.ndarray, " dof"],
    reference: Float[np.ndarray, " dof"],
) -> Complex[np.ndarray, " zeros"]:
    """Where a receptance without hysteresis vanishes: s with Z(s) x = reference, response · x = 0 [rad/s].

    At a drive point they are the poles of the system with that point held, at most 2n − 2; between two points
    those of a pencil that need not be symmetric.

    Args:
        system: mass, damping, stiffness.
        response: row of the motion.
        reference: row of the force.

    Raises:
        InvalidSystem: the mass matrix is not positive definite.
        InaccurateModes: stiffness and damping range over too many decades for a double.
    """
    ahead, behind = _across(response), _across(reference)
    if ahead.shape[1] == 0:
        return np.zeros(0, dtype=complex)
    if np.array_equal(response, reference) or np.array_equal(response, -reference):
        inertia, loss, springs = (
            _symmetric(ahead.T @ part @ ahead) for part in (system.mass, system.damping, system.stiffness)
        )
        names = tuple(f"free motion {place + 1}" for place in range(ahead.shape[1]))
        return solve_modes(SecondOrderSystem(inertia, loss, springs, names)).expanded()[0]
    return _pencil(system, system.stiffness, behind, ahead)


def _across(row: np.ndarray) -> np.ndarray:
    """Orthonormal motions that a row does not see, column by column."""
    from scipy.linalg import null_space

    return np.asarray(null_space(row[None]))


def _pencil(
    system: SecondOrderSystem, springs: np.ndarray, left: np.ndarray, right: np.ndarray
) -> Complex[np.ndarray, " finite"]:
    """Finite eigenvalues of leftᵀ (K + sB + s²D) right [rad/s]."""
    if right.shape[1] == 0:
        return np.zeros(0, dtype=complex)
    from scipy.linalg import eigvals

    unit = float(np.sqrt(np.trace(system.stiffness) / np.trace(system.mass)))
    scale = np.trace(system.stiffness)
    mass, damping, stiffness = (
        left.T @ part @ right * unit**power / scale
        for part, power in ((system.mass, 2), (system.damping, 1), (springs, 0))
    )
    one, none = np.eye(len(mass)), np.zeros_like(mass)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.asarray(
            eigvals(np.block([[none, one], [-stiffness, -damping]]), np.block([[one, none], [none, mass]]))
        )
    return np.asarray(found[np.isfinite(found)] * unit)


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

"""What a posture is judged by, each with its exact gradient.

Every objective is searched through a cost that is minimised: the natural logarithm of its value (negative
for stiffness, which is to be large). Raw receptances of 10⁻⁵ lie below the tolerances of any solver.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot, Robot
from flexmodal.model.gradient import jacobian_derivative, receptance_and_gradient
from flexmodal.model.measures import reduced_task

BLIND = 1e-15
"""A receptance below this [m/N] counts as none: the force does not shake the robot at all."""

_LEVER = 1e-3
"""A lever arm below this [m] counts as none."""

_SHARPNESS = 40
"""Power of the smooth maximum over a band and over singular values: within `n ** (1/40)` of the true one."""


class Limit(Enum):
    """Why a descent may stop although the gradient has not vanished."""

    NONE = "none"
    PERFECT = "nothing left to gain"
    UNBOUNDED = "the measure grows without bound"


@runtime_checkable
class Objective(Protocol):
    """A judge of postures."""

    @property
    def unit(self) -> str:
        """Unit of `value`."""
        ...

    def value(self, posed: PosedRobot) -> float:
        """What a user wants to read."""
        ...

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """What is minimised, and its derivative along every moving joint [1/rad, 1/m]."""
        ...

    def limit(self, cost: float, robot: Robot) -> Limit:
        """Whether nothing is left to gain, or the measure grows without bound here."""
        ...


@dataclass(frozen=True, eq=False)
class ReceptanceObjective:
    """|receptance| over some directions and frequencies.

    One direction gives |α| itself. Of several, `combine` "worst" takes the largest singular value of
    their receptance matrix (the worst force direction among them), and "weighted" the response along the
    weights to a force along the weights, coupling terms included [Hearne 4.6–4.8]. Over several
    frequencies "worst" takes the largest, the others the mean.
    """

    directions: tuple[PointDirection, ...]
    frequency: Float[np.ndarray, " line"]
    combine: str = "weighted"
    weights: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.combine not in ("worst", "weighted"):
            raise InvalidRequest(Fault("call", "combine", repr(self.combine), "worst or weighted"))
        weights = np.array(self.weights or [1.0] * len(self.directions), dtype=float)
        if len(weights) != len(self.directions) or not np.all(np.isfinite(weights)) or not np.any(weights):
            allowed = f"{len(self.directions)} finite weights, not all 0"
            raise InvalidRequest(Fault("call", "weights", str(self.weights), allowed))
        object.__setattr__(self, "weights", tuple(weights / np.linalg.norm(weights)))

    @property
    def unit(self) -> str:
        """Unit of the receptance."""
        return "rad/(N·m)" if all(d.is_rotation for d in self.directions) else "m/N"

    def value(self, posed: PosedRobot) -> float:
        """The receptance [m/N]."""
        matrices = posed.frf(self.frequency, response=self.directions).value
        sizes = np.array([self._parts(matrix)[0][0] for matrix in matrices])
        return float(np.max(sizes) if self.combine == "worst" else np.mean(sizes))

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Logarithm of the (smooth maximum or mean of the) receptance, and its gradient."""
        matrices, slopes = receptance_and_gradient(posed, self.directions, self.frequency)
        parts = [
            (size, np.einsum("u,uvk,v->k", left, slope, right).real)
            for matrix, slope in zip(matrices, slopes, strict=True)
            for size, left, right in self._parts(matrix)
        ]
        size, rate = np.array([part[0] for part in parts]), np.array([part[1] for part in parts])
        power = _SHARPNESS if self.combine == "worst" and len(size) > 1 else 1
        smooth = np.sqrt(size**2 + (BLIND * 1e-3) ** 2)
        ratio = smooth / smooth.max()
        total = np.sum(ratio**power)
        cost = float(np.log(smooth.max()) + np.log(total / len(matrices)) / power)
        return cost, (ratio**power / total * size / smooth**2) @ rate

    def limit(self, cost: float, robot: Robot) -> Limit:
        """A receptance as good as zero cannot be bettered."""
        return Limit.PERFECT if cost < np.log(BLIND) else Limit.NONE

    def _parts(self, matrix: np.ndarray) -> list[tuple[float, np.ndarray, np.ndarray]]:
        """Sizes of a receptance matrix, largest first, and left and right vectors that give their change.

        The change is the real part of left · dα · right. Of the worst direction all singular values are
        kept: where the two largest meet, the largest alone has a kink.
        """
        if self.combine == "worst" and len(self.directions) > 1:
            left, values, right = np.linalg.svd(matrix)
            return [(float(v), left[:, i].conj(), right[i].conj()) for i, v in enumerate(values)]
        weights = np.array(self.weights)
        number = weights @ matrix @ weights
        size = abs(number)
        phase = np.conj(number) / size if size > 0 else 1.0
        return [(float(size), weights * phase, weights.astype(complex))]


@dataclass(frozen=True, eq=False)
class StiffnessObjective:
    """The stiffness measure ξ_K = uᵀ J⁺ᵀ K J⁺ u [Hearne 3.17], to be large."""

    direction: PointDirection
    task: str = "full"
    unit: str = "N/m"

    def value(self, posed: PosedRobot) -> float:
        """ξ_K [N/m]."""
        return posed.robot.measures(posed.posture, direction=self.direction, task=self.task).stiffness

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """−ln ξ_K, and its gradient by the derivative of the Moore–Penrose inverse at constant rank.

        dJ⁺ = −J⁺ dJ J⁺ + J⁺J⁺ᵀ dJᵀ (1 − JJ⁺) + (1 − J⁺J) dJᵀ J⁺ᵀJ⁺ (Golub and Pereyra 1973).
        """
        rows = reduced_task(posed, self.task)
        pick = posed.robot.flexible_index
        full = posed.full_jacobian(self.direction.point)
        jacobian = rows @ full[:, pick]
        slope = np.einsum("tr,rik->tik", rows, jacobian_derivative(full)[:, pick, :])
        along = rows @ self.direction.selector
        if not np.any(along):
            found = f"{self.direction}, along which nothing moves under task {self.task!r}"
            raise InvalidRequest(Fault("call", "direction", found, "a direction the chain can move along"))
        inverse = np.linalg.pinv(jacobian)
        deflection = inverse @ along
        missed = along - jacobian @ deflection
        pulled = inverse.T @ deflection
        change = (
            -inverse @ np.einsum("tik,i->tk", slope, deflection)
            + inverse @ (inverse.T @ np.einsum("tik,t->ik", slope, missed))
            + (np.eye(len(pick)) - inverse @ jacobian) @ np.einsum("tik,t->ik", slope, pulled)
        )
        moment = posed.robot.stiffness @ deflection
        value = float(deflection @ moment)
        return -float(np.log(value)), -2 * (moment @ change) / value

    def limit(self, cost: float, robot: Robot) -> Limit:
        """Where J is singular ξ_K is infinite: constraint, not springs, resists the motion.

        Taken as reached when the stiffest joint would resist with a lever arm below a millimetre.
        """
        return Limit.UNBOUNDED if -cost > np.log(np.max(robot.stiffness) / _LEVER**2) else Limit.NONE


@dataclass(frozen=True, eq=False)
class MobilityObjective:
    """The mobility measure ξ_M = uᵀ J Jᵀ u [Hearne 3.18], to be small."""

    direction: PointDirection
    unit: str = "m²/rad²"

    def value(self, posed: PosedRobot) -> float:
        """ξ_M [m²/rad²]."""
        return posed.robot.measures(posed.posture, direction=self.direction).mobility

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Ln ξ_M and its gradient."""
        pick = posed.robot.flexible_index
        full = posed.full_jacobian(self.direction.point)
        row = (self.direction.selector @ full)[pick]
        slope = np.tensordot(self.direction.selector, jacobian_derivative(full), 1)[pick]
        value = float(row @ row) + np.finfo(float).tiny
        return float(np.log(value)), 2 * (row @ slope) / value

    def limit(self, cost: float, robot: Robot) -> Limit:
        """No joint moves the point along the direction."""
        return Limit.PERFECT if cost < 2 * np.log(_LEVER**2) else Limit.NONE

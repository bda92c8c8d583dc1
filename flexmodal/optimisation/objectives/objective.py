"""What a posture is judged by, each with its exact gradient.

Every objective is searched through a cost that is minimised: the natural logarithm of its value (negative
for stiffness, which is to be large). Raw receptances of 10⁻⁵ lie below the tolerances of any solver.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, ClassVar, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection, directions_of
from flexmodal.frf.axis import MOST_HERTZ
from flexmodal.model import PosedRobot, Robot
from flexmodal.model.receptance_source import MODEL, ReceptanceSource

if TYPE_CHECKING:
    OneGiven = PointDirection
    Given = tuple[PointDirection, ...]
    Lines = Float[np.ndarray, " line"]
else:  # what may be given for them; made into those as an objective is made
    OneGiven = str | PointDirection
    Given = str | PointDirection | Sequence[str | PointDirection]
    Lines = float | int | Sequence[float | int] | np.ndarray

BLIND = 1e-15
"""A receptance below this [m/N] counts as none: the force does not shake the robot at all."""

SHARPNESS = 40
"""Power of the smooth maximum over a band and over singular values: within `n ** (1/40)` of the true one."""

COMBINE, OVER = ("weighted", "force", "worst"), ("mean", "largest")


class Limit(Enum):
    """Why a descent may stop although the gradient has not vanished."""

    NONE = "none"
    PERFECT = "nothing left to gain"
    UNBOUNDED = "the measure grows without bound"


@runtime_checkable
class Objective(Protocol):
    """A judge of postures."""

    @property
    def larger_is_better(self) -> bool:
        """Whether `value` is to be large; its cost is then the negative logarithm."""
        ...

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
        """Whether nothing is left to gain, or the measure grows without bound here.

        Args:
            cost: as `cost_and_gradient` gives it.
            robot: whose stiffness may say what counts as boundless.
        """
        ...


@dataclass(frozen=True, eq=False)
class ReceptanceObjective:
    """|receptance| over some directions and frequencies.

    One direction gives |α| itself. Of several, with the coupling terms of their receptance matrix α
    [Hearne 4.6–4.8] and unit vectors of weights w and t,

    - "weighted" takes |tᵀ α w|, the motion along t under a force along w; without t, along w itself,
    - "force" takes ‖α w‖, the whole motion under a cutting force along w,
    - "worst" takes the largest singular value, the motion under the worst force direction among them.
    """

    directions: Given
    """One or several, as "tool:+z" too."""
    frequency: Lines
    """One or several [Hz]."""
    combine: str = "weighted"
    weights: tuple[float, ...] = ()
    """Components of the force along the directions; scaled to a unit vector."""
    toward: tuple[float, ...] = ()
    """Components of the direction in which motion counts, such as the normal of the surface cut."""
    over: str = ""
    """"mean" or "largest" over the frequencies; if empty, "largest" for "worst" and "mean" for the others."""
    line_weights: tuple[float, ...] = ()
    """Share of the force at each frequency, such as at harmonics of the tooth passing; 1 each if empty."""
    source: ReceptanceSource = MODEL
    """Where receptances come from: the robot itself, or a prediction."""
    larger_is_better: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "directions", directions_of(self.directions))
        object.__setattr__(self, "frequency", np.atleast_1d(np.array(self.frequency, dtype=float)))
        faults = []
        if self.combine not in COMBINE:
            faults.append(Fault("call", "combine", repr(self.combine), ", ".join(COMBINE)))
        if self.over not in ("", *OVER):
            faults.append(Fault("call", "over", repr(self.over), " or ".join(OVER)))
        if self.toward and self.combine != "weighted":
            faults.append(Fault("call", "toward", "given", f"nothing with combine {self.combine!r}"))
        weights = self.weights or (1.0,) * len(self.directions)
        toward = self.toward or weights
        shares = np.array(self.line_weights or (1.0,) * len(self.frequency), dtype=float)
        for key, given in (("weights", weights), ("toward", toward)):
            values = np.array(given, dtype=float)
            if len(values) != len(self.directions) or not np.all(np.isfinite(values)) or not np.any(values):
                allowed = f"{len(self.directions)} finite weights, not all 0"
                faults.append(Fault("call", key, str(given), allowed))
        if len(shares) != len(self.frequency) or not np.all(np.isfinite(shares) & (shares > 0)):
            found, allowed = str(self.line_weights), f"{len(self.frequency)} finite numbers above 0"
            faults.append(Fault("call", "line_weights", found, allowed))
        if faults:
            raise InvalidRequest(dict.fromkeys(faults))
        object.__setattr__(self, "weights", _unit(weights))
        object.__setattr__(self, "toward", _unit(toward))
        object.__setattr__(self, "over", self.over or ("largest" if self.combine == "worst" else "mean"))
        object.__setattr__(self, "line_weights", tuple(shares.tolist()))

    @property
    def unit(self) -> str:
        """Unit of the receptance."""
        return "rad/(N·m)" if all(d.is_rotation for d in self.directions) else "m/N"

    def value(self, posed: PosedRobot) -> float:
        """The receptance [m/N]."""
        sizes = self.sizes(posed, self.frequency) * self.line_weights
        return float(np.max(sizes) if self.over == "largest" else np.mean(sizes))

    def sizes(self, posed: PosedRobot, frequency: Float[np.ndarray, " line"]) -> Float[np.ndarray, " line"]:
        """|tᵀ α w|, ‖α w‖ or the largest singular value over any frequencies [m/N].

        Args:
            posed: the robot in its posture.
            frequency: [Hz].
        """
        matrices = self._matrices(posed, frequency)
        return np.array([self._parts(matrix)[0][0] for matrix in matrices])

    def cost_and_gradient(self, posed: PosedRobot) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Logarithm of the (smooth maximum or mean of the) receptance, and its gradient."""
        matrices, slopes = self.source.matrix_and_gradient(posed, self.directions, self.frequency)
        return self.of_receptances(matrices, slopes)

    def cost(self, posed: PosedRobot) -> float:
        """The cost alone."""
        matrices = self._matrices(posed, self.frequency)
        return self.of_receptances(matrices, np.zeros((*matrices.shape, 0), dtype=complex))[0]

    def of_receptances(
        self,
        matrices: Complex[np.ndarray, "line dir dir"],
        slopes: Complex[np.ndarray, "line dir dir moving"],
    ) -> tuple[float, Float[np.ndarray, " moving"]]:
        """Cost and gradient from receptance matrices and their derivatives along the joints.

        Args:
            matrices: α at each frequency [m/N].
            slopes: ∂α/∂q, the joint last.
        """
        parts = [
            (share * size, share * np.einsum("u,uvk,v->k", left, slope, right).real)
            for matrix, slope, share in zip(matrices, slopes, self.line_weights, strict=True)
            for size, left, right in self._parts(matrix)
        ]
        size, rate = np.array([part[0] for part in parts]), np.array([part[1] for part in parts])
        power = SHARPNESS if self.over == "largest" and len(size) > 1 else 1
        smooth = np.sqrt(size**2 + (BLIND * 1e-3) ** 2)
        ratio = smooth / smooth.max()
        total = np.sum(ratio**power)
        cost = float(np.log(smooth.max()) + np.log(total / len(matrices)) / power)
        return cost, (ratio**power / total * size / smooth**2) @ rate

    def limit(self, cost: float, robot: Robot) -> Limit:
        """A receptance as good as zero cannot be bettered."""
        return Limit.PERFECT if cost < np.log(BLIND) else Limit.NONE

    def _matrices(
        self, posed: PosedRobot, frequency: Float[np.ndarray, " some"]
    ) -> Complex[np.ndarray, "some dir dir"]:
        count = len(self.directions)
        pairs = [(row, column) for row in self.directions for column in self.directions]
        return self.source.receptances(posed, pairs, frequency).reshape(len(frequency), count, count)

    def _parts(self, matrix: np.ndarray) -> list[tuple[float, np.ndarray, np.ndarray]]:
        """Sizes of a receptance matrix, largest first, and left and right vectors that give their change.

        The change is the real part of left · dα · right. Of the worst direction all singular values are
        kept where the largest line counts: where the two largest meet, the largest alone has a kink.
        """
        weights, toward = np.array(self.weights), np.array(self.toward)
        if self.combine == "worst" and len(self.directions) > 1:
            left, values, right = np.linalg.svd(matrix)
            kept = len(values) if self.over == "largest" else 1
            return [(float(values[i]), left[:, i].conj(), right[i].conj()) for i in range(kept)]
        if self.combine == "force":
            motion = matrix @ weights
            size = float(np.linalg.norm(motion))
            return [(size, motion.conj() / max(size, np.finfo(float).tiny), weights.astype(complex))]
        number = toward @ matrix @ weights
        size = abs(number)
        phase = np.conj(number) / size if size > 0 else 1.0
        return [(float(size), toward * phase, weights.astype(complex))]


def tooth_passing(spindle: float, teeth: int, harmonics: int = 1) -> Float[np.ndarray, " line"]:
    """Tooth-passing frequency of a cutter and its harmonics, k · teeth · spindle / 60 [Hz].

    Args:
        spindle: speed [1/min].
        teeth: number of teeth.
        harmonics: how many lines, the fundamental included.

    Raises:
        InvalidRequest: not positive.
    """
    if not (0 < spindle <= MOST_HERTZ and teeth >= 1 and harmonics >= 1):
        found = f"{spindle:g} /min, {teeth} teeth, {harmonics} harmonics"
        raise InvalidRequest(
            Fault("call", "spindle", found, "a speed above 0, at least 1 tooth and 1 harmonic")
        )
    return spindle / 60 * teeth * np.arange(1, harmonics + 1)


def _unit(values: tuple[float, ...]) -> tuple[float, ...]:
    size = float(np.linalg.norm(values))
    return tuple(float(value) / size for value in values)

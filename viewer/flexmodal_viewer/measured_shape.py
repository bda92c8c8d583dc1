"""What the flexible joints do in a measured shape, and where they cannot do what was measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.ema.shapes import FittedShapes
from flexmodal.modal.mac import mac_with
from flexmodal.model import PosedRobot

_SEEN = 0.02
"""Motions of the joints that the places see so much less than what they see best are left at rest."""
WIDEST = 0.12
"""How far a joint turns in the picture at most [rad]."""
_ODD = 0.3
"""A point that the joints miss by more of the largest motion is told apart."""


@dataclass(frozen=True, eq=False)
class JointShape:
    """Amplitudes of the joints that come nearest to a measured shape."""

    amplitude: Complex[np.ndarray, " joint"]
    left: Complex[np.ndarray, " place"]
    """What was measured less what these joints do at each place."""
    share: float
    """Part of the squared shape that the joints can do, 0 to 1."""
    nearest: tuple[float, float]
    """Natural frequency of the model's mode that is most like the shape [Hz], and their MAC."""

    def widest(self, posed: PosedRobot, reach: float) -> float:
        """Factor that turns the joint that turns most by `WIDEST`; so far links and points keep together.

        Args:
            posed: the robot.
            reach: of the arm [m], which makes lengths of prismatic joints comparable with angles.
        """
        moving = posed.robot.moving
        kinds = [moving[name].is_prismatic for name in posed.robot.joints]
        turned = np.abs(self.amplitude) / np.where(kinds, reach, 1.0)
        return float(WIDEST / np.max(turned)) if np.any(turned) else np.inf


def joint_shape(
    posed: PosedRobot, rows: Float[np.ndarray, "place joint"], shape: Complex[np.ndarray, " place"]
) -> JointShape:
    """Joints that move the places as measured, as nearly as they can and with the least elastic energy.

    With K = LLᵀ and a = L⁻ᵀb the energy is |b|²/2, so that b is the least-norm solution of J L⁻ᵀ b = φ.

    Args:
        posed: the robot where it was measured.
        rows: what each place sees of each joint.
        shape: what was measured at the places, in any scale.
    """
    system = posed.system
    lift = 1e-9 * np.max(np.diag(system.stiffness)) * np.eye(system.dof)  # a joint without a spring has one
    back = np.linalg.inv(np.linalg.cholesky(system.stiffness + lift)).T
    amplitude = back @ (np.linalg.pinv(rows @ back, rcond=_SEEN) @ shape)
    left = shape - rows @ amplitude
    whole = float(np.sum(np.abs(shape) ** 2))
    share = 1 - float(np.sum(np.abs(left) ** 2)) / whole if whole > 0 else 0.0
    modes = posed.modes()
    likeness = np.asarray(mac_with(shape, rows @ modes.shape))
    best = int(np.argmax(likeness))
    return JointShape(amplitude, left, share, (float(modes.frequency[best]), float(likeness[best])))


def odd_points(shapes: FittedShapes, mode: int, joints: JointShape) -> frozenset[int]:
    """Points at which the joints miss what was measured by much, beside the largest motion.

    Args:
        shapes: of the fitted modes.
        mode: number of one of them.
        joints: what the joints do in it.
    """
    largest = float(np.max(np.abs(shapes.shape[:, mode])))
    missed = np.abs(joints.left) > _ODD * largest
    return frozenset(way[0] for way, far in zip(shapes.places, missed.tolist(), strict=True) if far)

"""Joint deflections to a motion that can be seen: scaled, sampled over one cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.frf import PointDirection, frequency_axis
from flexmodal.frf.receptance import dynamic_stiffness
from flexmodal.modal import Modes
from flexmodal.model import PosedRobot
from flexmodal.model.placements import link_placements
from flexmodal_viewer.arm import Arm

FRAMES = 32
"""Placements over one cycle; the viewer interpolates between them."""

SHARE = 0.1
"""How far the tool goes in the picture, as a part of the arm's reach."""

WIDEST = 0.35
"""How far a joint turns in the picture at most [rad]: modes that turn the tool on the spot need a bound."""


@dataclass(frozen=True, eq=False)
class Deflection:
    """Complex amplitudes of the flexible joints about a posture."""

    posed: PosedRobot
    amplitude: Complex[np.ndarray, " joint"]
    """[rad, m], for a force of 1 N, or of a mode in its own scale."""

    @property
    def tool(self) -> Complex[np.ndarray, "3"]:
        """Amplitude of the tool [m]."""
        return self.posed.jacobian(self.posed.robot.tool)[:3] @ self.amplitude

    @property
    def extreme(self) -> float:
        """Phase at which the tool is farthest out, or the joints are where it stays on the spot [rad].

        Of the two in a cycle the one away from phase 0, so that a still shows both sides.
        """
        moved = self.tool
        joints = self.amplitude * np.array(
            [1.0 if self._turns(name) else 0.0 for name in self.posed.robot.joints]
        )
        if np.linalg.norm(moved) <= 1e-9 * np.linalg.norm(self.amplitude):
            moved = joints if np.any(joints) else self.amplitude
        phase = -np.angle(np.sum(moved**2)) / 2
        return float(phase + np.pi if np.cos(phase) > 0 else phase)

    def farthest(self) -> float:
        """How far the tool goes at its extreme [m]."""
        return float(np.linalg.norm((self.tool * np.exp(1j * self.extreme)).real))

    def scale(self, reach: float) -> float:
        """Factor that brings the tool to `SHARE` of the reach, or the widest joint to `WIDEST`."""
        bounds = [SHARE * reach / self.farthest()] if self.farthest() > 0 else []
        sizes = np.abs(self.amplitude)
        for name, size in zip(self.posed.robot.joints, sizes, strict=True):
            if size > 0:
                bounds.append((WIDEST if self._turns(name) else WIDEST * reach) / size)
        return min(bounds, default=1.0)

    def _turns(self, joint: str) -> bool:
        return not self.posed.robot.moving[joint].is_prismatic

    def values(self, phase: float, scale: float) -> dict[str, float]:
        """Posture plus scaled deflection of every joint at a phase [rad, m].

        Args:
            phase: of the cycle [rad].
            scale: multiple of the deflection.
        """
        given: dict[str, float] = dict(self.posed.posture.values)
        moved = scale * (self.amplitude * np.exp(1j * phase)).real
        for name, value in zip(self.posed.robot.joints, moved, strict=True):
            given[name] = given.get(name, 0.0) + float(value)
        return given

    def tracks(
        self, arm: Arm, groups: Sequence[str], scale: float
    ) -> Mapping[str, Float[np.ndarray, "frame 4 4"]]:
        """Placements of every moving link over one cycle, first frame repeated at the end.

        Args:
            arm: that is drawn.
            groups: drawn postures that move alike.
            scale: multiple of the deflection.
        """
        phases = 2 * np.pi * np.arange(FRAMES + 1) / FRAMES
        placed = [link_placements(arm.robot, self.values(phase, scale)) for phase in phases]
        moving = [link for link in arm.index if link not in arm.still_links()]
        return {
            arm.node(group, link): np.array([frame[link] for frame in placed])
            for group in groups
            for link in moving
        }


def forced(posed: PosedRobot, direction: PointDirection, frequency: float) -> Deflection:
    """Deflection q_D(t) = Re(Z⁻¹ jᵀ e^{iωt}) under a harmonic unit force.

    Args:
        posed: the robot in its posture.
        direction: of the force.
        frequency: of it [Hz].

    Raises:
        InvalidFrequencies: negative or not finite.
        SingularResponse: an undamped mode is driven at its natural frequency.
    """
    axis = frequency_axis([frequency])
    posed.frf(axis, response=direction)  # refuses an infinite response
    row = posed.rows([direction])[0]
    return Deflection(posed, np.linalg.solve(dynamic_stiffness(posed.system, axis)[0], row.astype(complex)))


def mode_shapes(posed: PosedRobot, modes: Modes) -> list[Deflection]:
    """The mode shapes, each turned to be as real as it can be and of largest entry 1.

    Args:
        posed: the robot in its posture.
        modes: of it.
    """
    shapes = []
    for shape in modes.shape.T:
        turned = shape * np.exp(-0.5j * np.angle(np.sum(shape**2)))
        turned = turned / turned[int(np.argmax(np.abs(turned)))]
        shapes.append(Deflection(posed, turned))
    return shapes

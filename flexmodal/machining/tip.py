"""How the tip of the cutter gives way: the receptance that a cut sees, in the frame of the cut."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import FlexmodalError, SingularResponse
from flexmodal.frf.receptance import receptance
from flexmodal.machining.cut import Cut, ToolMode
from flexmodal.machining.measured_tip import MeasuredTip
from flexmodal.machining.tip_receptance import TipReceptance
from flexmodal.modal import SecondOrderSystem, solve_modes
from flexmodal.model import PosedRobot
from flexmodal.model.placements import link_placements

_UNDAMPED = 1e-9
"""Damping ratio below which a mode counts as undamped."""

_BLIND = 1e-9
"""Part of the largest static compliance below which a mode is not seen by the tip."""


@dataclass(frozen=True, eq=False)
class ModelTip(TipReceptance):
    """The tip of a second-order system, with a measured receptance added if there is one."""

    system: SecondOrderSystem
    rows: Float[np.ndarray, "3 dof"]
    """Displacement of the tip along x, y, z of the cut per coordinate."""
    added: MeasuredTip | None = None

    def receptance(self, frequency: Float[np.ndarray, " line"]) -> Complex[np.ndarray, "line 3 3"]:
        """Receptance of the system, plus the measured one [m/N].

        Raises:
            InvalidFrequencies: a frequency that the measurement does not cover.
        """
        value = receptance(self.system, self.rows, self.rows, frequency)
        return value if self.added is None else value + self.added.receptance(frequency)

    @cached_property
    def lines(self) -> Float[np.ndarray, " line"]:
        """Lines that crowd at the poles [Hz]."""
        size = np.abs(self.poles) / (2 * np.pi)
        low, high = 0.01 * size.min(), 4 * size.max()
        found = np.concatenate([np.geomspace(low, high, 400), self._about_poles(41)])
        if self.added is not None:
            low, high = max(low, self.added.lines[0]), self.added.highest
            found = np.concatenate([found, self.added.lines])
        return np.unique(found[(found >= low) & (found <= high)])

    @cached_property
    def resonances(self) -> Float[np.ndarray, " few"]:
        """Seven frequencies about each pole, and the lines of a measurement [Hz]."""
        found = self._about_poles(7)
        found = found if self.added is None else np.concatenate([found, self.added.lines])
        return np.unique(found[(found > 0) & (found <= self.highest)])

    @property
    def highest(self) -> float:
        """The last line of the measured part, if there is one [Hz]."""
        return np.inf if self.added is None else self.added.highest

    def _about_poles(self, count: int) -> np.ndarray:
        """Frequencies spread about each pole by its half width [Hz]."""
        pole = self.poles / (2 * np.pi)
        spread = (
            np.tan(np.linspace(-1.54, 1.54, count)) if count > 9 else np.tan(np.linspace(-1.2, 1.2, count))
        )
        centre = np.where(pole.imag > 0, pole.imag, np.abs(pole))
        return (centre[:, None] + np.abs(pole.real)[:, None] * spread).ravel()

    @cached_property
    def poles(self) -> Complex[np.ndarray, " mode"]:
        """Poles of the modes that the tip sees, one of each pair [rad/s].

        Raises:
            SingularResponse: one of them has no damping.
            FlexmodalError: the tip sees none.
        """
        modes = solve_modes(self.system)
        give = np.linalg.norm(self.rows @ modes.shape, axis=0) ** 2 / np.abs(modes.pole)
        if not np.any(give > 0):
            raise FlexmodalError("no joint moves the tip in this posture: there is nothing to chatter")
        seen = give > _BLIND * give.max()
        free = seen & (modes.damping_ratio < _UNDAMPED)
        if np.any(free):
            raise SingularResponse(
                f"the mode at {modes.frequency[free][0]:.4g} Hz has no damping, so no depth of "
                "cut is stable; give the joints damping"
            )
        return modes.pole[seen]


def tool_tip(posed: PosedRobot, cut: Cut, added: MeasuredTip | None = None) -> ModelTip:
    """The tip of the cutter on a robot in a posture.

    The modes of the cut's own tool, and a measured receptance, are added to that of the arm: right where
    they were found with the flange held fast, and where the spindle's inertia is small beside the arm's or
    already in the arm's model.

    Args:
        posed: the robot in its posture.
        cut: says where the tip is and how its axes lie.
        added: measured receptance of tool and spindle at the tip, in the frame of the cut.

    Raises:
        InvalidPoint: the robot has no such point.
    """
    point = cut.frame.point or posed.robot.tool
    posed.robot.frame_of(point, source="cut: frame.point")
    link = posed.robot.points[point].link if point in posed.robot.points else point
    turn = link_placements(posed.robot, posed.posture.values)[link][:3, :3]
    jacobian = posed.jacobian(point)
    lever = turn @ np.array(cut.frame.offset)
    rows = jacobian[:3] - _cross(lever) @ jacobian[3:]
    axes = cut.frame.rows @ turn.T if cut.frame.relative_to == "tool" else cut.frame.rows
    return _with_modes(posed.system, axes @ rows, cut.modes, added)


def modal_tip(modes: tuple[ToolMode, ...]) -> ModelTip:
    """The tip of a tool that is nothing but its modes, as on a machine that does not give way.

    Raises:
        FlexmodalError: no mode.
    """
    if not modes:
        raise FlexmodalError("a tip without any mode is rigid: there is nothing to chatter")
    system, rows = _modal_system(modes)
    return ModelTip(system, rows)


def _modal_system(modes: tuple[ToolMode, ...]) -> tuple[SecondOrderSystem, np.ndarray]:
    omega = 2 * np.pi * np.array([mode.frequency for mode in modes])
    stiffness = np.array([mode.stiffness for mode in modes])
    ratio = np.array([mode.damping_ratio for mode in modes])
    names = tuple(f"tool {mode.direction} {mode.frequency:g} Hz" for mode in modes)
    rows = np.array([[float(mode.direction == axis) for mode in modes] for axis in "xyz"])
    mass, damping = stiffness / omega**2, 2 * ratio * stiffness / omega
    return SecondOrderSystem(np.diag(mass), np.diag(damping), np.diag(stiffness), names), rows


def _with_modes(
    system: SecondOrderSystem, rows: np.ndarray, modes: tuple[ToolMode, ...], added: MeasuredTip | None
) -> ModelTip:
    if not modes:
        return ModelTip(system, rows, added)
    other, more = _modal_system(modes)
    loss, springs = system.hysteresis, np.diag(other.stiffness)
    if loss is not None:  # the arm's alone: the tool's modes have their damping ratios
        loss = replace(
            loss,
            stiffness=np.r_[loss.stiffness, springs],
            loss_factor=np.r_[loss.loss_factor, np.zeros(len(springs))],
        )
    joined = SecondOrderSystem(
        _blocks(system.mass, other.mass),
        _blocks(system.damping, other.damping),
        _blocks(system.stiffness, other.stiffness),
        (*system.coordinates, *other.coordinates),
        loss,
    )
    return ModelTip(joined, np.hstack([rows, more]), added)


def _blocks(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    size = len(first)
    whole = np.zeros((size + len(second),) * 2)
    whole[:size, :size], whole[size:, size:] = first, second
    return whole


def _cross(vector: np.ndarray) -> np.ndarray:
    """Matrix of the cross product with a vector on its left."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])

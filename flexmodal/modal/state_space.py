"""Linear models ẋ = A x + B u, y = C x + D u, for programs that design controllers and filters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.modal.modes import Modes
from flexmodal.modal.system import SecondOrderSystem
from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown, several


@dataclass(frozen=True, eq=False, repr=False)
class LinearModel(Shown):
    """A state-space model; it unpacks to A, B, C and D, which is how its neighbours take it."""

    A: Float[np.ndarray, "state state"]
    B: Float[np.ndarray, "state input"]
    C: Float[np.ndarray, "output state"]
    D: Float[np.ndarray, "output input"]
    inputs: tuple[str, ...]
    """What the forces and moments are called [N, N·m]."""
    outputs: tuple[str, ...]
    """What the motions are called [m, rad, and their derivatives]."""

    def _facts(self) -> Mapping[str, object]:
        return {
            "states": len(self.A),
            "inputs": several(self.inputs, 3),
            "outputs": several(self.outputs, 3),
        }

    def __iter__(self) -> Iterator[np.ndarray]:
        """A, B, C and D, so that `scipy.signal.StateSpace(*model)` and `control.ss(*model)` take it."""
        return iter((self.A, self.B, self.C, self.D))

    def response(self, frequency: Float[np.ndarray, " line"]) -> Complex[np.ndarray, "line output input"]:
        """C (iω − A)⁻¹ B + D, by frequency [Hz]."""
        s = 2j * np.pi * np.asarray(frequency, dtype=float)[:, None, None]
        return self.C @ np.linalg.solve(s * np.eye(len(self.A)) - self.A, self.B[None]) + self.D

    def to_scipy(self) -> Any:
        """The same as a `scipy.signal.StateSpace`."""
        from scipy.signal import StateSpace

        return StateSpace(*self)

    def to_control(self) -> Any:
        """The same as a `control.StateSpace`, with the names of its inputs and outputs.

        Raises:
            MissingExtra: python-control is not installed.
        """
        control = extra("control", "control", "to_control")
        # a dot in a signal's name means something to python-control
        inputs = [name.replace(".", "_") for name in self.inputs]
        outputs = [name.replace(".", "_") for name in self.outputs]
        return control.ss(*self, inputs=inputs, outputs=outputs)


def linear_model(
    system: SecondOrderSystem,
    response: Float[np.ndarray, "output dof"],
    reference: Float[np.ndarray, "input dof"],
    *,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    derivative: int = 0,
) -> LinearModel:
    """The state-space model of a second-order system, its states the coordinates and their velocities.

    Args:
        system: without hysteresis.
        response: rows that pick the motions.
        reference: rows along which the forces act.
        inputs: names of the forces.
        outputs: names of the motions.
        derivative: 0 for outputs that are motions, 1 for velocities, 2 for accelerations.

    Raises:
        InvalidRequest: a system with hysteresis, which no finite number of states has.
    """
    if system.hysteresis is not None:
        allowed = "viscous damping alone: a loss factor has no state space of finite order"
        raise InvalidRequest(Fault("system", "hysteresis", "springs with a loss factor", allowed))
    count = system.dof
    zero, unit = np.zeros((count, count)), np.eye(count)
    stiffness, damping, pushed = np.split(
        np.linalg.solve(system.mass, np.hstack([system.stiffness, system.damping, reference.T])),
        [count, 2 * count],
        axis=1,
    )
    moves = np.block([[zero, unit], [-stiffness, -damping]])
    forced = np.vstack([np.zeros_like(pushed), pushed])
    rows = np.hstack([response, np.zeros_like(response)])
    through = np.zeros((len(response), len(reference)))
    for _ in range(derivative):  # the derivative of y = C x + D u, as long as D is zero
        rows, through = rows @ moves, rows @ forced
    return LinearModel(moves, forced, rows, through, inputs, outputs)


def modal_model(
    poles: Complex[np.ndarray, " mode"],
    residues: Complex[np.ndarray, "mode output input"],
    *,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
) -> LinearModel:
    """The state-space model of a modal sum Σ R/(s − λ) + R̄/(s − λ̄), real and in blocks of one mode.

    Each pole gets as many states as its residue has rank, twice that where it is complex; a residue that is a
    product of shapes has rank one.

    Args:
        poles: with an imaginary part of 0 or more [rad/s]; of a complex pair one.
        residues: of the receptance [m/(s·N)].
        inputs: names of the forces.
        outputs: names of the motions.
    """
    blocks: list[np.ndarray] = []
    into: list[np.ndarray] = []
    out: list[np.ndarray] = []
    for pole, residue in zip(poles, residues, strict=True):
        left, size, right = np.linalg.svd(residue)
        for rank in range(int(np.sum(size > 1e-12 * max(size[0], np.finfo(float).tiny)))):
            seen, driven = left[:, rank] * size[rank], right[rank]
            if pole.imag == 0:
                # the residue of a real pole is real; its parts may share a phase
                turn = np.exp(-1j * np.angle(driven[np.argmax(np.abs(driven))]))
                blocks.append(np.array([[pole.real]]))
                into.append((driven * turn).real[None])
                out.append((seen / turn).real[:, None])
            else:
                blocks.append(np.array([[pole.real, pole.imag], [-pole.imag, pole.real]]))
                into.append(2 * np.array([driven.real, -driven.imag]))
                out.append(np.array([seen.real, seen.imag]).T)
    count = sum(map(len, blocks))
    moves, place = np.zeros((count, count)), 0
    for block in blocks:
        moves[place : place + len(block), place : place + len(block)] = block
        place += len(block)
    through = np.zeros((len(outputs), len(inputs)))
    forced = np.vstack(into) if into else np.zeros((0, len(inputs)))
    rows = np.hstack(out) if out else np.zeros((len(outputs), 0))
    return LinearModel(moves, forced, rows, through, inputs, outputs)


def model_of_modes(
    modes: Modes,
    response: Float[np.ndarray, "output dof"],
    reference: Float[np.ndarray, "input dof"],
    *,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    keep: int | None = None,
) -> LinearModel:
    """The state-space model of the first modes alone.

    Args:
        modes: in the order of |pole|.
        response: rows that pick the motions.
        reference: rows along which the forces act.
        inputs: names of the forces.
        outputs: names of the motions.
        keep: how many modes; all if none.
    """
    count = len(modes.pole) if keep is None else keep
    seen, driven = response @ modes.shape[:, :count], reference @ modes.shape[:, :count]
    residues = np.einsum("om,im->moi", seen, driven)
    return modal_model(modes.pole[:count], residues, inputs=inputs, outputs=outputs)

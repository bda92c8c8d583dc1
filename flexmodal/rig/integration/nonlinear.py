"""A non-linear plant under a hammer: integrated on the fine grid.

The linear part and the hammer's pulse are exact, as in `linear`; the forces of the non-linear elements are
taken as straight lines within a step (first-order hold), found by fixed-point iteration at its end: second
order in the step. Dry friction is Dahl's model (AFOSR report 0158, 1968), dF/du = σ (1 − (F/F_c) sgn u̇),
integrated over the distance moved in the step, which is exact while the direction holds and stays bounded by
F_c at any step.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.frf.kernels.route import has_numba
from flexmodal.frf.kernels.worth import pays_alone
from flexmodal.rig.analyser import Analyser
from flexmodal.rig.blow import Strike
from flexmodal.rig.integration import kernel
from flexmodal.rig.integration.exponential import exponential
from flexmodal.rig.integration.laws import LAWS, steepest
from flexmodal.rig.integration.linear import Outputs, pulse_states
from flexmodal.rig.plant.plant import NUMBERS, Plant

_ROUNDS = 4
"""Of the search for the elements' forces where no torque depends on a rate."""
_MOST_ROUNDS = 40
_ROUND_SECONDS, _COMPILATION = 1e-5, 8.0
"""What a round of the search takes in numpy, however many the blows, and compiling the loop [s]; processor
time of a core of 2020."""
_LEFT = 1e-4
"""Of the error of the first guess, which is of the order of a step already."""


def fine_records(
    plant: Plant,
    column: Float[np.ndarray, "blow state"],
    outputs: Outputs,
    rows: Float[np.ndarray, "channel dof"],
    strikes: list[Strike],
    analyser: Analyser,
    *,
    repeats: int = 1,
) -> Float[np.ndarray, "blow channel grid"]:
    """Accelerations on the fine grid, long enough for the filter at the last sample [m/s²].

    Args:
        plant: with or without non-linear elements.
        column: where each blow enters the state.
        outputs: what is measured, the same channels for every blow.
        rows: the same channels as rows over the coordinates.
        strikes: the blows.
        analyser: sets the grid.
        repeats: how often the like is done in a simulation; much of it pays for compiled loops.
    """
    step = analyser.step
    grid = (analyser.samples - 1) * analyser.oversampling + analyser.reach + 1
    a = plant.state_matrix
    origin, states = pulse_states(a, column, strikes, step)
    columns = plant.input_column(plant.element_rows).T
    phi, early, late = held(a, columns, step)
    pulse = np.ascontiguousarray(np.transpose(states[:, 1:] - states[:, :-1] @ phi.T, (1, 2, 0)))
    seen, rates = np.zeros((2, len(plant.elements), len(a)))
    seen[:, : plant.dof] = rates[:, plant.dof : 2 * plant.dof] = plant.element_rows
    by_element = rows @ columns[plant.dof : 2 * plant.dof]
    fine = np.zeros((len(strikes), len(rows), grid))
    kinds = np.array([element.kind for element in plant.elements], dtype=np.int64)
    parameters = np.zeros((len(plant.elements), NUMBERS))
    for element, numbers in zip(plant.elements, parameters, strict=True):
        numbers[: len(element.parameters)] = element.parameters
    ease, rounds = _search(kinds, parameters, rates @ late)
    _stepper(repeats * grid * rounds * _ROUND_SECONDS)(
        phi, early, late, pulse, origin, kinds, parameters, seen, rates, ease, rounds,
        np.ascontiguousarray(outputs.by_state[0]), np.ascontiguousarray(by_element), fine,
    )  # fmt: skip
    struck = slice(origin, min(origin + states.shape[1], grid))
    times = np.arange(struck.start, struck.stop) * step
    force = np.array([s.force(times) for s in strikes])
    fine[:, :, struck] += force[:, None, :] * outputs.by_force[:, :, None]
    return fine


def _search(kinds: np.ndarray, parameters: np.ndarray, swift: np.ndarray) -> tuple[np.ndarray, int]:
    """How much of the last guess stays in a round of the search for the forces, and how many rounds it takes.

    A torque that grows with the rate is sought by Newton's method with the steepest slope it can have: that
    never overshoots, and leaves at most ease/(1 + ease) of the error a round.
    """
    slopes = np.array([steepest(int(kind), p) for kind, p in zip(kinds, parameters, strict=True)])
    ease = slopes * np.abs(swift).sum(axis=1)
    left = float(np.max(ease / (1 + ease), initial=0.0))
    rounds = _ROUNDS if left == 0 else int(np.ceil(np.log(_LEFT) / np.log(left)))
    return ease, int(np.clip(rounds, _ROUNDS, _MOST_ROUNDS))


def held(
    a: Float[np.ndarray, "state state"], columns: Float[np.ndarray, "state input"], step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """exp(A h) and the weights of an input at both ends of a step, a straight line in between.

    Van Loan's formula: the exponential of [[A, B, 0], [0, 0, I], [0, 0, 0]].

    Args:
        a: state matrix.
        columns: input vectors.
        step: h [s].
    """
    n, r = columns.shape
    wide = np.zeros((n + 2 * r, n + 2 * r))
    wide[:n, :n], wide[:n, n : n + r] = a * step, columns * step
    wide[n : n + r, n + r :] = np.eye(r)
    whole = exponential(wide)
    late = whole[:n, n + r :]
    return (
        np.ascontiguousarray(whole[:n, :n]),
        np.ascontiguousarray(whole[:n, n : n + r] - late),
        np.ascontiguousarray(late),
    )


def _stepper(seconds: float) -> Any:
    """The compiled loop, or the same in numpy: without numba, or for less work than compiling would be."""
    if has_numba() and pays_alone("steps of the rig", seconds, _COMPILATION, _kernel().is_stored):
        return _kernel().compiled
    return step_through_numpy


@cache
def _kernel() -> Kernel:
    laws = (
        kernel.hardening,
        kernel.friction,
        kernel.backlash,
        kernel.elastic,
        kernel.sliding,
        kernel.yielding,
        kernel.wound,
    )
    inner, purpose = (kernel.add, *laws, kernel.act, kernel.search), "steps in time"
    return together(*inner, last=kernel.step_through, purpose=purpose, seconds=_COMPILATION)


def step_through_numpy(
    phi: np.ndarray, early: np.ndarray, late: np.ndarray, pulse: np.ndarray, origin: int, kinds: np.ndarray,
    parameters: np.ndarray, rows: np.ndarray, rates: np.ndarray, ease: np.ndarray, rounds: int,
    c: np.ndarray, d: np.ndarray, fine: np.ndarray,
) -> None:  # fmt: skip
    """What `kernel.step_through` does, for all blows at once; see there for the arguments."""
    blows, count = pulse.shape[2], len(kinds)
    now = np.zeros((len(phi), blows))
    force, memory, stretch = np.zeros((3, count, blows))
    gain, swift = rows @ late, rates @ late
    for grid in range(origin, fine.shape[2] - 1):
        base = phi @ now + early @ force
        if grid - origin < len(pulse):
            base += pulse[grid - origin]
        free, coast, guess, fresh = rows @ base, rates @ base, force.copy(), memory.copy()
        for _ in range(rounds):
            end, speed = free + gain @ guess, coast + swift @ guess
            for e in range(count):
                law = LAWS[int(kinds[e])]
                torque, fresh[e] = law(parameters[e], stretch[e], end[e], speed[e], memory[e])
                guess[e] += (-torque - guess[e]) / (1 + ease[e])
        stretch, memory, force = free + gain @ guess, fresh, guess
        now = base + late @ force
        fine[:, :, grid + 1] = (c @ now + d @ force).T

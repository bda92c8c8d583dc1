"""A non-linear plant under a hammer: marched on the fine grid.

The linear part and the hammer's pulse are exact, as in `linear`; the forces of the non-linear elements are
taken as straight lines within a step (first-order hold), found by fixed-point iteration at its end: second
order in the step. Dry friction is Dahl's model (AFOSR report 0158, 1968), dF/du = σ (1 − (F/F_c) sgn u̇),
integrated over the distance moved in the step, which is exact while the direction holds and stays bounded by
F_c at any step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.rig.analyser import Analyser
from flexmodal.rig.blow import Strike
from flexmodal.rig.integration.exponential import exponential
from flexmodal.rig.integration.linear import Outputs, pulse_states
from flexmodal.rig.plant.plant import BACKLASH, FRICTION, HARDENING, Plant


def fine_records(
    plant: Plant,
    column: Float[np.ndarray, "blow state"],
    outputs: Outputs,
    rows: Float[np.ndarray, "channel dof"],
    strikes: list[Strike],
    analyser: Analyser,
) -> Float[np.ndarray, "blow channel grid"]:
    """Accelerations on the fine grid, long enough for the filter at the last sample [m/s²].

    Args:
        plant: with or without non-linear elements.
        column: where each blow enters the state.
        outputs: what is measured, the same channels for every blow.
        rows: the same channels as rows over the coordinates.
        strikes: the blows.
        analyser: sets the grid.
    """
    step = analyser.step
    grid = (analyser.samples - 1) * analyser.oversampling + analyser.reach + 1
    a = plant.state_matrix
    origin, states = pulse_states(a, column, strikes, step)
    columns = plant.input_column(plant.element_rows).T
    phi, early, late = held(a, columns, step)
    pulse = np.ascontiguousarray(np.transpose(states[:, 1:] - states[:, :-1] @ phi.T, (1, 2, 0)))
    seen = np.zeros((len(plant.elements), len(a)))
    seen[:, : plant.dof] = plant.element_rows
    by_element = rows @ columns[plant.dof : 2 * plant.dof]
    fine = np.zeros((len(strikes), len(rows), grid))
    kinds = np.array([element.kind for element in plant.elements], dtype=np.int64)
    parameters = np.array([element.parameters for element in plant.elements], dtype=float).reshape(-1, 3)
    step_through = _stepper()
    step_through(
        phi, early, late, pulse, origin, kinds, parameters, seen, np.ascontiguousarray(outputs.by_state[0]),
        np.ascontiguousarray(by_element), fine,
    )  # fmt: skip
    struck = slice(origin, min(origin + states.shape[1], grid))
    times = np.arange(struck.start, struck.stop) * step
    force = np.array([s.force(times) for s in strikes])
    fine[:, :, struck] += force[:, None, :] * outputs.by_force[:, :, None]
    return fine


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


def _stepper() -> Any:
    """The compiled loop, or the same in numpy where numba is not installed."""
    try:
        from flexmodal.rig.integration.kernel import step_through
    except ImportError:
        return step_through_numpy
    return step_through


def step_through_numpy(
    phi: np.ndarray, early: np.ndarray, late: np.ndarray, pulse: np.ndarray, origin: int, kinds: np.ndarray,
    parameters: np.ndarray, rows: np.ndarray, c: np.ndarray, d: np.ndarray, fine: np.ndarray,
) -> None:  # fmt: skip
    """What `kernel.step_through` does, for all blows at once; see there for the arguments."""
    blows, count = pulse.shape[2], len(kinds)
    now = np.zeros((len(phi), blows))
    force, memory, stretch = np.zeros((3, count, blows))
    gain = rows @ late
    for grid in range(origin, fine.shape[2] - 1):
        base = phi @ now + early @ force
        if grid - origin < len(pulse):
            base += pulse[grid - origin]
        free, guess, fresh = rows @ base, force.copy(), memory
        for _ in range(4):
            end = free + gain @ guess
            taken = [_law(int(kinds[e]), parameters[e], stretch[e], end[e], memory[e]) for e in range(count)]
            guess = -np.array(taken).reshape(count, blows)
        fresh = -guess
        stretch, memory, force = free + gain @ guess, fresh, guess
        now = base + late @ force
        fine[:, :, grid + 1] = (c @ now + d @ force).T


def _law(kind: int, p: np.ndarray, old: np.ndarray, new: np.ndarray, memory: np.ndarray) -> np.ndarray:
    if kind == HARDENING:
        ratio = (new / p[1]) ** 2
        return p[0] * new * ratio / (1 + ratio)
    if kind == FRICTION:
        limit = np.where(new >= old, p[0], -p[0])
        return limit + (memory - limit) * np.exp(-p[1] * np.abs(new - old) / p[0])
    if kind == BACKLASH:
        pressed, gap = p[0] * new + p[2], p[0] * p[1]
        return (
            np.where(pressed > 0, pressed, np.where(pressed < -gap, pressed + gap, 0.0)) - p[2] - p[0] * new
        )
    raise AssertionError(f"no law of the code {kind}")

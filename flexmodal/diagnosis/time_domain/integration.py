"""Structures with non-linear torques under a hammer, integrated in time.

    M ẍ + C ẋ + K x = jᵀ f(t) − Σ wᵀ T(w x, history)

The linear part is propagated exactly; force and torques are straight lines within a step (first-order hold),
the torques at its end found by Newton's method: second order in the step. What is kept of it are the
spectrum of each torque over the record and the state at its end; the rest is linear (`record`).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.diagnosis.parallel.workers import free_cores
from flexmodal.diagnosis.time_domain import kernel, law_kernel, numpy_form, settle_kernel
from flexmodal.diagnosis.time_domain.kernel import LANES
from flexmodal.diagnosis.time_domain.law import FRICTION, SLOW, Law
from flexmodal.diagnosis.time_domain.propagation import Propagation, propagated, state_matrix
from flexmodal.diagnosis.time_domain.pulse import Pulse
from flexmodal.diagnosis.time_domain.spectrum import WHOLE, spectrum
from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.frf.kernels.route import has_numba, in_parts
from flexmodal.frf.kernels.worth import is_worth_it
from flexmodal.structure.structure import Axis, Structure

Blow = tuple[int, Pulse]
"""Row of `Structure.reference` that is struck, and the pulse."""

FINENESS = 10.0
"""Steps in a period of the highest line, at least."""
_STEP_SECONDS, _BLOW_SECONDS, _COMPILATION = 1.5e-4, 1e-6, 7.0
"""What numpy takes for a step, and for each blow in it, and what compiling takes [s]."""
_TOGETHER = 4_000_000
"""Torques kept at once."""


@dataclass(frozen=True)
class Steps:
    """How long the integration goes, and in what steps."""

    step: float
    """[s]"""
    count: int
    """From the blow to the end of the record."""
    whole: int
    """Of the whole record."""

    @property
    def length(self) -> float:
        """From the blow to the end of the record [s]."""
        return self.count * self.step

    @classmethod
    def behind(
        cls, frequency: Float[np.ndarray, " line"], length: float = 0.0, fineness: float = FINENESS
    ) -> Steps:
        """The record behind some lines: 1/Δf long, or as many times as its length asks for.

        Args:
            frequency: of the lines [Hz].
            length: of the record, from the blow to its end; 0 where it is not known [s].
            fineness: steps in a period of the highest line.
        """
        from scipy.fft import next_fast_len

        period = 1 / float(np.min(np.diff(frequency))) if len(frequency) > 1 else 1 / float(frequency[0])
        whole = period * max(1, int(np.ceil(length / period - WHOLE)))
        steps = int(next_fast_len(int(np.ceil(fineness * frequency[-1] * whole)), real=True))
        return cls(whole / steps, min(round(length / whole * steps), steps) or steps, steps)


@dataclass(frozen=True, eq=False)
class Struck:
    """A structure with its laws, and how it is struck."""

    structure: Structure
    laws: tuple[Law, ...]
    axis: Axis
    """Lines that are wanted, and the window."""
    blows: tuple[Blow, ...]

    @cached_property
    def key(self) -> tuple[object, ...]:
        """What an integration of it depends on."""
        s = self.structure
        arrays = (s.mass, s.damping, s.stiffness, s.loss, s.reference, *(law.row for law in self.laws))
        laws = tuple((law.kind, law.parameters) for law in self.laws)
        return (*(a.tobytes() for a in arrays), s.loss_factor, laws, self.axis.decay, self.blows)

    @cached_property
    def rows(self) -> Float[np.ndarray, "input dof"]:
        """Along which torques and blows act: laws, then references."""
        return np.vstack([*(law.row for law in self.laws), self.structure.reference])


@dataclass(frozen=True, eq=False)
class TimeResponse:
    """What an integration leaves, by blow."""

    force: Complex[np.ndarray, "blow line"]
    """Spectrum of the pulse [N·s]."""
    torque: Complex[np.ndarray, "blow law line"]
    """Spectrum of each torque over the record [N·m·s]."""
    last: Float[np.ndarray, "blow state"]
    """Coordinates and velocities at the end of the record."""


def integrate(struck: Sequence[Struck], steps: Steps, *, compiled: bool | None = None) -> list[TimeResponse]:
    """Integrate every blow on every structure; structures that occur twice are integrated once.

    Args:
        struck: with the same number of coordinates and the same kinds of law in the same order.
        steps: length of the record, and the steps.
        compiled: whether by the compiled loop; the other gives the same numbers but for rounding. By default,
            if numba is installed.
    """
    firsts, numbers = _distinct([one.key for one in struck])
    first = [struck[k] for k in firsts]
    most = _TOGETHER // (steps.count * max(len(one.laws) for one in first))
    made: list[TimeResponse] = []
    for some in _batches(first, most):
        made += _integrated(some, steps, loop_of(some, steps, compiled))
    return [made[number] for number in numbers]


def torques(
    struck: Sequence[Struck], steps: Steps, loop: Callable[..., None]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces [blow time], torques [blow law time] and last states [blow state], blow after blow.

    Args:
        struck: structures with the same number of coordinates and the same kinds of law.
        steps: of the record.
        loop: over the steps, see `loop_of`.
    """
    laws, h = len(struck[0].laws), steps.step
    part, number = _linear(struck, h)
    (turn, cross), (early, late) = part.once(), part.weights()
    turn, cross, early, late, back = (a[number] for a in (turn, cross, early, late, part.back))
    begun, held = (np.swapaxes(one[:, :, :laws], 1, 2) for one in (early, late))
    carried = begun + turn[:, None] * held + cross[:, None] * held[:, :, np.arange(turn.shape[1]) ^ 1]
    rows = np.array([[_felt(law) for law in one.laws] for one in struck]) @ back
    blows = [blow for one in struck for blow in one.blows]
    time = np.arange(min(1 + int(np.ceil(max(pulse.length for _, pulse in blows) / h)), steps.count) + 1) * h
    force = np.array([pulse.force(time) for _, pulse in blows])
    of = np.repeat(np.arange(len(struck)), [len(one.blows) for one in struck])
    row = laws + np.array([row for row, _ in blows])
    push = force[:, :-1, None] * early[of, :, row][:, None] + force[:, 1:, None] * late[of, :, row][:, None]
    lanes = next((one for one in LANES if one >= len(blows)), LANES[-1])
    tiles = -(-len(blows) // lanes)
    torque = np.zeros((tiles, lanes, laws, steps.count + 1))
    last = np.zeros((tiles, turn.shape[1], lanes))

    def tiled(of_blows: np.ndarray) -> np.ndarray:
        padded = of_blows[np.minimum(np.arange(tiles * lanes), len(blows) - 1)]
        return np.ascontiguousarray(np.moveaxis(padded.reshape(tiles, lanes, *padded.shape[1:]), 1, -1))

    gain = np.einsum("kli,kmi->klm", rows, held)
    systems = [tiled(one[of]) for one in (turn, cross, carried, held, rows, gain)]
    kinds = np.array([law.kind for law in struck[0].laws])
    laws_of_blows, pushes = tiled(_parameters(struck, h)[of]), tiled(push)

    def some(part: slice) -> None:
        loop(
            *(one[part] for one in systems),
            kinds,
            *(one[part] for one in (laws_of_blows, pushes, torque, last)),
        )

    in_parts(tiles, 1 if loop is numpy_form.integrate else min(free_cores(), tiles), some)
    last = np.moveaxis(last, 1, 2).reshape(tiles * lanes, -1)[: len(blows)]
    return (
        force,
        torque.reshape(tiles * lanes, laws, -1)[: len(blows)],
        np.einsum("bij,bj->bi", back[of], last),
    )


def _linear(struck: Sequence[Struck], step: float) -> tuple[Propagation, Int[np.ndarray, " system"]]:
    """The linear parts that differ, and which one each has: laws may be the only difference."""
    made = [(state_matrix(one.structure, one.axis), _columns(one)) for one in struck]
    firsts, number = _distinct([(a.tobytes(), b.tobytes()) for a, b in made])
    most = max(columns.shape[1] for _, columns in made)  # some may be struck at more points than others
    linear = np.array([made[k][0] for k in firsts])
    columns = [np.pad(made[k][1], ((0, 0), (0, most - made[k][1].shape[1]))) for k in firsts]
    return propagated(linear, np.array(columns), step), np.array(number)


def _distinct(keys: Sequence[Hashable]) -> tuple[list[int], list[int]]:
    """Where each different key occurs first, and which of these each one is."""
    different = {key: number for number, key in enumerate(dict.fromkeys(keys))}
    return [keys.index(key) for key in different], [different[key] for key in keys]


def _felt(law: Law) -> Float[np.ndarray, " state"]:
    """What of the state a law goes by: elongation or speed along its row."""
    still = np.zeros_like(law.row)
    return np.concatenate([still, law.row] if law.kind == SLOW else [law.row, still])


def _parameters(struck: Sequence[Struck], step: float) -> Float[np.ndarray, "system law 8"]:
    """Of the laws; of friction the speed as elongation in a step, and the time in steps."""
    found = np.array([[law.parameters for law in one.laws] for one in struck], dtype=float)
    rubs = np.flatnonzero([law.kind == FRICTION for law in struck[0].laws])
    found[:, rubs, 4] *= step
    found[:, rubs, 5] /= step
    return found


def _columns(one: Struck) -> Float[np.ndarray, "state input"]:
    """How torques and blows enter the state."""
    pushed = np.linalg.solve(one.structure.mass, one.rows.T)
    return np.vstack([np.zeros_like(pushed), pushed])


def _integrated(struck: Sequence[Struck], steps: Steps, loop: Callable[..., None]) -> list[TimeResponse]:
    force, torque, last = torques(struck, steps, loop)
    ends = np.cumsum([len(one.blows) for one in struck])
    return [
        TimeResponse(
            spectrum(force[own], one.axis, steps.step),
            spectrum(torque[own], one.axis, steps.step, steps.whole),
            last[own],
        )
        for one, own in zip(struck, map(slice, ends - [len(one.blows) for one in struck], ends), strict=True)
    ]


def _batches(struck: Sequence[Struck], most: int) -> Iterator[list[Struck]]:
    """Of at most so many blows, or of one structure."""
    batch: list[Struck] = []
    for one in struck:
        if batch and sum(len(b.blows) for b in [*batch, one]) > most:
            yield batch
            batch = []
        batch.append(one)
    yield batch


def loop_of(struck: Sequence[Struck], steps: Steps, compiled: bool | None = None) -> Callable[..., None]:
    """The loop over the steps: compiled if that is asked for, or pays for what is to be integrated.

    Args:
        struck: what is to be integrated.
        steps: of the record.
        compiled: whether by the compiled loop; if None, where numba is installed and it pays.
    """
    if compiled is None:
        blows = sum(len(one.blows) for one in struck)
        seconds = steps.count * (_STEP_SECONDS + _BLOW_SECONDS * blows)
        compiled = has_numba() and is_worth_it("time steps", seconds, _COMPILATION, _kernel().is_stored)
    return _kernel().compiled if compiled else numpy_form.integrate


@cache
def _kernel() -> Kernel:
    laws = (
        law_kernel.hardened, law_kernel.knee, law_kernel.slow, law_kernel.limits, law_kernel.rubbed,
        law_kernel.stuck_of,
    )  # fmt: skip
    newton = (
        settle_kernel.torques_of, settle_kernel.correct, settle_kernel.correct_one, settle_kernel.correct_two,
        settle_kernel.take, settle_kernel.settle,
    )  # fmt: skip
    steps = (kernel.coast, kernel.expect, kernel.go_on)
    return together(
        law_kernel.exponential, law_kernel.logarithm, *laws, *newton, *steps, last=kernel.integrate,
        purpose="steps in time", seconds=_COMPILATION, merged=True,
    )  # fmt: skip

"""Structures with non-linear torques under a hammer, integrated in time.

    M ẍ + C ẋ + K x = jᵀ f(t) − Σ wᵀ T(w x, history)

The linear part is propagated exactly; force and torques are straight lines within a step (first-order hold),
the torques at its end found by Newton's method: second order in the step. What is kept of it are the
spectrum of each torque over the record and the state at its end; the rest is linear (`record`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.time_domain import kernel, numpy_form
from flexmodal.diagnosis.time_domain.kernel import LANES
from flexmodal.diagnosis.time_domain.law import FRICTION, SLOW, Law
from flexmodal.diagnosis.time_domain.pulse import Pulse
from flexmodal.diagnosis.time_domain.spectrum import WHOLE, spectrum
from flexmodal.frf.kernels.compiled import Kernel, together
from flexmodal.frf.kernels.route import has_numba
from flexmodal.frf.kernels.worth import is_worth_it
from flexmodal.structure.structure import Axis, Structure

Blow = tuple[int, Pulse]
"""Row of `Structure.reference` that is struck, and the pulse."""

FINENESS = 10.0
"""Steps in a period of the highest line, at least."""
_STEP_SECONDS, _BLOW_SECONDS, _COMPILATION = 1.5e-4, 1e-6, 4.0
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
    different: dict[tuple[object, ...], int] = {}
    numbers = [different.setdefault(one.key, len(different)) for one in struck]
    first = [struck[numbers.index(k)] for k in range(len(different))]
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
    phi, early, late = held(
        np.array([state_matrix(one.structure, one.axis) for one in struck]),
        np.array([_columns(one) for one in struck]),
        h,
    )
    groups = [(k, some) for k, one in enumerate(struck) for some in _lanes(one.blows)]
    system = np.array([k for k, _ in groups])
    longest = max(pulse.length for _, some in groups for _, pulse in some)
    time = np.arange(min(1 + int(np.ceil(longest / h)), steps.count) + 1) * h
    states = phi.shape[1]
    force = np.zeros((len(groups), LANES, len(time)))
    push = np.zeros((len(groups), len(time) - 1, states, LANES))
    for group, (k, some) in enumerate(groups):
        for lane, (row, pulse) in enumerate(some):
            f = force[group, lane] = pulse.force(time)
            first, second = early[k, :, laws + row], late[k, :, laws + row]
            push[group, :, :, lane] = np.outer(f[:-1], first) + np.outer(f[1:], second)
    torque = np.zeros((len(groups), LANES, laws, steps.count + 1))
    last = np.zeros((len(groups), LANES, states))
    rows = np.array([[_felt(law) for law in one.laws] for one in struck])
    loop(
        np.ascontiguousarray(phi),
        np.ascontiguousarray(np.swapaxes(early[:, :, :laws] + phi @ late[:, :, :laws], 1, 2)),
        np.ascontiguousarray(np.swapaxes(late[:, :, :laws], 1, 2)),
        rows,
        np.array([law.kind for law in struck[0].laws]),
        _parameters(struck, h),
        system,
        push,
        torque,
        last,
    )
    taken = np.array([lane < len(some) for _, some in groups for lane in range(LANES)])
    return (
        force.reshape(-1, len(time))[taken],
        torque.reshape(-1, laws, steps.count + 1)[taken],
        last.reshape(-1, states)[taken],
    )


def _felt(law: Law) -> Float[np.ndarray, " state"]:
    """What of the state a law goes by: elongation or speed along its row."""
    still = np.zeros_like(law.row)
    return np.concatenate([still, law.row] if law.kind == SLOW else [law.row, still])


def _parameters(struck: Sequence[Struck], step: float) -> Float[np.ndarray, "system law 5"]:
    """Of the laws; the speed of friction as elongation in a step."""
    found = np.array([[law.parameters for law in one.laws] for one in struck], dtype=float)
    found[:, [law.kind == FRICTION for law in struck[0].laws], 4] *= step
    return found


def _lanes(blows: Sequence[Blow]) -> list[Sequence[Blow]]:
    """So many at once as are integrated together."""
    return [blows[start : start + LANES] for start in range(0, len(blows), LANES)]


def state_matrix(structure: Structure, axis: Axis) -> Float[np.ndarray, "state state"]:
    """A of ṡ = A s with s = coordinates, velocities.

    Hysteretic springs stand in it, between each two modes, as springs and dampers that are right at the
    geometric mean of their frequencies. Only the torques feel the difference: the linear part of a receptance
    is computed with the springs themselves.

    Args:
        structure: with hysteretic springs or without.
        axis: whose first line and middle count for these springs.
    """
    n, k, c = structure.dof, structure.stiffness, structure.damping
    if structure.loss_factor and structure.loss.any():
        from scipy.linalg import eigh

        square, shapes = eigh(k, structure.mass)
        each = np.sqrt(np.sqrt(np.maximum(square, 0.0)))
        omega = np.maximum(np.outer(each, each), 2 * np.pi * axis.frequency[0] / 10)
        grown, _ = Axis(omega.ravel() / (2 * np.pi), axis.middle).hysteresis(structure.loss_factor)
        between = shapes.T @ structure.loss @ shapes * grown.reshape(n, n)
        back = structure.mass @ shapes
        k = k + back @ between.real @ back.T
        c = c + back @ (between.imag / omega) @ back.T
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:] = np.eye(n)
    a[n:] = -np.linalg.solve(structure.mass, np.hstack([k, c]))
    return a


def held(
    a: Float[np.ndarray, "system state state"], columns: Float[np.ndarray, "system state input"], step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """exp(A h) and the weights of inputs at both ends of a step, straight lines in between.

    From the exponential of [[A, B, 0], [0, 0, I], [0, 0, 0]] h (Van Loan, IEEE Trans. Automatic Control 23,
    1978).

    Args:
        a: A of each system.
        columns: B of each, what the inputs do to ṡ.
        step: h [s].
    """
    from scipy.linalg import expm

    n, r = columns.shape[1:]
    wide = np.zeros((len(a), n + 2 * r, n + 2 * r))
    wide[:, :n, :n], wide[:, :n, n : n + r] = a * step, columns * step
    wide[:, n : n + r, n + r :] = np.eye(r)
    whole = expm(wide)
    late = whole[:, :n, n + r :]
    return whole[:, :n, :n], whole[:, :n, n : n + r] - late, late


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
    inner, purpose = (kernel.law, kernel.coast, kernel.eliminate, kernel.settle), "steps in time"
    return together(*inner, last=kernel.integrate, purpose=purpose, seconds=_COMPILATION, merged=True)

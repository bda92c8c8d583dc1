"""What the end of a record does to modes: the rest of a motion that goes on after it is missing.

A response that is measured as the k-th derivative of the displacement, in a record that ends a time T after
the blow, lacks

    ΔH(s) = Σ A λᵏ e^{(λ − s)T} / (s − λ),   s = iω,

summed over modes and their conjugates; exact for blows that are short beside T. It is the same in every blow
and every FRF, so that no noise tells of it; its phase depends on when in the record the hammer fell, which
no FRF says. So they are fitted twice more with the rest put back, the second time a quarter of a swing later.
The mean square of the two moves is the variance that the end of the record makes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import PRETRIGGER
from flexmodal.ema.methods.least_squares import LeastSquaresProblem, solve_many
from flexmodal.ema.mode import EstimatedModes, ModeEstimate
from flexmodal.frf import POWER

NOTHING = 1e-4
"""Part of its motion down to which a mode has to have decayed for the end to leave nothing out."""
LEAST_DAMPING = 1e-6
SAYS = "the motion that the end of the record cut off decides its interval: a longer record tells more"


def with_record_end(found: EstimatedModes, length: float | None) -> EstimatedModes:
    """Modes with the uncertainty that the end of the record makes of them.

    Args:
        found: modes, windows still in them.
        length: of the records [s]; None where it is not known, and nothing is added.
    """
    if length is None or not found.modes:
        return found
    after = (1 - PRETRIGGER) * length
    left = max(np.exp(mode.pole.real * after) for mode in found)
    measured, count = found.measured, len(found)
    if left < NOTHING or 2 * len(measured.frequency) <= 4 * count + 4:
        return found
    plain = _problem(found)
    parts = [replace(measured, value=measured.value + rest) for rest in missing(found, after)]
    base, *others = solve_many([plain, *(replace(plain, measured=part) for part in parts)])
    if not all(len(one) == count for one in (base, *others)):
        return found
    square = np.mean([(_numbers(one) - _numbers(base)) ** 2 for one in others], axis=0)
    modes = [_wider(*each) for each in zip(found, square, strict=True)]
    return replace(found, modes=tuple(modes))


def missing(found: EstimatedModes, after: float) -> list[Complex[np.ndarray, "line frf"]]:
    """What the end of the record cuts off, as if the blow had fallen then and a quarter of a swing later.

    Args:
        found: modes.
        after: time from the blow to the end of the record [s].
    """
    power, s = POWER[found.measured.form], 1j * found.measured.omega[:, None]
    rests = []
    for turn in (1.0, 1j):
        rest = np.zeros(found.measured.value.shape, dtype=complex)
        for mode in found:
            residue = turn * mode.residue
            for pole, part in ((mode.pole, residue), (mode.pole.conjugate(), residue.conj())):
                rest += part * pole**power * np.exp((pole - s) * after) / (s - pole)
        rests.append(rest)
    return rests


def _problem(found: EstimatedModes) -> LeastSquaresProblem:
    """The fit of these modes, from where they are."""
    start = [[mode.frequency, max(mode.damping_ratio, LEAST_DAMPING)] for mode in found]
    return LeastSquaresProblem(
        measured=found.measured, start=np.array(start), free=np.ones((len(start), 2), bool), vary=False,
        keep=True,
    )  # fmt: skip


def _numbers(found: EstimatedModes) -> Float[np.ndarray, "mode number"]:
    """Frequency [Hz], damping ratio and |A| of each FRF."""
    return np.array([[mode.frequency, mode.damping_ratio, *np.abs(mode.residue)] for mode in found])


def _wider(mode: ModeEstimate, square: Float[np.ndarray, " number"]) -> ModeEstimate:
    """A mode with these variances beside those that it has; what was forced stays without."""
    added = np.where(np.diag(mode.covariance) > 0, square[:2], 0.0)
    residues = square[2:] if mode.residue_choices is None else mode.residue_choices + square[2:]
    remarks = mode.remarks
    if np.any(added > np.diag(mode.covariance) + np.diag(mode.choices)):
        remarks = (*remarks, SAYS)
    return replace(mode, choices=mode.choices + np.diag(added), residue_choices=residues, remarks=remarks)

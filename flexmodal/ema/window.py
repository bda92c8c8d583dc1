"""Taking out the damping that an exponential window adds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import without_window as unwindowed
from flexmodal.ema.mode import EstimatedModes, ModeEstimate
from flexmodal.errors import Fault, InvalidRequest


def without_window(found: EstimatedModes, decay: float) -> EstimatedModes:
    """The modes as they would be had force and response not been multiplied by exp(−decay·t).

    The window moves every pole by −decay along the real axis: λ = λ′ + decay. The damped frequency and the
    residues stay; natural frequency and damping ratio follow from λ. The FRFs kept in the answer are still
    the windowed ones, and `synthesise` gives those.

    Args:
        found: modes of windowed FRFs.
        decay: of the window [1/s]; `ln(1/end)/T` for one that ends at `end` after T seconds.

    Raises:
        InvalidRequest: a decay that is negative or not finite.
    """
    if not (np.isfinite(decay) and decay >= 0):
        raise InvalidRequest(Fault("call", "decay", f"{decay:g} 1/s", "a finite number, 0 or more"))
    modes = tuple(_corrected(mode, decay) for mode in found.modes)
    return replace(found, modes=modes, decay=found.decay + decay)


def _corrected(mode: ModeEstimate, decay: float) -> ModeEstimate:
    frequency, damping = (float(part) for part in unwindowed(mode.frequency, mode.damping_ratio, decay))
    before = _slopes(2 * np.pi * mode.frequency, mode.damping_ratio)
    after = _slopes(2 * np.pi * frequency, damping)
    spread = np.diag([2 * np.pi, 1.0])
    turn = np.linalg.inv(after @ spread) @ before @ spread
    remarks = mode.remarks
    if damping <= 0:
        remarks = (*remarks, "the window's damping is more than all that was measured")
    return replace(
        mode,
        frequency=frequency,
        damping_ratio=damping,
        covariance=turn @ mode.covariance @ turn.T,
        choices=turn @ mode.choices @ turn.T,
        remarks=remarks,
    )


def _slopes(natural: float, damping: float) -> np.ndarray:
    """∂(Re λ, Im λ)/∂(ω_n, ζ)."""
    root = np.sqrt(1 - damping**2)
    return np.array([[-damping, -natural], [root, -natural * damping / root]])

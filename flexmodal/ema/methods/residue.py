"""From the mobility multiplier A′ that a graphical method reads off to the residue A of the receptance."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from flexmodal.ema.mode import Method, ModeEstimate


def from_multiplier(
    natural: float,
    damping: float,
    multiplier: complex,
    covariance: Float[np.ndarray, "4 4"],
    freedom: float,
    method: Method,
    remarks: tuple[str, ...] = (),
) -> ModeEstimate:
    """A = A′/(2iω_d) with ω_d = ω_n√(1 − ζ²), and its covariance.

    Args:
        natural: ω_n [rad/s].
        damping: ζ.
        multiplier: A′ [1/kg].
        covariance: of ω_n, ζ, ln|A′| and the phase of A′.
        freedom: degrees of freedom behind it.
        method: what the estimate is called.
        remarks: what to say of it.
    """
    residue = complex(multiplier / (2j * natural * np.sqrt(1 - damping**2)))
    # ln|A| = ln|A′| − ln ω_n − ½ ln(1 − ζ²)
    turn = np.array([[-1 / natural, damping / (1 - damping**2), 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    polar = turn @ covariance @ turn.T  # of ln|A| and its phase
    plane = np.array([[residue.real, -residue.imag], [residue.imag, residue.real]])
    spread = np.diag([1 / (2 * np.pi), 1.0])
    return ModeEstimate(
        frequency=float(natural / (2 * np.pi)),
        damping_ratio=float(damping),
        residue=np.array([residue]),
        covariance=spread @ covariance[:2, :2] @ spread,
        residue_covariance=(plane @ polar @ plane.T)[None],
        freedom=freedom,
        quality=0.0,
        method=method,
        remarks=remarks,
    )


def hidden_by_noise(mode: ModeEstimate) -> str | None:
    """A sentence where the standard error of the damping is as large as the damping itself."""
    if mode.damping_error < abs(mode.damping_ratio) and mode.frequency_error < abs(mode.frequency):
        return None
    found = f"damping ratio {mode.damping_ratio:.2g} with a standard error of {mode.damping_error:.2g}"
    return f"noise hides it: {found}"

"""The depth of cut at which a receptance first allows chatter, at whatever spindle speed.

With the mean directional matrix W₀ [N/m²] and the receptance Φ(ω) of the tip, chatter at ω sets in at the
depth a with `det(1 − a (1 − exp(−iωT)) Φ W₀) = 0` (Altintas and Budak 1995, whose matrix A₀ is 2 W₀ / K_t).
For an eigenvalue μ of Φ W₀ the tooth period T that makes a real and smallest gives `a = 1 / (2 Re μ)`: no
speed is unstable below the smallest of these. In one direction this is Tlusty's −1 / (2 K_s Re G).

These are plain functions of a receptance matrix over frequency, for whoever chooses a posture by depth of
cut.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float


def limiting_depth(
    receptance: Complex[np.ndarray, "line axis axis"], directional: Float[np.ndarray, "axis axis"]
) -> Float[np.ndarray, " line"]:
    """Depth below which no spindle speed gives chatter at a frequency [m].

    Args:
        receptance: Φ of the tip in the frame of the cut [m/N].
        directional: W₀, `flexmodal.machining.average(cut)` [N/m²].

    Returns:
        1 / (2 max Re μ) for each line; infinite where no eigenvalue has a positive real part. The
        smallest over all lines is the unconditional depth of cut.
    """
    largest = np.max(np.linalg.eigvals(receptance @ directional).real, axis=1)
    result = np.full(len(largest), np.inf)
    np.divide(0.5, largest, out=result, where=largest > 0)
    return result

"""How alike FRFs are: over frequency (FRAC) and over the degrees of freedom (FDAC)."""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidRequest


def frac(
    first: Complex[np.ndarray, "line *pair"], second: Complex[np.ndarray, "line *pair"]
) -> Float[np.ndarray, "*pair"]:
    """Frequency response assurance criterion |Σ H̄G|²/(Σ|H|² Σ|G|²) over the lines, for each pair.

    1 where one FRF is a constant times the other; blind to that constant, so to a wrong calibration.

    Args:
        first: FRFs, lines first.
        second: as many on the same lines.

    Raises:
        InvalidRequest: arrays that differ in shape, are not finite, or an FRF that is zero.
    """
    one, other = _checked(first, second)
    product = np.abs(np.sum(one.conj() * other, axis=0)) ** 2
    return np.clip(product / (np.sum(np.abs(one) ** 2, axis=0) * np.sum(np.abs(other) ** 2, axis=0)), 0, 1)


def fdac(
    first: Complex[np.ndarray, "line dof"], second: Complex[np.ndarray, "other dof"]
) -> Float[np.ndarray, "line other"]:
    """Frequency domain assurance criterion: signed cosine of the responses at two frequencies, −1 to 1.

    Re(Σ H̄(f₁)G(f₂))/(|H(f₁)||G(f₂)|) over the degrees of freedom (Pascual, Golinval and Razeto). A ridge
    off the diagonal shows by how much the frequencies of one set are shifted against the other; the sign
    tells 180° apart from 0°.

    Args:
        first: FRFs, lines first.
        second: the same FRFs on lines of their own.

    Raises:
        InvalidRequest: different degrees of freedom, values not finite, or a line where nothing moves.
    """
    one, other = np.asarray(first), np.asarray(second)
    faults = [
        Fault("call", name, "values that are not finite or a line of zeros", "finite, moving responses")
        for name, array in (("first", one), ("second", other))
        if not np.all(np.isfinite(array)) or np.any(np.max(np.abs(array), axis=1) == 0)
    ]
    if one.shape[1] != other.shape[1]:
        found = f"{one.shape[1]} and {other.shape[1]}"
        faults.append(Fault("call", "degrees of freedom", found, "the same ones in both"))
    if faults:
        raise InvalidRequest(faults)
    one = one / np.linalg.norm(one, axis=1, keepdims=True)
    other = other / np.linalg.norm(other, axis=1, keepdims=True)
    return np.clip((one.conj() @ other.T).real, -1.0, 1.0)


def _checked(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    one, other = np.asarray(first), np.asarray(second)
    if one.shape != other.shape:
        found = f"{one.shape} and {other.shape}"
        raise InvalidRequest(Fault("call", "FRFs", found, "the same lines and pairs in both"))
    faults = [
        Fault("call", name, "values that are not finite or an FRF of zeros", "finite FRFs that respond")
        for name, array in (("first", one), ("second", other))
        if not np.all(np.isfinite(array)) or np.any(np.max(np.abs(array), axis=0, initial=0.0) == 0)
    ]
    if faults:
        raise InvalidRequest(faults)
    return one / np.max(np.abs(one), axis=0), other / np.max(np.abs(other), axis=0)

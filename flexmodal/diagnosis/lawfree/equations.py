"""Normal equations of a ported model: the functions line by line, the parameters over all lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float


@dataclass(frozen=True, eq=False)
class Equations:
    """Normal equations at a state."""

    zz: Complex[np.ndarray, "cell line function function"]
    zp: Complex[np.ndarray, "cell line function parameter"]
    z: Complex[np.ndarray, "cell line function"]
    pp: Float[np.ndarray, "parameter parameter"]
    p: Float[np.ndarray, " parameter"]


Products = tuple[
    Complex[np.ndarray, "#line function function"],
    Complex[np.ndarray, "#line function parameter"],
    Complex[np.ndarray, "#line function"],
]


def products(
    along: Complex[np.ndarray, "observation line function"],
    residual: Complex[np.ndarray, "observation line"],
    parameters: Float[np.ndarray, "parameter observation 2 line"],
    *,
    pooled: bool,
) -> Products:
    """Of the derivatives along the functions with themselves, along the parameters, and the residuals.

    Args:
        along: derivatives along the functions, weighted.
        residual: weighted.
        parameters: derivatives along the parameters by real and imaginary part, weighted.
        pooled: whether a function is one number over all lines, so that lines are summed.
    """
    turned = np.moveaxis(along.conj(), (1, 2), (0, 1))  # line function observation
    zz, z = turned @ np.moveaxis(along, 1, 0), (turned @ residual.T[:, :, None])[..., 0]
    others = np.empty((along.shape[1], along.shape[0], len(parameters)), dtype=complex)
    others.real, others.imag = parameters[:, :, 0].T, parameters[:, :, 1].T
    zp = turned @ others
    if pooled:
        zz, zp, z = (one.sum(axis=0, keepdims=True) for one in (zz, zp, z))
    return zz, zp, z

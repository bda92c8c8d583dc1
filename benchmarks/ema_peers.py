"""Modes found without a person by flexmodal, sdypy-EMA and pyOMA2 in the same FRFs.

Neither peer chooses by itself where FRFs are given, so that one rule, as people use it, serves both: a pole
is stable where the order before has one within 1 % in frequency and 5 % in damping; what is stable in three
tenths of the orders is a mode.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Sequence

import numpy as np

from flexmodal.frf.form import convert

HIGHEST = 40
"""Order of each program's polynomials, as many poles a reference."""
FREQUENCY, DAMPING, SHARE = 0.01, 0.05, 0.3

Modes = list[tuple[float, float]]
"""Frequency [Hz] and damping ratio."""


def by_sdypy(axis: np.ndarray, matrix: np.ndarray) -> Modes:
    """LSCF of sdypy-EMA: a common denominator of all FRFs.

    Args:
        axis: lines, evenly spaced [Hz].
        matrix: mobilities by line, response and reference.
    """
    from sdypy import EMA

    value = convert(matrix.reshape(len(axis), -1), axis, "mobility", "inertance").T
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        model = EMA.Model(
            value, axis, lower=axis[0], upper=axis[-1], pol_order_high=HIGHEST, frf_form="accelerance"
        )
        model.get_poles(method="lscf", show_progress=False)
    return stable([np.asarray(poles) for poles in model.all_poles], axis)


def by_pyoma(axis: np.ndarray, matrix: np.ndarray) -> Modes:
    """Poly-reference LSCF of pyOMA2, its spectra taken to be FRFs and the band mapped to its own circle.

    Args:
        axis: lines, evenly spaced [Hz].
        matrix: mobilities by line, response and reference.
    """
    return stable([pole for pole, _ in pyoma_poles(axis, matrix, HIGHEST)], axis)


def pyoma_poles(axis: np.ndarray, matrix: np.ndarray, highest: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Poles [rad/s] of every order, and their participation factors [reference, pole].

    Args:
        axis: lines, evenly spaced [Hz].
        matrix: FRFs by line, response and reference.
        highest: order to which it goes.
    """
    from pyoma2.functions import plscf

    step = 1 / (2 * (axis[-1] - axis[0]))
    # Its cross-spectra are those of response by reference conjugate, so that FRFs go in as conjugates.
    spectra = np.moveaxis(matrix.conj() / np.max(np.abs(matrix)), 0, -1)
    with contextlib.redirect_stderr(io.StringIO()):
        denominators, numerators = plscf.pLSCF(spectra, step, highest, sgn_basf=-1)
    found = []
    for denominator, numerator in zip(denominators, numerators, strict=True):
        state, _ = plscf.rmfd2ac(denominator, numerator)
        values, left = np.linalg.eig(state.T)
        pole = np.log(values) / step
        keep = (pole.imag > 0) & (pole.real < 0) & np.isfinite(pole)
        # The state's left vectors begin with those of the denominator times its last coefficient.
        factors = np.linalg.solve(denominator[-1].T, left[: matrix.shape[2], keep])
        found.append((pole[keep] + 2j * np.pi * axis[0], factors))
    return found


def stable(orders: Sequence[np.ndarray], axis: np.ndarray) -> Modes:
    """Frequency and damping ratio of what stays where it is while the order rises.

    Args:
        orders: poles of each order [rad/s].
        axis: the lines [Hz]; poles outside them do not count.
    """
    before: np.ndarray | None = None
    kept: list[tuple[float, float]] = []
    for poles in orders:
        now = np.array([[abs(p) / 2 / np.pi, -p.real / abs(p)] for p in poles if p.imag > 0 and p.real < 0])
        now = now.reshape(-1, 2)
        now = now[(now[:, 0] > axis[0]) & (now[:, 0] < axis[-1]) & (now[:, 1] < 0.5)]
        if before is not None and len(before):
            for frequency, damping in now:
                near = np.abs(before[:, 0] / frequency - 1) < FREQUENCY
                if np.any(near & (np.abs(before[:, 1] / damping - 1) < DAMPING)):
                    kept.append((float(frequency), float(damping)))
        before = now
    kept.sort()
    groups: list[list[tuple[float, float]]] = []
    for one in kept:
        if groups and one[0] / np.median([f for f, _ in groups[-1]]) - 1 < FREQUENCY:
            groups[-1].append(one)
        else:
            groups.append([one])
    enough = [group for group in groups if len(group) >= SHARE * len(orders)]
    return [(float(np.median([f for f, _ in g])), float(np.median([z for _, z in g]))) for g in enough]


PEERS: dict[str, Callable[[np.ndarray, np.ndarray], Modes]] = {"sdypy-EMA": by_sdypy, "pyOMA2": by_pyoma}

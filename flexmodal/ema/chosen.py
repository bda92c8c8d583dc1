"""Modes that a person chose in the page of a fit, as a file: which data they belong to, and the fit repeated.

The poles are held where they were chosen; residues and residual terms are those of least squares with every
line alike, by an orthogonal factorisation in the page as well as here, so that both give the same numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.basis import Residuals, mode_columns, residual_columns
from flexmodal.ema.methods.least_squares import build_least_squares, solve_least_squares
from flexmodal.ema.methods.peak import Peak
from flexmodal.ema.mode import EstimatedModes, fold_terms, solve_columns
from flexmodal.ema.quality import with_quality
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import POWER
from flexmodal.text.toml import parse_toml
from flexmodal.text.validation import validated
from flexmodal.text.words import FaultList

ALIKE = 1e-9
"""Two fingerprints are of the same data if no number parts by more, relative to its size."""
_APART = 1e-6
"""Two modes closer than this part of their frequency cannot be told apart by any line."""

Pole = tuple[float, float]
"""Natural frequency [Hz] and damping ratio."""


@dataclass(frozen=True)
class Chosen:
    """The modes of one posture, and the data that they were chosen for."""

    fingerprint: tuple[float, ...]
    poles: tuple[Pole, ...]


@dataclass(frozen=True)
class Choice:
    """What a file of chosen modes says."""

    path: Path
    band: tuple[float, float]
    """[Hz]."""
    residuals: Residuals
    postures: Mapping[int, Chosen]


def read_choice(path: Path) -> Choice:
    """Read a file that the page of a fit wrote.

    Args:
        path: the file.

    Raises:
        InvalidRequest: no such file, or everything in it that may not stand there.
    """
    from flexmodal.ema.choice_schema import ChoiceTable

    content = parse_toml(path, kind="a choice of modes")
    if isinstance(content, Fault):
        raise InvalidRequest(content)
    faults = FaultList(path)
    table = validated(ChoiceTable, content, faults)
    if table is None or faults.faults:
        raise InvalidRequest(faults.faults)
    low, high = table.band
    postures: dict[int, Chosen] = {}
    for place, one in enumerate(table.posture):
        if one.id in postures:
            faults.add(f"posture[{place}].id", str(one.id), "each posture once")
        poles = tuple(sorted((mode.frequency, mode.damping_ratio) for mode in one.mode))
        for number, mode in enumerate(one.mode):
            if not low <= mode.frequency <= high:
                key = f"posture[{place}].mode[{number}].frequency"
                faults.add(key, f"{mode.frequency:g}", f"a frequency inside the band, {low:g} to {high:g} Hz")
        for first, second in pairwise(poles):
            if max(second[0] / first[0] - 1, abs(second[1] - first[1])) < _APART:
                faults.add(f"posture[{place}].mode", f"two modes at {first[0]:g} Hz", "each mode once")
        postures[one.id] = Chosen(tuple(one.fingerprint), poles)
    if faults.faults:
        raise InvalidRequest(faults.faults)
    return Choice(path, (low, high), table.residuals, postures)


def fingerprint_of(measured: Measured) -> tuple[float, ...]:
    """Seven numbers that other data would not share: lines, FRFs, ends of the band, size and two mixed sums.

    They are compared and not hashed, since FRFs estimated from blows differ in their last digits between
    machines.

    Args:
        measured: the lines of the band.
    """
    value = measured.value
    turn = np.exp(1j * np.arange(1, value.size + 1) ** 2 * 0.1).reshape(value.shape)
    size = float(np.linalg.norm(value))
    mixed = complex(np.sum(turn * value)) / size
    ends = (float(measured.frequency[0]), float(measured.frequency[-1]))
    return float(value.shape[0]), float(value.shape[1]), *ends, size, mixed.real, mixed.imag


def check_data(choice: Choice, posture: int, measured: Measured) -> None:
    """Refuse a choice that was made for other data.

    Args:
        choice: as it was read.
        posture: id of the posture.
        measured: its FRFs within the choice's band.

    Raises:
        InvalidRequest: the fingerprints part.
    """
    theirs, ours = np.array(choice.postures[posture].fingerprint), np.array(fingerprint_of(measured))
    if np.all(np.abs(theirs - ours) <= ALIKE * np.maximum(np.abs(ours), 1.0)):
        return
    names = ("lines", "FRFs", "first line [Hz]", "last line [Hz]", "size", "sum", "sum")
    worst = int(np.argmax(np.abs(theirs - ours) > ALIKE * np.maximum(np.abs(ours), 1.0)))
    found = f"that of other data ({names[worst]}: {theirs[worst]:.6g} there, {ours[worst]:.6g} here)"
    place = list(choice.postures).index(posture)
    key = f"posture[{place}].fingerprint"
    allowed = "a choice made in the page of a fit of this file, with the same --estimator"
    raise InvalidRequest(Fault(str(choice.path), key, found, allowed))


def fit_poles(measured: Measured, poles: Sequence[Pole], residuals: Residuals) -> EstimatedModes:
    """Modes with these poles: residues and residual terms by least squares, every line alike.

    Args:
        measured: FRFs of one posture.
        poles: held as they are, in the order of frequency.
        residuals: none, real or complex terms for what lies outside the band.

    Raises:
        InvalidRequest: more unknowns than lines.
    """
    peaks = [
        Peak(f, 0.999 * f, 1.001 * f, width=2 * z * f, by_hand=True, holds_frequency=True, damping=z)
        for f, z in poles
    ]
    problem = replace(
        build_least_squares(measured, peaks, residuals=residuals, weighting="uniform"), keep=True
    )
    found = solve_least_squares(problem)
    omega, power = measured.omega, POWER[measured.form]
    held = [
        replace(one, frequency=f, damping_ratio=z) for one, (f, z) in zip(found.modes, poles, strict=True)
    ]
    columns = np.concatenate(
        [
            mode_columns(omega, np.array([mode.pole for mode in held]), power),
            residual_columns(omega, power, residuals),
        ],
        axis=1,
    )
    terms = solve_columns(columns, measured.value)
    modes = tuple(
        replace(mode, residue=terms[2 * k] + 1j * terms[2 * k + 1], remarks=()) for k, mode in enumerate(held)
    )
    upper, lower = fold_terms(terms[2 * len(modes) :])
    return with_quality(replace(found, modes=modes, upper=upper, lower=lower))

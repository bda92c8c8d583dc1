"""From the records of `frf.uff` to labelled FRFs on one frequency axis, coherence beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmodal.campaign.abscissa import same_axis
from flexmodal.campaign.consistency import ROUNDING
from flexmodal.campaign.description.tested import Tested
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.uff.codes import COHERENCE, FORM_OF_CODE, FRF
from flexmodal.campaign.uff.records import Labelled, read_records
from flexmodal.frf import POWER, Form
from flexmodal.frf.form import convert
from flexmodal.text.words import FaultList


def read_frf_uff(file: Path, tested: Tested, faults: FaultList, warnings: list[str]) -> FrfRecords | None:
    """Read `frf.uff`; None where faults leave nothing sound.

    Args:
        file: a universal file.
        tested: what was tested; records have to fit it.
        faults: where the faults of the file go.
        warnings: where sentences about what is odd go.
    """
    found = read_records(file, tested, (FRF, COHERENCE), faults, warnings)
    frfs = [one for one in found if one.header.function == FRF]
    coherences = [one for one in found if one.header.function == COHERENCE]
    for one in frfs:
        if not one.header.is_complex:
            faults.add(one.key, "an FRF of real values", "complex values")
    for one in coherences:
        _check_coherence(one, faults)
    _check_twice(frfs, faults)
    _check_twice(coherences, faults)
    if not frfs:
        if not faults.faults:
            faults.add("", "no FRF among the records", "one dataset 58 of function type 4 at least")
        return None
    axis = frfs[0].record.abscissa
    _check_axis(axis, [*frfs, *coherences], faults)
    if faults.faults:
        return None
    value, form = _one_form(frfs, axis, warnings, file)
    return FrfRecords(
        frequency=axis,
        value=value,
        coherence=_match(frfs, coherences, warnings, file),
        posture=np.array([one.posture for one in frfs]),
        trial=np.array([one.trial for one in frfs]),
        response=np.array([one.header.response for one in frfs]),
        reference=np.array([one.header.reference for one in frfs]),
        form=form,
        trials=tested.trials,
    )


def _check_axis(axis: np.ndarray, records: list[Labelled], faults: FaultList) -> None:
    if axis[0] < 0:
        faults.add(records[0].key, f"a frequency of {axis[0]:g} Hz", "0 Hz or more")
    for one in records[1:]:
        other = one.record.abscissa
        if not same_axis(axis, other):
            found = f"{len(other)} lines from {other[0]:g} to {other[-1]:g} Hz"
            first = f"{len(axis)} lines from {axis[0]:g} to {axis[-1]:g} Hz"
            faults.add(f"{one.key}: abscissa", found, f"that of {records[0].key}: {first}, line for line")


def _check_coherence(one: Labelled, faults: FaultList) -> None:
    value = one.record.value
    if np.iscomplexobj(value):
        faults.add(one.key, "a coherence of complex values", "real values from 0 to 1")
    elif value.min() < 0 or value.max() > 1 + ROUNDING:
        worst = value.max() if value.max() > 1 + ROUNDING else value.min()
        line = int(np.flatnonzero(value == worst)[0])
        faults.add(one.key, f"a coherence of {worst:g} at {one.record.abscissa[line]:g} Hz", "0 to 1")


def _check_twice(records: list[Labelled], faults: FaultList) -> None:
    first: dict[tuple[int, ...], Labelled] = {}
    for one in records:
        key = (one.posture, one.trial, *one.pair)
        if key in first:
            what = f"the same posture, trial, response and reference as {first[key].key}"
            faults.add(one.key, what, "each once; measure again under another trial")
        first.setdefault(key, one)


def _one_form(
    frfs: list[Labelled], axis: np.ndarray, warnings: list[str], file: Path
) -> tuple[np.ndarray, Form]:
    """The values in one form; of mixed forms the one with the most derivatives, which divides by nothing."""
    codes = [one.header.numerator.code for one in frfs]
    target = max(codes, key=lambda code: POWER[FORM_OF_CODE[code]])
    if len(set(codes)) > 1:
        forms = " and ".join(sorted({FORM_OF_CODE[code] for code in codes}))
        warnings.append(f"{file}: {forms} side by side, all taken as {FORM_OF_CODE[target]}")
    form = FORM_OF_CODE[target]
    rows = [
        convert(np.asarray(one.record.value, dtype=complex), axis, FORM_OF_CODE[code], form)
        for one, code in zip(frfs, codes, strict=True)
    ]
    return np.array(rows, dtype=complex), form


def _match(
    frfs: list[Labelled], coherences: list[Labelled], warnings: list[str], file: Path
) -> np.ndarray | None:
    """The coherence of each FRF; it has no sign, so that ± directions find each other."""
    if not coherences:
        return None
    held = {(c.posture, c.trial, *map(abs, c.pair)): c for c in coherences}
    rows, without = [], []
    for one in frfs:
        match = held.get((one.posture, one.trial, *map(abs, one.pair)))
        if match is None:
            without.append(one.record.number)
        rows.append(
            np.ones_like(one.record.abscissa) if match is None else np.minimum(match.record.value, 1.0)
        )
    if without:
        count = f"{len(without)} of {len(frfs)} FRFs have"
        warnings.append(f"{file}: {count} no coherence, first dataset {without[0]}: taken as 1")
    used = {(one.posture, one.trial, *map(abs, one.pair)) for one in frfs}
    spare = [c.record.number for key, c in held.items() if key not in used]
    if spare:
        warnings.append(f"{file}: coherence without an FRF left out, first dataset {spare[0]}")
    return np.array(rows, dtype=float)

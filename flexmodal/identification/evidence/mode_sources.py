"""Modes of a campaign: the rows of its table, or fits of its FRFs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodal.campaign import Campaign, CampaignPosture, ModeTable
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.evidence.measured_modes import (
    Antiresonance,
    MeasuredMode,
    MeasuredShape,
    ModeObservations,
)
from flexmodal.identification.signal import with_signal

FINEST_FREQUENCY, FINEST_DAMPING, FINEST_RESIDUE = 1e-4, 5e-3, 1e-2
"""Relative errors below which no modal parameter is taken to be known."""
SINGLE_FREQUENCY, SINGLE_DAMPING, SINGLE_RESIDUE = 0.01, 0.2, 0.2
"""Relative errors of what was found at one place only, with nothing that says how well."""
DEEP = 12.0
"""How far below both sides a dip has to be to count as an antiresonance [dB]."""
PLACED = 0.003
"""Relative error of where a dip is seen: it hangs on where exactly hammer and sensor sit."""
LOWEST = 4
"""Lines at the lower end of the band in which no dip is looked for: drift makes some."""
DOUBTS = ("doubtful", "lost", "missing")
"""Words in the remark on a field that keep it from being used."""


def modes_of_table(campaign: Campaign, direction: int = 3) -> ModeObservations:
    """Take the rows of `modes.csv`: frequency and damping the median over the places, shapes from amplitudes.

    Args:
        campaign: with modes.
        direction: of sensor and hammer, ±1 ±2 ±3 for ±x ±y ±z; the table has none.

    Raises:
        InvalidRequest: no modes.
    """
    table = campaign.modes
    if table is None or not len(table):
        raise InvalidRequest(Fault(str(campaign.path or "campaign"), "modes.csv", "no modes", "modes to fit"))
    postures = tuple(p for p in campaign.postures if np.any(table.posture == p.id))
    modes = []
    for place, posture in enumerate(postures):
        rows = np.flatnonzero(table.posture == posture.id)
        for number in np.unique(table.mode[rows]).tolist():
            found = _mode_of(table, rows[table.mode[rows] == number], place, int(number), direction)
            if found is not None:
                modes.append(found)
    return ModeObservations(campaign, postures, tuple(modes))


def _mode_of(
    table: ModeTable, rows: np.ndarray, posture: int, number: int, direction: int
) -> MeasuredMode | None:
    def sound(field: str, values: np.ndarray) -> np.ndarray:
        doubted = np.array([_doubted(table.flag[row], field) for row in rows])
        return np.isfinite(values[rows]) & ~doubted

    frequency = table.natural_frequency[rows][sound("natural_frequency", table.natural_frequency)]
    damping = table.damping_ratio[rows][sound("damping_ratio", table.damping_ratio)]
    if not frequency.size:
        return None
    middle = float(np.median(frequency))
    ratio = float(np.median(damping)) if damping.size else float("nan")
    pole = 2 * np.pi * middle * 1j * np.sqrt(1 - min(ratio, 0.99) ** 2 if np.isfinite(ratio) else 1.0)
    shapes = []
    usable = rows[sound("amplitude", table.amplitude.real)]
    for struck in np.unique(table.reference[usable]).tolist():
        some = usable[table.reference[usable] == struck]
        places = np.column_stack([table.response[some], np.full(len(some), direction)])
        residue = table.amplitude[some] / (2 * pole)  # A = A′/(2iω_d)
        shapes.append(
            MeasuredShape((int(struck), direction), places, residue, np.full(len(some), SINGLE_RESIDUE))
        )
    return MeasuredMode(
        posture,
        number,
        middle,
        _spread(frequency, middle, SINGLE_FREQUENCY, FINEST_FREQUENCY * 10),
        ratio,
        _spread(damping, ratio, SINGLE_DAMPING, FINEST_DAMPING * 10),
        tuple(shapes),
    )


def _doubted(flag: str, field: str) -> bool:
    """Whether a row's remark casts doubt on a field."""
    for remark in flag.split(";"):
        name, _, mark = remark.strip().partition(":")
        if name == field and any(word in mark for word in DOUBTS):
            return True
    return False


def _spread(values: np.ndarray, middle: float, single: float, least: float) -> float:
    """Relative standard error of a median, from the median of the deviations."""
    if len(values) < 2 or not middle > 0:
        return single
    deviation = 1.4826 * float(np.median(np.abs(values - middle)))
    return max(1.2533 * deviation / np.sqrt(len(values)) / middle, least)


def modes_of_frfs(
    campaign: Campaign,
    near: Mapping[int, Sequence[float]] | None = None,
    *,
    antiresonances: bool = False,
) -> ModeObservations:
    """Fit the modes of each posture, poles common to its FRFs, with their standard errors.

    Args:
        campaign: with FRFs or blows.
        near: by posture id, natural frequencies to begin from [Hz], those of a model for instance: two modes
            that make one peak are told apart only if somebody says that they are two. Automatic peaks where a
            posture has none.
        antiresonances: look for the dips of each FRF too.

    Raises:
        InvalidRequest: nothing to fit, or no mode found.
    """
    from flexmodal.ema import records_of

    records, _ = with_signal(records_of(campaign), campaign)
    measured = replace(campaign, frfs=records, blows=())
    postures = tuple(p for p in campaign.postures if np.any(records.posture == p.id))
    modes = []
    for place, posture in enumerate(postures):
        start = [f for f in (near or {}).get(posture.id, ()) if campaign.band[0] < f < campaign.band[1]]
        modes += _fitted(measured, posture.id, place, start)
    if not modes:
        found = "FRFs in which no mode stands out"
        raise InvalidRequest(Fault(str(campaign.path or "campaign"), "", found, "FRFs with resonances"))
    found_zeros = _antiresonances(measured, postures) if antiresonances else ()
    return ModeObservations(campaign, postures, tuple(modes), found_zeros)


def _fitted(campaign: Campaign, posture: int, place: int, start: list[float]) -> list[MeasuredMode]:
    """Modes of one posture; without those whose damping is none."""
    from flexmodal.ema import Choices
    from flexmodal.ema import fit as fit_modes

    assert campaign.frfs is not None
    part = replace(campaign, frfs=campaign.frfs.select(posture=posture))
    choices = Choices(band=campaign.band, at=sorted(start) or None)
    try:
        fits = fit_modes(part, "least-squares", per="posture", choices=choices)
    except InvalidRequest:  # a frequency of the model that these lines cannot hold
        fits = fit_modes(part, "least-squares", per="posture")
    found = []
    for number, (fit, mode) in enumerate(((one, mode) for one in fits for mode in one.modes), start=1):
        if not 0 < mode.damping_ratio - 2 * mode.damping_error < 1:
            continue
        shapes: dict[tuple[int, int], list[tuple[tuple[int, int], complex, float]]] = {}
        for where, residue, error in zip(fit.places, mode.residue, mode.residue_error, strict=True):
            relative = float(np.hypot(error / max(abs(residue), 1e-300), FINEST_RESIDUE))
            shapes.setdefault(where.reference, []).append((where.response, complex(residue), relative))
        found.append(
            MeasuredMode(
                place,
                number,
                mode.frequency,
                float(np.hypot(mode.frequency_error / mode.frequency, FINEST_FREQUENCY)),
                mode.damping_ratio,
                float(np.hypot(mode.damping_error / mode.damping_ratio, FINEST_DAMPING)),
                tuple(_shape(reference, entries) for reference, entries in shapes.items()),
            )
        )
    return found


def _shape(
    reference: tuple[int, int], entries: Sequence[tuple[tuple[int, int], complex, float]]
) -> MeasuredShape:
    return MeasuredShape(
        reference,
        np.array([place for place, _, _ in entries], dtype=int),
        np.array([residue for _, residue, _ in entries], dtype=complex),
        np.array([error for _, _, error in entries], dtype=float),
    )


def _antiresonances(campaign: Campaign, postures: Sequence[CampaignPosture]) -> tuple[Antiresonance, ...]:
    """Dips of the averaged FRFs that are `DEEP`, on lines that are not noise."""
    from flexmodal.frf import antiresonances
    from flexmodal.identification.observations import observe

    seen = observe(campaign)
    place_of = {posture.id: place for place, posture in enumerate(postures)}
    axis = seen.axis.frequency
    step = float(np.median(np.diff(axis)))
    found = []
    for row in range(len(seen)):
        for dip in antiresonances(axis, seen.value[row], prominence=DEEP).tolist():
            line = int(np.argmin(np.abs(axis - dip)))
            if line < LOWEST or not seen.used[row, line - 2 : line + 3].all():
                continue
            error = float(np.hypot(0.3 * step / dip, PLACED))
            found.append(
                Antiresonance(
                    place_of[seen.postures[int(seen.posture[row])].id],
                    (int(seen.response[row, 0]), int(seen.response[row, 1])),
                    (int(seen.reference[row, 0]), int(seen.reference[row, 1])),
                    dip,
                    error,
                )
            )
    return tuple(found)

"""Does a campaign hold together? Every record belongs to something described, every number is a number."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from flexmodal.campaign.abscissa import evened
from flexmodal.campaign.blow import Blow
from flexmodal.campaign.description.axes import AXES, axes_fault
from flexmodal.campaign.description.tested import BAND, Described
from flexmodal.campaign.mode_table import ModeTable
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.trial import MOST_DIGITS, MOST_TRIAL
from flexmodal.errors import Fault
from flexmodal.text.words import FaultList, listing, shown

DIRECTIONS = (-3, -2, -1, 1, 2, 3)
ROUNDING = 1e-6
"""How far above 1 a coherence may lie by rounding."""


def campaign_faults(
    tested: Described,
    frfs: FrfRecords | None,
    blows: Sequence[Blow],
    modes: ModeTable | None,
    path: Path | None,
) -> list[Fault]:
    """Every contradiction of a campaign in memory.

    Args:
        tested: what is said of its postures, points, trials and band.
        frfs: its FRFs, if any.
        blows: its hammer blows.
        modes: its modes, if any.
        path: where it was read from, for the faults.
    """
    faults = FaultList(path or Path("campaign"))
    add_contradictions(faults, tested)
    for section, most in (("postures", MOST_DIGITS), ("points", MOST_DIGITS), ("trials", MOST_TRIAL)):
        for entry in getattr(tested, section):
            if not 1 <= entry.id <= most:
                faults.add(section, f"the id {entry.id}", f"a whole number from 1 to {most}")
    if frfs is not None:
        _add_frf_faults(faults, tested, frfs)
    for blow in blows:
        _add_blow_faults(faults, tested, blow)
    if modes is not None:
        _add_mode_faults(faults, tested, modes)
    return faults.faults


def add_contradictions(faults: FaultList, tested: Described) -> None:
    """Add a fault for each id or name given twice, repeat of no trial, trace line astray, band backward.

    Args:
        faults: where they go.
        tested: what is said of the postures, points, trials and band.
    """
    for section, entries in (("posture", tested.postures), ("point", tested.points)):
        _add_twice(faults, section, "id", [entry.id for entry in entries])
        _add_twice(faults, section, "name", [entry.name for entry in entries])
    for place, point in enumerate(tested.points):
        odd = None if point.axes is None else axes_fault(point.axes)
        if odd is not None:
            faults.add(f"point[{place}].axes", odd, AXES)
    _add_twice(faults, "trial", "id", [trial.id for trial in tested.trials])
    ids = {trial.id for trial in tested.trials}
    for place, trial in enumerate(tested.trials):
        if trial.repeat_of is not None and trial.repeat_of not in ids - {trial.id}:
            faults.add(f"trial[{place}].repeat_of", str(trial.repeat_of), "the id of another trial")
    names = {point.name for point in tested.points}
    for place, posture in enumerate(tested.postures):
        if strange := sorted(set(posture.masses) - names):
            allowed = f"names of points of this campaign: {listing(sorted(names))}"
            faults.add(f"posture[{place}].masses", listing(map(repr, strange)), allowed)
        if len(set(posture.locked)) < len(posture.locked):
            faults.add(f"posture[{place}].locked", "a joint named twice", "each joint once")
    known = {point.id for point in tested.points}
    for place, line in enumerate(tested.trace_lines):
        strangers = sorted({one for one in line if one not in known})
        if strangers or len(line) < 2:
            found = f"point {listing(map(str, strangers))}" if strangers else f"{len(line)} ids"
            faults.add(f"trace_lines[{place}]", found, "two or more ids of points of this campaign")
    if tested.band is not None and not 0 <= tested.band[0] < tested.band[1]:
        faults.add("band", f"{tested.band[0]:g} to {tested.band[1]:g}", BAND)


def _add_twice(faults: FaultList, section: str, key: str, values: Sequence[object]) -> None:
    for place, value in enumerate(values):
        if value in values[:place]:
            first = values.index(value)
            faults.add(
                f"{section}[{place}].{key}", f"{shown(value)}, as in {section}[{first}]", "one of its own"
            )


def _add_frf_faults(faults: FaultList, tested: Described, frfs: FrfRecords) -> None:
    frequency = frfs.frequency
    if len(frequency) < 2 or not np.all(np.isfinite(frequency)) or frequency[0] < 0:
        faults.add(
            "frfs", "a frequency axis that is short, negative or not finite", "two lines or more, in Hz"
        )
    elif np.min(np.diff(frequency)) <= 0:
        faults.add("frfs", "frequencies that do not ascend", "ascending frequencies in Hz")
    if not len(frfs):
        faults.add("frfs", "no records", "one or more, or none at all as None")
    if not np.all(np.isfinite(frfs.value)):
        faults.add("frfs", "values that are not finite", "finite values")
    coherence = frfs.coherence
    if coherence is not None:
        wrong = np.argwhere(~((coherence >= 0) & (coherence <= 1 + ROUNDING)))
        if len(wrong):
            row, line = wrong[0]
            where = f"posture {frfs.posture[row]}, trial {frfs.trial[row]}, record {row + 1}"
            found = (
                f"a coherence outside 0 to 1, {coherence[row, line]:g} at {frequency[line]:g} Hz of {where}"
            )
            faults.add("frfs", found, "coherences from 0 to 1")
    _add_unknown(faults, "frfs", "posture", frfs.posture.tolist(), tested.postures)
    _add_unknown(faults, "frfs", "trial", frfs.trial.tolist(), tested.trials)
    for name in ("response", "reference"):
        places = getattr(frfs, name)
        _add_unknown(faults, "frfs", f"{name} point", places[:, 0].tolist(), tested.points)
        strange = set(places[:, 1].tolist()) - set(DIRECTIONS)
        if strange:
            faults.add("frfs", f"{name} directions {listing(map(str, sorted(strange)))}", "±1 ±2 ±3")


def _add_blow_faults(faults: FaultList, tested: Described, blow: Blow) -> None:
    key = f"blow {blow.sequence} of posture {blow.posture}, trial {blow.trial}"
    _add_unknown(faults, key, "posture", [blow.posture], tested.postures)
    _add_unknown(faults, key, "trial", [blow.trial], tested.trials)
    places = (blow.reference, *blow.channels)
    _add_unknown(faults, key, "point", [point for point, _ in places], tested.points)
    if any(direction not in DIRECTIONS for _, direction in places):
        faults.add(key, "a direction that is none of the six", "±1 ±2 ±3")
    numbers = (blow.time, blow.force, blow.response)
    if len(blow.time) < 2 or not all(np.all(np.isfinite(part)) for part in numbers):
        faults.add(key, "records that are short or not finite", "two finite samples or more")
        return
    if not blow.time[0] < blow.time[-1] or evened(blow.time) is None:
        faults.add(key, "samples that are not evenly spaced in time", "one time step throughout")
    if not np.any(blow.force):
        faults.add(key, "a force that is zero throughout", "a blow")


def _add_mode_faults(faults: FaultList, tested: Described, modes: ModeTable) -> None:
    _add_unknown(faults, "modes", "posture", modes.posture.tolist(), tested.postures)
    for name in ("response", "reference"):
        _add_unknown(faults, "modes", f"{name} point", getattr(modes, name).tolist(), tested.points)
    if np.any(modes.natural_frequency <= 0) or np.any(np.isinf(modes.natural_frequency)):
        faults.add(
            "modes", "a natural frequency that is not above 0", "a frequency in Hz, or NaN where missing"
        )
    if np.any(np.isinf(modes.damping_ratio)) or np.any(np.isinf(modes.amplitude)):
        faults.add("modes", "an infinite damping ratio or amplitude", "finite numbers, or NaN where missing")


def _add_unknown(faults: FaultList, key: str, what: str, ids: Iterable[int], among: Iterable[object]) -> None:
    known = [entry.id for entry in among]  # type: ignore[attr-defined]
    unknown = sorted(set(ids) - set(known))
    if unknown:
        shown = listing(map(str, unknown[:10]))
        faults.add(key, f"{what} {shown}", f"one that is described: {listing(map(str, known[:50]))}")

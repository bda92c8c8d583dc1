"""From the records of `time.uff` to blows: a force history and the responses that share its axis."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmodal.campaign.abscissa import evened, same_axis
from flexmodal.campaign.blow import Blow
from flexmodal.campaign.description.tested import Tested
from flexmodal.campaign.uff.codes import FORCE, QUANTITY_OF, TIME_RESPONSE
from flexmodal.campaign.uff.records import Labelled, read_records
from flexmodal.text.words import FaultList

Key = tuple[int, int, int, int, int]


def read_time_uff(file: Path, tested: Tested, faults: FaultList, warnings: list[str]) -> tuple[Blow, ...]:
    """Read `time.uff`; faults go to `faults`, and what is sound comes back.

    Args:
        file: a universal file.
        tested: what was tested; records have to fit it.
        faults: where the faults of the file go.
        warnings: where sentences about what is odd go.
    """
    before = len(faults.faults)
    found = read_records(file, tested, (TIME_RESPONSE,), faults, warnings)
    if len(faults.faults) > before:
        return ()  # what belongs together cannot be told while records are missing
    forces: dict[Key, Labelled] = {}
    responses: dict[Key, list[Labelled]] = {}
    for one in found:
        key = (one.posture, one.trial, one.header.sequence, *one.header.reference)
        if np.iscomplexobj(one.record.value):
            faults.add(one.key, "a time history of complex values", "real values")
        elif one.header.numerator.code != FORCE:
            responses.setdefault(key, []).append(one)
        elif one.header.response != one.header.reference:
            faults.add(one.key, "a force whose response and reference differ", "response = reference")
        elif key in forces:
            faults.add(one.key, f"the force of {forces[key].key} again", "another sequence number")
        else:
            forces[key] = one
    for key, ones in responses.items():
        if key not in forces:
            says = f"the force at {key[3]} {key[4]:+d}, posture {key[0]}, trial {key[1]}, sequence {key[2]}"
            faults.add(ones[0].key, "a response without its force", says)
    blows = [_blows(force, responses.get(key, []), faults) for key, force in forces.items()]
    return tuple(blow for several in blows for blow in several)


def _blows(force: Labelled, responses: list[Labelled], faults: FaultList) -> list[Blow]:
    """One blow for each quantity that was measured with this force; none where faults were found."""
    before = len(faults.faults)
    time = force.record.abscissa
    even = evened(time)
    if even is None:
        faults.add(force.key, "samples that are not evenly spaced", "one time step throughout")
    if not np.any(force.record.value):
        faults.add(force.key, "a force that is zero throughout", "a blow")
    if not responses:
        faults.add(force.key, "a force without a response", "one response at least")
    seen: dict[tuple[int, int], str] = {}
    for one in responses:
        other = one.record.abscissa
        if not same_axis(time, other):
            found = f"{len(other)} samples from {other[0]:g} to {other[-1]:g} s"
            faults.add(f"{one.key}: abscissa", found, f"that of its force, {force.key}")
        if one.header.response in seen:
            faults.add(one.key, f"the response of {seen[one.header.response]} again", "each once in a blow")
        seen.setdefault(one.header.response, one.key)
    if len(faults.faults) > before or even is None:
        return []
    kinds = dict.fromkeys(one.header.numerator.code for one in responses)
    return [_blow(force, even, [r for r in responses if r.header.numerator.code == kind]) for kind in kinds]


def _blow(force: Labelled, time: np.ndarray, responses: list[Labelled]) -> Blow:
    return Blow(
        posture=force.posture,
        trial=force.trial,
        sequence=force.header.sequence,
        reference=force.header.reference,
        time=time,
        force=np.asarray(force.record.value, dtype=float),
        channels=tuple(one.header.response for one in responses),
        response=np.array([one.record.value for one in responses], dtype=float),
        quantity=QUANTITY_OF[responses[0].header.numerator.code],
    )

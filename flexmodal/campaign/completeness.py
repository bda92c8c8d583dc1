"""Whether the records of a campaign are all there: a file may have lost its end where a record ended."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from flexmodal.campaign.blow import Blow
from flexmodal.campaign.description.tested import Tested
from flexmodal.campaign.records import FrfRecords

_NAMED = 3


def frf_gaps(file: Path, frfs: FrfRecords, tested: Tested) -> list[str]:
    """What `frf.uff` does not hold, though the campaign says or other postures show that it was measured.

    Args:
        file: for the sentences.
        frfs: its FRFs.
        tested: what was tested.
    """
    places = [
        (int(posture), int(trial), (*map(abs, response), *map(abs, reference)))
        for posture, trial, response, reference in zip(
            frfs.posture.tolist(),
            frfs.trial.tolist(),
            frfs.response.tolist(),
            frfs.reference.tolist(),
            strict=True,
        )
    ]
    return _gaps(file, "FRF", places, tested)


def blow_gaps(file: Path, blows: Iterable[Blow], tested: Tested) -> list[str]:
    """Likewise of `time.uff`.

    Args:
        file: for the sentences.
        blows: what it holds.
        tested: what was tested.
    """
    places = [(blow.posture, blow.trial, (*blow.reference, *blow.channels)) for blow in blows]
    return _gaps(file, "blow", places, tested)


def _gaps(
    file: Path, what: str, records: list[tuple[int, int, tuple[object, ...]]], tested: Tested
) -> list[str]:
    held: dict[int, set[tuple[object, ...]]] = {posture.id: set() for posture in tested.postures}
    for posture, trial, place in records:
        held[posture].add((trial, place))
    found = []
    names = {posture.id: posture.name for posture in tested.postures}
    missing = [names[number] for number, places in held.items() if not places]
    if missing:
        found.append(f"{file}: no {what} of posture {', '.join(missing)}: is the file whole?")
    untried = {trial.id for trial in tested.trials} - {trial for _, trial, _ in records}
    if untried:
        found.append(f"{file}: no {what} of trial {', '.join(map(str, sorted(untried)))}: is the file whole?")
    most = max(map(len, held.values()))
    short = [f"{names[n]} {len(places)}" for n, places in held.items() if 0 < len(places) < most]
    if short:
        more = ", …" * (len(short) > _NAMED)
        kinds = f"kinds of {what} of posture {', '.join(short[:_NAMED])}{more}"
        found.append(f"{file}: fewer {kinds}, where another has {most}: is the file whole?")
    return found

"""Which records have a signal in them, before anything is fitted to them."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from flexmodal.campaign import COHERENT, Campaign, FrfRecords, is_coherent
from flexmodal.errors import Fault, InvalidRequest

COHERENT_SHARE = 0.15
"""Part of the lines that have to be coherent for a record to count as a measurement."""
ROUGH = 0.5
"""Part of the power that is not shared with the lines beside, from which on a record is nothing but noise."""
RANGE = 1e-9
"""Part of the largest response that no analyser resolves beside it, 180 dB: a zero but for rounding."""
ENOUGH = 20
"""Lines from which that can be told."""


def with_signal(frfs: FrfRecords, campaign: Campaign) -> tuple[FrfRecords, tuple[str, ...]]:
    """Records with a signal in them, and the names of the others.

    A sensor that sits where nothing moves along its axis records noise. With few averages some lines of noise
    are coherent by chance: one in 25 above 0.8 with three averages.

    Args:
        frfs: the records.
        campaign: they belong to.

    Raises:
        InvalidRequest: there is none.
    """
    kept = has_signal(frfs, campaign)
    names = [
        f"posture {int(frfs.posture[row])}, response {frfs.response[row].tolist()}, "
        f"reference {frfs.reference[row].tolist()}, trial {int(frfs.trial[row])}"
        for row in np.flatnonzero(~kept)
    ]
    return frfs.take(np.flatnonzero(kept)), tuple(names)


def has_signal(frfs: FrfRecords, campaign: Campaign) -> Bool[np.ndarray, " record"]:
    """Which records have a signal in them; see `with_signal`.

    Args:
        frfs: records of a campaign.
        campaign: whose name an error bears.

    Raises:
        InvalidRequest: none has.
    """
    coherent = np.ones(len(frfs), dtype=bool)
    if frfs.coherence is not None:
        coherent = np.mean(is_coherent(frfs.coherence), axis=1) >= COHERENT_SHARE
    size = np.abs(frfs.value).max(axis=1)
    there = size > RANGE * size.max()
    kept = coherent & there & (roughness(frfs) < ROUGH)
    if not kept.any():
        found = f"coherence below {COHERENT:g} on nearly every line of every record"
        if not there.any():
            found = "records that are zero throughout"
        elif (coherent & there).any():
            found = "nothing but noise: each line has nothing to do with those beside it"
        allowed = "records with a signal in them"
        raise InvalidRequest(Fault(str(campaign.path or "campaign"), "frfs", found, allowed))
    return np.asarray(kept)


def roughness(frfs: FrfRecords) -> Float[np.ndarray, " record"]:
    """Median over the lines of the part of |H|² that is not linear from line to line: 0.9 for white noise.

    Of three lines the second difference, 1 −2 1, takes a third of the power of noise and next to nothing of a
    response that the lines resolve; of noise the threefold part follows 3 Beta(1, 2), whose median is
    3 (1 − √½) = 0.88. Zero for fewer lines than `ENOUGH`.
    """
    value = frfs.value
    if value.shape[1] < ENOUGH:
        return np.zeros(len(value))
    jump = np.abs(value[:, 2:] - 2 * value[:, 1:-1] + value[:, :-2]) ** 2 / 6
    square = np.abs(value) ** 2
    power = (square[:, 2:] + square[:, 1:-1] + square[:, :-2]) / 3
    return np.median(np.where(power > 0, jump / np.where(power > 0, power, 1.0), 0.0), axis=1)

"""What can be wrong with a blow or an averaged FRF, named where it happened."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.campaign.blow import Blow
from flexmodal.campaign.campaign import Campaign
from flexmodal.campaign.coherence import COHERENT
from flexmodal.campaign.quality_flag import FlagKind, QualityFlag
from flexmodal.campaign.records import FrfRecords

EQUAL = 1e-6
"""Relative difference below which neighbouring samples count as one flat top."""


@dataclass(frozen=True)
class QualityLimits:
    """What counts as odd."""

    second_hit: float = 0.15
    """A second pulse that stands out by this part of the first; less is the ringing of filters."""
    lasting: float = 0.1
    """A force that is larger than `second_hit` of its peak for this part of the record is a sweep or a random
    force and no blow, of which nobody expects a single pulse."""
    flat_top: int = 3
    """As many samples at the extreme value, one after the other, are an overload."""
    energy: float = 20.0
    """How far the spectrum of the force may fall below its maximum inside the band [dB]."""
    coherence: float = COHERENT
    """The median over the band has to reach it."""


def check_blows(
    blows: Iterable[Blow], band: tuple[float, float], limits: QualityLimits | None = None
) -> tuple[QualityFlag, ...]:
    """Double hits, overloads and forces without energy in the band [Hz].

    Args:
        blows: time records.
        band: the lines of interest [Hz].
        limits: what counts as odd.
    """
    limits = limits or QualityLimits()
    return tuple(flag for blow in blows for flag in _blow_flags(blow, band, limits))


def check_campaign_quality(
    campaign: Campaign, records: FrfRecords, limits: QualityLimits | None = None
) -> tuple[QualityFlag, ...]:
    """What is odd about the blows of a campaign and about the FRFs that are used of it.

    Args:
        campaign: its blows, where it has any, its band and trials.
        records: its FRFs, or those estimated from its blows. The coherence of a single blow is 1 and says
            nothing.
        limits: what counts as odd.
    """
    limits = limits or QualityLimits()
    flags = list(check_blows(campaign.blows, campaign.band, limits))
    if records.coherence is not None:
        for row, coherence in enumerate(records.coherence):
            response, reference = (
                (int(place[row, 0]), int(place[row, 1])) for place in (records.response, records.reference)
            )
            labels = (int(records.posture[row]), int(records.trial[row]), response, reference)
            flag = coherence_flag(coherence, records.frequency, campaign.band, labels, limits)
            flags += [flag] if flag is not None else []
    return tuple(flags)


def coherence_flag(
    coherence: Float[np.ndarray, " line"],
    frequency: Float[np.ndarray, " line"],
    band: tuple[float, float],
    labels: tuple[int, int, tuple[int, int], tuple[int, int]],
    limits: QualityLimits,
) -> QualityFlag | None:
    """A flag where the median coherence over the band is low; labels: posture, trial, response, reference.

    Args:
        coherence: of one record, 0 to 1.
        frequency: of its lines [Hz].
        band: the lines of interest [Hz].
        labels: posture, trial, response, reference.
        limits: what counts as odd.
    """
    inside = (frequency >= band[0]) & (frequency <= band[1])
    if not inside.any() or np.median(coherence[inside]) >= limits.coherence:
        return None
    point, direction = labels[3]
    says = f"median {np.median(coherence[inside]):.2f} from {band[0]:g} to {band[1]:g} Hz"
    says += f", force at point {point} direction {direction:+d}"
    return QualityFlag("low coherence", labels[0], labels[1], None, labels[2], says)


def _blow_flags(blow: Blow, band: tuple[float, float], limits: QualityLimits) -> list[QualityFlag]:
    found: list[tuple[FlagKind, tuple[int, int], str]] = []
    hits = [] if _lasts(blow, limits) else _hits(blow, limits.second_hit)
    if len(hits) > 1:
        times = ", ".join(f"{1e3 * time:.1f}" for time in hits[:5])
        found.append(("double hit", blow.reference, f"{len(hits)} pulses, at {times} ms"))
    channels = ((blow.reference, blow.force), *zip(blow.channels, blow.response, strict=True))
    for point, values in channels:
        if _flat_top(values) >= limits.flat_top:
            says = f"{_flat_top(values)} samples at the extreme value {np.abs(values).max():.4g}"
            found.append(("overload", point, says))
    lacking = _lacking_energy(blow, band, limits.energy)
    if lacking is not None:
        says = f"the force falls {limits.energy:g} dB below its maximum at {lacking:.4g} Hz"
        found.append(("low energy in band", blow.reference, says))
    return [
        QualityFlag(kind, blow.posture, blow.trial, blow.sequence, point, says) for kind, point, says in found
    ]


def _lasts(blow: Blow, limits: QualityLimits) -> bool:
    """Whether the force goes on as no blow does; an offset of the cell is no force."""
    size = np.abs(blow.force - np.median(blow.force))
    return bool(np.mean(size > limits.second_hit * size.max()) > limits.lasting)


def _hits(blow: Blow, part: float) -> list[float]:
    """Times of the pulses of the force, measured from the start of the record [s]."""
    from scipy.signal import find_peaks

    peak = int(np.argmax(np.abs(blow.force)))
    force = blow.force * np.sign(blow.force[peak])
    padded = np.concatenate([[0.0], force, [0.0]])  # a pulse at either end of the record counts
    places, _ = find_peaks(padded, prominence=part * force[peak], height=part * force[peak])
    return [float(blow.time[place - 1] - blow.time[0]) for place in places]


def _flat_top(values: Float[np.ndarray, " sample"]) -> int:
    """The longest run of samples at the largest value, or at the smallest."""
    longest = 0
    for signed in (values, -values):
        top = signed.max()
        if top <= 0:
            continue
        at_top = np.concatenate([[False], signed >= top * (1 - EQUAL), [False]])
        edges = np.flatnonzero(np.diff(at_top.astype(int)))
        longest = max(longest, int((edges[1::2] - edges[::2]).max()))
    return longest


def _lacking_energy(blow: Blow, band: tuple[float, float], decibel: float) -> float | None:
    """The first frequency of the band where the force has too little energy, or None [Hz]."""
    frequency = np.fft.rfftfreq(len(blow.force), blow.step)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    size = np.abs(np.fft.rfft(blow.force))[inside]
    if not size.size:
        return None
    weak = np.flatnonzero(size < size.max() * 10 ** (-decibel / 20))
    return float(frequency[inside][weak[0]]) if weak.size else None

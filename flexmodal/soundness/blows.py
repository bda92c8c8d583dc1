"""What the time records of the blows show by themselves: second hits, overloads, drift, coupled force."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import Blow, Campaign, place_text
from flexmodal.soundness.finding import Finding

REBOUND = 0.02
"""Part of the first pulse from which a second one is looked at."""
ABOVE_NOISE = 8.0
"""Standard deviations of the quiet part of the force that it has to stand above."""
WEAK = 10 ** (-20 / 20)
"""Part of the force's largest spectral value below which a line is hardly struck."""
OFFSET = 0.15
"""Mean of a response over its root mean square from which it drifts; motion from rest to rest has none."""
UNDERSHOOT = 0.10
"""Part of a blow's impulse that has to come back after it for its channel to be coupled."""
EQUAL = 1e-12
"""Relative difference up to which two sizes are one."""
AT_TOP = 3
"""Samples at the largest size, of either sign and anywhere, from which a record was cut off."""
TWICE = 3
"""Records of a channel in one posture with two such samples each that mean the same."""
NAMED = 4


def blow_findings(campaign: Campaign) -> list[Finding]:
    """Look at every blow.

    Args:
        campaign: with or without blows.
    """
    if not campaign.blows:
        return []
    found = [*_overloads(campaign), *_drifts(campaign), *_double_hits(campaign)]
    coupled = [(blow, corner) for blow in campaign.blows if (corner := force_corner(blow)) is not None]
    if len(coupled) > len(campaign.blows) / 2:
        corner = float(np.median([one for _, one in coupled]))
        found.append(
            Finding(
                "AC coupling",
                "the force channel",
                f"in {len(coupled)} of {len(campaign.blows)} blows the force swings back after the pulse and "
                f"decays as behind a high pass of {corner:.2g} Hz",
                f"every FRF is too large and late below some {3 * corner:.2g} Hz",
                "measure with the force channel DC coupled, or take the corner out: flexmodal import "
                f"CAMPAIGN --without-coupling force={corner:.2g} --out DIR",
            )
        )
    return found


def force_corner(blow: Blow) -> float | None:
    """Corner of a first-order high pass that the force went through [Hz]; None where it shows none.

    After the pulse a high pass leaves −ω_c I e^(−ω_c t), I the impulse: its integral is −I, and its decay
    gives the corner. A free force is zero there.

    Args:
        blow: one record.
    """
    peak = int(np.argmax(np.abs(blow.force)))
    force = (blow.force - np.median(blow.force[: max(peak // 2, 1)])) * np.sign(blow.force[peak])
    below = np.flatnonzero(force[peak:] <= 0)
    if not below.size:
        return None
    end = peak + int(below[0]) + 2
    impulse, tail = float(force[:end].sum()), force[end:]
    if len(tail) < 16 or not impulse > 0:
        return None
    back = -float(tail.sum()) / impulse
    if back < UNDERSHOOT:
        return None
    total = np.cumsum(-tail)
    if not total[-1] > 0:
        return None
    # I e^(−ω_c t) of the impulse is still to come back; the slope of its logarithm where that is well known
    left = 1 - total / impulse
    kept = np.flatnonzero(left > 0.2)
    if kept.size < 4 or kept.size < kept[-1]:  # not a decay
        return None
    slope = np.polyfit(np.arange(kept.size) * blow.step, np.log(left[kept]), 1)[0]
    return float(-slope / (2 * np.pi)) if slope < 0 else None


def _overloads(campaign: Campaign) -> list[Finding]:
    cut: dict[tuple[int, tuple[int, int]], list[tuple[int, Blow]]] = {}
    for blow in campaign.blows:
        for place, values in ((blow.reference, blow.force), *zip(blow.channels, blow.response, strict=True)):
            most = float(np.abs(values).max())
            count = int(np.sum(np.abs(values) >= most * (1 - EQUAL))) if most > 0 else 0
            if count >= 2:
                cut.setdefault((blow.posture, place), []).append((count, blow))
    found = []
    for (_, place), here in cut.items():
        if len(here) < TWICE and max(count for count, _ in here) < AT_TOP:
            continue
        ids = [(blow.posture, blow.trial, blow.sequence) for _, blow in here]
        found.append(
            Finding(
                "overload",
                f"{place_text(place)} in {len(here)} blows: {_blows(ids)}",
                f"up to {max(count for count, _ in here)} samples stand at one largest size, of either sign",
                "what was cut off is missing in the FRF, at all frequencies",
                "a larger range or softer blows; leave these blows out",
            )
        )
    return found


def _drifts(campaign: Campaign) -> list[Finding]:
    worst: dict[tuple[int, int], list[tuple[float, Blow]]] = {}
    for blow in campaign.blows:
        for place, values in zip(blow.channels, blow.response, strict=True):
            size = float(np.sqrt(np.mean(values**2)))
            part = abs(float(np.mean(values))) / size if size > 0 else 0.0
            if blow.quantity == "acceleration" and part > OFFSET:
                worst.setdefault(place, []).append((part, blow))
    return [
        Finding(
            "drift",
            f"{place_text(place)} in {len(here)} blows: "
            f"{_blows([(b.posture, b.trial, b.sequence) for _, b in here])}",
            f"the mean of the record is up to {100 * max(part for part, _ in here):.0f} % of its root mean "
            "square, where motion from rest to rest has none",
            "the lowest lines of these FRFs are the drift's",
            "let the sensor warm up, look at its cable; leave these blows out, or raise the band's lower end",
        )
        for place, here in worst.items()
    ]


def _double_hits(campaign: Campaign) -> list[Finding]:
    """Harmless where every line of the band was struck: force and response both hold the second hit."""
    harmful: list[tuple[Blow, str]] = []
    harmless: list[tuple[Blow, str]] = []
    for blow in campaign.blows:
        second = second_hit(blow)
        if second is None:
            continue
        part, later = second
        weak = weak_share(blow, campaign.band)
        says = f"a second hit of {100 * part:.0f} % after {1e3 * later:.0f} ms"
        (harmful if weak > 0 else harmless).append(
            (blow, f"{says}, {100 * weak:.0f} % of the band hardly struck")
        )
    found = []
    for listed, fine in ((harmful, False), (harmless, True)):
        if listed:
            ids = [(blow.posture, blow.trial, blow.sequence) for blow, _ in listed]
            cost = (
                "it is in the force record too, and the force holds every line of the band: harmless"
                if fine
                else "lines at which the two hits cancel are all noise"
            )
            remedy = "none needed" if fine else "leave these blows out, or strike again"
            found.append(
                Finding("double hit", f"{len(ids)} blows: {_blows(ids)}", listed[0][1], cost, remedy, fine)
            )
    return found


def second_hit(blow: Blow) -> tuple[float, float] | None:
    """Size over the first and time after it [s] of the largest second pulse; None where there is none.

    Args:
        blow: one record.
    """
    from scipy.signal import find_peaks

    peak = int(np.argmax(np.abs(blow.force)))
    quiet = blow.force[: max(peak // 2, 1)]
    level = float(np.median(quiet))
    force = (blow.force - level) * np.sign(blow.force[peak] - level)
    noise = float(np.std(quiet)) if len(quiet) > 8 else 0.0
    least = max(REBOUND * force[peak], ABOVE_NOISE * noise)
    if np.mean(np.abs(force) > 0.15 * force[peak]) > 0.1:  # a sweep or a random force
        return None
    padded = np.concatenate([[0.0], force, [0.0]])
    places, _ = find_peaks(padded, prominence=least, height=least)
    ringing = _width(force, peak)
    others = [place - 1 for place in places if abs(place - 1 - peak) > 3 * ringing]
    if not others:
        return None
    largest = max(others, key=lambda place: force[place])
    return float(force[largest] / force[peak]), abs(largest - peak) * blow.step


def weak_share(blow: Blow, band: tuple[float, float]) -> float:
    """Part of the band in which the force has less than a tenth of its largest spectral value.

    Args:
        blow: one record.
        band: [Hz].
    """
    frequency = np.fft.rfftfreq(len(blow.force), blow.step)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    size: Float[np.ndarray, " line"] = np.abs(np.fft.rfft(blow.force))[inside]
    return float(np.mean(size < WEAK * size.max())) if size.size else 0.0


def _width(force: Float[np.ndarray, " sample"], peak: int) -> int:
    """Samples that the pulse is above half of its peak, two at least."""
    below = np.flatnonzero(force < force[peak] / 2)
    before, after = below[below < peak], below[below > peak]
    first = int(before[-1]) if before.size else 0
    last = int(after[0]) if after.size else len(force) - 1
    return max(last - first, 2)


def _blows(ids: Sequence[tuple[int, int, int | None]] | Iterable[tuple[int, int, int | None]]) -> str:
    """Postures and trials of blows, the commonest first."""
    counts = Counter((posture, trial) for posture, trial, _ in ids).most_common()
    named = [f"posture {p} trial {t}" for (p, t), _ in counts[:NAMED]]
    return ", ".join(named) + (", …" if len(counts) > NAMED else "")

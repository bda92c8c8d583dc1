"""What FRFs show without a model: drive points, reciprocity, whether they are those of their blows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign import Campaign, FrfRecords, estimate_frfs, place_text
from flexmodal.errors import InvalidInput
from flexmodal.soundness.finding import Finding

TURNED = 0.6
"""Part of the lines of a drive point with negative power from which its sign is wrong."""
AWAY = 0.15
"""Root mean square of |ln| from which two FRFs that should be one are not."""
CLEAR = 0.95
"""Coherence of lines that are compared with each other."""
CLEAR_SHARE = 0.3
"""Of all lines, that have to be so clear."""
OF_BLOWS = 0.1
"""The same of FRFs and the H1 of their own blows."""
NAMED = 4


def record_findings(campaign: Campaign, records: FrfRecords) -> list[Finding]:
    """Look at FRFs.

    Args:
        campaign: with its band and points.
        records: its FRFs, or those of its blows.
    """
    inside = (records.frequency >= campaign.band[0]) & (records.frequency <= campaign.band[1])
    inside &= records.frequency > 0
    if not inside.any():
        return []
    kept = replace(
        records,
        frequency=records.frequency[inside],
        value=records.value[:, inside],
        coherence=None if records.coherence is None else records.coherence[:, inside],
    ).positive()
    return [*_drive_points(kept), *_reciprocity(kept), *_against_blows(campaign)]


def _drive_points(records: FrfRecords) -> list[Finding]:
    """The real part of a drive-point mobility is the power that goes in: never negative in a passive body."""
    mobility = records.to("mobility")
    turned: dict[tuple[int, int], list[tuple[int, float]]] = {}
    for row in range(len(records)):
        if not np.array_equal(records.response[row], records.reference[row]):
            continue
        weight = (
            records.weight[row]
            * np.abs(mobility.value[row].real)
            / np.maximum(np.abs(mobility.value[row]), 1e-300)
        )
        if not weight.sum() > 0:
            continue
        share = float(weight[mobility.value[row].real < 0].sum() / weight.sum())
        if share > TURNED:
            place = (int(records.response[row, 0]), int(records.response[row, 1]))
            turned.setdefault(place, []).append((int(records.posture[row]), share))
    return [
        Finding(
            "drive point",
            f"{place_text(place)} in posture {_ids([posture for posture, _ in rows])}",
            f"{100 * max(share for _, share in rows):.0f} % of the drive-point FRF would give power back",
            "hammer and sensor point opposite ways: every phase of this channel is off by 180°",
            "turn the sense of the sensor or of the hammer in its records",
        )
        for place, rows in turned.items()
    ]


def _reciprocity(records: FrfRecords) -> list[Finding]:
    """H of a at b is H of b at a."""
    rows: dict[tuple[int, ...], int] = {}
    for row in range(len(records)):
        key = (int(records.posture[row]), int(records.trial[row]))
        rows[(*key, *map(int, records.response[row]), *map(int, records.reference[row]))] = row
    worst: dict[tuple[int, ...], list[tuple[int, float, float]]] = {}
    for (posture, trial, p, d, q, e), row in rows.items():
        other = rows.get((posture, trial, q, e, p, d))
        if other is None or (p, d) >= (q, e):
            continue
        there = (records.value[row] != 0) & (records.value[other] != 0)
        if records.coherence is not None:
            there &= np.minimum(records.coherence[row], records.coherence[other]) > CLEAR
        if there.mean() < CLEAR_SHARE:
            continue
        ratio = np.log(records.value[row][there] / records.value[other][there])
        middle = np.array([np.median(ratio.real), np.median(np.abs(ratio.imag))])
        if np.abs(middle[0]) > AWAY or middle[1] > 2 * AWAY:
            worst.setdefault((p, d, q, e), []).append((posture, float(middle[0]), float(middle[1])))
    found = []
    for (p, d, q, e), cases in worst.items():
        size, phase = (float(np.median([case[k] for case in cases])) for k in (1, 2))
        found.append(
            Finding(
                "reciprocity",
                f"{place_text((p, d))} and {place_text((q, e))} in posture {_ids([one[0] for one in cases])}",
                f"struck and sensed the other way round the FRF is {np.exp(size):.3g} times as large and "
                f"{np.degrees(phase):.0f}° apart on half of its lines",
                "one of the two is not what its label says: scale, sign, direction or place",
                "look at sensitivity, sense and place of both; a linear body gives the same both ways",
            )
        )
    return found


def _against_blows(campaign: Campaign) -> list[Finding]:
    """FRFs of an analyser beside the H1 of the blows that lie beside them."""
    if campaign.frfs is None or not campaign.blows:
        return []
    try:
        own = estimate_frfs(campaign).to(campaign.frfs.form)
    except InvalidInput:
        return []
    rows = {_key(own, row): row for row in range(len(own))}
    frfs = campaign.frfs.positive()
    own = own.positive()
    low, high = campaign.band
    away: dict[int, list[float]] = {}
    for row in range(len(frfs)):
        other = rows.get(_key(frfs, row))
        if other is None:
            continue
        axis = frfs.frequency[(frfs.frequency >= low) & (frfs.frequency <= high) & (frfs.frequency > 0)]
        if len(own.frequency) < 2 or not axis.size:
            continue
        value = np.interp(axis, own.frequency, own.value[other].real) + 1j * np.interp(
            axis, own.frequency, own.value[other].imag
        )
        given = frfs.value[row][np.searchsorted(frfs.frequency, axis)]
        there = (value != 0) & (given != 0)
        ratio = np.abs(np.log(given[there] / value[there]))
        if ratio.size and np.median(ratio) > OF_BLOWS:
            away.setdefault(int(frfs.posture[row]), []).append(float(np.median(ratio)))
    if not away:
        return []
    most = max(value for values in away.values() for value in values)
    count = sum(map(len, away.values()))
    return [
        Finding(
            "FRFs against blows",
            f"{count} records, posture {_ids(list(away))}",
            f"half of their lines are {most:.2g} and more (|ln|) away from the H1 of their own blows",
            "FRFs and blows are not of the same test, or one of them was scaled, filtered or mislabelled",
            "say which of the two is right and leave the other out",
        )
    ]


def _key(records: FrfRecords, row: int) -> tuple[int, ...]:
    places = (*records.response[row].tolist(), *records.reference[row].tolist())
    return (int(records.posture[row]), int(records.trial[row]), *map(abs, places))


def _ids(ids: list[int]) -> str:
    every = sorted(set(ids))
    return ", ".join(map(str, every[:NAMED])) + (", …" if len(every) > NAMED else "")

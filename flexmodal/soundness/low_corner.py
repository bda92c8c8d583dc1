"""High passes of AC-coupled channels: their corner from the phase of the lowest lines, and taking them out.

Behind a first-order high pass a response reads H · iω/(iω + ω_c), whose phase leads by atan(f_c/f). What the
model has wrong of a resonance turns the phase of every channel alike; so of each line the median of the other
channels under the same blows is taken off first. The corner is the one that leaves the least mean deviation,
a line counting by 1/f, as the lead does. Lower and upper half of the lines agree on it; a delay, a lag or a
wrong stiffness makes two.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import FrfRecords, place_text
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.soundness.finding import Finding

LOW = 0.25
"""Part of the lines, from the lowest, in which a corner is looked for."""
FEWEST = 8
"""Usable lines among them."""
LEAST = 0.15
"""Corner over the lowest line from which it matters: 9° of phase there. In 180 clean channels on which both
halves agree it is 0.06 at most."""
BETTER = 0.9
"""Part of the mean deviation of phase that a corner has to leave at most; clean channels leave 0.93."""
ALONE = 0.7
"""The same where there is no other channel to take the median of."""
LARGEST = 2.5
"""Deviation of phase beyond which a line says nothing of a lead [rad]."""
ALIKE = 2.0
"""Factor within which lower and upper half of these lines agree on the corner."""


def corner_findings(
    observations: Observations, model: Complex[np.ndarray, "observation line"]
) -> list[Finding]:
    """Channels whose low lines lead as behind a high pass.

    Args:
        observations: what was measured.
        model: receptances of every observation [m/N].
    """
    found = []
    for place in np.unique(observations.response, axis=0):
        rows = np.flatnonzero(np.all(observations.response == place, axis=1))
        corner = low_corner(observations, model, rows)
        if corner is None:
            continue
        where = place_text((int(place[0]), int(place[1])))
        found.append(
            Finding(
                "AC coupling",
                where,
                f"its lowest lines lead as behind a high pass of {corner:.2g} Hz",
                f"stiffness and damping are read wrongly below some {3 * corner:.2g} Hz",
                "measure DC coupled, or take the corner out: flexmodal import CAMPAIGN --without-coupling "
                f"{where}={corner:.2g} --out DIR",
            )
        )
    return found


def low_corner(
    observations: Observations, model: Complex[np.ndarray, "observation line"], rows: np.ndarray
) -> float | None:
    """Corner of the high pass that some records went through [Hz]; None where they show none.

    Args:
        observations: what was measured.
        model: receptances of every observation [m/N].
        rows: numbers of the observations of one channel.
    """
    frequency = observations.records.frequency
    low = np.arange(len(frequency)) < max(FEWEST, int(LOW * len(frequency)))
    every = np.where(observations.used, -residual(model, observations.value).imag, np.nan)
    leads, lines, beside = [], [], False
    for row in rows.tolist():
        common = _common(observations, every, row)
        used = low & observations.used[row] & (np.abs(every[row]) < LARGEST)
        beside = beside or bool(np.any(np.isfinite(common)))
        leads.append((every[row] - np.where(np.isfinite(common), common, 0.0))[used])
        lines.append(frequency[used])
    lead, at = np.concatenate(leads), np.concatenate(lines)
    if lead.size < FEWEST:
        return None
    corner, left = _best(lead, at)
    most = BETTER if beside else ALONE
    if corner < LEAST * float(at.min()) or left > most * float(np.average(np.abs(lead), weights=1 / at)):
        return None
    order = np.sort(at)
    split = order[int(np.searchsorted(np.cumsum(1 / order), np.sum(1 / order) / 2))]
    for part in (at <= split, at > split):
        if part.any() and not 1 / ALIKE < _best(lead[part], at[part])[0] / corner < ALIKE:
            return None
    return corner


def _common(
    observations: Observations, lead: Float[np.ndarray, "observation line"], row: int
) -> Float[np.ndarray, " line"]:
    """Median of the other channels in the same posture under the same blows; NaN where there is none."""
    same = observations.posture == observations.posture[row]
    same &= np.all(observations.reference == observations.reference[row], axis=1)
    same &= observations.level == observations.level[row]
    same &= ~np.all(observations.response == observations.response[row], axis=1)
    others = lead[same]
    there = np.any(np.isfinite(others), axis=0) if len(others) else np.zeros(lead.shape[1], bool)
    found = np.full(lead.shape[1], np.nan)
    found[there] = np.nanmedian(others[:, there], axis=0)
    return found


def _best(lead: Float[np.ndarray, " one"], at: Float[np.ndarray, " one"]) -> tuple[float, float]:
    """Corner with the least mean deviation of phase [Hz], and that deviation [rad]."""
    corners = np.concatenate([[0.0], np.geomspace(0.02, 5.0, 120) * float(at.min())])
    away = np.abs(lead - np.arctan(corners[:, None] / at)) @ (1 / at) / np.sum(1 / at)
    best = int(np.argmin(away))
    return float(corners[best]), float(away[best])


def without_coupling(
    records: FrfRecords, corner: float, *, response: tuple[int, int] | None = None, force: bool = False
) -> FrfRecords:
    """Take a first-order high pass out of FRFs.

    Args:
        records: as they were measured.
        corner: of the high pass [Hz].
        response: point and direction of the channel that it was in; every one if None.
        force: whether it was in the force channel instead.

    Raises:
        InvalidRequest: a corner that is no frequency above 0.
    """
    if not (np.isfinite(corner) and corner > 0):
        raise InvalidRequest(Fault("call", "corner", repr(corner), "a frequency above 0 Hz"))
    frequency: Float[np.ndarray, " line"] = records.frequency
    with np.errstate(divide="ignore"):
        passed = 1j * frequency / (1j * frequency + corner)
        factor = passed if force else np.where(frequency > 0, 1 / np.where(frequency > 0, passed, 1), 0)
    here = np.ones(len(records), bool)
    if response is not None:
        here = np.all(np.abs(records.response) == np.abs(response), axis=1)
    return replace(records, value=np.where(here[:, None], records.value * factor, records.value))

"""From hammer blows to FRFs: H1, H2, Hv and coherence, averaged over the blows of a trial.

With S_ff, S_rr the auto spectra of force and response and S_fr = mean(F* R):

    H1 = S_fr / S_ff            unbiased where only the response is noisy
    H2 = S_rr / S_rf            unbiased where only the force is noisy
    Hv = S_fr/|S_fr| · sqrt(S_rr / S_ff)        the geometric mean of the two
    γ² = |S_fr|² / (S_ff S_rr)

Source: Bendat and Piersol, Random Data, chapters 5 to 7; Rocklin, Crowley and Vold 1985 for Hv.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign.band_pass import band_pass_blow
from flexmodal.campaign.blow import FORM_OF, Blow
from flexmodal.campaign.campaign import Campaign, default_band
from flexmodal.campaign.quality import QualityLimits, check_blows, coherence_flag
from flexmodal.campaign.quality_flag import QualityFlag
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.trial import Trial
from flexmodal.campaign.window import windowed
from flexmodal.errors import Fault, InvalidCampaign, InvalidRequest
from flexmodal.frf import POWER, Form
from flexmodal.frf.form import convert

Estimator = Literal["H1", "H2", "Hv"]

NOTHING = 1e-30
"""Part of the largest power below which a line holds no force at all; such a line is 0 with coherence 0."""


@dataclass(frozen=True, eq=False)
class _Record:
    """One estimated FRF."""

    posture: int
    trial: int
    response: tuple[int, int]
    reference: tuple[int, int]
    form: Form
    blows: int
    frequency: Float[np.ndarray, " line"]
    value: Complex[np.ndarray, " line"]
    coherence: Float[np.ndarray, " line"]


def estimate_frfs(
    source: Campaign | Iterable[Blow],
    *,
    estimator: str = "H1",
    trials: Sequence[Trial] | None = None,
    band: tuple[float, float] | None = None,
    band_pass: tuple[float, float] | None = None,
    limits: QualityLimits | None = None,
) -> FrfRecords:
    """Estimate FRFs from blows, one record for each posture, trial, response and reference.

    Args:
        source: a campaign with blows, or the blows.
        estimator: H1, H2 or Hv.
        trials: what is known of the trials; of a campaign, its own. Their windows are applied to the blows.
        band: the lines that the quality flags look at [Hz]; of a campaign, its own.
        band_pass: keep only this band of the time records first [Hz], see `band_pass_blow`; by default not.
        limits: of the quality flags.

    Returns:
        The records with coherence, in the form of the measured quantity; `trials` says how many blows each
        trial really averaged, `flags` what is odd. A single blow has the coherence 1, which says nothing.

    Raises:
        InvalidRequest: no such estimator.
        InvalidCampaign: no blows, a force that is zero, or blows on different time axes.
    """
    if estimator not in get_args(Estimator):
        raise InvalidRequest(Fault("call", "estimator", repr(estimator), ", ".join(get_args(Estimator))))
    limits = limits or QualityLimits()
    blows = source.blows if isinstance(source, Campaign) else tuple(source)
    if isinstance(source, Campaign):
        trials, band = trials or source.trials, band or source.band
    _check(blows)
    band = band or default_band(None, blows)
    flags = check_blows(blows, band, limits)
    if band_pass is not None:
        blows = tuple(band_pass_blow(blow, *band_pass) for blow in blows)
    known = {trial.id: trial for trial in trials or ()}
    for blow in blows:
        known.setdefault(blow.trial, Trial(blow.trial, float(np.abs(blow.force).max()), 1, "not stated"))
    records = _one_form(
        [record for group in _groups(blows).values() for record in _estimate(group, known, estimator)]
    )
    flags += tuple(flag for record in records if (flag := _flag(record, band, limits)) is not None)
    return _gathered(records, known, flags)


def spectra(
    force: Float[np.ndarray, "blow sample"], response: Float[np.ndarray, "blow sample"], rate: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies [Hz] and the averaged spectra S_ff, S_rr, S_fr of blows, each one rectangular segment.

    Args:
        force: a row for each blow [N].
        response: a row for each blow.
        rate: samples a second [1/s].
    """
    from scipy.signal import csd

    samples = force.shape[1]

    def cross(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        frequency, density = csd(
            one.ravel(),
            other.ravel(),
            fs=rate,
            window="boxcar",
            nperseg=samples,
            noverlap=0,
            detrend=False,
        )
        return frequency, density

    frequency, between = cross(force, response)
    return frequency, cross(force, force)[1].real, cross(response, response)[1].real, between


def ratio(
    force: Float[np.ndarray, " line"],
    response: Float[np.ndarray, " line"],
    between: Complex[np.ndarray, " line"],
    estimator: str,
) -> tuple[Complex[np.ndarray, " line"], Float[np.ndarray, " line"]]:
    """FRF and coherence from S_ff, S_rr and S_fr; both 0 on lines without force or response.

    Args:
        force: auto spectrum of the force.
        response: auto spectrum of the response.
        between: their cross spectrum.
        estimator: H1, H2 or Hv.
    """
    size = np.abs(between)
    some = (force > NOTHING * force.max()) & (response > 0) & (size > 0)
    value, coherence = np.zeros(len(force), dtype=complex), np.zeros(len(force))
    f, r, b, s = force[some], response[some], between[some], size[some]
    coherence[some] = np.minimum((s / f) * (s / r), 1.0)
    if estimator == "H1":
        value[some] = b / f
    elif estimator == "H2":
        value[some] = r / b.conj()
    else:
        value[some] = b / s * np.sqrt(r / f)
    return value, coherence


def _check(blows: tuple[Blow, ...]) -> None:
    if not blows:
        raise InvalidCampaign(Fault("blows", "", "none", "one blow at least"))
    first = blows[0]
    faults = []
    for blow in blows:
        key = f"blow {blow.sequence} of posture {blow.posture}, trial {blow.trial}"
        finite = all(np.all(np.isfinite(part)) for part in (blow.time, blow.force, blow.response))
        if len(blow.time) < 2 or not finite:
            faults.append(Fault("blows", key, "records that are short or not finite", "finite samples"))
        elif not np.any(blow.force):
            faults.append(Fault("blows", key, "a force that is zero throughout", "a blow"))
        elif len(blow.time) != len(first.time) or abs(blow.step / first.step - 1) > 1e-5:
            found = f"{len(blow.time)} samples every {blow.step:g} s"
            wanted = f"{len(first.time)} samples every {first.step:g} s, as the first blow"
            faults.append(Fault("blows", key, found, wanted))
    if faults:
        raise InvalidCampaign(faults)


def _groups(blows: Iterable[Blow]) -> dict[tuple[object, ...], list[Blow]]:
    """Blows that are averaged: of one posture, trial, reference and quantity."""
    groups: dict[tuple[object, ...], list[Blow]] = {}
    for blow in blows:
        groups.setdefault((blow.posture, blow.trial, blow.reference, blow.quantity), []).append(blow)
    return groups


def _estimate(blows: list[Blow], known: dict[int, Trial], estimator: str) -> list[_Record]:
    first = blows[0]
    window = known[first.trial].window
    shaped = [(blow, *windowed(blow, window)) for blow in blows]
    records = []
    for channel in dict.fromkeys(channel for blow in blows for channel in blow.channels):
        having = [(b.channels.index(channel), f, r) for b, f, r in shaped if channel in b.channels]
        force = np.array([force for _, force, _ in having])
        response = np.array([responses[place] for place, _, responses in having])
        frequency, s_ff, s_rr, s_fr = spectra(force, response, 1 / first.step)
        value, coherence = ratio(s_ff, s_rr, s_fr, estimator)
        form = FORM_OF[first.quantity]
        labels = (first.posture, first.trial, channel, first.reference, form, len(having))
        records.append(_Record(*labels, frequency, value, coherence))
    return records


def _one_form(records: list[_Record]) -> list[_Record]:
    """All records in the form with the most derivatives among them; see `read_frf_uff`."""
    target = max((record.form for record in records), key=POWER.__getitem__)
    return [
        replace(
            record,
            value=convert(record.value, record.frequency, record.form, target),
            form=target,
        )
        for record in records
    ]


def _flag(record: _Record, band: tuple[float, float], limits: QualityLimits) -> QualityFlag | None:
    labels = (record.posture, record.trial, record.response, record.reference)
    return coherence_flag(record.coherence, record.frequency, band, labels, limits)


def _gathered(records: list[_Record], known: dict[int, Trial], flags: tuple[QualityFlag, ...]) -> FrfRecords:
    averaged: dict[int, int] = {}
    for record in records:
        averaged[record.trial] = min(record.blows, averaged.get(record.trial, record.blows))
    trials = tuple(replace(known[id], averages=n) for id, n in averaged.items())
    return FrfRecords(
        frequency=records[0].frequency,
        value=np.array([record.value for record in records]),
        coherence=np.array([record.coherence for record in records]),
        posture=np.array([record.posture for record in records]),
        trial=np.array([record.trial for record in records]),
        response=np.array([record.response for record in records]),
        reference=np.array([record.reference for record in records]),
        form=records[0].form,
        trials=trials,
        flags=flags,
    )

"""A campaign's FRFs as a fit sees them: receptances averaged over repeats, with the variance of each line."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float, Int, Shaped

from flexmodal.campaign import (
    Campaign,
    CampaignPosture,
    FrfRecords,
    added_decay,
    estimate_frfs,
    is_coherent,
    named_direction,
    record_variance,
    repeat_groups,
)
from flexmodal.campaign.noise import expected_gap_square
from flexmodal.ema import FEWEST_LINES, LARGEST, scatter
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf.form import POWER
from flexmodal.identification.layout import Layout
from flexmodal.identification.record_end import length_after
from flexmodal.identification.signal import has_signal, with_signal
from flexmodal.structure.structure import Axis

NOISIEST = 0.1
"""Relative variance beyond which the logarithm of a line is biased by its own noise."""


@dataclass(frozen=True, eq=False)
class Observations:
    """What was measured; observation n is the receptance `value[n]` of one posture, pair and force level."""

    campaign: Campaign
    records: FrfRecords
    """The records, receptances with directions along positive axes, inside the band."""
    postures: tuple[CampaignPosture, ...]
    """Those with records."""
    posture: Int[np.ndarray, " observation"]
    """Number in `postures`."""
    response: Int[np.ndarray, "observation 2"]
    reference: Int[np.ndarray, "observation 2"]
    """Point id and direction 1, 2, 3."""
    level: Int[np.ndarray, " observation"]
    """Number in `levels`."""
    levels: tuple[tuple[int, ...], ...]
    """Trials that repeat each other: one kind of blow."""
    decays: tuple[float, ...]
    """Of the exponential window of each level [1/s]."""
    lengths: tuple[float, ...]
    """Of the records of each level, from the blow to their end [s]; 0 where that is not known."""
    value: Complex[np.ndarray, "observation line"]
    """Mean over the repeats [m/N]."""
    variance: Float[np.ndarray, "observation line"]
    """Relative variance of that mean."""
    used: Bool[np.ndarray, "observation line"]
    """Coherent enough, less noisy than `NOISIEST`, and not zero."""
    of_record: Int[np.ndarray, " record"]
    """The observation that each record belongs to."""
    noise: Float[np.ndarray, "record line"]
    """E|ln(true / measured)|² of each record: what its noise alone puts into the gap."""
    silent: tuple[str, ...] = ()
    """Records that were left out because hardly a line of theirs is coherent."""
    power: int = 2
    """What was recorded: acceleration 2, velocity 1, displacement 0."""
    by_lines: bool = False
    """Whether nothing but how neighbouring lines disagree says how noisy they are."""
    cut_slopes: bool = True
    """See `Axis`."""
    endless: bool = False
    """Whether what is linear is taken as if records lasted until all is still. A joint that sticks stays away
    from where it was: what is integrated in time has records as they are."""

    @cached_property
    def axis(self) -> Axis:
        """The lines, as if without a window."""
        frequency = self.records.frequency
        return Axis(frequency, float(np.sqrt(frequency[0] * frequency[-1])))

    @cached_property
    def layout(self) -> Layout:
        """Which of them share structures and receptances."""
        lengths = (0.0,) * len(self.lengths) if self.endless else self.lengths
        axes = tuple(zip(self.decays, lengths, strict=True))
        return Layout(self.posture, self.response, self.reference, self.level, axes)

    def axis_of(self, level: int) -> Axis:
        """The lines for one kind of blow."""
        recorded = self.recorded(level)
        return replace(recorded, length=0.0) if self.endless else recorded

    def recorded(self, level: int) -> Axis:
        """The same with the length of the records, whatever is linear."""
        decay, length = self.decays[level], self.lengths[level]
        return replace(self.axis, decay=decay, length=length, power=self.power, cut_slopes=self.cut_slopes)

    def peak(self, level: int) -> float:
        """Typical force peak of a kind of blow [N]."""
        return float(np.mean([self.campaign.trial(trial).force_peak for trial in self.levels[level]]))

    def direction(self, where: Sequence[int] | Int[np.ndarray, " 2"]) -> str:
        """A point and a direction as text, such as tip:+z."""
        number, way = (int(one) for one in where)
        return str(named_direction((number, way), {number: self.campaign.point(number).name}))

    def keeping(self, keep: Bool[np.ndarray, " observation"]) -> Observations:
        """Some of the observations; postures keep their numbers."""
        number = np.cumsum(keep) - 1
        rows = np.flatnonzero(keep[self.of_record])
        return replace(
            self,
            records=self.records.take(rows),
            posture=self.posture[keep],
            response=self.response[keep],
            reference=self.reference[keep],
            level=self.level[keep],
            value=self.value[keep],
            variance=self.variance[keep],
            used=self.used[keep],
            of_record=number[self.of_record[rows]],
            noise=self.noise[rows],
        )

    def __len__(self) -> int:
        """How many there are."""
        return len(self.value)


def unlimited(observations: Observations) -> Observations:
    """As if every record lasted until all is still: of what is linear nothing is cut off.

    Args:
        observations: of a campaign.
    """
    return replace(observations, endless=True)


def observe(campaign: Campaign, *, bare: bool = False) -> Observations:
    """Take a campaign's FRFs, or those its blows give, for a fit.

    Args:
        campaign: what was measured.
        bare: where neither repeats nor coherence say how noisy the FRFs are, take it from how neighbouring
            lines disagree.

    Raises:
        InvalidRequest: no FRFs and no blows, no line in the band, or nothing that says how noisy they are.
    """
    measured = _measured(campaign)
    records, silent = with_signal(measured, campaign)
    absolute, by_lines = _variance(measured, campaign, bare=bare)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(records.value == 0, np.inf, absolute / np.abs(records.value) ** 2)
    noise = expected_gap_square(records.value, absolute)
    power = POWER[records.form]
    groups = repeat_groups(records.trials or campaign.trials)
    records = _receptances(records, campaign)
    postures = tuple(p for p in campaign.postures if np.any(records.posture == p.id))
    table, of_record = _grouped(records, postures, groups)
    count = np.bincount(of_record)[:, None]
    coherence = np.ones(records.value.shape) if records.coherence is None else records.coherence
    value = _summed(records.value, of_record) / count
    variance = _summed(relative, of_record) / count**2
    coherent = is_coherent(_summed(coherence, of_record) / count)
    return Observations(
        campaign=campaign,
        records=records,
        postures=postures,
        posture=table[:, 0],
        response=table[:, 1:3],
        reference=table[:, 3:5],
        level=table[:, 5],
        levels=groups,
        decays=tuple(_decay(campaign, group) for group in groups),
        lengths=tuple(length_after(campaign, group) for group in groups),
        value=value,
        variance=variance,
        used=coherent & (value != 0) & (variance <= NOISIEST),
        of_record=of_record,
        noise=noise,
        silent=silent,
        power=power,
        by_lines=by_lines,
    )


def _measured(campaign: Campaign) -> FrfRecords:
    """FRFs of a campaign, or of its blows, inside its band."""
    source, frfs = str(campaign.path or "campaign"), campaign.frfs
    if frfs is None:
        if not campaign.blows:
            allowed = "frf.uff or time.uff; with modes.csv alone, identify from modes"
            raise InvalidRequest(Fault(source, "", "no FRFs and no blows", allowed))
        frfs = estimate_frfs(campaign)
    records = _inside(frfs, campaign.band).positive()
    if not records.frequency.size:
        low, high = campaign.band
        found = f"no line from {low:g} to {high:g} Hz"
        raise InvalidRequest(Fault(source, "band", found, "a band with lines in it"))
    return records


def _grouped(
    records: FrfRecords, postures: Sequence[CampaignPosture], groups: Sequence[Sequence[int]]
) -> tuple[Int[np.ndarray, "observation 6"], Int[np.ndarray, " record"]]:
    """Posture, response, reference and level of each observation, and the observation of each record."""
    level_of = {trial: number for number, group in enumerate(groups) for trial in group}
    posture_of = {posture.id: number for number, posture in enumerate(postures)}
    keys: dict[tuple[int, ...], int] = {}
    of_record = []
    for row in range(len(records)):
        places = (*records.response[row].tolist(), *records.reference[row].tolist())
        key = (posture_of[int(records.posture[row])], *places, level_of[int(records.trial[row])])
        of_record.append(keys.setdefault(key, len(keys)))
    return np.array(list(keys)), np.array(of_record)


def _summed(
    value: Shaped[np.ndarray, "record line"], of_record: Int[np.ndarray, " record"]
) -> Shaped[np.ndarray, "observation line"]:
    """Sums over the records of each observation."""
    total = np.zeros((int(of_record.max()) + 1, value.shape[1]), dtype=value.dtype)
    np.add.at(total, of_record, value)
    return total


def _variance(
    measured: FrfRecords, campaign: Campaign, *, bare: bool
) -> tuple[Float[np.ndarray, "record line"], bool]:
    """Noise of the records with a signal, and whether neighbouring lines alone tell it.

    What cannot tell is named. A record without a signal still tells the noise of the one that it repeats.
    """
    kept = has_signal(measured, campaign)
    records = measured.take(np.flatnonzero(kept))
    with suppress(InvalidRequest):
        return record_variance(measured)[kept], False
    try:
        return record_variance(records), False
    except InvalidRequest as error:
        too_large = np.max(np.abs(records.value), initial=0.0) > LARGEST
        if not bare or too_large or len(records.frequency) < FEWEST_LINES:
            source = str(campaign.path or "campaign")
            faults = [Fault(source, f"frfs: {one.key}", one.found, one.allowed) for one in error.faults]
            raise InvalidRequest(faults) from None
        least = 1e-24 * np.max(np.abs(records.value) ** 2, axis=1, keepdims=True)
        return np.maximum(scatter(np.asarray(records.value).T).T, least), True


def _inside(frfs: FrfRecords, band: tuple[float, float]) -> FrfRecords:
    keep = (
        (frfs.frequency >= band[0] * (1 - 1e-6))
        & (frfs.frequency <= band[1] * (1 + 1e-6))
        & (frfs.frequency > 0)
    )
    return replace(
        frfs,
        frequency=frfs.frequency[keep],
        value=frfs.value[:, keep],
        coherence=None if frfs.coherence is None else frfs.coherence[:, keep],
    )


def _receptances(records: FrfRecords, campaign: Campaign) -> FrfRecords:
    """Receptances; under an exponential window exp(−σt) a derivative is a factor iω + σ, not iω."""
    power = POWER[records.form]
    found = records.to("receptance")
    decay = np.array([added_decay(campaign.trial(int(trial))) for trial in found.trial])
    if not power or not decay.any():
        return found
    s = 2j * np.pi * found.frequency
    return replace(found, value=found.value * (s / (s + decay[:, None])) ** power)


def _decay(campaign: Campaign, group: tuple[int, ...]) -> float:
    return float(np.mean([added_decay(campaign.trial(trial)) for trial in group]))

"""A campaign to its modes: FRFs as measured or from blows, windows taken out, a table for `modes.csv`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import (
    Campaign,
    FrfRecords,
    ModeTable,
    added_decay,
    estimate_frfs,
    record_variance,
)
from flexmodal.ema.choices import Choices
from flexmodal.ema.chosen import Choice, check_data, fit_poles
from flexmodal.ema.fit import Fit, fit_records
from flexmodal.ema.records import by_posture
from flexmodal.ema.window import without_window
from flexmodal.errors import Fault, InvalidRequest


def records_of(campaign: Campaign, estimator: str = "H1") -> FrfRecords:
    """The campaign's own FRFs, or those estimated from its blows: it has none, or H2 or Hv is asked for.

    Args:
        campaign: what was measured.
        estimator: H1, H2 or Hv, where FRFs are estimated from blows.

    Raises:
        InvalidRequest: it has neither, or no blows to estimate from.
    """
    if campaign.frfs is not None and estimator == "H1":
        return campaign.frfs
    if not campaign.blows:
        found = "neither FRFs nor blows" if campaign.frfs is None else "no blows"
        allowed = "frf.uff or time.uff to find modes in"
        raise InvalidRequest(Fault(str(campaign.path or campaign.title), "", found, allowed))
    return estimate_frfs(campaign, estimator=estimator)


def known_variance(records: FrfRecords) -> Float[np.ndarray, "record line"] | None:
    """E|noise|² of each line of each record, from repeats or coherence; None where a record has neither."""
    try:
        variance = record_variance(records)
    except InvalidRequest:
        return None
    floor = 1e-24 * np.max(np.abs(records.value) ** 2, axis=1, keepdims=True)
    return np.maximum(variance, np.maximum(floor, np.finfo(float).tiny))


def fit(
    measured: Campaign | FrfRecords,
    method: str = "least-squares",
    *,
    per: str = "frf",
    trials: str = "average",
    estimator: str = "H1",
    variance: Float[np.ndarray, "record line"] | None = None,
    choices: Choices | None = None,
    advance: Callable[[str, float], None] = lambda doing, part: None,
) -> tuple[Fit, ...]:
    """Find the modes of a campaign, or of FRFs by themselves.

    Of a campaign the FRFs are those measured or, without, those its blows give; how noisy they are is taken
    from repeats or coherence, where every record has one of them; damping that exponential windows added is
    taken out again. The peaks are chosen for each posture from all its FRFs together, so that a mode keeps
    its number from one FRF to the next; `choices` can name them by hand.

    Args:
        measured: the campaign, whose band is used unless `choices` has one; or FRFs.
        method: peaks, circle, least-squares or lscf.
        per: "frf" for poles of each FRF's own, "posture" for poles common to the FRFs of a posture.
        trials: "average" them, or fit each one "separate"ly.
        estimator: H1, H2 or Hv, where FRFs are estimated from the blows of a campaign.
        variance: E|noise|² of each record's values, in their unit squared; see above for a campaign. Of FRFs
            alone from the scatter of trials where there are several, else from what the fit leaves over.
        choices: what a person decides; the band among it.
        advance: told before each posture what is done, and which part of it is done.

    Returns:
        A `Fit` for each FRF, or for each posture.

    Raises:
        InvalidRequest: no FRFs and no blows, trials with different windows to be averaged, or a choice that
            does not exist or does not suit the lines.
    """
    if not isinstance(measured, Campaign):
        return fit_records(
            measured, method, per=per, trials=trials, variance=variance, choices=choices, advance=advance
        )
    wanted = choices or Choices()
    if wanted.band is None and measured.band is not None:
        wanted = replace(wanted, band=measured.band)
    records = records_of(measured, estimator)
    noise = known_variance(records) if variance is None else variance
    return _unwindowed(
        measured,
        fit_records(records, method, per=per, trials=trials, variance=noise, choices=wanted, advance=advance),
    )


def fit_choice(measured: Campaign, choice: Choice, *, estimator: str = "H1") -> tuple[Fit, ...]:
    """The modes that a person chose in the page of a fit, once more: poles held, residues by least squares.

    Args:
        measured: the campaign that they were chosen in.
        choice: as `read_choice` gives it.
        estimator: H1, H2 or Hv, where FRFs are estimated from blows.

    Returns:
        A `Fit` for each posture that the choice has.

    Raises:
        InvalidRequest: a choice made for other data; every posture of it that is.
    """
    records = records_of(measured, estimator)
    fits: list[Fit] = []
    faults: list[Fault] = []
    for posture, places, whole in by_posture(records, "average", known_variance(records)):
        if posture not in choice.postures:
            continue
        try:
            part = whole.within(*choice.band)
            check_data(choice, posture, part)
            found = fit_poles(part, choice.postures[posture].poles, choice.residuals)
        except InvalidRequest as error:
            faults += error.faults
            continue
        fits.append(Fit(posture, tuple(places), found))
    known = {posture for posture, _, _ in by_posture(records, "average", None)}
    for posture in choice.postures:
        if posture not in known:
            there = ", ".join(map(str, sorted(known)))
            faults.append(Fault(str(choice.path), "posture", f"posture {posture}", f"of the data: {there}"))
    if faults:
        raise InvalidRequest(faults)
    return _unwindowed(measured, tuple(fits))


def _unwindowed(measured: Campaign, fits: tuple[Fit, ...]) -> tuple[Fit, ...]:
    """Without the damping that exponential windows added."""
    decays = {trial.id: added_decay(trial) for trial in measured.trials}
    return tuple(_without_window(one, decays) for one in fits) if any(decays.values()) else fits


def _without_window(one: Fit, decays: dict[int, float]) -> Fit:
    used = {decays[place.trial] for place in one.places if place.trial is not None} or set(decays.values())
    if len(used) != 1:
        found = "trials whose exponential windows differ"
        raise InvalidRequest(Fault("call", "trials", found, "separate, not averaged"))
    return replace(one, modes=without_window(one.modes, used.pop()))


def _of_amplitude(row: dict[str, Any]) -> float:
    """Standard error of |A′| = 2ω_d|A|, in proportion to that of |A|."""
    size = abs(complex(*row["residue"]))
    return float(row["uncertainty"]["residue"] * abs(complex(*row["amplitude"])) / size) if size else math.nan


def mode_table(fits: Sequence[Fit]) -> ModeTable:
    """The modes as rows of `modes.csv`, remarks as flags; the amplitude is that of the mobility form."""
    rows = [row for one in fits for row in one.rows()]
    return ModeTable(
        posture=np.array([row["posture"] for row in rows], dtype=int),
        response=np.array([row["response"][0] for row in rows], dtype=int),
        reference=np.array([row["reference"][0] for row in rows], dtype=int),
        mode=np.array([row["mode"] for row in rows], dtype=int),
        natural_frequency=np.array([row["frequency"] for row in rows], dtype=float),
        damping_ratio=np.array([row["damping_ratio"] for row in rows], dtype=float),
        amplitude=np.array([complex(*row["amplitude"]) for row in rows], dtype=complex),
        flag=tuple("; ".join(row["remarks"]) for row in rows),
        frequency_error=np.array([row["uncertainty"]["frequency"] for row in rows], dtype=float),
        damping_error=np.array([row["uncertainty"]["damping_ratio"] for row in rows], dtype=float),
        amplitude_error=np.array([_of_amplitude(row) for row in rows], dtype=float),
    )

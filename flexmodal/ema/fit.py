"""`fit_records`: the modes of every posture of a campaign, FRF by FRF or all FRFs of a posture together."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import FrfRecords, QualityFlag, place_text
from flexmodal.ema.choices import Choices
from flexmodal.ema.estimate import (
    by_reading,
    check_method,
    each_by_least_squares,
    estimate,
    nothing,
    peaks_of,
)
from flexmodal.ema.measured import LARGEST, Measured
from flexmodal.ema.methods.record_end import with_record_end
from flexmodal.ema.mode import EstimatedModes, Method, ModeEstimate
from flexmodal.ema.records import Place, Trials, by_posture, record_length
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.modal import LinearModel, modal_model
from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown, several

_ALIKE = 0.05
"""Relative distance of two frequencies at which they are hardly those of one mode."""


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Shown):
    """The modes of one posture, of one FRF or of several together."""

    posture: int
    places: tuple[Place, ...]
    modes: EstimatedModes
    numbers: tuple[int, ...] = ()
    """What each mode is called, the same in all FRFs of a posture; from 1 on where this is empty."""

    _PICTURE: ClassVar[str] = "flexmodal.ema.plot:draw_one"

    def _facts(self) -> Mapping[str, object]:
        return {
            "posture": self.posture,
            "of": several(map(str, self.places), 3),
            "modes at [Hz]": several(f"{mode.frequency:.4g}" for mode in self.modes) or "none",
        }

    def to_pandas(self) -> Any:
        """A table: a row for each mode and FRF, with the standard errors.

        Raises:
            MissingExtra: pandas is not installed.
        """
        pandas = extra("pandas", "pandas", "to_pandas")
        rows = []
        for row in self.rows():
            errors = row.pop("uncertainty")
            spread = {f"{name}_error": errors[name] for name in ("frequency", "damping_ratio", "residue")}
            whole = {name: complex(*row[name]) for name in ("residue", "amplitude")}
            rows.append(row | whole | spread)
        return pandas.DataFrame(rows)

    def to_ss(self) -> LinearModel:
        """The modes as a state-space model of the receptance; what lies outside the band is left out.

        Raises:
            InvalidRequest: not every response was measured under every reference, or trials were kept apart.
        """
        outputs = list(dict.fromkeys(place_text(place.response) for place in self.places))
        inputs = list(dict.fromkeys(place_text(place.reference) for place in self.places))
        where = {
            (place_text(one.response), place_text(one.reference)): k for k, one in enumerate(self.places)
        }
        if len(where) != len(outputs) * len(inputs) or len(where) != len(self.places):
            found = f"{len(self.places)} FRFs of {len(outputs)} responses and {len(inputs)} references"
            raise InvalidRequest(Fault("call", "fit", found, "each response under each reference, once"))
        pick = np.array([[where[out, into] for into in inputs] for out in outputs])
        residues = np.array([mode.residue[pick] for mode in self.modes]).reshape(-1, *pick.shape)
        poles = np.array([mode.pole for mode in self.modes], dtype=complex)
        return modal_model(poles, residues.astype(complex), inputs=tuple(inputs), outputs=tuple(outputs))

    def numbered(self) -> Iterator[tuple[int, ModeEstimate]]:
        """The modes with their numbers, in the order of frequency."""
        yield from zip(self.numbers or range(1, len(self.modes) + 1), self.modes, strict=True)

    def rows(self) -> Iterator[dict[str, Any]]:
        """One mapping for each mode and FRF, as `flexmodal fit --json` prints them."""
        for number, mode in self.numbered():
            low, high = mode.residue_interval()
            multiplier = mode.amplitude_multiplier
            for frf, place in enumerate(self.places):
                row: dict[str, Any] = {"posture": self.posture, "mode": number}
                row |= {"response": list(place.response), "reference": list(place.reference)}
                if place.trial is not None:
                    row["trial"] = place.trial
                residue = mode.residue[frf]
                row |= {
                    "frequency": mode.frequency,
                    "damping_ratio": mode.damping_ratio,
                    "residue": [float(residue.real), float(residue.imag)],
                    "amplitude": [float(multiplier[frf].real), float(multiplier[frf].imag)],
                    "uncertainty": {
                        **_errors(np.hypot(mode.by_noise, mode.by_choices), frf),
                        "frequency_95": list(mode.frequency_interval()),
                        "damping_ratio_95": list(mode.damping_interval()),
                        "residue_95": [float(low[frf]), float(high[frf])],
                        "noise": _errors(mode.by_noise, frf),
                        "choices": _errors(mode.by_choices, frf),
                    },
                    "quality": mode.quality,
                    "method": mode.method,
                    "remarks": list(mode.remarks),
                }
                yield row


def _errors(errors: Float[np.ndarray, " number"], frf: int) -> dict[str, float]:
    """Standard errors by name; those of frequency and damping come first, then one for each FRF."""
    return {
        "frequency": float(errors[0]),
        "damping_ratio": float(errors[1]),
        "residue": float(errors[2 + frf]),
    }


def fit_records(
    records: FrfRecords,
    method: str = "least-squares",
    *,
    per: str = "frf",
    trials: str = "average",
    variance: Float[np.ndarray, "record line"] | None = None,
    choices: Choices | None = None,
    advance: Callable[[str, float], None] = lambda doing, part: None,
) -> tuple[Fit, ...]:
    """Find the modes in measured FRFs; more of it at `fit`, which takes a campaign as well.

    Args:
        records: FRFs of a campaign.
        method: peaks, circle, least-squares or lscf.
        per: "frf" for poles of each FRF's own, "posture" for poles common to the FRFs of a posture.
        trials: "average" them, or fit each one "separate"ly.
        variance: E|noise|² of each record's values, in their unit squared.
        choices: what a person decides; the band among it.
        advance: told before each posture what is done, and which part of it is done.

    Raises:
        InvalidRequest: no records, or a choice that does not exist or does not suit the lines.
    """
    name = check_method(method)
    for key, given, allowed in (
        ("per", per, ("frf", "posture")),
        ("trials", trials, ("average", "separate")),
    ):
        if given not in allowed:
            raise InvalidRequest(Fault("call", key, repr(given), ", ".join(allowed)))
    if len(records.value) == 0:
        raise InvalidRequest(Fault("call", "records", "none", "at least one FRF"))
    if np.max(np.abs(records.value)) > LARGEST:
        largest = f"a value above {LARGEST:g}"
        raise InvalidRequest(Fault("call", "records", largest, "sizes that can be squared"))
    wanted = choices or Choices()
    fits: list[Fit] = []
    count = len(np.unique(records.posture))
    for done, (posture, places, whole) in enumerate(by_posture(records, _trials(trials), variance)):
        advance(f"fitting, posture {done + 1} of {count}", done / count)
        measured = whole if wanted.band is None else whole.within(*wanted.band)
        length = record_length(records, posture)
        if per == "posture":
            modes = with_record_end(estimate(measured, name, wanted), length)
            fits.append(Fit(posture, tuple(places), modes))
            continue
        found = _one_by_one([measured.only(frf) for frf in range(len(places))], measured, name, wanted)
        found = [with_record_end(one, length) for one in found]
        numbers = _numbers(found)
        fits += [Fit(posture, (p,), m, n) for p, m, n in zip(places, found, numbers, strict=True)]
    return tuple(fits)


def _numbers(found: Sequence[EstimatedModes]) -> list[tuple[int, ...]]:
    """The same number for a mode in all FRFs, whichever of them do not show it."""
    from flexmodal.modal import track

    most = max(found, key=len)
    answer = []
    for one in found:
        partner = track(one.frequency, None, most.frequency, None, frequency_scale=_ALIKE)
        fresh = itertools.count(len(most) + 1)
        answer.append(tuple(int(place) + 1 if place >= 0 else next(fresh) for place in partner))
    return answer


def _trials(text: str) -> Trials:
    return "separate" if text == "separate" else "average"


def _one_by_one(
    parts: Sequence[Measured], together: Measured, method: Method, choices: Choices
) -> list[EstimatedModes]:
    """Fit each FRF by itself from peaks chosen in all of them."""
    if method == "lscf":
        return [estimate(part, method, choices) for part in parts]
    peaks = peaks_of(together, choices)
    if not peaks:
        return [nothing(part, method) for part in parts]
    if method == "least-squares":
        return each_by_least_squares(parts, peaks, choices)
    return [by_reading(part, peaks, method, choices) for part in parts]


def as_json(fits: Sequence[Fit], flags: Sequence[QualityFlag] = ()) -> dict[str, Any]:
    """The object that `flexmodal fit --json` prints: `modes`, `refused` peaks that gave none, and `flags`.

    Args:
        fits: what was found.
        flags: what is odd about the data.
    """
    refused = [
        {"posture": one.posture, "frf": str(place), "frequency": frequency, "why": why}
        for one in fits
        for place in (one.places if len(one.places) == 1 else ("all",))
        for frequency, why in one.modes.refused
    ]
    odd = [{**vars(flag), "point": list(flag.point)} for flag in flags]
    return {"modes": [row for one in fits for row in one.rows()], "refused": refused, "flags": odd}

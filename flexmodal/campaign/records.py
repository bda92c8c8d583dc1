"""Measured FRFs as labelled arrays: posture, response, reference, trial and frequency."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Int

from flexmodal.campaign.abscissa import same_axis
from flexmodal.campaign.coherence import is_coherent
from flexmodal.campaign.quality_flag import QualityFlag
from flexmodal.campaign.trial import Trial, repeat_groups
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import Form, Frf, PointDirection
from flexmodal.frf.form import POWER, check_form, convert
from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown, several

AXES = "xyz"

Place = int | tuple[int, int]
"""A point id, or a point id with a direction ±1 ±2 ±3."""


@dataclass(frozen=True, eq=False, repr=False)
class FrfRecords(Shown):
    """Records of one form on one frequency axis; record r is the FRF `value[r]`."""

    frequency: Float[np.ndarray, " line"]
    """Ascending [Hz]."""
    value: Complex[np.ndarray, "record line"]
    """In SI units of `form`."""
    coherence: Float[np.ndarray, "record line"] | None
    """Between 0 and 1; a record without coherence among others that have it holds 1 throughout."""
    posture: Int[np.ndarray, " record"]
    trial: Int[np.ndarray, " record"]
    response: Int[np.ndarray, "record 2"]
    """Point id and direction, ±1 ±2 ±3 for motion along ±x ±y ±z of the world frame."""
    reference: Int[np.ndarray, "record 2"]
    """Point id and direction of the force."""
    form: Form
    trials: tuple[Trial, ...] = ()
    """What is known of the trials: averages, windows, repeats."""
    flags: tuple[QualityFlag, ...] = ()
    """What was odd about the blows that the records were estimated from."""

    @property
    def weight(self) -> Float[np.ndarray, "record line"]:
        """What each line counts for: its coherence, 0 where that is too low; 1 where there is none."""
        if self.coherence is None:
            return np.ones(self.value.shape)
        return np.where(is_coherent(self.coherence), self.coherence, 0.0)

    def _facts(self) -> Mapping[str, object]:
        places = {tuple(place) for place in self.response.tolist()}
        low, high = (self.frequency[0], self.frequency[-1]) if len(self.frequency) else (np.nan, np.nan)
        return {
            "": f"{len(self)} records of {self.form}",
            "postures": several(sorted(set(self.posture.tolist()))),
            "responses": several(place_text((int(point), int(way))) for point, way in sorted(places)),
            "lines": f"{len(self.frequency)} from {low:g} to {high:g} Hz",
        }

    def to_xarray(self) -> Any:
        """Values and coherence as a data set over record and frequency [Hz].

        Posture, trial, response and reference ("3:+2" is point 3 along y) are coordinates of the records.

        Raises:
            MissingExtra: xarray is not installed.
        """
        xarray = extra("xarray", "xarray", "to_xarray")
        columns = {"posture": self.posture, "trial": self.trial}
        for name in ("response", "reference"):
            places = getattr(self, name).tolist()
            columns[name] = np.array([f"{point}:{way:+d}" for point, way in places])
        data: dict[str, Any] = {self.form: (("record", "frequency"), self.value)}
        if self.coherence is not None:
            data["coherence"] = (("record", "frequency"), self.coherence)
        return xarray.Dataset(
            data,
            coords={
                "frequency": ("frequency", self.frequency, {"units": "Hz"}),
                **{name: ("record", column) for name, column in columns.items()},
            },
        )

    def __len__(self) -> int:
        """How many records there are."""
        return len(self.value)

    def take(self, rows: Sequence[int] | Int[np.ndarray, " taken"]) -> FrfRecords:
        """The records of these row numbers, in that order."""
        index = np.asarray(rows, dtype=int)
        return replace(
            self,
            value=self.value[index],
            coherence=None if self.coherence is None else self.coherence[index],
            posture=self.posture[index],
            trial=self.trial[index],
            response=self.response[index],
            reference=self.reference[index],
        )

    def joined(self, other: FrfRecords) -> FrfRecords:
        """These records and others of the same form on the same lines.

        Args:
            other: they come last.

        Raises:
            ValueError: another form, or other lines.
        """
        if self.form != other.form or not same_axis(self.frequency, other.frequency):
            raise ValueError("FRFs of one form on the same lines can be joined")
        coherence = None
        if self.coherence is not None and other.coherence is not None:
            coherence = np.concatenate([self.coherence, other.coherence])
        return replace(
            self,
            value=np.concatenate([self.value, other.value]),
            coherence=coherence,
            posture=np.concatenate([self.posture, other.posture]),
            trial=np.concatenate([self.trial, other.trial]),
            response=np.concatenate([self.response, other.response]),
            reference=np.concatenate([self.reference, other.reference]),
            flags=(*self.flags, *other.flags),
        )

    def select(
        self,
        *,
        posture: int | Iterable[int] | None = None,
        response: Place | None = None,
        reference: Place | None = None,
        trial: int | Iterable[int] | None = None,
    ) -> FrfRecords:
        """The records that fit; none fitting gives none.

        A direction finds the records of its axis in either sense and turns their sign to the sense asked
        for: `response=(3, 1)` finds −x records too, and gives them as +x.

        Args:
            posture: id or ids; all of them if None.
            response: point id, or point id with a direction.
            reference: the same of the force.
            trial: id or ids; all of them if None.
        """
        keep = np.ones(len(self), dtype=bool)
        for wanted, ids in ((posture, self.posture), (trial, self.trial)):
            if wanted is not None:
                keep &= np.isin(ids, [wanted] if isinstance(wanted, int) else list(wanted))
        for place, column in ((response, self.response), (reference, self.reference)):
            if place is not None:
                point, direction = (place, None) if isinstance(place, int) else place
                keep &= column[:, 0] == point
                if direction is not None:
                    keep &= np.abs(column[:, 1]) == abs(direction)
        found = self.take(np.flatnonzero(keep))
        senses = tuple(None if p is None or isinstance(p, int) else p[1] for p in (response, reference))
        return _turned(found, *senses)

    def positive(self) -> FrfRecords:
        """The same records with every direction along the positive axis, signs of the values turned."""
        sign = np.sign(self.response[:, 1]) * np.sign(self.reference[:, 1])
        return replace(
            self,
            value=self.value * sign[:, None],
            response=np.abs(self.response),
            reference=np.abs(self.reference),
        )

    def to(self, form: str, *, floor: float | None = None) -> FrfRecords:
        """The same records as receptance, mobility or inertance.

        Integration divides by (iω)ᵏ, which lifts drift and noise of the lowest lines without bound; below
        `floor` the divisor stays that of `floor`, so that those lines keep their phase and stay finite.

        Args:
            form: receptance, mobility or inertance.
            floor: [Hz]; without it the first line above 0 Hz, so that only a line at 0 Hz is held.

        Raises:
            InvalidRequest: no such form, or a floor that is no frequency above 0.
        """
        target = check_form(form)
        power = POWER[target] - POWER[self.form]
        if floor is not None and not (np.isfinite(floor) and floor > 0):
            raise InvalidRequest(Fault("call", "floor", repr(floor), "a frequency above 0 Hz"))
        if power == 0:
            return self
        frequency = self.frequency
        if power < 0:
            above = frequency[frequency > 0]
            lowest = floor if floor is not None else (above[0] if above.size else 1.0)
            frequency = np.maximum(frequency, lowest)
        value = convert(self.value.T, frequency, self.form, target).T
        return replace(self, value=value, form=target)

    def repeats(self) -> tuple[tuple[int, int], ...]:
        """Pairs of row numbers: the same FRF measured in two trials that repeat each other."""
        head = {trial: group[0] for group in repeat_groups(self.trials) for trial in group}
        same: dict[tuple[int, ...], list[int]] = {}
        for row in range(len(self)):
            trial = int(self.trial[row])
            places = (*self.response[row].tolist(), *self.reference[row].tolist())
            same.setdefault((int(self.posture[row]), head.get(trial, trial), *places), []).append(row)
        return tuple(
            (rows[first], other)
            for rows in same.values()
            for first in range(len(rows))
            for other in rows[first + 1 :]
        )

    def to_frf(self, posture: int, trial: int, points: Mapping[int, str]) -> Frf:
        """The records of one posture and trial as a matrix of responses and references.

        Args:
            posture: its id.
            trial: its id.
            points: name of each point id.

        Raises:
            InvalidRequest: no such records, a pair that was not measured, or a point without a name.
        """
        chosen = self.select(posture=posture, trial=trial)
        asked = f"posture {posture}, trial {trial}"
        if not len(chosen):
            raise InvalidRequest(
                Fault("call", asked, "no records", "a posture and a trial that were measured")
            )
        rows = {
            (*r, *f): row
            for row, (r, f) in enumerate(
                zip(chosen.response.tolist(), chosen.reference.tolist(), strict=True)
            )
        }
        responses = list(dict.fromkeys((p, d) for p, d, _, _ in rows))
        references = list(dict.fromkeys((p, d) for _, _, p, d in rows))
        faults = [
            Fault(
                "call",
                asked,
                f"no record of {place_text(r)} per {place_text(f)}",
                "every pair; select fewer points",
            )
            for r in responses
            for f in references
            if (*r, *f) not in rows
        ]
        unnamed = sorted({p for p, _ in (*responses, *references)} - set(points))
        faults += [Fault("call", "points", f"no name for point {point}", "a name each") for point in unnamed]
        if faults:
            raise InvalidRequest(faults)
        order = [[rows[(*r, *f)] for f in references] for r in responses]
        return Frf(
            frequency=self.frequency,
            value=np.ascontiguousarray(np.moveaxis(chosen.value[np.array(order)], 2, 0)),
            response=tuple(named_direction(place, points) for place in responses),
            reference=tuple(named_direction(place, points) for place in references),
            form=self.form,
        )


def _turned(records: FrfRecords, response: int | None, reference: int | None) -> FrfRecords:
    """The records with the sense of their directions as asked."""
    value, places = records.value, [records.response, records.reference]
    for column, wanted in enumerate((response, reference)):
        if wanted is not None:
            value = value * (np.sign(places[column][:, 1]) * np.sign(wanted))[:, None]
            places[column] = np.column_stack([places[column][:, 0], np.full(len(value), wanted)])
    return replace(records, value=value, response=places[0], reference=places[1])


def named_direction(place: Sequence[int], points: Mapping[int, str]) -> PointDirection:
    """A point's id and ±1, ±2, ±3 as a direction at a named point.

    Args:
        place: point id and direction ±1 ±2 ±3.
        points: name of each point id.
    """
    point, direction = place
    return PointDirection(points[point], AXES[abs(direction) - 1], 1 if direction > 0 else -1)


def place_text(place: tuple[int, int]) -> str:
    """A point's id and ±1, ±2, ±3 in words, such as "3:+z"."""
    return f"{place[0]}:{'+' if place[1] > 0 else '-'}{AXES[abs(place[1]) - 1]}"

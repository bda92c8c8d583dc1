"""A labelled frequency response function, predicted or measured."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidPoint
from flexmodal.frf.direction import PointDirection
from flexmodal.frf.form import Form, check_form, convert, unit
from flexmodal.text.extras import extra
from flexmodal.text.shown import Shown, several


@dataclass(frozen=True, eq=False, repr=False)
class Frf(Shown):
    """FRFs between some responses and some references on one frequency axis."""

    frequency: Float[np.ndarray, " line"]
    """Ascending [Hz]."""
    value: Complex[np.ndarray, "line response reference"]
    """In SI units of `form`."""
    response: tuple[PointDirection, ...]
    reference: tuple[PointDirection, ...]
    form: Form = "receptance"
    _PICTURE: ClassVar[str] = "flexmodal.frf.plot:draw_one"

    def _facts(self) -> Mapping[str, object]:
        low, high = (self.frequency[0], self.frequency[-1]) if len(self.frequency) else (math.nan, math.nan)
        return {
            "": self.form,
            "response": several(self.response, 3),
            "reference": several(self.reference, 3),
            "lines": f"{len(self.frequency)} from {low:g} to {high:g} Hz",
        }

    def to_xarray(self) -> Any:
        """The values as a labelled array over frequency [Hz], response and reference.

        Raises:
            MissingExtra: xarray is not installed.
        """
        xarray = extra("xarray", "xarray", "to_xarray")
        units = {self.unit(row, column) for row, column, _ in self.pairs()}
        return xarray.DataArray(
            self.value,
            coords={
                "frequency": ("frequency", self.frequency, {"units": "Hz"}),
                "response": [str(one) for one in self.response],
                "reference": [str(one) for one in self.reference],
            },
            dims=("frequency", "response", "reference"),
            name=self.form,
            attrs={"units": ", ".join(sorted(units))},
        )

    def to_pandas(self) -> Any:
        """The values as a table: a row a line, a column each pair of response and reference.

        Raises:
            MissingExtra: pandas is not installed.
        """
        pandas = extra("pandas", "pandas", "to_pandas")
        pairs = [(str(r), str(c)) for r in self.response for c in self.reference]
        columns = pandas.MultiIndex.from_tuples(pairs, names=["response", "reference"])
        index = pandas.Index(self.frequency, name="frequency [Hz]")
        return pandas.DataFrame(self.value.reshape(len(self.frequency), -1), index=index, columns=columns)

    def to(self, form: str) -> Frf:
        """The same FRFs as receptance, mobility or inertance.

        Raises:
            InvalidRequest: no such form.
            InvalidFrequencies: integration of a line at 0 Hz.
        """
        target = check_form(form)
        return replace(self, value=convert(self.value, self.frequency, self.form, target), form=target)

    def between(self, response: str | PointDirection, reference: str | PointDirection) -> np.ndarray:
        """The complex values of one pair, by line.

        Args:
            response: point and direction of the motion.
            reference: point and direction of the force.

        Raises:
            InvalidPoint: the pair is not among these FRFs.
        """
        row = _index(self.response, response, "response")
        column = _index(self.reference, reference, "reference")
        return self.value[:, row, column]

    def pairs(self) -> Iterator[tuple[int, int, str]]:
        """Rows and columns of `value`, with what they are of, such as "tool:+x per tip:+z"."""
        for row, response in enumerate(self.response):
            for column, reference in enumerate(self.reference):
                yield row, column, f"{response} per {reference}"

    def unit(self, response: int = 0, reference: int = 0) -> str:
        """Unit of one entry, such as "m/N".

        Args:
            response: which response; the first by default.
            reference: which reference; the first by default.
        """
        return unit(
            self.form,
            response_rotates=self.response[response].is_rotation,
            reference_rotates=self.reference[reference].is_rotation,
        )


def _index(among: tuple[PointDirection, ...], wanted: str | PointDirection, key: str) -> int:
    direction = PointDirection.parse(wanted)
    if direction not in among:
        raise InvalidPoint(Fault("call", key, str(direction), ", ".join(map(str, among))))
    return among.index(direction)

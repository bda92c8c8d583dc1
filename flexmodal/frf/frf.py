"""A labelled frequency response function, predicted or measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidPoint
from flexmodal.frf.direction import PointDirection
from flexmodal.frf.form import Form, check_form, convert, unit


@dataclass(frozen=True, eq=False)
class Frf:
    """FRFs between some responses and some references on one frequency axis."""

    frequency: Float[np.ndarray, " line"]
    """Ascending [Hz]."""
    value: Complex[np.ndarray, "line response reference"]
    """In SI units of `form`."""
    response: tuple[PointDirection, ...]
    reference: tuple[PointDirection, ...]
    form: Form = "receptance"

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

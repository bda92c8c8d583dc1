"""Receptance, mobility, inertance: displacement, velocity, acceleration per force."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.errors import Fault, InvalidFrequencies, InvalidRequest

Form = Literal["receptance", "mobility", "inertance"]
FORMS: tuple[str, ...] = get_args(Form)

POWER: Mapping[Form, int] = MappingProxyType({"receptance": 0, "mobility": 1, "inertance": 2})
"""Power of iω that a receptance is multiplied by."""

_PER_SECOND = {"receptance": "", "mobility": "/s", "inertance": "/s²"}


def check_form(form: str) -> Form:
    """Return the form, or raise InvalidRequest that lists the three."""
    if form not in FORMS:
        raise InvalidRequest(Fault("call", "form", repr(form), ", ".join(FORMS)))
    return form  # type: ignore[return-value]


def convert(
    value: Complex[np.ndarray, "line *rest"],
    frequency: Float[np.ndarray, " line"],
    source: Form,
    target: Form,
) -> Complex[np.ndarray, "line *rest"]:
    """Multiply by the power of iω that leads from one form to the other.

    Args:
        value: of the source form, in SI units.
        frequency: of the lines [Hz].
        source: the form there is.
        target: the form wanted.

    Raises:
        InvalidFrequencies: integration at 0 Hz, where the constant of integration is unknown.
    """
    power = POWER[target] - POWER[source]
    if power == 0:
        return value
    if power < 0 and frequency[0] == 0:
        raise InvalidFrequencies(
            Fault("call", "frequencies", f"0 Hz in {source} to be integrated", "frequencies above 0 Hz")
        )
    factor = (2j * np.pi * frequency) ** power
    return value * factor.reshape((-1,) + (1,) * (value.ndim - 1))


def unit(form: Form, *, response_rotates: bool = False, reference_rotates: bool = False) -> str:
    """Unit of one entry, such as "m/N", "rad/(s·N·m)" or "m/(s²·N)".

    Args:
        form: receptance, mobility or inertance.
        response_rotates: whether the response is a rotation.
        reference_rotates: whether the reference is a moment.
    """
    over = "N·m" if reference_rotates else "N"
    time = _PER_SECOND[form].lstrip("/")
    below = f"{time}·{over}" if time else over
    return f"{'rad' if response_rotates else 'm'}/{f'({below})' if '·' in below else below}"

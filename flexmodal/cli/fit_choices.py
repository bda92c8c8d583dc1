"""What the options of `flexmodal fit` decide of a fit, and the file of modes that stands for them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import SOURCE, band_of, number
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.ema import Choice, Choices, Tolerances

_DECIDED = (
    "method", "per", "trials", "band", "at", "forbid", "damping", "hold_frequency", "weighting", "residuals",
    "order", "tolerances", "refine", "vary",
)  # fmt: skip
"""Options that a file of chosen modes stands for."""


def choices_of(
    *,
    band: str | None,
    at: str | None,
    forbid: tuple[str, ...],
    damping: tuple[str, ...],
    hold_frequency: str | None,
    order: int,
    tolerances: str | None,
    **others: Any,
) -> Choices:
    """The options as `Choices`.

    Args:
        band: "LOW:HIGH" [Hz].
        at: frequencies of peaks [Hz], separated by commas.
        forbid: bands without automatic peaks.
        damping: "HZ=RATIO", each to be forced.
        hold_frequency: frequencies to take as they are [Hz], separated by commas.
        order: highest of LSCF.
        tolerances: "FREQUENCY,DAMPING" of a stable pole.
        others: what goes into `Choices` as it is.

    Raises:
        InvalidRequest: text that is none of these.
    """
    from flexmodal.ema import Choices

    forced = {}
    for text in damping:
        peak, equals, ratio = text.partition("=")
        if not equals:
            raise InvalidRequest(Fault(SOURCE, "--damping", repr(text), "HZ=RATIO, such as 38=0.13"))
        forced[number(peak, "--damping", "a frequency in Hz")] = number(ratio, "--damping", "a ratio")
    return Choices(
        band=None if band is None else band_of(band),
        at=None if at is None else _hertz(at, "--at"),
        forbid=[band_of(text) for text in forbid],
        hold_frequency=[] if hold_frequency is None else _hertz(hold_frequency, "--hold-frequency"),
        damping=forced,
        highest_order=order,
        tolerances=_tolerances(tolerances),
        **others,
    )


def _tolerances(text: str | None) -> Tolerances:
    from flexmodal.ema import Tolerances

    if text is None:
        return Tolerances()
    parts = [number(part, "--tolerances", "relative changes") for part in text.split(",")]
    if len(parts) != 2:
        raise InvalidRequest(
            Fault(SOURCE, "--tolerances", repr(text), "FREQUENCY,DAMPING, such as 0.01,0.05")
        )
    return Tolerances(frequency=parts[0], damping=parts[1])


def _hertz(text: str, option: str) -> list[float]:
    return [number(part, option, "frequencies in Hz, separated by commas") for part in text.split(",")]


def chosen_at(path: Path) -> Choice:
    """The file of chosen modes, unless an option is given that it decides.

    Args:
        path: a choice.toml.

    Raises:
        InvalidRequest: such options, or everything that is wrong with the file.
    """
    from flexmodal.ema import read_choice

    context = click.get_current_context()
    given = [
        f"--{name.replace('_', '-')}"
        for name in _DECIDED
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
    ]
    if given:
        found = f"{', '.join(given)} beside --choice"
        raise InvalidRequest(Fault(SOURCE, "--choice", found, "one or the other: the file decides these"))
    return read_choice(path)

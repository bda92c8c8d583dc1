"""Fits as rows of text, for the terminal and the page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import QualityFlag
from flexmodal.ema.fit import Fit
from flexmodal.ema.mode import ModeEstimate

HEADER = (
    "posture: FRF",
    "mode",
    "frequency ± (noise, choices) [Hz]",
    "ζ ± (noise, choices) [%]",
    "largest |residue| [m/(s·N)]",
    "quality",
    "remarks",
)
LEGEND = "± is half of the 95 % interval; in brackets its parts by noise and by choices of the analyst."

_MOST_DIGITS = 9
_MOST_BLOWS = 6
"""Blows that are named in a line."""


def mode_cells(one: Fit) -> Iterator[tuple[str, ...]]:
    """One row of text for each mode, under `HEADER`; of several FRFs the one that shows it best."""
    for number, mode in one.numbered():
        reach = mode.reach()
        frf = int(np.argmax(np.abs(mode.residue)))
        yield (
            f"{one.posture}: {one.places[frf]}" + (f" of {len(one.places)}" if len(one.places) > 1 else ""),
            str(number),
            _with_parts(mode, reach, 0, mode.frequency),
            _with_parts(mode, 100 * reach, 1, 100 * mode.damping_ratio, 100.0),
            f"{abs(mode.residue[frf]):.4g} ± {reach[2 + frf]:.2g}",
            f"{mode.quality:.3f}",
            "; ".join(mode.remarks),
        )


def _with_parts(
    mode: ModeEstimate, reach: Float[np.ndarray, " number"], which: int, value: float, unit: float = 1.0
) -> str:
    """Such as "2.77 ± 0.30 (0.30, 0.04)", to two digits of the interval."""
    whole = float(reach[which])
    choices = 1.96 * unit * float(mode.by_choices[which])
    noise = math.sqrt(max(whole**2 - choices**2, 0.0))
    digits = decimals(whole, value)
    return f"{value:.{digits}f} ± {whole:.{digits}f} ({noise:.{digits}f}, {choices:.{digits}f})"


def decimals(reach: float, value: float) -> int:
    """Decimals that show two digits of the uncertainty; six digits of the value where there is none.

    Args:
        reach: the uncertainty; 0 where there is none.
        value: the number.
    """
    size = reach if reach > 0 else 1e-4 * abs(value)
    if not (math.isfinite(size) and size > 0):
        return 3
    return min(max(1 - math.floor(math.log10(size)), 0), _MOST_DIGITS)


def flag_lines(flags: Sequence[QualityFlag]) -> list[str]:
    """One sentence for each kind of doubt about each channel, however many of its blows raise it."""
    groups: dict[tuple[object, ...], list[QualityFlag]] = {}
    for flag in flags:
        groups.setdefault((flag.kind, flag.posture, flag.trial, flag.point), []).append(flag)
    lines = []
    for same in groups.values():
        blows = [str(flag.blow) for flag in same if flag.blow is not None]
        if len(same) == 1 or not blows:
            lines += [str(flag) for flag in same]
            continue
        first = same[0]
        shown = ", ".join(blows[:_MOST_BLOWS]) + (", …" if len(blows) > _MOST_BLOWS else "")
        lines.append(f"{replace(first, blow=None)} (blow {blows[0]}; {len(blows)} blows in all: {shown})")
    return lines

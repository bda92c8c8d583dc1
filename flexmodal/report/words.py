"""Numbers in words: a value with its unit, its error, a part of a whole, so many of a thing."""

from __future__ import annotations

import math

DASH = "–"
"""Stands for a number that there is not."""
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
"""Of digits and minus sign to those of an exponent."""


def figure(value: float, unit: str = "", digits: int = 4) -> str:
    """A physical number with four figures and its unit, such as "2 × 10⁵ N·m/rad".

    Args:
        value: the number; a dash where it is not finite.
        unit: behind it.
        digits: figures.
    """
    text = f"{value:.{digits}g}" if math.isfinite(value) else DASH
    if "e" in text:
        head, power = text.split("e")
        text = f"{head} × 10{str(int(power)).translate(RAISED)}"
    return minus(f"{text} {unit}".strip())


def error(value: float | None, unit: str = "") -> str:
    """A standard error with two figures; a dash where the data do not tell it.

    Args:
        value: the standard error.
        unit: behind it.
    """
    return DASH if value is None or not math.isfinite(value) else figure(float(f"{value:.2g}"), unit)


def size(value: float | None) -> str:
    """A number without a unit, with three figures; a dash for none."""
    return DASH if value is None or not math.isfinite(value) else f"{value:#.3g}".rstrip(".")


def fixed(value: float | None, digits: int, sign: str = "") -> str:
    """A number with so many decimals; a dash for none.

    Args:
        value: the number.
        digits: decimals.
        sign: "+" for one before positive numbers too.
    """
    if value is None or not math.isfinite(value):
        return DASH
    return minus(f"{value:{sign}.{digits}f}")


def times_noise(ratio: float) -> str:
    """How far a model is from what was measured, such as "1.2 × the noise": the one scale of every page.

    It is the distance from the averages over that of their noise alone, 1 for a perfect model.

    Args:
        ratio: one decimal below ten, two figures above; a dash where it is not finite.
    """
    return f"{noises(ratio)} × the noise"


def noises(ratio: float) -> str:
    """The number of `times_noise` by itself, under a head that says what it is.

    Args:
        ratio: see there.
    """
    if not math.isfinite(ratio):
        return DASH
    return f"{ratio:.1f}" if ratio < 9.95 else f"{float(f'{ratio:.2g}'):.0f}"


def percent(part: float) -> str:
    """A part of one; small ones keep a figure, and nothing is rounded to certainty."""
    if part > 0.995:
        return "> 99 %"
    if part < 0.005:
        return "< 1 %"
    return f"{100 * part:.0f} %"


def minus(text: str) -> str:
    """A number with a minus sign in place of a hyphen."""
    return text.replace("-", "−")

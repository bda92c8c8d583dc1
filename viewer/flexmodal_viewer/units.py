"""Numbers as people read them: three or four digits, a prefix, a unit."""

from __future__ import annotations

import math

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_PREFIXED = ("m/N", "N/m", "m", "rad/(N·m)", "N·m/rad")
"""Units whose prefix belongs to their first letter alone; others, such as m²/rad², get a power of ten."""


def quantity(value: float, unit: str) -> str:
    """Such as "12.3 µm/N".

    Args:
        value: in that unit.
        unit: without a prefix.
    """
    if value == 0 or not math.isfinite(value) or unit not in _PREFIXED:
        return f"{plain(value)} {unit}".strip()
    power = min(max(3 * math.floor(math.log10(abs(value)) / 3 + 1e-9), -12), 9)
    return f"{value / 10.0**power:.4g} {_PREFIXES[power]}{unit}"


def plain(value: float, digits: int = 4) -> str:
    """So many digits, and a power of ten where it is needed.

    Args:
        value: the number.
        digits: figures.
    """
    text = f"{value:.{digits}g}"
    if "e" not in text:
        return text.replace("-", "−")
    factor, power = text.split("e")
    raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{factor} × 10{raised}".replace("-", "−")


def joint_value(value: float, *, slides: bool) -> str:
    """Degrees, or millimetres of a joint that slides.

    Args:
        value: of the joint [rad, m].
        slides: whether it is a length.
    """
    if slides:
        return f"{1e3 * value:.1f} mm".replace("-", "−")
    return degrees(value, 1)


def degrees(value: float, digits: int) -> str:
    """An angle [rad] in degrees, never −0.

    Args:
        value: the angle [rad].
        digits: decimals.
    """
    return f"{round(math.degrees(value), digits) + 0.0:.{digits}f}°".replace("-", "−")

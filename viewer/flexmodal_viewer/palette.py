"""Colours that colour-blind readers can tell apart, after Okabe and Ito, on a white ground."""

from __future__ import annotations

Colour = tuple[float, float, float]
"""Red, green, blue from 0 to 1."""


def from_hex(text: str) -> Colour:
    """Read "0072B2"."""
    value = int(text, 16)
    return (value >> 16) / 255, (value >> 8 & 255) / 255, (value & 255) / 255


def to_hex(colour: Colour) -> str:
    """Write "#0072b2"."""
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour)


def luminance(colour: Colour) -> float:
    """How bright a colour looks, from 0 to 1."""
    return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]


def shade(role: Colour, own: Colour) -> Colour:
    """The colour of a role, darker for the parts of an arm that are dark themselves.

    Args:
        role: colour of the role.
        own: colour that the part has of itself.
    """
    factor = 0.62 if luminance(own) < 0.3 else 1.0
    return role[0] * factor, role[1] * factor, role[2] * factor


START = from_hex("767C86")
"""A posture to compare with: grey, drawn translucent."""
BASE = from_hex("6B7078")
"""What stands still, whatever the posture."""
OPTIMISED = from_hex("0072B2")
"""The optimised posture."""
EXTREME = from_hex("CC79A7")
"""The extreme of a vibration, drawn translucent."""
TARGET = from_hex("D55E00")
"""Where the end-effector is held."""
FORCE = from_hex("E69F00")
"""The force that excites."""
POINT = from_hex("009E73")
"""Points of measurement."""
OBSTACLE = from_hex("B59A6A")
"""What the arm may run into, drawn translucent."""
JOINT = from_hex("9AA3AD")
"""A joint that holds none of the energy; the page makes it orange as it holds more."""
PLAIN = from_hex("7D8590")
"""A part of an arm whose colour nobody gave."""
GRID = from_hex("D9DCE0")
AXIS = from_hex("4B5058")

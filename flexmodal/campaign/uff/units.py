"""Unit labels of dataset 58, which have to say what the data type says, in SI."""

from __future__ import annotations

import re

from flexmodal.campaign.uff.codes import ACCELERATION, DISPLACEMENT, FORCE, VELOCITY

TIME, FREQUENCY = 17, 18
UNITS: dict[int, tuple[str, ...]] = {
    DISPLACEMENT: ("m",),
    VELOCITY: ("m/s", "m*s^-1", "ms^-1"),
    ACCELERATION: ("m/s^2", "m/s2", "m/s/s", "m/ss", "m*s^-2", "ms^-2", "ms-2"),
    FORCE: ("N", "n"),
    TIME: ("s",),
    FREQUENCY: ("Hz", "hz", "1/s", "s^-1", "cycles/s"),
}
"""Labels of each data type, the usual one first, in lower case and in the abbreviations below."""
_SHORT = {"met(er|re)s?": "m", "sec(ond)?s?": "s", "newtons?": "n", "hertz": "hz", r"\*\*": "^"}


def says(label: str, code: int) -> bool:
    """Whether a unit label says what a data type says; an empty one says nothing against it.

    Args:
        label: as it stands in the record.
        code: specific data type; an unknown one is somebody else's to judge.
    """
    plain = re.sub(r"[\s()\[\]]", "", label.lower())
    for long, short in _SHORT.items():
        plain = re.sub(long, short, plain)
    if code in (DISPLACEMENT, VELOCITY, ACCELERATION):
        plain = re.sub(r"/n$", "", plain)  # of an FRF, whose denominator has a label of its own
    return not plain or code not in UNITS or plain in UNITS[code]

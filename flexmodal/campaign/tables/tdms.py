"""Channels of a TDMS file (LabVIEW, DIAdem) by their names, `group/channel`, with their units.

A waveform has no column of times: its channels say when they begin and how far two samples are apart. For
each group of which all waveforms agree on that, `group/time` is the column of times; where the group itself
has a channel of that name, that is the one.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Shaped

from flexmodal.text.extras import extra

MAGIC = b"TDSm"
"""With which every segment of such a file begins."""
TIME = "time"
_UNIT, _STEP, _START = "unit_string", "wf_increment", "wf_start_offset"


def tdms_channels(content: bytes) -> tuple[Mapping[str, Shaped[np.ndarray, " sample"]], Mapping[str, str]]:
    """Values and units of every channel of numbers.

    Args:
        content: of the file.

    Returns:
        Values by `group/channel`, and the unit of each that states one.

    Raises:
        MissingExtra: npTDMS is not installed.
    """
    nptdms = extra("nptdms", "tdms", "reading TDMS files")
    values: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    for group in nptdms.TdmsFile.read(io.BytesIO(content)).groups():
        waves = set()
        for channel in group.channels():
            given = np.asarray(channel[:])
            if given.dtype.kind not in "iufc" or len(given) < 2:
                continue
            name = f"{group.name}/{channel.name}"
            values[name] = given
            units[name] = str(channel.properties.get(_UNIT, ""))
            waves.add(_wave(channel, len(given)))
        time = f"{group.name}/{TIME}"
        if len(waves) == 1 and time not in values and (wave := waves.pop()) is not None:
            start, step, count = wave
            values = {time: start + step * np.arange(count), **values}
            units[time] = "s"
    return values, units


def _wave(channel: Any, count: int) -> tuple[float, float, int] | None:
    """Start, step and length of a waveform; None of a channel that is none."""
    step = channel.properties.get(_STEP)
    if not isinstance(step, int | float) or not step > 0:
        return None
    start = channel.properties.get(_START, 0.0)
    return (float(start) if isinstance(start, int | float) else 0.0, float(step), count)

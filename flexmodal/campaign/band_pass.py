"""Band-pass filtering of time records before anything else, as in section 2.5.2 of the thesis.

Zero phase: the filter runs forward and backward, so that peaks stay where they are. Force and responses are
filtered alike; inside the band the ratio of their spectra changes only by what the filter would spread beyond
the ends of the record, so let some 1/low seconds pass before the blow.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.campaign.blow import Blow
from flexmodal.errors import Fault, InvalidRequest

ORDER = 4
"""Of the Butterworth filter, run twice."""


def band_pass_blow(blow: Blow, low: float, high: float) -> Blow:
    """The blow with only the band from `low` to `high` [Hz] in it.

    Args:
        blow: what was recorded.
        low: lower corner, above 0 Hz.
        high: upper corner, below half the sampling rate.

    Raises:
        InvalidRequest: corners that are reversed or outside what the record holds.
    """
    from scipy.signal import butter, sosfiltfilt

    half = 0.5 / blow.step
    if not (np.isfinite(low) and np.isfinite(high) and 0 < low < high < half):
        allowed = f"0 < low < high < {half:g} Hz, half the sampling rate"
        raise InvalidRequest(Fault("call", "band_pass", f"{low:g} to {high:g} Hz", allowed))
    sections = butter(ORDER, (low, high), btype="bandpass", fs=2 * half, output="sos")
    padding = min(3 * (2 * len(sections) + 1), len(blow.time) - 1)

    def passed(values: np.ndarray) -> np.ndarray:
        return sosfiltfilt(sections, values, padlen=padding)

    return replace(blow, force=passed(blow.force), response=passed(blow.response))

"""Peaks beside those of scipy."""

import numpy as np
import pytest
from scipy.signal import find_peaks

from flexmodal.diagnosis.disagreement.peaks import peaks


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("prominence", [0.0, 0.3, 2.0])
def test_peaks_are_those_of_scipy(seed, prominence):
    random = np.random.default_rng(seed)
    for curve in (
        random.normal(size=200),
        np.cumsum(random.normal(size=300)),
        random.integers(0, 4, 200) * 1.0,
    ):
        expected, _ = find_peaks(curve, prominence=prominence)
        np.testing.assert_array_equal(peaks(curve, prominence), expected)
        assert len(expected)


def test_nothing_stands_out_of_a_slope_or_a_level():
    assert not len(peaks(np.arange(5.0), 0.0))
    assert not len(peaks(np.ones(5), 0.0))
    np.testing.assert_array_equal(peaks(np.array([0.0, 2, 2, 2, 1]), 0.5), [2])

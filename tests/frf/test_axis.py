"""The frequency axis: every fault it can have."""

import numpy as np
import pytest

from flexmodal.errors import InvalidFrequencies
from flexmodal.frf.axis import MOST_LINES, frequency_axis, stepped_axis


@pytest.mark.parametrize("values", [[0.0, 1.0, 2.5], [0.0], np.array([1, 2]), 7.0, 0.0, np.float64(3.0)])
def test_accepts(values):
    axis = frequency_axis(values)
    assert axis.dtype == np.float64
    np.testing.assert_array_equal(axis, np.atleast_1d(values))


def test_is_a_read_only_copy():
    given = np.array([1.0, 2.0])
    axis = frequency_axis(given)
    given[0] = 99.0
    assert axis[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        axis[0] = 3.0


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ([], "no frequencies"),
        (np.zeros((0, 3)), "no frequencies"),
        ([[1.0, 2.0]], "an array of shape (1, 2)"),
        ("fast", "something that is not a number"),
        (["1", "x"], "something that is not a number"),
        ([[1.0, 2.0], [3.0]], "something that is not a number"),
        ([1.0 + 2.0j], "something that is not a number"),
        (np.array([1j]), "something that is not a number"),
        ([10**400], "something that is not a number"),
        ([1.0, np.nan], "nan Hz"),
        ([1.0, np.inf], "inf Hz"),
        (-np.inf, "-inf Hz"),
        ([-1.0, 2.0], "a negative frequency, -1 Hz"),
        (-1e-300, "a negative frequency, -1e-300 Hz"),
        ([1.0, 1.0], "1 Hz followed by 1 Hz"),
        ([1.0, 3.0, 2.0, 4.0], "3 Hz followed by 2 Hz"),
        ([5.0, 4.0, 1.0], "4 Hz followed by 1 Hz"),
    ],
)
def test_refuses(values, found):
    with pytest.raises(InvalidFrequencies) as raised:
        frequency_axis(values, source="lines.csv")
    (fault,) = raised.value.faults
    assert (fault.file, fault.key, fault.found) == ("lines.csv", "frequencies", found)
    assert "ascending" in fault.allowed


@pytest.mark.parametrize(
    ("start", "stop", "step", "lines", "last"),
    [
        (0.0, 10.0, 2.0, 6, 10.0),
        (0.0, 1.0, 0.1, 11, 1.0),  # 0.1 has no exact binary form; the last line must not get lost
        (0.0, 0.3, 0.1, 4, 0.3),
        (5.0, 5.0, 1.0, 1, 5.0),
        (0.0, 10.0, 3.0, 4, 9.0),
        (1.0, 2.0, 5.0, 1, 1.0),
        (0.0, 500.0, 0.0625, 8001, 500.0),
    ],
)
def test_steps_include_the_end(start, stop, step, lines, last):
    axis = stepped_axis(start, stop, step, source="call")
    assert len(axis) == lines
    assert axis[0] == start
    # step × number of lines, rounded once or twice.
    np.testing.assert_allclose(axis[-1], last, rtol=1e-15)
    assert not axis.flags.writeable


@pytest.mark.parametrize(
    ("start", "stop", "step", "found"),
    [
        (10.0, 1.0, 1.0, "a reversed range, 10 to 1 Hz"),
        (0.0, 10.0, 0.0, "a step of 0 Hz"),
        (0.0, 10.0, -1.0, "a step of -1 Hz"),
        (-1.0, 10.0, 1.0, "-1:10:1"),
        (np.nan, 10.0, 1.0, "nan:10:1"),
        (0.0, np.inf, 1.0, "0:inf:1"),
        (0.0, 10.0, np.nan, "0:10:nan"),
        (0.0, 1e9, 1e-3, f"a range of 1e+12 lines, more than {MOST_LINES:,}"),
        (0.0, 1e308, 1e-308, f"a range of inf lines, more than {MOST_LINES:,}"),
        # A step too small for the numbers it is added to.
        (9e11, 9e11 + 0.01, 1e-5, "9e+11 Hz followed by 9e+11 Hz"),
    ],
)
def test_step_faults(start, stop, step, found):
    with pytest.raises(InvalidFrequencies) as raised:
        stepped_axis(start, stop, step, source="command line")
    (fault,) = raised.value.faults
    assert (fault.file, fault.found) == ("command line", found)

"""Whatever is typed, the parsers of small texts give a value or InvalidInput, and nothing else."""
# ruff: noqa: PT017 - either end is a right one

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import flexmodal
from flexmodal.cli.options import band_of, frequencies_of, number, per_joint, posture_of
from flexmodal.errors import InvalidInput
from flexmodal.frf import PointDirection

FEW = settings(max_examples=150, deadline=None)

digits = st.text("0123456789.eE+-_ ", max_size=8)
finite = st.floats(allow_nan=True, allow_infinity=True).map(repr)
number_like = (
    digits | finite | st.sampled_from(["nan", "-inf", "1e999", "1e-999", "٣", "0x10", "1_0", "", "5deg"])
)


def joined(separator, parts, most=5):
    return st.lists(parts, max_size=most).map(separator.join)


name_like = st.sampled_from(["q1", "q2", "rho", "Q1", "", " q1 ", "tool"]) | st.text(max_size=4)
pairs = joined(",", st.tuples(name_like, st.sampled_from(["=", "", "==", " = "]), number_like).map("".join))


@pytest.fixture(scope="module")
def fanuc():
    return flexmodal.load("fanuc_s360")


@FEW
@given(st.text(max_size=20) | number_like)
def test_number(text):
    try:
        value = number(text, "--key")
    except InvalidInput as error:
        assert repr(text) in str(error)
    else:
        assert math.isfinite(value)
        assert math.isfinite(value**3)


@FEW
@given(st.text(max_size=20) | pairs)
def test_per_joint(text):
    try:
        found = per_joint(text, "--stiffness")
    except InvalidInput as error:
        assert "--stiffness" in str(error)
        return
    values = found.values() if isinstance(found, dict) else [found]
    assert all(math.isfinite(value) for value in values)


@FEW
@given(text=st.text(max_size=20) | pairs)
def test_posture(fanuc, text):
    try:
        posture = posture_of(fanuc, text)
    except InvalidInput as error:
        assert "--posture" in str(error)
        return
    assert list(posture.values) == ["q1", "q2", "q3"]
    for joint, value in posture.values.items():
        assert fanuc.commanded[joint].lower - 1e-6 <= value <= fanuc.commanded[joint].upper + 1e-6


@FEW
@given(
    st.text(max_size=20)
    | joined(",", number_like)
    | st.lists(digits | st.integers(0, 99).map(str), min_size=2, max_size=4).map(":".join)
)
def test_frequencies(text):
    try:
        axis = frequencies_of(text)
    except InvalidInput as error:
        assert "--frequencies" in str(error)
        return
    assert axis.ndim == 1
    assert axis.size >= 1
    assert np.all(np.isfinite(axis**2))
    assert axis[0] >= 0
    assert np.all(np.diff(axis) > 0)


@FEW
@given(joined(":", number_like, 3))
def test_band(text):
    try:
        low, high = band_of(text)
    except InvalidInput as error:
        assert "--band" in str(error)
        return
    assert 0 <= low < high < math.inf


@FEW
@given(
    st.text(max_size=20)
    | st.tuples(name_like, st.sampled_from([":", "", "::"]), st.text("+-rxyz", max_size=4)).map("".join)
)
def test_direction(text):
    try:
        found = PointDirection.parse(text)
    except InvalidInput as error:
        assert "direction" in str(error)
        return
    assert PointDirection.parse(str(found)) == found
    assert abs(found.selector).sum() == 1


@settings(max_examples=100, deadline=None)
@given(st.floats(0, 1e6), st.integers(0, 400), st.floats(1e-3, 1e3))
def test_both_ends_of_a_range_are_in_it(start, steps, step):
    stop = start + steps * step
    axis = frequencies_of(f"{start!r}:{stop!r}:{step!r}")
    # `stop` is rounded, and so may end a hair before the last line: 1e-9 of a step is let pass for that,
    # more than the rounding of numbers up to 1e6 amounts to only while the steps are not tiny beside them.
    if stop * 1e-16 < step * 1e-10:
        assert len(axis) == steps + 1
        assert axis[-1] == pytest.approx(stop, rel=1e-12, abs=1e-12)


@settings(max_examples=100, deadline=None)
@given(st.floats(-720, 720))
def test_degrees_are_degrees(angle):
    six = _six_link()
    text = f"q3={angle!r}deg"
    if abs(angle) <= 360:
        assert posture_of(six, text).values["q3"] == math.radians(angle)
    elif abs(angle) > 360.001:
        with pytest.raises(InvalidInput, match="limits"):
            posture_of(six, text)


def _six_link(kept=[]):  # noqa: B006 - loaded once
    if not kept:
        kept.append(flexmodal.load("six_link"))
    return kept[0]

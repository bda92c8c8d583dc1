"""Points and directions as text."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmodal.errors import InvalidPoint
from flexmodal.frf import PointDirection
from flexmodal.frf.direction import AXES


@pytest.mark.parametrize(
    ("text", "point", "axis", "sign"),
    [
        ("tool:+z", "tool", "z", 1),
        ("tool:-x", "tool", "x", -1),
        ("tool:y", "tool", "y", 1),
        ("tool:+ry", "tool", "ry", 1),
        ("tool:-rz", "tool", "rz", -1),
        ("tool:rx", "tool", "rx", 1),
        ("  tool:+z\n", "tool", "z", 1),
        ("upper arm:-z", "upper arm", "z", -1),
        ("12:+x", "12", "x", 1),
        ("link_3/tip.2:x", "link_3/tip.2", "x", 1),
        ("Stößel:+z", "Stößel", "z", 1),
    ],
)
def test_parse(text, point, axis, sign):
    found = PointDirection.parse(text)
    assert (found.point, found.axis, found.sign) == (point, axis, sign)
    assert found.is_rotation == axis.startswith("r")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "tool",
        "tool:",
        ":+z",
        " :+z",
        "tool:+w",
        "tool:++z",
        "tool:+-z",
        "tool:z+",
        "tool:+Z",
        "tool:+zz",
        "tool:+rr",
        "tool:+ z",
        "tool :+z",
        "a:b:+",
        "tool::z",
        "tool:+x,+y",
        "tool;+z",
        "tool:−z",
        "tool:1",
    ],
)
def test_bad_text_is_refused(text):
    with pytest.raises(InvalidPoint, match="point and direction, such as tool:") as raised:
        PointDirection.parse(text, source="command line")
    (fault,) = raised.value.faults
    assert fault.file == "command line"
    assert fault.found == repr(text)


@pytest.mark.parametrize(
    ("point", "axis", "sign"),
    [
        ("tool", "w", 1),
        ("tool", "++z", 1),
        ("tool", "z", 0),
        ("tool", "z", 2),
        ("", "z", 1),
        ("a:b:", "z", 1),
        (" tool", "z", 1),
        ("  ", "z", 1),
    ],
)
def test_what_cannot_be_written_cannot_be_made(point, axis, sign):
    with pytest.raises(InvalidPoint):
        PointDirection(point, axis, sign)


names = st.text(st.characters(exclude_characters=":", exclude_categories=["Cs"]), min_size=1).filter(
    lambda name: name == name.strip()
)


@settings(deadline=None, derandomize=True, database=None)
@given(names, st.sampled_from(AXES), st.sampled_from([1, -1]))
def test_round_trip(point, axis, sign):
    direction = PointDirection(point, axis, sign)
    assert PointDirection.parse(str(direction)) == direction


def test_a_direction_passes_through():
    direction = PointDirection("tool", "x", -1)
    assert PointDirection.parse(direction) is direction
    assert str(direction) == "tool:-x"
    assert len({direction, PointDirection.parse("tool:-x")}) == 1


def test_selector_picks_its_row():
    jacobian = np.arange(12.0).reshape(6, 2)
    for row, axis in enumerate(AXES):
        np.testing.assert_array_equal(PointDirection("p", axis).selector @ jacobian, jacobian[row])
        np.testing.assert_array_equal(PointDirection("p", axis, -1).selector @ jacobian, -jacobian[row])

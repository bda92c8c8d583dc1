"""Each coordinate has one name, and its owner finds it by the one that the owner calls it."""

import pytest

from flexmodal.structure.coordinates import Coordinates


def test_what_two_add_to_one_place_each_finds_by_the_same_name():
    names = Coordinates(["q1", "q2"])
    assert names.add(["q1 tilt", "q2 tilt"], "all bearings") == slice(2, 4)
    assert names.add(["q1 tilt", "q1 shift"], "one bearing") == slice(4, 6)
    assert len(set(names)) == len(names) == 6
    assert names.number("q1 tilt", "all bearings") == 2
    assert names.number("q1 tilt", "one bearing") == 4
    assert names.number("q1 shift", "one bearing") == 5
    assert names.number("q2 tilt", "one bearing") == 3
    assert names.number("q1", "one bearing") == 0


def test_what_nobody_has_is_not_found():
    with pytest.raises(ValueError, match="q3"):
        Coordinates(["q1"]).number("q3", "")

"""Places that give nearly alike: which ports touch which."""

import pytest

from flexmodal.diagnosis.lawfree.adjacent import adjacent


@pytest.mark.parametrize(
    ("here", "touching"),
    [
        (("base", "base"), {("bearing", "q1")}),
        (("bearing", "q1"), {("base", "base"), ("link", "link_1")}),
        (("bearing", "q2"), {("link", "link_1"), ("link", "link_2")}),
        (("link", "link_1"), {("bearing", "q1"), ("bearing", "q2")}),
        (("link", "link_3"), {("bearing", "q3")}),
        (("body", "link_1"), set()),
        (("coupling", "q1+q2"), set()),
    ],
)
def test_a_foundation_touches_the_first_bearing_and_a_link_those_at_its_ends(context, here, touching):
    assert context.joints == ("q1", "q2", "q3")
    assert adjacent(context, *here) == touching

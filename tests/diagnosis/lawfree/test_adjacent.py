"""Places that give nearly alike: which ports touch which, and what a coupling of two joints holds."""

import pytest

from flexmodal.diagnosis.lawfree.adjacent import adjacent, between, on_base, within


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


def test_on_the_base_stand_the_first_joint_and_the_link_that_it_carries(context):
    assert on_base(context) == {("bearing", "q1"), ("joint", "q1"), ("torque", "q1"), ("link", "link_1")}


@pytest.mark.parametrize(
    ("coupled", "link"), [("q1+q2", {("link", "link_1")}), ("q2+q3", {("link", "link_2")}), ("q1+q3", set())]
)
def test_two_joints_in_a_row_hold_a_link_between_them(context, coupled, link):
    assert between(context, coupled) == link


SERVO, ABSORBER, MASS = "servo_compliance", "local_absorber", "added_mass"


@pytest.mark.parametrize(
    ("keys", "where", "inside"),
    [
        ([(ABSORBER, "link_1"), (SERVO, "q3")], "q1+q3", True),
        ([(ABSORBER, "link_1"), (SERVO, "q3")], "q1+q2", False),
        ([(MASS, "link_2"), (SERVO, "q2")], "q1+q2", True),  # both joints move the second link, and no other
        ([(MASS, "link_3"), (SERVO, "q2")], "q1+q2", False),
        ([("bearing_flexibility", "q1"), (SERVO, "q2")], "q1+q2", False),
        ([("sensor_gain", "tip"), (SERVO, "q2")], "q1+q2", False),
        ([(ABSORBER, "link_1"), ("coulomb_friction", "q3")], "q1+q3", True),  # what rubs sticks
    ],
)
def test_a_coupling_holds_what_its_joints_alone_move(context, keys, where, inside):
    assert within(context, keys, "coupling", where) is inside
    assert not within(context, keys, "link", where)

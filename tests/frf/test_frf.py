"""Labelled FRFs: picking a pair, changing the form, naming the unit."""

import dataclasses

import numpy as np
import pytest

from flexmodal.errors import InvalidFrequencies, InvalidPoint, InvalidRequest
from flexmodal.frf import Frf, PointDirection, receptance
from flexmodal.modal import SecondOrderSystem

RESPONSE = tuple(PointDirection.parse(text) for text in ("tool:+z", "tool:-x", "elbow:+ry"))
REFERENCE = tuple(PointDirection.parse(text) for text in ("tool:+z", "tool:+rx"))
FREQUENCY = np.array([1.0, 2.0, 4.0, 8.0])


def frf(frequency=FREQUENCY):
    value = np.arange(len(frequency) * 6.0).reshape(-1, 3, 2) * (1 + 0.5j)
    return Frf(frequency, value, RESPONSE, REFERENCE)


def test_between_picks_the_pair_by_its_labels():
    held = frf()
    for row, response in enumerate(RESPONSE):
        for column, reference in enumerate(REFERENCE):
            for left, right in ((response, reference), (str(response), str(reference))):
                np.testing.assert_array_equal(held.between(left, right), held.value[:, row, column])
    np.testing.assert_array_equal(held.between("tool:z", "tool:z"), held.value[:, 0, 0])


@pytest.mark.parametrize(
    ("response", "reference", "key", "found"),
    [
        ("tool:+y", "tool:+z", "response", "tool:+y"),
        ("tool:+x", "tool:+z", "response", "tool:+x"),  # the other sense is another label
        ("tool:+z", "elbow:+ry", "reference", "elbow:+ry"),
    ],
)
def test_between_says_what_there_is(response, reference, key, found):
    with pytest.raises(InvalidPoint) as raised:
        frf().between(response, reference)
    (fault,) = raised.value.faults
    assert (fault.key, fault.found) == (key, found)
    assert fault.allowed == ", ".join(map(str, RESPONSE if key == "response" else REFERENCE))


def test_between_refuses_bad_text():
    with pytest.raises(InvalidPoint, match="such as tool:"):
        frf().between("tool", "tool:+z")


def test_to_changes_value_and_form_and_nothing_else():
    held = frf()
    mobility = held.to("mobility")
    omega = 2 * np.pi * FREQUENCY[:, None, None]
    np.testing.assert_allclose(mobility.value, 1j * omega * held.value, rtol=1e-14)  # some eps
    assert mobility.form == "mobility"
    assert (mobility.response, mobility.reference) == (RESPONSE, REFERENCE)
    np.testing.assert_array_equal(mobility.frequency, FREQUENCY)
    assert held.form == "receptance"
    np.testing.assert_allclose(mobility.to("inertance").to("receptance").value, held.value, rtol=1e-14)
    np.testing.assert_array_equal(held.to("receptance").value, held.value)


def test_to_refuses():
    with pytest.raises(InvalidRequest, match="receptance, mobility, inertance"):
        frf().to("compliance")
    from_rest = frf(np.array([0.0, 1.0]))
    mobility = from_rest.to("mobility")
    np.testing.assert_array_equal(mobility.value[0], 0)
    with pytest.raises(InvalidFrequencies, match="0 Hz"):
        mobility.to("receptance")


def test_unit_of_each_entry():
    held = frf()
    assert [[held.unit(i, j) for j in range(2)] for i in range(3)] == [
        ["m/N", "m/(N·m)"],
        ["m/N", "m/(N·m)"],
        ["rad/N", "rad/(N·m)"],
    ]
    assert held.unit() == "m/N"
    assert held.to("inertance").unit(2, 1) == "rad/(s²·N·m)"


def test_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        frf().form = "mobility"


def test_sense_of_response_and_reference():
    """Turning round the response or the reference turns the sign, both leave it."""
    held = SecondOrderSystem(np.eye(2), np.diag([0.3, 0.1]), np.diag([50.0, 80.0]), ("a", "b"))
    jacobian = np.random.default_rng(0).normal(size=(6, 2))
    ahead, back = PointDirection.parse("tool:+z"), PointDirection.parse("tool:-z")
    rows = np.stack([ahead.selector, back.selector]) @ jacobian
    found = Frf(FREQUENCY, receptance(held, rows, rows, FREQUENCY), (ahead, back), (ahead, back))
    np.testing.assert_array_equal(found.between(ahead, ahead), found.between(back, back))
    np.testing.assert_array_equal(found.between(ahead, back), -found.between(ahead, ahead))

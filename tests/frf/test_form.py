"""Receptance, mobility and inertance, and what they are measured in."""

import itertools

import numpy as np
import pytest

from flexmodal.errors import InvalidFrequencies, InvalidRequest
from flexmodal.frf.form import FORMS, check_form, convert, unit

FREQUENCY = np.array([0.5, 1.0, 20.0])
VALUE = np.array([1 + 2j, -0.3j, 4.0 + 0j])


def test_the_three_forms():
    assert FORMS == ("receptance", "mobility", "inertance")
    assert [check_form(form) for form in FORMS] == list(FORMS)


@pytest.mark.parametrize("bad", ["", "Receptance", "accelerance", "dynamic stiffness"])
def test_unknown_form_lists_the_three(bad):
    with pytest.raises(InvalidRequest, match="receptance, mobility, inertance") as raised:
        check_form(bad)
    assert raised.value.faults[0].found == repr(bad)


def test_differentiation_is_the_formula():
    # mobility iω α and inertance −ω² α, to some eps for the power.
    omega = 2 * np.pi * FREQUENCY
    np.testing.assert_allclose(
        convert(VALUE, FREQUENCY, "receptance", "mobility"), 1j * omega * VALUE, rtol=1e-14
    )
    np.testing.assert_allclose(
        convert(VALUE, FREQUENCY, "receptance", "inertance"), -(omega**2) * VALUE, rtol=1e-14
    )
    np.testing.assert_allclose(
        convert(VALUE, FREQUENCY, "inertance", "mobility"), VALUE / (1j * omega), rtol=1e-14
    )


@pytest.mark.parametrize(("source", "target"), list(itertools.product(FORMS, FORMS)))
def test_there_and_back(source, target):
    there = convert(VALUE, FREQUENCY, source, target)
    np.testing.assert_allclose(convert(there, FREQUENCY, target, source), VALUE, rtol=1e-14)  # some eps


@pytest.mark.parametrize(("source", "target"), list(itertools.product(FORMS, FORMS)))
def test_zero_hertz(source, target):
    frequency = np.array([0.0, 1.0])
    value = np.array([2.0 + 0j, 3.0 + 0j])
    order = FORMS.index(target) - FORMS.index(source)
    if order < 0:
        with pytest.raises(InvalidFrequencies, match=f"0 Hz in {source} to be integrated"):
            convert(value, frequency, source, target)
    else:
        assert convert(value, frequency, source, target)[0] == (2.0 if order == 0 else 0.0)


@pytest.mark.parametrize("shape", [(3,), (3, 2), (3, 2, 4), (3, 1, 1)])
def test_any_number_of_responses_and_references(shape):
    rng = np.random.default_rng(0)
    value = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    found = convert(value, FREQUENCY, "receptance", "mobility")
    assert found.shape == shape
    for line in range(3):
        np.testing.assert_allclose(found[line], 2j * np.pi * FREQUENCY[line] * value[line], rtol=1e-14)


@pytest.mark.parametrize(
    ("form", "response", "reference", "text"),
    [
        ("receptance", False, False, "m/N"),
        ("receptance", True, False, "rad/N"),
        ("receptance", False, True, "m/(N·m)"),
        ("receptance", True, True, "rad/(N·m)"),
        ("mobility", False, False, "m/(s·N)"),
        ("mobility", True, False, "rad/(s·N)"),
        ("mobility", False, True, "m/(s·N·m)"),
        ("mobility", True, True, "rad/(s·N·m)"),
        ("inertance", False, False, "m/(s²·N)"),
        ("inertance", True, False, "rad/(s²·N)"),
        ("inertance", False, True, "m/(s²·N·m)"),
        ("inertance", True, True, "rad/(s²·N·m)"),
    ],
)
def test_unit(form, response, reference, text):
    assert unit(form, response_rotates=response, reference_rotates=reference) == text

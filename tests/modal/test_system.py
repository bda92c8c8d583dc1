"""SecondOrderSystem: what it accepts, what it refuses, and how it says so."""

import dataclasses

import numpy as np
import pytest

from flexmodal.errors import FlexmodalError, InvalidSystem
from flexmodal.modal import SecondOrderSystem

NAMES = ("base", "elbow")
MASS = np.array([[2.0, 0.5], [0.5, 1.0]])
DAMPING = np.diag([0.3, 0.1])
STIFFNESS = np.array([[50.0, -20.0], [-20.0, 80.0]])


def system(mass=MASS, damping=DAMPING, stiffness=STIFFNESS, coordinates=NAMES):
    return SecondOrderSystem(mass, damping, stiffness, coordinates)


def faults(**given):
    with pytest.raises(InvalidSystem) as raised:
        system(**given)
    return raised.value.faults


def test_holds_what_it_was_given():
    held = system()
    np.testing.assert_array_equal(held.mass, MASS)
    np.testing.assert_array_equal(held.damping, DAMPING)
    np.testing.assert_array_equal(held.stiffness, STIFFNESS)
    assert held.dof == 2
    assert held.coordinates == NAMES


@pytest.mark.parametrize("name", ["mass", "damping", "stiffness"])
def test_arrays_are_read_only_copies(name):
    given = {"mass": MASS.copy(), "damping": DAMPING.copy(), "stiffness": STIFFNESS.copy()}
    held = system(**given)
    with pytest.raises(ValueError, match="read-only"):
        getattr(held, name)[0, 0] = 7.0
    before = getattr(held, name).copy()
    given[name][0, 0] = 99.0
    np.testing.assert_array_equal(getattr(held, name), before)
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(held, name, MASS)


@pytest.mark.parametrize("name", ["mass", "damping", "stiffness"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_not_finite_is_refused(name, bad):
    matrix = {"mass": MASS, "damping": DAMPING, "stiffness": STIFFNESS}[name].copy()
    matrix[0, 1] = matrix[1, 0] = bad
    (fault,) = faults(**{name: matrix})
    assert fault.key == name
    assert "finite" in fault.allowed


@pytest.mark.parametrize("name", ["mass", "damping", "stiffness"])
def test_asymmetry_is_refused(name):
    matrix = {"mass": MASS, "damping": DAMPING, "stiffness": STIFFNESS}[name].copy()
    matrix[0, 1] += 0.05
    (fault,) = faults(**{name: matrix})
    assert fault.key == name
    assert fault.found == "asymmetry of 0.05"


def test_rounding_is_evened_out():
    # 1e-12 of the largest entry lies below the 1e-9 that counts as rounding and far above eps.
    skewed = STIFFNESS.copy()
    skewed[0, 1] += 80e-12
    held = system(stiffness=skewed)
    np.testing.assert_array_equal(held.stiffness, held.stiffness.T)


def faults_of_shapes(mass, damping, stiffness, coordinates=NAMES):
    """As `faults`, past the check of the annotations that the tests switch on and ordinary use does not."""
    held = object.__new__(SecondOrderSystem)
    for name, value in (("mass", mass), ("damping", damping), ("stiffness", stiffness)):
        object.__setattr__(held, name, value)
    object.__setattr__(held, "coordinates", coordinates)
    with pytest.raises(InvalidSystem) as raised:
        held.__post_init__()
    return raised.value.faults


@pytest.mark.parametrize("shape", [(3, 3), (1, 1), (2, 3), (2,), (0, 0), (1, 2, 2)])
def test_wrong_shape_is_refused(shape):
    (fault,) = faults_of_shapes(MASS, np.ones(shape), STIFFNESS)
    assert fault.key == "damping"
    assert fault.found == f"shape {shape}"
    assert fault.allowed.startswith("2 × 2")


def test_no_coordinates_is_refused():
    empty = np.zeros((0, 0))
    assert len(faults(mass=empty, damping=empty, stiffness=empty, coordinates=())) == 3


@pytest.mark.parametrize("name", ["mass", "damping", "stiffness"])
@pytest.mark.parametrize("place", [0, 1])
def test_negative_diagonal_names_its_coordinate(name, place):
    diagonal = np.array([3.0, 3.0])
    diagonal[place] = -2.5
    (fault,) = faults(**{name: np.diag(diagonal)})
    assert fault.key == f"{name} of {NAMES[place]}"
    assert fault.found == "-2.5"


def test_massless_coordinate_is_refused():
    (fault,) = faults(mass=np.diag([1.0, 0.0]))
    assert fault.key == "mass of elbow"


def test_indefinite_by_coupling_is_refused():
    # [[1, 2], [2, 1]] has eigenvalues 3 and −1 although its diagonal is positive.
    coupled = np.array([[1.0, 2.0], [2.0, 1.0]])
    for name in ("mass", "damping", "stiffness"):
        (fault,) = faults(**{name: coupled})
        assert fault.key.startswith(f"{name} of ")
        assert fault.found == "a relative eigenvalue of -1"


def test_indefinite_names_the_coordinate_that_carries_it():
    # Between the first two the coupling exceeds the diagonal; the third stands alone.
    matrix = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 1.5], [0.0, 1.5, 1.0]])
    (fault,) = faults(
        mass=np.eye(3), damping=np.eye(3), stiffness=matrix, coordinates=("base", "elbow", "wrist")
    )
    assert fault.key in {"stiffness of elbow", "stiffness of wrist"}


def test_singular_mass_is_refused_singular_stiffness_is_not():
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    system(stiffness=spring, damping=spring)
    system(stiffness=np.zeros((2, 2)), damping=np.zeros((2, 2)))
    (fault,) = faults(mass=np.ones((2, 2)))
    assert fault.key.startswith("mass of ")


def test_every_fault_at_once():
    found = faults_of_shapes(np.diag([1.0, -1.0]), np.full((2, 2), np.nan), np.ones((3, 3)))
    assert [fault.key for fault in found] == ["mass of elbow", "damping", "stiffness"]
    assert {fault.file for fault in found} == {"system"}


def test_the_error_is_a_value_error_of_the_family():
    with pytest.raises(
        ValueError, match=r"system: mass of elbow: found -1; allowed: a positive definite"
    ) as raised:
        system(mass=np.diag([1.0, -1.0]))
    assert isinstance(raised.value, FlexmodalError)


@pytest.mark.parametrize("decades", [1e-150, 1e-12, 1e-4, 1e4, 1e12])
def test_units_do_not_matter(decades):
    # Scaling one coordinate scales its rows and columns: definite stays definite, indefinite indefinite.
    scale = np.outer([1.0, decades], [1.0, decades])
    system(mass=MASS * scale, damping=DAMPING * scale, stiffness=STIFFNESS * scale)
    indefinite = np.array([[1.0, 1.1], [1.1, 1.0]])
    assert len(faults(mass=indefinite * scale)) == 1
    assert len(faults(stiffness=indefinite * scale)) == 1

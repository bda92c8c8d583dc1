"""Masses that no structure can have."""

import numpy as np

from flexmodal.structure.definite import is_definite, with_inertia


def test_masses_that_are_definite_stay_the_same_object():
    mass = np.array([np.diag([2.0, 1e-9]), np.eye(2)])
    assert with_inertia(mass) is mass


def test_coordinates_without_mass_stay_so():
    mass = np.array([np.diag([2.0, 0.0, -1e-12])])
    assert not is_definite(mass)
    assert with_inertia(mass) is mass


def test_a_negative_inertia_becomes_as_large_a_positive_one():
    """In its direction; the others, and systems that are well, stay what they were."""
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    mass = np.array([turn @ np.diag([2.0, -0.3, 1.0]) @ turn.T, np.eye(3)])
    assert not is_definite(mass)
    made = with_inertia(mass)
    np.testing.assert_allclose(turn.T @ made[0] @ turn, np.diag([2.0, 0.3, 1.0]), atol=1e-14)
    np.testing.assert_allclose(made[1], np.eye(3), atol=1e-15)

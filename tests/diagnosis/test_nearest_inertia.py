"""Inertias that no body has become ones that a body can have; those that are sound stay."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from flexmodal.diagnosis.improved.inertia import nearest_inertia

BODY = np.array([[2.0, 0.1, 0.0], [0.1, 2.5, 0.3], [0.0, 0.3, 1.5]])
NORMAL = np.array([0.0, -1.0, 0.0])


def can_be(inertia):
    small, middle, large = np.linalg.eigvalsh(inertia)
    return small >= -1e-12 and small + middle >= large * (1 - 1e-12)


def test_a_body_stays_what_it_is():
    found, differs = nearest_inertia(BODY, None)
    assert_array_equal(found, BODY)
    assert not differs


def test_a_moment_that_exceeds_the_sum_of_the_others():
    wrong = np.diag([1.0, 1.0, 3.0])
    found, differs = nearest_inertia(wrong, None)
    assert differs
    assert can_be(found)
    assert_allclose(found, np.diag([1.5, 1.5, 3.0]))  # second moments 1.5, 1.5 and −0.5, which becomes 0


def test_in_a_plane_only_the_normal_counts():
    wrong = np.diag([0.1, 4.0, 0.2])
    found, differs = nearest_inertia(wrong, NORMAL)
    assert not differs
    assert can_be(found)
    assert_allclose(NORMAL @ found @ NORMAL, 4.0)


def test_a_negative_moment_becomes_none():
    found, differs = nearest_inertia(np.diag([0.1, -2.0, 0.1]), NORMAL)
    assert differs
    assert_array_equal(found, np.zeros((3, 3)))
    found, differs = nearest_inertia(np.diag([-1.0, -1.0, -1.0]), None)
    assert differs
    assert can_be(found)

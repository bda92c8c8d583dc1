"""One step of a linear system, against the exponential of a matrix."""

import numpy as np
import pytest
from scipy.linalg import expm

from flexmodal.diagnosis.time_domain import propagation
from flexmodal.diagnosis.time_domain.propagation import propagated

STEP = 2e-3


def system(damping, *, count=3, seed=0):
    """Matrices A and B of a chain of masses; `damping` of each mode's critical one."""
    random = np.random.default_rng(seed)
    shapes = random.normal(size=(count, count))
    omega = 2 * np.pi * np.geomspace(3.0, 150.0, count)
    back = np.linalg.inv(shapes)
    a = np.zeros((2 * count, 2 * count))
    a[:count, count:] = np.eye(count)
    a[count:, :count] = -shapes @ np.diag(omega**2) @ back
    a[count:, count:] = -shapes @ np.diag(2 * np.asarray(damping) * omega) @ back
    return a, np.vstack([np.zeros((count, 2)), random.normal(size=(count, 2))])


def by_exponential(a, b):
    """exp(A h) and the weights of both ends (Van Loan, IEEE Trans. Automatic Control 23, 1978)."""
    n, r = b.shape
    wide = np.zeros((n + 2 * r, n + 2 * r))
    wide[:n, :n], wide[:n, n : n + r] = a * STEP, b * STEP
    wide[n : n + r, n + r :] = np.eye(r)
    whole = expm(wide)
    late = whole[:n, n + r :]
    return whole[:n, :n], whole[:n, n : n + r] - late, late


def in_coordinates(part, number):
    """The same of a propagation, brought back."""
    (turn, cross), (early, late), back = part.once(), part.weights(), part.back[number]
    own = np.diag(turn[number])
    pairs = np.arange(len(own))
    own[pairs, pairs ^ 1] = cross[number]
    return back @ own @ np.linalg.inv(back), back @ early[number], back @ late[number]


@pytest.mark.parametrize(
    "damping",
    [(0.02, 0.02, 0.02), (0.001, 0.3, 3.0), (2.0, 4.0, 1.5), (1.0, 0.1, 1.0)],
    ids=["light", "mixed", "overdamped", "critical"],
)
def test_a_step_is_that_of_the_exponential(damping):
    systems = [system(damping, seed=seed) for seed in range(3)]
    part = propagated(np.array([a for a, _ in systems]), np.array([b for _, b in systems]), STEP)
    tolerance = 1e-6 if 1.0 in damping else 1e-11  # two poles meet: the square root of the last digit
    for number, (a, b) in enumerate(systems):
        for found, expected in zip(in_coordinates(part, number), by_exponential(a, b), strict=True):
            np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(expected).max())


def test_eigenvectors_that_are_parallel_are_pulled_apart(monkeypatch):
    a = np.array([[0.0, 1.0], [-100.0, -20.0]])  # a double pole
    b = np.array([[0.0], [1.0]])
    found = in_coordinates(propagated(a[None], b[None], STEP), 0)
    for one, expected in zip(found, by_exponential(a, b), strict=True):
        np.testing.assert_allclose(one, expected, atol=1e-8 * np.abs(expected).max())
    monkeypatch.setattr(propagation, "APART", 0.0)
    left, *_ = in_coordinates(propagated(a[None], b[None], STEP), 0)
    assert np.abs(left - by_exponential(a, b)[0]).max() > 1e-3  # it is needed


def test_eigenvectors_that_are_the_same_do_not_stop_it():
    whole = np.array([np.eye(2), [[1.0, 1.0], [0.0, 0.0]]])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np.linalg, "eig", lambda a: (np.zeros(a.shape[:2]), whole[: len(a)]))
        found = propagated(np.zeros((2, 2, 2)), np.ones((2, 2, 1)), STEP)
    assert np.all(np.isfinite(found.inputs))


def test_small_steps_take_their_weights_from_the_series():
    a, b = system((0.02, 0.02, 0.02))
    part = propagated(a[None], b[None], 1e-9)
    early, late = part.weights()
    np.testing.assert_allclose(part.back[0] @ (early + late)[0], 1e-9 * b, atol=1e-6 * 1e-9)
    np.testing.assert_allclose(early, late, rtol=1e-3, atol=1e-5 * np.abs(late).max())

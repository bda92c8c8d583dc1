"""Sixteen systems side by side against LAPACK, as ordinary Python and compiled."""

import numpy as np
import pytest

import flexmodal
from flexmodal.frf.kernels.factor import GROWTH
from flexmodal.model.batch import gradient_batch
from flexmodal.model.batch.tile import TILE, factor_tile, fill_lane, solve_tile


def filled(masses, stiffness, damping, loss, omega):
    n = len(stiffness)
    matrix, size = np.zeros((n, n, 2, TILE)), np.zeros((n, TILE))
    matrices, lag = np.array([stiffness, damping]), np.array([0.1 * loss, loss])
    for lane in range(TILE):
        fill_lane(np.arange(n), matrices, lag, omega[lane], masses[lane], lane, matrix, size)
    return matrix, size


def test_every_lane_is_a_system_of_its_own():
    rng = np.random.default_rng(3)
    n = 5
    A = rng.normal(size=(TILE, n, n))
    masses = A @ np.swapaxes(A, 1, 2) + 0.1 * np.eye(n)
    Q = rng.normal(size=(n, n))
    stiffness = Q @ Q.T + 100 * np.eye(n)
    damping, loss = 1e-2 * stiffness, 0.05 * np.diag(stiffness)
    omega = rng.uniform(0, 5, TILE)
    row = rng.normal(size=(TILE, n))
    matrix, size = filled(masses, stiffness, damping, loss, omega)
    trust, y = np.empty(TILE), np.zeros((n, 2, TILE))
    y[:, 0] = row.T
    factor_tile(matrix, size, trust)
    solve_tile(matrix, y)
    assert np.all(trust >= 0)
    for lane in range(TILE):
        w = omega[lane]
        Z = stiffness - w**2 * masses[lane] + 1j * w * damping + np.diag((0.1 + 1j) * loss)
        np.testing.assert_allclose(
            y[:, 0, lane] + 1j * y[:, 1, lane], np.linalg.solve(Z, row[lane]), rtol=1e-10
        )


def test_a_pivot_that_grows_is_not_trusted():
    """k − ω²m of the first coordinate next to nothing: the second pivot becomes −(ω²m₁₂)²/next to nothing."""
    masses = np.tile(np.array([[1.0, 0.5], [0.5, 2.0]]), (TILE, 1, 1))
    omega = np.linspace(0.5, 0.9, TILE)
    omega[7] = np.sqrt(1.0 - 1e-3 / GROWTH)
    matrix, size = filled(masses, np.eye(2), np.zeros((2, 2)), np.zeros(2), omega)
    trust = np.empty(TILE)
    factor_tile(matrix, size, trust)
    np.testing.assert_array_equal(np.flatnonzero(trust < 0), [7])


@pytest.mark.parametrize(("postures", "lines"), [(1, 1), (1, 40), (35, 1), (5, 7)])
def test_tiles_that_are_not_full(postures, lines):
    pytest.importorskip("numba")
    robot = flexmodal.load("six_link")
    q = np.random.default_rng(4).uniform(-1, 1, (postures, 6))
    axis = np.linspace(1.0, 20.0, lines)
    pairs = ["tool:+z", ("tool:+x", "tool:+z")]
    found, expected = (gradient_batch(robot, q, pairs, axis, way=way) for way in ("compiled", "numpy"))
    np.testing.assert_allclose(found.value, expected.value, rtol=1e-9)
    for one, other in zip(found.slope.reshape(-1, 6), expected.slope.reshape(-1, 6), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 * np.max(np.abs(other)))

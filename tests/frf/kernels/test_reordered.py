"""Points that the recursion does not trust, eliminated from the base, against LAPACK."""

import numpy as np
import pytest

from flexmodal.frf.kernels.reordered import WORTH_A_TILE, solve_from_base
from flexmodal.frf.kernels.task import Task

numba = pytest.importorskip("numba")


def task(n=9, systems=3, lines=40):
    rng = np.random.default_rng(0)
    A = rng.normal(size=(systems, n, n))
    mass = A @ np.swapaxes(A, 1, 2) + 0.1 * np.eye(n)
    rows = rng.normal(size=(systems, 2, n))
    stiffness = np.diag(10 ** rng.uniform(2, 4, n))
    pairs = ((0, 0), (0, 1))
    omega = np.linspace(1.0, 60.0, lines)
    return Task(
        systems,
        lambda part: (mass[part], rows[part]),
        stiffness,
        2e-3 * stiffness,
        0.01 * stiffness,
        pairs,
        omega,
    )


@pytest.mark.parametrize("holes", [0, WORTH_A_TILE - 1, 50])
def test_only_what_stands_as_nan_is_solved(holes):
    from flexmodal.frf.kernels.compiled import sweep_of_any_size

    whole = task()
    systems, lines = slice(0, 3), slice(10, 40)
    expected = np.empty((3, 30, 2), dtype=complex)
    whole.solve_lapack(systems, lines, expected)
    places = np.random.default_rng(1).permutation(90)[:holes]
    found = expected.copy()
    found.reshape(90, 2)[places] = np.nan
    marked = np.isnan(found[..., 0])
    left = solve_from_base(whole, whole.block(systems), lines, sweep_of_any_size().compiled, found)
    assert left == np.count_nonzero(np.isnan(found[..., 0]))
    assert left == holes if holes < WORTH_A_TILE else left < holes / 5
    solved = marked & ~np.isnan(found[..., 0])
    np.testing.assert_allclose(found[solved], expected[solved], rtol=1e-9)
    np.testing.assert_array_equal(found[~marked], expected[~marked])

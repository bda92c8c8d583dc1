"""The quadratic step against its optimality conditions, and against scipy's general solver."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, minimize

from flexmodal.optimisation.descent import work_for
from flexmodal.optimisation.descent.algebra import null_space, orthogonal_rows
from flexmodal.optimisation.descent.quadratic_step import quadratic_step as fill_step


def free_rows(matrix):
    """Orthonormal rows that span what a constraint leaves free."""
    held, width = matrix.shape
    rows, left, sizes, basis = matrix.copy(), np.empty((held, held)), np.empty(held), np.empty((width, width))
    orthogonal_rows(rows, left, sizes)
    return basis[null_space(rows, sizes, basis) :]


def quadratic_step(model, gradient, constraint, lower, upper):
    """The step as an array of its own; none where the model is not positive definite."""
    work = work_for(*constraint.shape)
    for name, values in (("model", model), ("gradient", gradient), ("below", lower), ("above", upper)):
        getattr(work, name)[:] = values
    return work.step.copy() if fill_step(work, 0.0, free_rows(constraint)) else None


def draw(seed: int, joints: int, held: int, tightness: float):
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(joints, joints))
    model = root @ root.T + 0.1 * np.eye(joints)
    lower = -tightness * generator.uniform(0, 1, joints) * (generator.uniform(size=joints) < 0.8)
    upper = tightness * generator.uniform(0, 1, joints) * (generator.uniform(size=joints) < 0.8)
    return model, 3 * generator.normal(size=joints), generator.normal(size=(held, joints)), lower, upper


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    joints=st.integers(1, 9),
    held=st.integers(0, 3),
    tightness=st.sampled_from([1e-3, 0.1, 1.0, 100.0]),
)
def test_it_is_the_minimum(seed, joints, held, tightness):
    """Feasible, and −(Bs + g) a combination of the held rows and of the limits met, pushing back."""
    model, gradient, constraint, lower, upper = draw(seed, joints, held, tightness)
    step = quadratic_step(model, gradient, constraint, lower, upper)
    assert np.all((lower <= step) & (step <= upper))
    # rounding of a few solves with condition up to some thousands
    assert np.max(np.abs(constraint @ step), initial=0.0) <= 1e-10
    slope = model @ step + gradient
    at_lower, at_upper = step <= lower + 1e-10, step >= upper - 1e-10
    unit = np.eye(joints)
    matrix = np.hstack([constraint.T, unit[:, at_lower], -unit[:, at_upper]])
    if matrix.shape[1] == 0:
        assert np.max(np.abs(slope)) <= 1e-9
        return
    lowest = np.r_[np.full(held, -np.inf), np.zeros(matrix.shape[1] - held)]
    multipliers = lsq_linear(matrix, slope, bounds=(lowest, np.inf), tol=1e-14).x
    assert np.max(np.abs(matrix @ multipliers - slope)) <= 1e-7


@pytest.mark.parametrize("seed", range(8))
def test_against_slsqp(seed):
    model, gradient, constraint, lower, upper = draw(seed, 6, 2, 0.5)
    found = quadratic_step(model, gradient, constraint, lower, upper)

    def cost(step):
        return 0.5 * step @ model @ step + gradient @ step

    other = minimize(
        cost,
        np.zeros(6),
        jac=lambda step: model @ step + gradient,
        bounds=list(zip(lower, upper, strict=True)),
        constraints={"type": "eq", "fun": lambda step: constraint @ step, "jac": lambda step: constraint},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert cost(found) <= cost(other.x) + 1e-9
    np.testing.assert_allclose(found, other.x, atol=1e-5)  # the other stops when the cost stands still


def test_no_limits_no_hold_is_newton():
    model, gradient, *_ = draw(3, 5, 0, 1.0)
    wide = np.full(5, np.inf)
    np.testing.assert_allclose(
        quadratic_step(model, gradient, np.zeros((0, 5)), -wide, wide), -np.linalg.solve(model, gradient)
    )


def test_nothing_can_move():
    model, gradient, constraint, lower, upper = draw(4, 4, 2, 1.0)
    np.testing.assert_array_equal(quadratic_step(model, gradient, constraint, 0 * lower, 0 * upper), 0)
    wide = np.full(4, np.inf)
    np.testing.assert_array_equal(quadratic_step(model, gradient, np.eye(4), -wide, wide), 0)


def test_a_model_that_is_not_definite():
    assert quadratic_step(-np.eye(2), np.ones(2), np.zeros((0, 2)), -np.ones(2), np.ones(2)) is None


def test_null_space():
    matrix = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]])  # one row said twice
    basis = free_rows(matrix)
    assert basis.shape == (2, 3)
    np.testing.assert_allclose(basis @ basis.T, np.eye(2), atol=1e-15)
    np.testing.assert_allclose(basis @ matrix.T, 0, atol=1e-14)
    np.testing.assert_array_equal(free_rows(np.zeros((0, 3))), np.eye(3))
    np.testing.assert_array_equal(free_rows(np.zeros((2, 3))).T @ free_rows(np.zeros((2, 3))), np.eye(3))

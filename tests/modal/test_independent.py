"""Modes against routes that share no code with them: the pencil, and polynomial roots at 50 digits."""

import mpmath
import numpy as np
import pytest
import scipy.linalg
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flexmodal.modal import SecondOrderSystem, solve_modes

settings.register_profile("modes", deadline=None, derandomize=True, database=None, max_examples=50)
PROFILE = settings.get_profile("modes")


def even(matrix):
    return (matrix + matrix.T) / 2


def spd(rng, size, decades):
    Q = np.linalg.qr(rng.normal(size=(size, size)))[0]
    return even(Q @ np.diag(10 ** rng.uniform(0, decades, size)) @ Q.T)


def random_system(size, level, seed):
    """Random full matrices; `level` is the logarithm of the damping, from nearly none to overdamped."""
    rng = np.random.default_rng(seed)
    mass, stiffness = spd(rng, size, 1), spd(rng, size, 2)
    damping = spd(rng, size, 2) * 10.0**level
    return SecondOrderSystem(mass, damping, stiffness, tuple(f"q{i}" for i in range(size)))


# Hypothesis chooses the recipe; the matrices are drawn inside the test.
recipes = st.tuples(st.integers(1, 6), st.floats(-4, 2), st.integers(0, 2**32 - 1))


def pencil(held):
    S = np.block([[held.damping, held.mass], [held.mass, np.zeros_like(held.mass)]])
    T = np.block([[held.stiffness, np.zeros_like(held.mass)], [np.zeros_like(held.mass), -held.mass]])
    return S, T


@PROFILE
@given(recipes)
def test_poles_are_those_of_the_pencil(recipe):
    held = random_system(*recipe)
    S, T = pencil(held)
    truth = scipy.linalg.eig(T, -S, right=False)
    found = solve_modes(held)
    assume(np.max(found.condition) < 100)
    poles, _ = found.expanded()
    assert len(poles) == 2 * held.dof
    # Two backward stable routes: eps × the largest pole × the condition of S and of the pole. S is no
    # worse than 1e3 and a pole, by the line above, than 1e2: 1e-16 × 1e5 with a margin of ten.
    distance = np.abs(poles[:, None] - truth[None, :])
    limit = 1e-10 * np.max(np.abs(truth))
    assert np.max(distance.min(axis=0)) < limit
    assert np.max(distance.min(axis=1)) < limit


@PROFILE
@given(recipes)
def test_scaling_and_orthogonality_across_modes(recipe):
    held = random_system(*recipe)
    found = solve_modes(held)
    assume(np.max(found.condition) < 100)
    poles, shapes = found.expanded()
    # The formula of the docstring, mode by mode: uᵀ(2λM + C)u = 1.
    scale = np.einsum("ip,pij,jp->p", shapes, 2 * poles[:, None, None] * held.mass + held.damping, shapes)
    # eps × condition × the decades of poles (up to 1e5), after one step of orthogonalisation.
    np.testing.assert_allclose(scale, 1, atol=1e-9)
    phi = np.vstack([shapes, shapes * poles])
    S, T = pencil(held)
    np.testing.assert_allclose(phi.T @ S @ phi, np.eye(len(poles)), atol=1e-9)
    # φᵀTφ = −Λ: its entries are of the size of the poles.
    np.testing.assert_allclose(phi.T @ T @ phi, -np.diag(poles), atol=1e-9 * np.max(np.abs(poles)))


@PROFILE
@given(recipes)
def test_each_mode_solves_the_quadratic_problem(recipe):
    held = random_system(*recipe)
    found = solve_modes(held)
    for pole, u in zip(found.pole, found.shape.T, strict=True):
        terms = [pole**2 * held.mass, pole * held.damping, held.stiffness]
        size = sum(np.linalg.norm(term, 2) for term in terms) * np.linalg.norm(u)
        # A residual relative to the terms: eps times cond(M) and the spread of poles, far below 1e-8.
        assert np.linalg.norm(sum(terms) @ u) <= 1e-8 * size


@PROFILE
@given(recipes)
def test_a_passive_system_has_no_growing_mode(recipe):
    held = random_system(*recipe)
    found = solve_modes(held)
    # Rounding may lift a pole by eps × the largest one.
    assert np.all(found.pole.real <= 1e-12 * np.max(np.abs(found.pole)))
    assert np.all(found.damping_ratio <= 1 + 1e-12)


def horner(coefficients, x):
    value = mpmath.mpf(0)
    for coefficient in coefficients:
        value = value * x + coefficient
    return value


def determinant(held):
    """Coefficients of det(λ²M + λC + K) of two coordinates, highest power first, at full precision."""
    (m, c, k) = (
        [[mpmath.mpf(float(x)) for x in row] for row in matrix]
        for matrix in (held.mass, held.damping, held.stiffness)
    )

    def product(i, j, p, q):
        a, b = (m[i][j], c[i][j], k[i][j]), (m[p][q], c[p][q], k[p][q])
        return [sum(a[s] * b[n - s] for s in range(3) if 0 <= n - s < 3) for n in range(5)]

    return [x - y for x, y in zip(product(0, 0, 1, 1), product(0, 1, 1, 0), strict=True)]


@pytest.mark.parametrize("level", [-4, -1, 0, 1, 2])
@pytest.mark.parametrize("seed", range(4))
def test_poles_and_residues_against_polynomial_roots(level, seed):
    held = random_system(2, level, seed)
    found = solve_modes(held)
    with mpmath.workdps(50):
        coefficients = determinant(held)
        slope = [(4 - n) * a for n, a in enumerate(coefficients[:-1])]
        roots = [mpmath.mpc(root) for root in np.roots([float(a) for a in coefficients])]
        for _ in range(8):  # Newton from sixteen digits, or from four, doubles them beyond fifty
            roots = [x - horner(coefficients, x) / horner(slope, x) for x in roots]
        truth = []
        for root in roots:
            if root.imag < -(mpmath.mpf(10) ** -30):
                continue
            p = [
                [
                    root**2 * float(held.mass[i, j])
                    + root * float(held.damping[i, j])
                    + float(held.stiffness[i, j])
                    for j in range(2)
                ]
                for i in range(2)
            ]
            # Residue of the inverse: adjugate over the slope of the determinant.
            adjugate = [[p[1][1], -p[0][1]], [-p[1][0], p[0][0]]]
            residue = [[complex(x / horner(slope, root)) for x in row] for row in adjugate]
            truth.append((complex(root), np.array(residue)))
    truth.sort(key=lambda one: abs(one[0]))
    # Rounding of eps × the fastest pole lands on the slowest one, times its condition; ten times that.
    spread = abs(truth[-1][0]) / abs(truth[0][0])
    limit = 10 * np.finfo(float).eps * spread * np.max(found.condition)
    assert limit < 1e-7
    np.testing.assert_allclose(found.pole, [pole for pole, _ in truth], rtol=limit)
    for u, (_, residue) in zip(found.shape.T, truth, strict=True):
        np.testing.assert_allclose(np.outer(u, u), residue, rtol=0, atol=limit * np.max(np.abs(residue)))

"""Modes against what can be worked out on paper.

Tolerance: a well-conditioned eigenproblem of a handful of coordinates is solved to some units in the last
place of its largest pole; 1e-12 leaves a factor of several hundred for their sum, and no wrong formula
comes as near as that.
"""

import numpy as np
import pytest

from flexmodal.modal import SecondOrderSystem, solve_modes

RTOL = 1e-12


def system(mass, damping, stiffness):
    arrays = [np.array(matrix, dtype=float) for matrix in (mass, damping, stiffness)]
    return SecondOrderSystem(*arrays, tuple(f"q{i}" for i in range(len(arrays[0]))))


def oscillator(m, c, k):
    return system([[m]], [[c]], [[k]])


def rotation(size, seed):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(size, size)))[0]


def even(matrix):
    return (matrix + matrix.T) / 2


@pytest.mark.parametrize("ratio", [0.0, 1e-6, 0.02, 0.5, 0.99])
@pytest.mark.parametrize(("m", "k"), [(1.0, 1.0), (3.0, 7e5), (2e-4, 0.3)])
def test_underdamped_oscillator(m, k, ratio):
    omega = np.sqrt(k / m)
    found = solve_modes(oscillator(m, 2 * ratio * np.sqrt(k * m), k))
    pole = omega * (-ratio + 1j * np.sqrt(1 - ratio**2))
    # At a ratio of 0.99 the square root loses a factor 1/(1 − ζ²) = 50, inside the tolerance.
    np.testing.assert_allclose(found.pole, [pole], rtol=RTOL)
    np.testing.assert_allclose(found.frequency, [omega / (2 * np.pi)], rtol=RTOL)
    # atol: the ratio 0 is only zero as far as rounding of the size of eps goes.
    np.testing.assert_allclose(found.damping_ratio, [ratio], rtol=RTOL, atol=1e-15)
    assert not found.overdamped.any()
    assert not found.is_defective
    # Residue of pole p: 1 / (m (λ − λ̄)), from partial fractions of 1 / (m (s − λ)(s − λ̄)).
    residue = 1 / (m * (pole - pole.conj()))
    np.testing.assert_allclose(found.shape[0] ** 2, [residue], rtol=RTOL)


@pytest.mark.parametrize("ratio", [1.01, 3.0, 1e4])
@pytest.mark.parametrize(("m", "k"), [(1.0, 1.0), (3.0, 7e5), (2e-4, 0.3)])
def test_overdamped_oscillator_has_two_single_real_poles(m, k, ratio):
    omega = np.sqrt(k / m)
    found = solve_modes(oscillator(m, 2 * ratio * np.sqrt(k * m), k))
    # The slow pole as k / (m fast): −ζ + √(ζ² − 1) would cancel on paper just as in the computer.
    fast = -omega * (ratio + np.sqrt(ratio**2 - 1))
    slow = omega**2 / fast
    np.testing.assert_allclose(found.pole, [slow, fast], rtol=RTOL)
    assert found.overdamped.all()
    np.testing.assert_allclose(found.damping_ratio, [1.0, 1.0], rtol=RTOL)
    np.testing.assert_allclose(
        found.shape[0] ** 2, [1 / (m * (slow - fast)), 1 / (m * (fast - slow))], rtol=RTOL
    )
    assert len(found.expanded()[0]) == 2


def test_two_equal_masses_between_walls():
    # m, k – m, k – m, k: in phase at √(k/m), against each other at √(3k/m).
    m, k = 2.5, 40.0
    found = solve_modes(system(np.eye(2) * m, np.zeros((2, 2)), [[2 * k, -k], [-k, 2 * k]]))
    omega = np.sqrt(np.array([1.0, 3.0]) * k / m)
    np.testing.assert_allclose(found.pole, 1j * omega, rtol=RTOL)
    # Mass-normalised shapes (1, ±1)/√(2m), and φφᵀ/(2iω) the residue.
    for mode, signs in enumerate(([[1, 1], [1, 1]], [[1, -1], [-1, 1]])):
        residue = np.array(signs) / (2 * m) / (2j * omega[mode])
        u = found.shape[:, mode]
        np.testing.assert_allclose(np.outer(u, u), residue, rtol=RTOL)


def test_unequal_chain_on_paper():
    # m₁ = 2, m₂ = 1, wall – 3 – m₁ – 1 – m₂: det [[4 − 2x, −1], [−1, 1 − x]] = 2x² − 6x + 3, x = ω².
    found = solve_modes(system(np.diag([2.0, 1.0]), np.zeros((2, 2)), [[4.0, -1.0], [-1.0, 1.0]]))
    square = (3 + np.array([-1, 1]) * np.sqrt(3.0)) / 2
    np.testing.assert_allclose((found.pole / 1j) ** 2, square, rtol=RTOL)
    # Second row: −u₁ + (1 − x) u₂ = 0.
    np.testing.assert_allclose(found.shape[0] / found.shape[1], 1 - square, rtol=RTOL)


def test_undamped_modes_are_those_of_the_real_problem():
    # Rows turned at random; M = TTᵀ, K = T diag(ω²) Tᵀ have exactly the frequencies ω.
    rng = np.random.default_rng(3)
    omega = np.array([1.0, 2.0, 5.0, 7.0, 11.0])
    T = rng.normal(size=(5, 5)) + 3 * np.eye(5)
    found = solve_modes(system(even(T @ T.T), np.zeros((5, 5)), even(T @ np.diag(omega**2) @ T.T)))
    np.testing.assert_allclose(found.pole.imag, omega, rtol=1e-11)  # cond(M) of some tens costs a digit
    assert np.all(found.pole.real == 0)
    np.testing.assert_allclose(found.condition, 1.0, rtol=RTOL)


def test_rayleigh_damping():
    # C = aM + bK gives ζ = (a/ω + bω)/2 at unchanged frequencies |λ|.
    rng = np.random.default_rng(4)
    omega = np.array([1.0, 2.0, 5.0, 7.0])
    T = rng.normal(size=(4, 4)) + 3 * np.eye(4)
    M, K = even(T @ T.T), even(T @ np.diag(omega**2) @ T.T)
    a, b = 0.04, 0.02
    found = solve_modes(system(M, a * M + b * K, K))
    np.testing.assert_allclose(found.frequency * 2 * np.pi, omega, rtol=1e-11)
    np.testing.assert_allclose(found.damping_ratio, (a / omega + b * omega) / 2, rtol=1e-10)
    # Proportional damping leaves the shapes real up to one complex factor.
    turned = found.shape / found.shape[np.argmax(np.abs(found.shape), axis=0), range(4)]
    assert np.max(np.abs(turned.imag)) < 1e-12


def test_general_caughey_damping():
    # C = M Σ aⱼ (M⁻¹K)ʲ, j = −1 … 2: the modal damping is Σ aⱼ ω²ʲ, in no way of the Rayleigh form.
    rng = np.random.default_rng(5)
    omega = np.array([1.0, 1.5, 2.0, 3.0])
    T = rng.normal(size=(4, 4)) + 3 * np.eye(4)
    M, K = even(T @ T.T), even(T @ np.diag(omega**2) @ T.T)
    weights = {-1: 0.05, 0: 0.01, 1: 0.002, 2: 0.03}
    inner = np.linalg.solve(M, K)
    C = even(M @ sum(a * np.linalg.matrix_power(inner, j) for j, a in weights.items()))
    found = solve_modes(system(M, C, K))
    c = sum(a * omega ** (2.0 * j) for j, a in weights.items())
    # The highest mode: c = 2.45 < 2ω = 6, so that all four are underdamped and keep |λ| = ω.
    np.testing.assert_allclose(found.frequency * 2 * np.pi, omega, rtol=1e-10)
    np.testing.assert_allclose(found.damping_ratio, c / (2 * omega), rtol=1e-9)


def test_mixed_over_and_underdamped():
    # Three free-standing oscillators behind a rotation: ζ = 0.1, 2 and 0.
    Q = rotation(3, 6)
    omega, ratio = np.array([1.0, 4.0, 30.0]), np.array([0.1, 2.0, 0.0])
    found = solve_modes(
        system(np.eye(3), even(Q @ np.diag(2 * ratio * omega) @ Q.T), even(Q @ np.diag(omega**2) @ Q.T))
    )
    root = np.sqrt(3.0)
    paper = [-0.1 + 1j * np.sqrt(0.99), -4 * (2 - root), -4 * (2 + root), 30j]
    # atol: 1e-12 of the largest pole, as the smaller ones carry its rounding.
    np.testing.assert_allclose(found.pole, paper, rtol=0, atol=30 * RTOL)
    np.testing.assert_array_equal(found.overdamped, [False, True, True, False])
    assert len(found.expanded()[0]) == 6


def test_order_is_by_size_of_the_pole():
    rng = np.random.default_rng(7)
    for _ in range(20):
        A, B, C = rng.normal(size=(3, 4, 4))
        found = solve_modes(system(even(A @ A.T) + np.eye(4), even(B @ B.T) * 3, even(C @ C.T)))
        assert np.all(np.diff(np.abs(found.pole)) >= 0)
        assert np.all(found.pole.imag >= 0)
        assert np.all(np.diff(found.frequency) >= 0)


def test_expanded_lists_pairs_twice_and_real_poles_once():
    found = solve_modes(system(np.eye(2), np.diag([0.2, 30.0]), np.diag([1.0, 100.0])))
    poles, shapes = found.expanded()
    assert len(found.pole) == 3
    assert poles.shape == (4,)
    assert shapes.shape == (2, 4)
    assert np.count_nonzero(poles.imag) == 2
    assert poles.sum().imag == 0
    # The sum of all poles is −trace(M⁻¹C).
    np.testing.assert_allclose(poles.sum().real, -30.2, rtol=RTOL)


def test_free_body_with_a_grounded_damper():
    # K = 0: each coordinate slides, λ = 0 and λ = −c/m.
    found = solve_modes(system(np.diag([2.0, 4.0]), np.diag([1.0, 8.0]), np.zeros((2, 2))))
    np.testing.assert_allclose(found.pole, [0, 0, -0.5, -2.0], rtol=RTOL)
    assert not found.is_defective
    np.testing.assert_array_equal(found.damping_ratio, 1.0)


def test_spring_between_two_free_masses():
    # One rigid-body motion at 0 (both its poles, so no full set of modes) and √(2k/m) = 3.
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    found = solve_modes(system(np.eye(2), np.zeros((2, 2)), 4.5 * spring))
    # A frequency is the root of an eigenvalue that is zero to eps: half the digits, √eps ≈ 1.5e-8.
    np.testing.assert_allclose(found.pole, [0, 0, 3j][-len(found.pole) :], rtol=RTOL, atol=1e-7)


def test_no_stiffness_and_no_damping_is_defective():
    found = solve_modes(system(np.diag([2.0, 1.0]), np.zeros((2, 2)), np.zeros((2, 2))))
    np.testing.assert_array_equal(found.pole, 0)
    assert found.is_defective


def test_eight_decades_of_stiffness_undamped():
    # Coupled through the mass; the soft frequency against the quotient uᵀKu of a 50-digit eigenproblem.
    import mpmath

    mass = np.array([[3.0, 0.5, 0.2], [0.5, 2.0, 0.1], [0.2, 0.1, 1.0]])
    stiffness = np.diag([1e8, 1e4, 1.0])
    found = solve_modes(system(mass, np.zeros((3, 3)), stiffness))
    with mpmath.workdps(50):
        inverse = mpmath.inverse(mpmath.matrix(mass.tolist()))
        values = mpmath.eig(inverse * mpmath.matrix(stiffness.tolist()), left=False, right=False)
        truth = [float(mpmath.sqrt(v.real)) for v in sorted(values, key=lambda v: v.real)]
    # Rounding of eps × 1e8 in ω² against a soft ω² of 1: 1e-8 in the worst case, half that in ω.
    np.testing.assert_allclose(found.pole.imag, truth, rtol=1e-8)


def test_eight_decades_uncoupled_are_exact():
    # Every number stands in a coordinate of its own: nothing is lost, and no soft mode looks defective
    # because a neighbour is stiff or heavily damped.
    stiffness, damping = np.array([1.0, 1e4, 1e8]), np.array([0.1, 10.0, 1e6])
    found = solve_modes(system(np.eye(3), np.diag(damping), np.diag(stiffness)))
    slow, fast = -1e8 / (5e5 + np.sqrt(2.5e11 - 1e8)), -(5e5 + np.sqrt(2.5e11 - 1e8))
    paper = [-0.05 + 1j * np.sqrt(1 - 0.05**2), -5 + 1j * np.sqrt(1e4 - 25), slow, fast]
    np.testing.assert_allclose(found.pole, paper, rtol=RTOL)
    # An oscillator far from critical damping has a condition of a few.
    assert np.all(found.condition < 5)


@pytest.mark.parametrize("damping", [0.0, 0.3, 40.0])
def test_signs_of_shapes_do_not_hang_on_rounding(damping):
    """The largest component points towards −30°, whatever the solver made of the eigenvector."""
    random = np.random.default_rng(1)
    for _ in range(20):
        n = int(random.integers(1, 7))
        a, b = random.normal(size=(2, n, n))
        mass, stiffness = a @ a.T + np.eye(n), 100 * (b @ b.T + np.eye(n))
        modes = solve_modes(system(mass, damping * (mass + stiffness / 50), stiffness))
        largest = modes.shape[np.argmax(np.abs(modes.shape), axis=0), np.arange(modes.shape.shape[1])]
        assert np.all((largest * np.exp(1j * np.pi / 6)).real > 0.4 * np.abs(largest))

"""Repeated poles, nearly repeated poles, and poles without a full set of modes."""

import numpy as np
import pytest

from flexmodal.errors import DefectiveModes
from flexmodal.frf.receptance import modal_sum, receptance
from flexmodal.modal import SecondOrderSystem, solve_modes
from flexmodal.modal.modes import DEFECTIVE

A = np.array([[2.0, -0.5], [-0.5, 1.0]])
C = np.array([[0.3, 0.1], [0.1, 0.2]])  # A⁻¹C and A⁻¹K do not commute
K = np.array([[50.0, -20.0], [-20.0, 80.0]])
LINES = np.array([0.0, 0.3, 1.0, 3.0])


def system(mass, damping, stiffness):
    arrays = [np.array(matrix, dtype=float) for matrix in (mass, damping, stiffness)]
    return SecondOrderSystem(*arrays, tuple(f"q{i}" for i in range(len(arrays[0]))))


def even(matrix):
    return (matrix + matrix.T) / 2


def rotation(size, seed):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(size, size)))[0]


def copies(count, seed, damping=1.0):
    """The same non-proportional pair of coordinates several times over, behind one rotation."""
    Q = rotation(2 * count, seed)
    return system(*(even(Q @ np.kron(np.eye(count), X) @ Q.T) for X in (A, C * damping, K)))


def s_product(held, found):
    """ΦᵀSΦ over all poles, with S = [[C, M], [M, 0]] written out."""
    poles, shapes = found.expanded()
    phi = np.vstack([shapes, shapes * poles])
    S = np.block([[held.damping, held.mass], [held.mass, np.zeros_like(held.mass)]])
    return phi.T @ S @ phi


def gap(held, found):
    """Largest error of the modal sum, relative to the largest entry at its line."""
    rows = np.eye(held.dof)
    direct = receptance(held, rows, rows, LINES)
    summed = modal_sum(found, rows, rows, LINES)
    return np.max(np.abs(summed - direct) / np.max(np.abs(direct), axis=(1, 2), keepdims=True))


def test_repeated_undamped():
    Q = rotation(3, 1)
    held = system(np.eye(3), np.zeros((3, 3)), even(Q @ np.diag([9.0, 9.0, 25.0]) @ Q.T))
    found = solve_modes(held)
    np.testing.assert_allclose(found.pole, [3j, 3j, 5j], rtol=1e-13)  # some units in the last place
    # Symmetric eigenvectors are orthogonal to a few eps whatever the gap.
    np.testing.assert_allclose(s_product(held, found), np.eye(6), atol=1e-13)
    assert gap(held, found) < 1e-12


def test_repeated_proportional():
    held = system(np.eye(3), 0.1 * np.eye(3), 100 * np.eye(3))
    found = solve_modes(held)
    np.testing.assert_allclose(found.pole, [-0.05 + 1j * np.sqrt(100 - 0.0025)] * 3, rtol=1e-14)
    assert np.linalg.matrix_rank(found.shape) == 3
    assert gap(held, found) < 1e-13


def test_equal_stiffness_unequal_damping():
    # M⁻¹K is the identity and commutes with anything: three oscillators, one of them overdamped.
    Q = rotation(3, 2)
    held = system(np.eye(3), even(Q @ np.diag([0.1, 0.2, 50.0]) @ Q.T), 100 * np.eye(3))
    found = solve_modes(held)
    slow = -100 / (25 + np.sqrt(525.0))
    paper = [slow, -0.1 + 1j * np.sqrt(99.99), -0.05 + 1j * np.sqrt(99.9975), 100 / slow]
    np.testing.assert_allclose(sorted(found.pole, key=np.real), sorted(paper, key=np.real), rtol=1e-12)
    assert gap(held, found) < 1e-12


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("damping", [1.0, 100.0, 1000.0])
def test_repeated_non_proportional(count, damping):
    """At 1 all poles are complex, at 100 some real, at 1000 all real: each one must come `count` times."""
    single = solve_modes(system(A, C * damping, K))
    for seed in range(25):  # equal real poles come out as a false complex pair in some rotations only
        held = copies(count, seed, damping)
        found = solve_modes(held)
        # Rounding of eps × (fastest pole)² lands on each pole: 1e-16 × 400² / 1 on a slow one at worst.
        np.testing.assert_allclose(found.pole, np.repeat(single.pole, count), rtol=1e-10)
        np.testing.assert_array_equal(found.overdamped, np.repeat(single.overdamped, count))
        # The same rounding, amplified by a condition below ten.
        np.testing.assert_allclose(s_product(held, found), np.eye(4 * count), atol=1e-10)
        assert gap(held, found) < 1e-10
        assert not found.is_defective


@pytest.mark.parametrize("damping", [1.0, 100.0])
@pytest.mark.parametrize("apart", [1e-12, 1e-10, 1e-9, 3e-9, 1e-8, 1e-6, 1e-3])
def test_nearly_repeated(apart, damping):
    for seed in range(10):
        Q = rotation(4, seed)
        zero = np.zeros((2, 2))
        held = system(
            even(Q @ np.kron(np.eye(2), A) @ Q.T),
            even(Q @ np.kron(np.eye(2), C * damping) @ Q.T),
            even(Q @ np.block([[K, zero], [zero, K * (1 + apart)]]) @ Q.T),
        )
        # Poles nearer than 1e-9 are taken as one, which errs by their distance (with a factor for the
        # resonance); those farther apart are orthogonal to (1e-14 / 1e-9)² = 1e-10.
        assert gap(held, solve_modes(held)) < 1e-8


def critical(m, k):
    return system([[m]], [[2 * np.sqrt(m * k)]], [[k]])


@pytest.mark.parametrize(("m", "k"), [(1.0, 1.0), (3.0, 7.0), (0.1, 3e5)])
def test_critical_damping_is_defective_and_the_direct_solve_is_not(m, k):
    held = critical(m, k)
    found = solve_modes(held)
    assert found.is_defective
    # A double root found to eps splits by √eps = 1.5e-8, so the condition is near 1e8 or infinite.
    assert np.all(found.condition > 1e6)
    np.testing.assert_allclose(found.pole, -np.sqrt(k / m), rtol=1e-6)  # the same √eps, with room
    rows = np.eye(1)
    with pytest.raises(DefectiveModes, match="direct solve"):
        modal_sum(found, rows, rows, LINES)
    omega = 2 * np.pi * LINES
    paper = 1 / (m * (np.sqrt(k / m) + 1j * omega) ** 2)
    np.testing.assert_allclose(receptance(held, rows, rows, LINES)[:, 0, 0], paper, rtol=1e-14)


def test_one_critical_mode_among_others():
    Q = rotation(3, 8)
    omega, ratio = np.array([2.0, 5.0, 9.0]), np.array([0.1, 1.0, 0.3])
    held = system(np.eye(3), even(Q @ np.diag(2 * ratio * omega) @ Q.T), even(Q @ np.diag(omega**2) @ Q.T))
    found = solve_modes(held)
    assert found.is_defective
    far = np.abs(found.pole + 5) > 1  # the other modes are as good as ever
    assert np.all(found.condition[far] < 10)
    rows = np.eye(3)
    drive = 2j * np.pi * LINES[:, None]
    diagonal = 1 / (drive**2 + 2 * ratio * omega * drive + omega**2)
    paper = np.einsum("ip,lp,jp->lij", Q, diagonal, Q)
    # Solving with a condition of (9/2)² and some units in the last place.
    np.testing.assert_allclose(receptance(held, rows, rows, LINES), paper, rtol=0, atol=1e-14)


def test_complex_defective_pole():
    # det(λ² + Cλ + K) = (λ² + aλ + κ − d²/2)² for C = diag(a ± d), K = [[κ + ad/2, k], [k, κ − ad/2]],
    # k² = d²(κ − (a² + d²)/4): a double complex pole with one shape. a = 0.5, d = 0.4, κ = 4.
    a, d, kappa = 0.5, 0.4, 4.0
    k = d * np.sqrt(kappa - (a**2 + d**2) / 4)
    stiffness = np.array([[kappa + a * d / 2, k], [k, kappa - a * d / 2]])
    held = system(np.eye(2), np.diag([a + d, a - d]), stiffness)
    found = solve_modes(held)
    pole = -a / 2 + 1j * np.sqrt(kappa - d**2 / 2 - a**2 / 4)
    np.testing.assert_allclose(found.pole, [pole, pole], rtol=1e-6)  # √eps again
    assert found.is_defective
    with pytest.raises(DefectiveModes):
        modal_sum(found, np.eye(2), np.eye(2), LINES)
    s = 2j * np.pi * LINES
    p, q = s**2 + (a + d) * s + stiffness[0, 0], s**2 + (a - d) * s + stiffness[1, 1]
    det = (s**2 + a * s + kappa - d**2 / 2) ** 2
    paper = np.array([[q, -k + 0 * s], [-k + 0 * s, p]]).transpose(2, 0, 1) / det[:, None, None]
    # det by its factors and by elimination agree to eps × |pq/det|, which is below 10 here.
    np.testing.assert_allclose(receptance(held, np.eye(2), np.eye(2), LINES), paper, rtol=1e-13)


@pytest.mark.parametrize("off", [1e-12, 1e-9, 1e-7, 1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("side", [-1, 1])
def test_condition_near_critical_damping(off, side):
    """On paper 2λ + c = ∓2√(ζ² − 1), so the condition is about 4/(2√(2·off)) for |λ| = 1."""
    held = system([[1.0]], [[2 * (1 + side * off)]], [[1.0]])
    found = solve_modes(held)
    # 10 %: ζ² − 1 ≈ 2·off is good to off itself, |λ| to √off, and rounding of 2·off to eps/off = 2e-4.
    np.testing.assert_allclose(found.condition, 4 / (2 * np.sqrt(2 * off)), rtol=0.15 if off > 1e-3 else 0.01)
    # Conditions of 1.4e6 and 4.5e4 are refused, those of 4.5e3 and less keep half the digits of the sum.
    assert found.is_defective == (off <= 1e-9)
    assert found.is_defective == bool(np.max(found.condition) > DEFECTIVE)
    if not found.is_defective:
        # The sum of two residues of size κ, each known to κ·eps: κ²·eps, with a factor ten.
        assert gap(held, found) < 10 * np.max(found.condition) ** 2 * np.finfo(float).eps


def test_what_passes_as_sound_keeps_half_its_digits():
    """Random systems with one mode near critical damping: the promise of DEFECTIVE, kept or refused."""
    rng = np.random.default_rng(9)
    checked = 0
    for _ in range(200):
        Q = np.linalg.qr(rng.normal(size=(2, 2)))[0]
        off = 10 ** rng.uniform(-14, -1) * rng.choice([-1, 1])
        k = np.exp(2 * rng.normal())
        coupling = 10 ** rng.uniform(-8, -1) * np.ones((2, 2))
        damping = np.sqrt(k) * (Q @ np.diag([2 * (1 + off), 0.3]) @ Q.T + coupling)
        held = system(np.eye(2), even(damping), even(Q @ np.diag([k, 3 * k]) @ Q.T))
        found = solve_modes(held)
        if not found.is_defective:
            checked += 1
            assert gap(held, found) < 1e-6  # 20 × eps × DEFECTIVE², the factor measured on 20 000 systems
    assert checked > 50


@pytest.mark.parametrize("damped", [False, True])
def test_rigid_body_without_damping_of_its_own(damped):
    """Its pole 0 is double with one shape; the direct solve needs no modes and is right."""
    link = np.array([[1.0, -1.0], [-1.0, 1.0]])
    held = system(np.eye(2), 0.1 * damped * link, 9.0 * link)
    lines = np.array([0.1, 1.0, 5.0])
    s = 2j * np.pi * lines
    rigid, bending = 0.5 / s**2, 0.5 / (s**2 + 0.2 * damped * s + 18)
    paper = np.array([[rigid + bending, rigid - bending], [rigid - bending, rigid + bending]]).transpose(
        2, 0, 1
    )
    # Rigid and bending parts cancel in the off-diagonal at low frequency; 1e-12 leaves three digits for it.
    np.testing.assert_allclose(receptance(held, np.eye(2), np.eye(2), lines), paper, rtol=1e-12)
    assert solve_modes(held).is_defective

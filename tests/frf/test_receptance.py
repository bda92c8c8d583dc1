"""The direct solve against paper, against 50 digits, and against what physics demands."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmodal.frf.receptance import dynamic_stiffness, receptance
from flexmodal.modal import SecondOrderSystem, solve_modes

PROFILE = settings(deadline=None, derandomize=True, database=None, max_examples=50)
EPS = float(np.finfo(float).eps)


def system(mass, damping, stiffness):
    arrays = [np.array(matrix, dtype=float) for matrix in (mass, damping, stiffness)]
    return SecondOrderSystem(*arrays, tuple(f"q{i}" for i in range(len(arrays[0]))))


def even(matrix):
    return (matrix + matrix.T) / 2


def spd(rng, size, decades):
    Q = np.linalg.qr(rng.normal(size=(size, size)))[0]
    return even(Q @ np.diag(10 ** rng.uniform(0, decades, size)) @ Q.T)


def random_system(size, level, seed):
    rng = np.random.default_rng(seed)
    return system(spd(rng, size, 1), spd(rng, size, 2) * 10.0**level, spd(rng, size, 2))


recipes = st.tuples(st.integers(1, 6), st.floats(-4, 2), st.integers(0, 2**32 - 1))
LINES = np.array([0.0, 1e-3, 0.05, 0.2, 0.5, 1.0, 3.0, 20.0])  # the natural frequencies lie in 0.05–1.6 Hz


def exact(held, response, reference, frequency):
    """j_u Z⁻¹ j_vᵀ at 50 digits, straight from the definition."""
    with mpmath.workdps(50):
        lines = []
        for line in frequency:
            omega = 2 * mpmath.pi * mpmath.mpf(float(line))
            M, C, K = (mpmath.matrix(x.tolist()) for x in (held.mass, held.damping, held.stiffness))
            Z = K - omega**2 * M + mpmath.mpc(0, 1) * omega * C
            value = mpmath.matrix(response.tolist()) * mpmath.inverse(Z) * mpmath.matrix(reference.T.tolist())
            lines.append([[complex(value[i, j]) for j in range(value.cols)] for i in range(value.rows)])
    return np.array(lines)


def assert_matches(held, response, reference, frequency, found):
    """Agreement to what rounding of Z allows: eps × its condition, a hundred times that.

    The hundred holds the growth factor of the elimination and the rounding of ω² next to a resonance.
    """
    truth = exact(held, response, reference, frequency)
    Z = dynamic_stiffness(held, frequency)
    inverse = np.linalg.norm(np.linalg.inv(Z), 2, axis=(1, 2))
    omega = 2 * np.pi * frequency
    terms = (
        np.linalg.norm(held.stiffness, 2)
        + omega**2 * np.linalg.norm(held.mass, 2)
        + omega * np.linalg.norm(held.damping, 2)
    )
    size = np.linalg.norm(response, 2) * np.linalg.norm(reference, 2) * inverse
    limit = 100 * EPS * terms * inverse * size
    assert np.all(np.abs(found - truth) <= limit[:, None, None])


def test_single_joint_on_paper():
    # The tool at arm's length r: displacement r per radian, moment r per newton.
    m, c, k, r = 2.0, 5.0, 300.0, 1.5
    frequency = np.array([0.0, 0.5, np.sqrt(k / m) / (2 * np.pi), 10.0])
    omega = 2 * np.pi * frequency
    found = receptance(system([[m]], [[c]], [[k]]), np.array([[r]]), np.array([[r]]), frequency)
    paper = r**2 / (k - omega**2 * m + 1j * omega * c)
    # Some units in the last place; at resonance k − ω²m cancels to eps × k, seen against ωc = 61.
    np.testing.assert_allclose(found[:, 0, 0], paper, rtol=1e-14)
    np.testing.assert_allclose(found[2, 0, 0], r**2 / (1j * omega[2] * c), rtol=1e-14)


def test_two_joints_on_paper():
    M, C, K = (
        np.array([[3.0, 0.7], [0.7, 1.0]]),
        np.array([[2.0, -0.3], [-0.3, 0.5]]),
        np.diag([900.0, 400.0]),
    )
    response = np.array([[1.0, 0.4], [0.0, 1.0], [-0.6, 0.2]])
    reference = np.array([[0.3, -0.8], [1.0, 0.0]])
    frequency = np.linspace(0.0, 8.0, 50)
    found = receptance(system(M, C, K), response, reference, frequency)
    assert found.shape == (50, 3, 2)
    for line, f in enumerate(frequency):
        s = 2j * np.pi * f
        a, b, d = (s**2 * M[i, j] + s * C[i, j] + K[i, j] for i, j in ((0, 0), (0, 1), (1, 1)))
        paper = response @ np.array([[d, -b], [-b, a]]) @ reference.T / (a * d - b * b)
        # ad − b² cancels by a factor of some tens at the two resonances (ζ of 2 to 6 %).
        np.testing.assert_allclose(found[line], paper, rtol=0, atol=1e-13 * np.max(np.abs(paper)))


def test_dynamic_stiffness_is_the_formula():
    held = random_system(3, 0, 1)
    for line, f in enumerate(LINES):
        omega = 2 * np.pi * f
        paper = held.stiffness - omega**2 * held.mass + 1j * omega * held.damping
        np.testing.assert_allclose(dynamic_stiffness(held, LINES)[line], paper, rtol=1e-14)


@PROFILE
@given(recipes)
def test_static_compliance_at_zero_hertz(recipe):
    held = random_system(*recipe)
    rows = np.random.default_rng(0).normal(size=(2, held.dof))
    found = receptance(held, rows, rows, np.array([0.0]))[0]
    paper = rows @ np.linalg.inv(held.stiffness) @ rows.T
    # cond(K) ≤ 100, two routes: 1e-16 × 100 × some tens.
    np.testing.assert_allclose(found, paper, rtol=0, atol=1e-12 * np.max(np.abs(paper)))
    assert np.max(np.abs(found.imag)) == 0


@PROFILE
@given(recipes)
def test_reciprocity(recipe):
    held = random_system(*recipe)
    rng = np.random.default_rng(1)
    u, v = rng.normal(size=(2, 3, held.dof))
    there, back = receptance(held, u, v, LINES), receptance(held, v, u, LINES)
    # Z is symmetric to the bit, its elimination is not: eps × cond(Z), below 1e5 at 1e-4 of damping.
    size = np.max(np.abs(there), axis=(1, 2), keepdims=True)
    assert np.all(np.abs(there - back.transpose(0, 2, 1)) <= 1e-9 * size)


@PROFILE
@given(recipes)
def test_passivity(recipe):
    """A force does no negative work over a cycle: Im α is negative semidefinite, Im α_drive ≤ 0."""
    held = random_system(*recipe)
    rows = np.random.default_rng(2).normal(size=(3, held.dof))
    found = receptance(held, rows, rows, LINES)
    size = np.max(np.abs(found), axis=(1, 2))
    # Zero at 0 Hz and tiny far from the resonances, where rounding (as in reciprocity) decides its sign.
    drive = np.einsum("lii->li", found).imag
    assert np.all(drive <= 1e-12 * size[:, None])
    largest = np.linalg.eigvalsh((found.imag + found.imag.transpose(0, 2, 1)) / 2)[:, -1]
    assert np.all(largest <= 1e-9 * size)


@settings(PROFILE, max_examples=15)
@given(recipes)
def test_against_fifty_digits(recipe):
    held = random_system(*recipe)
    rng = np.random.default_rng(3)
    response, reference = rng.normal(size=(2, held.dof)), rng.normal(size=(1, held.dof))
    assert_matches(held, response, reference, LINES, receptance(held, response, reference, LINES))


@pytest.mark.parametrize("level", [-12, -8, -4, -2])
@pytest.mark.parametrize("away", [0.0, 1e-9, 1e-5, -1e-3])
def test_against_fifty_digits_near_resonance(level, away):
    held = random_system(4, level, 11)
    frequency = np.sort(solve_modes(held).frequency * (1 + away))
    rows = np.eye(4)
    assert_matches(held, rows, rows, frequency, receptance(held, rows, rows, frequency))


def test_against_fifty_digits_with_eight_decades_of_stiffness():
    mass = np.array([[3.0, 0.5, 0.2], [0.5, 2.0, 0.1], [0.2, 0.1, 1.0]])
    held = system(mass, np.diag([10.0, 2.0, 0.1]), np.diag([1e8, 1e4, 1.0]))
    frequency = np.array([0.0, 0.1, 0.159, 1.0, 11.3, 100.0, 943.7, 5000.0])
    found = receptance(held, np.eye(3), np.eye(3), frequency)
    truth = exact(held, np.eye(3), np.eye(3), frequency)
    # Entry by entry: a diagonally scaled Z is well conditioned whatever the decades, but for a factor
    # 1/ζ of up to 1000 on a resonance, and entries between soft and stiff are products of the two.
    scale = np.sqrt(np.abs(np.einsum("lii->li", truth)))
    limit = 1e-11 * scale[:, :, None] * scale[:, None, :]
    assert np.all(np.abs(found - truth) <= limit)


def test_a_long_axis_gives_the_numbers_of_its_pieces():
    """The axis is solved in blocks of 4096; neither their border nor their size may show."""
    held = random_system(3, -1, 4)
    rows = np.random.default_rng(5).normal(size=(2, 3))
    frequency = np.linspace(0.0, 3.0, 3 * 4096 + 5)
    whole = receptance(held, rows, rows[:1], frequency)
    assert whole.shape == (len(frequency), 2, 1)
    for start, stop in ((0, 1), (4090, 4100), (4096, 8192), (8191, 8193), (12288, len(frequency))):
        piece = receptance(held, rows, rows[:1], frequency[start:stop])
        # Each line is its own factorisation; only the product with the rows may round differently.
        np.testing.assert_allclose(whole[start:stop], piece, rtol=1e-13)


def test_exactly_one_block_and_one_more():
    held = random_system(2, 0, 6)
    for lines in (4095, 4096, 4097):
        assert receptance(held, np.eye(2), np.eye(2), np.linspace(0, 1, lines)).shape == (lines, 2, 2)

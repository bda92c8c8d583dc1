"""The modal sum against the direct solve: two routes to the same receptance."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flexmodal.errors import DefectiveModes
from flexmodal.frf.receptance import modal_sum, receptance
from flexmodal.modal import SecondOrderSystem, solve_modes

PROFILE = settings(deadline=None, derandomize=True, database=None, max_examples=50)
EPS = float(np.finfo(float).eps)
LINES = np.array([0.0, 1e-3, 0.05, 0.2, 0.5, 1.0, 3.0, 20.0])  # natural frequencies lie in 0.05–1.6 Hz


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


seeds = st.integers(0, 2**32 - 1)
sizes = st.integers(1, 6)


def assert_agree(held, frequency=LINES):
    """Agreement of the two routes to what the terms of the sum allow.

    A pole is off by eps × its condition × the fastest pole, which is felt against its distance from iω; a
    residue is off by eps × condition. Both act on terms that cancel: well above the resonances the sum
    falls as 1/ω², its terms as 1/ω. A factor of thirty covers up to twelve poles and the direct solve.
    """
    found = solve_modes(held)
    assume(np.max(found.condition) < 100)
    rows = np.eye(held.dof)
    direct = receptance(held, rows, rows, frequency)
    summed = modal_sum(found, rows, rows, frequency)
    poles, shapes = found.expanded()
    distance = np.abs(2j * np.pi * frequency[:, None] - poles)
    terms = np.max(np.sum(np.abs(shapes) ** 2, axis=0) / distance, axis=1)
    felt = np.max(1 + np.max(np.abs(poles)) / distance, axis=1)
    limit = 30 * EPS * np.max(found.condition) * felt * terms
    error = np.max(np.abs(summed - direct), axis=(1, 2))
    assert np.all(error <= limit)


@PROFILE
@given(sizes, st.floats(-4, -1.5), seeds)
def test_underdamped(size, level, seed):
    held = random_system(size, level, seed)
    # Damping at most 10^0.5 against 2√(K M) of at least 2 may just overdamp a mode; nearly all have none.
    assume(not solve_modes(held).overdamped.any())
    assert_agree(held)


@PROFILE
@given(sizes, st.floats(-0.5, 1), seeds)
def test_mixed(size, level, seed):
    held = random_system(size, level, seed)
    assume(solve_modes(held).overdamped.any())
    assert_agree(held)


@PROFILE
@given(sizes, seeds)
def test_all_overdamped(size, seed):
    rng = np.random.default_rng(seed)
    # Damping of at least 80 against 2√(10 × 100) = 63: every mode is overdamped.
    held = system(spd(rng, size, 1), 80 * spd(rng, size, 0.5), spd(rng, size, 2))
    assert solve_modes(held).overdamped.all()
    assert_agree(held)


@PROFILE
@given(sizes, st.floats(0, 0.5), st.floats(0, 0.5), seeds)
def test_proportional(size, alpha, beta, seed):
    rng = np.random.default_rng(seed)
    mass, stiffness = spd(rng, size, 1), spd(rng, size, 2)
    held = system(mass, alpha * mass + beta * stiffness, stiffness)
    lines = LINES if alpha + beta > 1e-3 else LINES[:2]  # undamped: keep clear of the resonances
    assert_agree(held, lines)


def test_sum_written_out():
    """α = Σ φ_u φ_v / (iω − λ_p) over all 2n poles, one term after the other."""
    held = random_system(3, 0.3, 5)
    found = solve_modes(held)
    assert found.overdamped.any()
    assert not found.overdamped.all()
    poles, shapes = found.expanded()
    response, reference = np.array([[1.0, 0.0, 2.0], [0.0, 1.0, -1.0]]), np.array([[0.5, 0.5, 0.0]])
    summed = modal_sum(found, response, reference, LINES)
    assert summed.shape == (len(LINES), 2, 1)
    for line, f in enumerate(LINES):
        for row in range(2):
            terms = [
                (response[row] @ u) * (u @ reference[0]) / (2j * np.pi * f - pole)
                for pole, u in zip(poles, shapes.T, strict=True)
            ]
            # The same terms in another order: some eps of the largest.
            np.testing.assert_allclose(
                summed[line, row, 0], sum(terms), rtol=0, atol=1e-14 * np.max(np.abs(terms))
            )


def test_static_sum_is_real():
    # At 0 Hz each pole and its conjugate give a real number, −2 Re(φφᵀ/λ).
    held = random_system(4, -1, 6)
    summed = modal_sum(solve_modes(held), np.eye(4), np.eye(4), np.array([0.0]))[0]
    assert np.max(np.abs(summed.imag)) < 1e-15 * np.max(np.abs(summed)) * 10
    np.testing.assert_allclose(summed.real, np.linalg.inv(held.stiffness), atol=1e-12)  # cond(K) ≤ 100


def test_leaving_out_the_second_real_pole_would_show():
    """Taking each pole with "its conjugate" is wrong for real poles, by far more than the tolerance."""
    held = system([[1.0]], [[30.0]], [[100.0]])
    found = solve_modes(held)
    poles = np.concatenate([found.pole, found.pole.conj()])
    shapes = np.concatenate([found.shape, found.shape.conj()], axis=1)
    wrong = np.sum(shapes[0] ** 2 / (0 - poles))
    right = modal_sum(found, np.eye(1), np.eye(1), np.array([0.0]))[0, 0, 0]
    np.testing.assert_allclose(right, 0.01, rtol=1e-13)  # 1/k, some eps
    assert abs(wrong - right) > 0.5 * abs(right)


def test_eight_decades_of_stiffness():
    mass = np.array([[3.0, 0.5, 0.2], [0.5, 2.0, 0.1], [0.2, 0.1, 1.0]])
    held = system(mass, np.diag([10.0, 2.0, 0.1]), np.diag([1e8, 1e4, 1.0]))
    frequency = np.array([0.0, 0.1, 0.159, 1.0, 11.3, 100.0, 943.7, 5000.0])
    direct = receptance(held, np.eye(3), np.eye(3), frequency)
    summed = modal_sum(solve_modes(held), np.eye(3), np.eye(3), frequency)
    size = np.max(np.abs(direct), axis=(1, 2), keepdims=True)
    # eps × 1e8 in the square of the soft frequency, times 1/(2ζ) = 10 on its resonance.
    assert np.all(np.abs(summed - direct) <= 1e-7 * size)


def test_a_heavily_damped_neighbour_is_no_reason_to_refuse():
    # Two oscillators that know nothing of each other, twelve decades of damping apart.
    held = system(np.eye(2), np.diag([1e9, 0.1]), np.diag([1e8, 1.0]))
    found = solve_modes(held)
    assert not found.is_defective
    summed = modal_sum(found, np.eye(2), np.eye(2), LINES)
    s = 2j * np.pi * LINES
    np.testing.assert_allclose(summed[:, 1, 1], 1 / (s**2 + 0.1 * s + 1), rtol=1e-13)  # 1/ζ × some eps


def test_refuses_critical_damping():
    with pytest.raises(DefectiveModes, match="direct solve"):
        modal_sum(solve_modes(system([[1.0]], [[2.0]], [[1.0]])), np.eye(1), np.eye(1), LINES)

"""Where the receptance is infinite it must say so, and nowhere else."""

import numpy as np
import pytest

from flexmodal.errors import SingularResponse
from flexmodal.frf.receptance import modal_sum, receptance
from flexmodal.modal import SecondOrderSystem, solve_modes


def system(mass, damping, stiffness):
    arrays = [np.array(matrix, dtype=float) for matrix in (mass, damping, stiffness)]
    return SecondOrderSystem(*arrays, tuple(f"q{i}" for i in range(len(arrays[0]))))


def even(matrix):
    return (matrix + matrix.T) / 2


def rotation(size, seed):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(size, size)))[0]


def solve(held, *frequency):
    rows = np.eye(held.dof)
    return receptance(held, rows, rows, np.array(frequency))


def hertz(omega):
    return omega / (2 * np.pi)


@pytest.mark.parametrize(("m", "k"), [(1.0, 1.0), (3.0, 7e5), (0.7, 1e-3)])
def test_undamped_oscillator(m, k):
    held = system([[m]], [[0.0]], [[k]])
    at = hertz(np.sqrt(k / m))
    with pytest.raises(SingularResponse, match=f"infinite at {at:.9g} Hz: an undamped mode"):
        solve(held, 0.5 * at, at, 2 * at)
    with pytest.raises(SingularResponse):
        modal_sum(solve_modes(held), np.eye(1), np.eye(1), np.array([at]))
    # Beside it the number is large and right: relative distance d gives 1/(2dk), known to eps/d.
    for d in (1e-3, 1e-6, 1e-9, 1e-11):
        found = solve(held, at * (1 - d))[0, 0, 0]
        np.testing.assert_allclose(found, 1 / (k * d * (2 - d)), rtol=1e-15 / d + 1e-14)


def test_all_modes_at_one_frequency():
    """Z vanishes altogether: no entry is left to compare with, and it is singular all the same."""
    Q = rotation(3, 1)
    mass = even(Q @ np.diag([1.0, 2.0, 3.0]) @ Q.T)
    held = system(mass, np.zeros((3, 3)), 9 * mass)
    with pytest.raises(SingularResponse):
        solve(held, hertz(3.0))


@pytest.mark.parametrize("mode", range(4))
def test_every_mode_of_an_undamped_chain(mode):
    # n equal masses between walls: ω = 2√(k/m) sin(πp / 2(n + 1)).
    chain = 2 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    held = system(0.5 * np.eye(4), np.zeros((4, 4)), 700 * chain)
    omega = 2 * np.sqrt(1400.0) * np.sin(np.pi * (mode + 1) / 10)
    with pytest.raises(SingularResponse):
        solve(held, 1.0, hertz(omega))
    solve(held, hertz(omega * (1 + 1e-9)))


@pytest.mark.parametrize("others", [0.01, 1.0, 1e4])
def test_one_undamped_mode_among_damped_ones(others):
    """B has rank n − 1: a damping matrix that is not zero hides one mode it does not touch."""
    Q = rotation(3, 2)
    omega = np.array([2.0, 5.0, 9.0])
    held = system(
        np.eye(3),
        even(Q @ np.diag([others, 0.0, 2 * others]) @ Q.T),
        even(Q @ np.diag(omega**2) @ Q.T),
    )
    with pytest.raises(SingularResponse, match=r"0\.795774715 Hz"):
        solve(held, 0.1, hertz(5.0))
    solve(held, hertz(2.0), hertz(9.0))  # the damped ones, at their own natural frequencies
    # Rounding of the rotated matrices is eps × the damping of the others: 1e-6 lies clear of it.
    found = solve(held, hertz(5.0 * (1 - 1e-6)))[0]
    expected = np.outer(Q[:, 1], Q[:, 1]) / (25 * 1e-6 * (2 - 1e-6))
    # The other two modes add some 1e-1 to 1e4; the distance itself is known to 1e-12 × others / 1e-6.
    np.testing.assert_allclose(found.real, expected, rtol=0, atol=1e-4 * np.max(np.abs(expected)))


def test_a_damper_at_a_node():
    # Three masses, dampers on the middle one only: the antisymmetric mode (1, 0, −1) never moves it.
    chain = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    held = system(np.eye(3), np.diag([0.0, 3.0, 0.0]), 50 * chain)
    with pytest.raises(SingularResponse):
        solve(held, hertz(10.0))  # ω² = 2k/m = 100
    solve(held, *np.linspace(0.0, 1.5, 100))


@pytest.mark.parametrize("d", [1e-4, 1e-8, 1e-11])
@pytest.mark.parametrize("beyond", [0.0, 1e5])
def test_close_is_not_singular_whatever_else_is_on_the_axis(d, beyond):
    held = system(np.eye(2), np.zeros((2, 2)), np.diag([4.0, 100.0]))
    at = hertz(2.0) * (1 - d)
    found = solve(held, at, *([beyond] if beyond else []))[0, 0, 0]
    np.testing.assert_allclose(found, 1 / (4 * d * (2 - d)), rtol=1e-15 / d + 1e-14)


@pytest.mark.parametrize("beyond", [0.0, 1e5])
def test_eight_decades_of_stiffness_are_not_singular(beyond):
    held = system(np.eye(3), np.zeros((3, 3)), np.diag([1.0, 1e4, 1e8]))
    more = [beyond] if beyond else []
    for omega, stiffness in ((1.0, 1.0), (100.0, 1e4), (1e4, 1e8)):
        for d in (1e-2, 1e-6, 1e-10):
            found = solve(held, hertz(omega) * (1 - d), *more)[0]
            expected = 1 / (stiffness * d * (2 - d))
            index = (1.0, 1e4, 1e8).index(stiffness)
            np.testing.assert_allclose(found[index, index], expected, rtol=1e-15 / d + 1e-14)
        with pytest.raises(SingularResponse):
            solve(held, hertz(omega), *more)
    solve(held, 0.0, *more)


def test_huge_damping_elsewhere_is_not_singular():
    held = system(np.eye(2), np.diag([0.0, 1e8]), np.diag([4.0, 100.0]))
    d = 1e-9
    np.testing.assert_allclose(
        solve(held, hertz(2.0) * (1 - d))[0, 0, 0], 1 / (4 * d * (2 - d)), rtol=1e-15 / d
    )
    with pytest.raises(SingularResponse):
        solve(held, hertz(2.0))


def test_hardly_any_damping_is_finite():
    held = system([[1.0]], [[1e-9]], [[4.0]])
    # At resonance α = 1/(iωc) but for the rounding of ω², eps × 4 against ωc = 2e-9.
    np.testing.assert_allclose(solve(held, hertz(2.0))[0, 0, 0], 1 / 2e-9j, rtol=1e-6)


def free(damping):
    return system(np.eye(2), damping, 9.0 * np.array([[1.0, -1.0], [-1.0, 1.0]]))


@pytest.mark.parametrize(
    "damping", [np.zeros((2, 2)), np.diag([0.3, 0.1]), np.array([[0.1, -0.1], [-0.1, 0.1]])]
)
def test_a_free_body_at_zero_hertz(damping):
    """Nothing holds it at rest, with dampers to the ground or without."""
    with pytest.raises(SingularResponse, match="infinite at 0 Hz"):
        solve(free(damping), 0.0, 1.0)
    solve(free(damping), 0.01, 1.0)


def test_a_body_without_any_stiffness_at_zero_hertz():
    held = system(np.eye(2), np.diag([0.3, 0.1]), np.zeros((2, 2)))
    with pytest.raises(SingularResponse):
        solve(held, 0.0)
    modes = solve_modes(held)
    with pytest.raises(SingularResponse):
        modal_sum(modes, np.eye(2), np.eye(2), np.array([0.0, 1.0]))
    s = 2j * np.pi
    paper = np.diag(1 / (s**2 + s * np.array([0.3, 0.1])))
    # Some units in the last place of the largest entry, by either route.
    np.testing.assert_allclose(solve(held, 1.0)[0], paper, atol=1e-15)
    np.testing.assert_allclose(modal_sum(modes, np.eye(2), np.eye(2), np.array([1.0]))[0], paper, atol=1e-15)


def test_resonance_in_a_later_block():
    held = system([[1.0]], [[0.0]], [[4.0]])
    frequency = np.sort(np.append(np.linspace(0.0, 0.3, 5000), hertz(2.0)))
    assert np.searchsorted(frequency, hertz(2.0)) > 4096
    with pytest.raises(SingularResponse):
        receptance(held, np.eye(1), np.eye(1), frequency)

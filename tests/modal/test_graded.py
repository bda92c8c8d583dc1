"""Springs over many decades: every mode against eighty digits."""

import mpmath
import numpy as np
import pytest

from flexmodal.errors import InaccurateModes
from flexmodal.modal import SecondOrderSystem, solve_modes


def truth(mass, damping, stiffness):
    """Poles with a positive imaginary part by eighty digits, in the order of their size, and unit shapes."""
    count = len(mass)
    with mpmath.workdps(80):
        inverse = mpmath.inverse(mpmath.matrix(mass.tolist()))
        lower = [-inverse * mpmath.matrix(one.tolist()) for one in (stiffness, damping)]
        whole = mpmath.zeros(2 * count)
        for row in range(count):
            whole[row, count + row] = 1
            for column in range(count):
                whole[count + row, column] = lower[0][row, column]
                whole[count + row, count + column] = lower[1][row, column]
        found, vectors = mpmath.eig(whole, left=False, right=True)
        kept = sorted((k for k, one in enumerate(found) if mpmath.im(one) > 0), key=lambda k: abs(found[k]))
        shapes = np.array([[complex(vectors[row, k]) for k in kept] for row in range(count)])
        return np.array([complex(found[k]) for k in kept]), shapes / np.linalg.norm(shapes, axis=0)


def system(exponents, ratio, seed):
    rng = np.random.default_rng(seed)
    count = len(exponents)
    factor = rng.normal(size=(count, count))
    mass = factor @ factor.T + count * np.eye(count)
    stiffness = np.diag(10.0 ** np.array(exponents, dtype=float))
    omega = np.sqrt(np.diag(stiffness) / np.diag(mass))
    damping = np.diag(2 * ratio * rng.uniform(0.5, 2, count) * omega * np.diag(mass))
    return SecondOrderSystem(mass, damping, stiffness, tuple(f"q{i}" for i in range(count)))


RANGES = [(18, 18, 2), (18, 2), (2, 18), (12, 0), (12, 8, 4, 0), (3, 4, 15, 16), (18, 14, 10, 6, 2)]


@pytest.mark.some(3)
@pytest.mark.parametrize("ratio", [0.0, 1e-3, 0.05])
@pytest.mark.parametrize("exponents", RANGES, ids=str)
def test_every_mode_has_its_own_digits(exponents, ratio):
    for seed in range(3):
        held = system(exponents, ratio, seed)
        found = solve_modes(held)
        poles, shapes = truth(held.mass, held.damping, held.stiffness)
        assert len(found.pole) == len(poles)
        # Of undamped modes all digits; dampers are turned with all others, at rounding of the largest.
        np.testing.assert_allclose(found.pole, poles, rtol=1e-9)
        np.testing.assert_allclose(found.damping_ratio, -poles.real / np.abs(poles), rtol=1e-7, atol=1e-15)
        likeness = np.abs(np.sum(found.shape.conj() * shapes, axis=0)) / np.linalg.norm(found.shape, axis=0)
        np.testing.assert_allclose(likeness, 1.0, rtol=1e-12)


def test_a_coupling_beside_rigid_joints():
    held = system((17, 17, 3, 2), 0.0, 5)
    stiffness = held.stiffness.copy()
    stiffness[2, 3] = stiffness[3, 2] = 0.8 * np.sqrt(stiffness[2, 2] * stiffness[3, 3])
    tied = SecondOrderSystem(held.mass, held.damping, stiffness, held.coordinates)
    poles, _ = truth(tied.mass, tied.damping, tied.stiffness)
    np.testing.assert_allclose(solve_modes(tied).pole, poles, rtol=1e-10)


def test_rigid_body_modes_stay_at_nought():
    mass = np.array([[2.0, 0.5], [0.5, 1.0]])
    free = SecondOrderSystem(mass, np.zeros((2, 2)), np.diag([0.0, 1e16]), ("q1", "q2"))
    assert solve_modes(free).frequency[0] < 1e-3
    chain = np.array([[1e16, -1e16], [-1e16, 1e16]])
    free = SecondOrderSystem(mass, np.zeros((2, 2)), chain, ("q1", "q2"))
    poles, _ = truth(mass, np.zeros((2, 2)), chain)
    assert solve_modes(free).pole[1] == pytest.approx(poles[-1])


@pytest.mark.parametrize("damping", [(1e18, 1e9, 1.0), (1.0, 1e14, 1e3), (1e6, 1e6, 1e-3)])
def test_a_pole_without_digits_is_refused_and_no_other(damping):
    """Dampers far beyond critical: slow poles beside fast ones. What comes back solves its own equation."""
    held = system((0, 1, 2), 0.0, 1)
    rigid = SecondOrderSystem(held.mass, np.diag(damping), held.stiffness, held.coordinates)
    try:
        found = solve_modes(rigid)
    except InaccurateModes:
        assert max(damping) > 1e12
        return
    for pole, shape in zip(found.pole, found.shape.T, strict=True):
        left = (pole**2 * held.mass + pole * rigid.damping + held.stiffness) @ shape
        size = abs(pole) ** 2 * abs(held.mass) + abs(pole) * rigid.damping + held.stiffness
        assert np.all(np.abs(left) <= 1e-6 * np.linalg.norm(shape) * size.sum(axis=1))

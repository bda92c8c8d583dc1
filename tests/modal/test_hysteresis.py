"""Hysteretic springs: the law itself, one oscillator on paper, and poles against the receptance they make."""

import numpy as np
import pytest

from flexmodal.errors import InvalidSystem
from flexmodal.frf.receptance import dynamic_stiffness, receptance
from flexmodal.modal import Hysteresis, SecondOrderSystem, solve_modes

MASS = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.2], [0.1, 0.2, 0.6]])
DAMPING = np.diag([0.3, 0.1, 0.2])
STIFFNESS = np.array([[5000.0, -900.0, 0.0], [-900.0, 8000.0, 0.0], [0.0, 0.0, 30000.0]])
NAMES = ("a", "b", "c")


def system(loss, frequency, *, damping=DAMPING, mass=MASS, stiffness=STIFFNESS):
    held = Hysteresis(np.diag(stiffness).copy(), np.array(loss, dtype=float), frequency)
    return SecondOrderSystem(mass, damping, stiffness, NAMES[: len(mass)], held)


def test_power_law_is_what_it_says():
    law = Hysteresis(np.array([700.0]), np.array([0.2]), 10.0)
    omega = 2 * np.pi * np.array([0.5, 10.0, 80.0])
    value = 700 + law.added(1j * omega)[:, 0]
    np.testing.assert_allclose(value.imag / value.real, 0.2, rtol=1e-12)  # one loss factor everywhere
    np.testing.assert_allclose(value.real[1], 700, rtol=1e-12)
    beta = 2 / np.pi * np.arctan(0.2)
    np.testing.assert_allclose(np.abs(value) / np.abs(value[1]), (omega / omega[1]) ** beta, rtol=1e-12)


def test_power_law_is_causal():
    """Kramers and Kronig: over narrow bands, d Re K / d ln ω = (2/π) Im K to first order in η."""
    law = Hysteresis(np.array([1.0]), np.array([0.01]), 10.0)
    omega = 2 * np.pi * 10 * np.exp(np.array([-0.01, 0.0, 0.01]))
    value = law.added(1j * omega)[:, 0]
    slope = (value[2].real - value[0].real) / 0.02
    np.testing.assert_allclose(slope, 2 / np.pi * value[1].imag, rtol=1e-3)  # η² beside η


def test_held_below_a_thousandth_and_at_rest():
    law = Hysteresis(np.array([1.0]), np.array([0.1]), 10.0)
    value = law.added(2j * np.pi * np.array([0.0, 1e-5, 0.01]))[:, 0]
    np.testing.assert_allclose(value, value[2], rtol=1e-12)
    assert np.all(law.slope(2j * np.pi * np.array([0.0, 1e-5])) == 0)


@pytest.mark.parametrize("frequency", [None, 12.0])
def test_slope_by_differences(frequency):
    law = Hysteresis(np.array([3.0, 5.0]), np.array([0.1, 0.4]), frequency)
    s, step = np.array([3.0 + 70j]), 1e-4
    numeric = (law.added(s + step) - law.added(s - step)) / (2 * step)
    np.testing.assert_allclose(law.slope(s), numeric, atol=1e-8)


def test_one_oscillator_of_constant_loss():
    """λ² = −K(1 + iη)/M."""
    held = system([0.3], None, mass=MASS[:1, :1], damping=np.zeros((1, 1)), stiffness=STIFFNESS[:1, :1])
    modes = solve_modes(held)
    truth = np.sqrt(-5000 / 2 * (1 + 0.3j) + 0j)
    truth = truth if truth.imag > 0 else -truth
    np.testing.assert_allclose(modes.pole, [truth], rtol=1e-12)
    np.testing.assert_allclose(
        modes.shape[0, 0] ** 2, 1 / (2 * truth * 2.0), rtol=1e-12
    )  # residue of 1/(K − …)


@pytest.mark.parametrize("frequency", [None, 12.0])
def test_poles_are_zeros_of_the_dynamic_stiffness(frequency):
    held = system([0.05, 0.2, 0.02], frequency)
    modes = solve_modes(held)
    assert np.all(np.diff(np.abs(modes.pole)) > 0)
    for pole, shape in zip(modes.pole, modes.shape.T, strict=True):
        stiffness = held.stiffness + np.diag(held.hysteresis.added(np.array([pole]))[0])
        z = pole**2 * held.mass + pole * held.damping + stiffness
        # the rounds end at 1e-12 of the pole
        assert np.linalg.norm(z @ shape) < 1e-9 * np.linalg.norm(stiffness) * np.linalg.norm(shape)


def test_residues_carry_the_resonance():
    """Next to a light resonance one pole makes the receptance: on the line the rest is small."""
    held = system([0.01, 0.01, 0.01], 12.0, damping=np.zeros((3, 3)))
    modes = solve_modes(held)
    for mode in range(3):
        line = np.array([modes.pole[mode].imag / (2 * np.pi)])
        alpha = receptance(held, np.eye(3), np.eye(3), line)[0]
        driven = 2j * np.pi * line[0]
        one = np.outer(modes.shape[:, mode], modes.shape[:, mode]) / (driven - modes.pole[mode])
        # what is left is of the other modes: about η times the peak
        assert np.max(np.abs(alpha - one)) < 0.03 * np.max(np.abs(alpha))


def test_without_loss_nothing_changes():
    plain = SecondOrderSystem(MASS, DAMPING, STIFFNESS, NAMES)
    held = system([0.0, 0.0, 0.0], 12.0)
    np.testing.assert_array_equal(solve_modes(held).pole, solve_modes(plain).pole)
    line = np.array([0.0, 3.0, 30.0])
    np.testing.assert_allclose(dynamic_stiffness(held, line), dynamic_stiffness(plain, line), rtol=1e-15)


def test_elimination_and_factorisation_agree():
    held = system([0.05, 0.2, 0.02], 12.0)
    line = np.linspace(0.0, 60.0, 3001)  # long enough for the kernels
    rows = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 2.0]])
    long = receptance(held, rows, rows, line)
    short = np.concatenate([receptance(held, rows, rows, part) for part in np.split(line[:3000], 6)])
    np.testing.assert_allclose(long[:3000], short, rtol=1e-9)


def test_refuses_what_is_no_spring():
    with pytest.raises(InvalidSystem, match="loss_factor"):
        Hysteresis(np.ones(2), np.array([-0.1, 0.0]))
    with pytest.raises(InvalidSystem, match="frequency"):
        Hysteresis(np.ones(2), np.zeros(2), 0.0)
    with pytest.raises(InvalidSystem, match="2 springs"):
        SecondOrderSystem(MASS, DAMPING, STIFFNESS, NAMES, Hysteresis(np.ones(2), np.zeros(2)))

"""Least squares: exact data, forms, forced numbers, slopes against finite differences, failures."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from flexmodal.ema import Choices, Measured, build_least_squares, choose_peaks, estimate, solve_least_squares
from flexmodal.ema.methods.basis import residual_columns
from flexmodal.ema.methods.least_squares import with_terms_enough
from flexmodal.ema.methods.separable import Separable, eliminate, minimise
from flexmodal.ema.mode import solve_columns
from flexmodal.errors import InvalidRequest

from .truth import Truth, measured, real_modes

AXIS = np.linspace(2, 120, 300)


@pytest.mark.parametrize("form", ["receptance", "mobility", "inertance"])
def test_exact_data_give_the_truth_back(four_modes: Truth, form: str) -> None:
    data = measured(four_modes, AXIS, form)
    peaks = choose_peaks(data, at=[7.5, 50.0, 60.0, 90.0])
    found = solve_least_squares(build_least_squares(data, peaks))
    assert found.converged
    # Rounding of 1e-16 times the condition of the normal equations, about 1e5.
    np.testing.assert_allclose(found.frequency, four_modes.frequency, rtol=1e-9)
    np.testing.assert_allclose(found.damping_ratio, four_modes.damping, rtol=1e-8)
    np.testing.assert_allclose(found.residue, four_modes.residue, rtol=1e-8)
    np.testing.assert_allclose(found.upper, four_modes.upper, rtol=1e-6)
    assert found.misfit < 1e-10


def test_synthesis_is_the_modal_sum_of_the_modal_room() -> None:
    """The residues mean the same as those of `modal_sum` for a system with known matrices."""
    from flexmodal.frf import receptance
    from flexmodal.modal import SecondOrderSystem, solve_modes

    system = SecondOrderSystem(
        np.diag([2.0, 1.0]),
        np.array([[30.0, -8.0], [-8.0, 12.0]]),
        np.array([[9e4, -3e4], [-3e4, 4e4]]),
        ("a", "b"),
    )
    rows = np.eye(2)
    axis = np.linspace(5, 70, 260)
    value = receptance(system, rows, rows[:1], axis)[:, :, 0]
    found = estimate(Measured(axis, value, "receptance"), choices=Choices(residuals="none"))
    modes = solve_modes(system)
    np.testing.assert_allclose(found.frequency, modes.frequency, rtol=1e-8)  # exact data
    np.testing.assert_allclose(found.damping_ratio, modes.damping_ratio, rtol=1e-7)
    np.testing.assert_allclose(found.residue, modes.shape * modes.shape[0], rtol=1e-6)


def test_thesis_multiplier_has_the_same_residue_at_the_pole() -> None:
    """A' = 2iω_d A: for a real mode both forms are the same function, evaluated literally."""
    truth = real_modes([30.0], [0.05], np.array([[0.7]]))
    found = estimate(measured(truth, np.linspace(20, 40, 80)), choices=Choices(residuals="none"))
    np.testing.assert_allclose(found.modes[0].amplitude_multiplier, 0.7, rtol=1e-8)
    omega, natural = 2 * np.pi * np.linspace(20, 40, 80), 2 * np.pi * 30.0
    literal = 1j * omega * 0.7 / (natural**2 - omega**2 + 2j * 0.05 * natural * omega)
    np.testing.assert_allclose(found.synthesise()[:, 0], literal, rtol=1e-8)


def test_gradient_agrees_with_finite_differences(four_modes: Truth) -> None:
    omega = 2 * np.pi * AXIS / 300
    value = four_modes.frf(AXIS)[None, :, :2] * 1e2
    problem = Separable(omega, value, np.ones((1, len(AXIS), 1)), 1, "complex", np.ones((4, 2), dtype=bool))
    start = 2 * np.pi * four_modes.frequency[None] / 300 * 1.01
    damping = four_modes.damping[None] * 1.1
    gradient = eliminate(problem, start, damping).gradient[0]
    step = 1e-6
    for place in range(8):
        shift = np.zeros((1, 4, 2))
        shift[0, place // 2, place % 2] = step
        costs = [
            eliminate(problem, start + sign * shift[..., 0], damping + sign * shift[..., 1]).cost[0]
            for sign in (1, -1)
        ]
        # The gradient is of minus half the cost; central differences of step 1e-6 leave some 1e-6 of it.
        assert gradient[place] == pytest.approx(-(costs[0] - costs[1]) / (4 * step), rel=1e-5)


def test_uncertainty_agrees_with_the_inverse_of_a_numerical_hessian(one_mode: Truth) -> None:
    """Second route to the covariance: scipy's Jacobian of all unknowns at once."""
    from scipy.optimize import least_squares

    axis = np.linspace(40, 62, 90)
    data = measured(one_mode, axis, level=0.01, seed=4)
    found = estimate(data, choices=Choices(residuals="none"))
    mode = found.modes[0]
    sigma = np.sqrt(data.variance[0, 0] / 2)

    def away(unknown: np.ndarray) -> np.ndarray:
        frequency, damping, real, imaginary = unknown
        truth = Truth(
            np.array([frequency]), np.array([damping]), np.array([[1e-3 * (real + 1j * imaginary)]])
        )
        gap = (truth.frf(axis) - data.value)[:, 0] / sigma
        return np.concatenate([gap.real, gap.imag])

    residue = mode.residue[0] * 1e3
    other = least_squares(
        away, [51.2, 0.045, residue.real, residue.imag], x_scale=[1, 0.01, 1, 1], xtol=1e-14
    )
    covariance = np.linalg.inv(other.jac.T @ other.jac)
    chi = max(1.0, 2 * other.cost / (2 * len(axis) - 4))
    np.testing.assert_allclose([mode.frequency, mode.damping_ratio], other.x[:2], rtol=1e-6)
    # Ours adds the colour of the deviations, at least 1; white noise leaves it near 1.
    ratio = mode.covariance / (covariance[:2, :2] * chi)
    assert np.all((ratio > 0.99) & (ratio < 1.6))


def test_forced_numbers_stay(four_modes: Truth) -> None:
    data = measured(four_modes, AXIS, level=0.01, seed=1)
    at = [8.0, 51.0, 58.0, 94.0]
    found = estimate(data, choices=Choices(at=at, damping={58.0: 0.045}, hold_frequency=(94.0,)))
    third, fourth = found.modes[2], found.modes[3]
    assert third.damping_ratio == 0.045
    assert third.damping_error == 0
    assert fourth.frequency == 94.0
    assert fourth.frequency_error == 0
    assert fourth.damping_error > 0
    assert third.frequency_error > 0


@pytest.mark.parametrize("weighting", ["uniform", "logarithmic", "variance"])
def test_every_weighting_states_an_honest_error(four_modes: Truth, weighting: str) -> None:
    """Errors in units of the stated standard errors are of order one whatever the weights."""
    scores = []
    for seed in range(8):
        data = measured(four_modes, AXIS, level=0.01, seed=seed)
        found = estimate(data, choices=Choices(at=[8.0, 51.0, 58.0, 94.0], weighting=weighting))
        errors = np.array([mode.frequency_error for mode in found])
        scores.append((found.frequency - four_modes.frequency) / errors)
    # 32 numbers of unit variance: their mean square lies within 0.4 to 1.9 but once in a thousand times.
    assert 0.4 < np.mean(np.square(scores)) < 1.9


def test_a_mode_that_is_not_there_is_refused(one_mode: Truth) -> None:
    data = measured(one_mode, np.linspace(40, 80, 160), level=0.01, seed=2)
    found = estimate(data, choices=Choices(at=[51.0, 70.0]))
    assert len(found) == 1
    assert found.refused[0][0] == 70.0
    assert not found.is_sound
    assert "70" in found.verdict


def test_a_lightly_damped_peak_between_two_lines() -> None:
    truth = real_modes([50.37], [2e-4], np.array([[1.0]]))  # half-power band 0.02 of a line
    found = estimate(measured(truth, np.arange(30.0, 71.0)))
    assert found.modes[0].frequency == pytest.approx(50.37, rel=1e-7)
    assert found.modes[0].damping_ratio == pytest.approx(2e-4, rel=1e-4)
    assert any("lines wide" in remark for remark in found.modes[0].remarks)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"weighting": "odd"}, "weighting"),
        ({"residuals": "odd"}, "residuals"),
        ({"at": [500.0]}, "500"),
        ({"at": list(np.linspace(10, 110, 160))}, "modes"),
        ({"band": (50.0, 50.5)}, "band"),
        ({"damping": {30.0: 0.02}}, "30"),
        ({"damping": {51.0: 1.5}}, "1.5"),
    ],
)
def test_bad_choices_are_named(four_modes: Truth, change: dict, said: str) -> None:
    with pytest.raises(InvalidRequest, match=said):
        estimate(measured(four_modes, AXIS), choices=Choices(**change))


def test_bad_data_are_named() -> None:
    axis = np.linspace(1, 10, 20)
    value = np.ones((20, 1), dtype=complex)
    with pytest.raises(InvalidRequest, match="not finite"):
        Measured(axis, value * np.nan)
    with pytest.raises(InvalidRequest, match="zero throughout"):
        Measured(axis, value * 0)
    with pytest.raises(InvalidRequest) as caught:
        Measured(axis, np.full((20, 1), np.inf + 0j), variance=np.zeros((20, 1)), labels=("a", "b"))
    assert len(caught.value.faults) == 3  # all at once


def test_groups_do_not_disturb_each_other(four_modes: Truth) -> None:
    """Fitted together or alone, a group gives the same answer."""
    omega = 2 * np.pi * AXIS / 300
    value = 1e2 * np.moveaxis(four_modes.frf(AXIS)[:, :, None], 1, 0)
    weight = np.ones((5, len(AXIS), 1))
    free = np.ones((4, 2), dtype=bool)
    start = np.repeat(2 * np.pi * four_modes.frequency[None] / 300 * 1.01, 5, axis=0)
    damping = np.repeat(four_modes.damping[None] * 1.2, 5, axis=0)
    together = minimise(Separable(omega, value, weight, 1, "complex", free), start, damping)[0]
    alone = minimise(Separable(omega, value[2:3], weight[:1], 1, "complex", free), start[:1], damping[:1])[0]
    np.testing.assert_allclose(together[2], alone[0], rtol=1e-9)  # both converged on exact data


@pytest.mark.parametrize("power", [0, 1, 2])
def test_residual_terms_are_the_series_of_the_modes_beyond_the_band(power: int) -> None:
    """Modes at 6 and 300 Hz from 40 to 60 Hz: each term more leaves at most a third of what was left.

    The modes by `real_modes` and a formula of their own. The first term left out is that of ω/300 and 6/ω to
    a power, a sixth, and least squares spreads it over the lines.
    """
    axis = np.linspace(40.0, 60.0, 41)
    truth = real_modes([6.0, 300.0], [0.3, 0.1], np.array([[1.0, 40.0]]))
    value = truth.frf(axis, ["receptance", "mobility", "inertance"][power])
    left = []
    for further in range(4):
        columns = residual_columns(2 * np.pi * axis, power, "complex", further)
        assert columns.shape == (len(axis), 4 * (1 + further))
        terms = solve_columns(columns, value)
        left.append(np.linalg.norm(value - columns @ terms) / np.linalg.norm(value))
    assert left[0] > 1e-3
    assert all(after < before / 3 for before, after in itertools.pairwise(left))


def test_as_many_residual_terms_as_the_lines_ask_for() -> None:
    """None more where there is nothing to explain; some where a strong mode lies close to the band."""
    axis = np.arange(40.0, 60.1, 0.25)
    alone = real_modes([51.0], [0.04], np.array([[1.0]]))
    beside = real_modes([51.0, 66.0], [0.04, 0.03], np.array([[1.0, 1.5]]))
    taken = []
    for truth in (alone, beside):
        peaks = choose_peaks(measured(truth, axis, level=0.002), at=[51.0])
        problem = build_least_squares(measured(truth, axis, level=0.002), peaks)
        taken.append(with_terms_enough(problem, 3).further)
    assert taken[0] == 0
    assert taken[1] > 0

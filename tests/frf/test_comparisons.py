"""FRAC, FDAC, antiresonances, drive points and reciprocity on systems with known matrices."""

from __future__ import annotations

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest
from flexmodal.frf import antiresonances, check_drive_point, fdac, frac, receptance, reciprocity
from flexmodal.modal import SecondOrderSystem, solve_modes

AXIS = np.linspace(1, 80, 1600)
MASS = np.diag([2.0, 1.0, 1.5])
STIFFNESS = np.array([[9e4, -4e4, 0], [-4e4, 9e4, -5e4], [0, -5e4, 8e4]])


def _system(share: float = 2e-4) -> SecondOrderSystem:
    return SecondOrderSystem(MASS, share * STIFFNESS, STIFFNESS, ("a", "b", "c"))


def _frf(share: float = 2e-4) -> np.ndarray:
    return receptance(_system(share), np.eye(3), np.eye(3), AXIS)


def test_antiresonances_are_the_modes_with_the_point_held() -> None:
    """Between the zeros of the drive-point receptance and the resonances of the system less that row."""
    value = _frf(2e-6)[:, 0, 0]
    held = SecondOrderSystem(MASS[1:, 1:], 2e-6 * STIFFNESS[1:, 1:], STIFFNESS[1:, 1:], ("b", "c"))
    expected = solve_modes(held).frequency
    # A complex parabola through three lines 0.05 Hz apart leaves far less than a line.
    np.testing.assert_allclose(antiresonances(AXIS, value), expected, atol=2e-3)


def test_drive_points_pass_and_others_do_not() -> None:
    value = _frf()
    for form, factor in (
        ("receptance", 1),
        ("mobility", 2j * np.pi * AXIS),
        ("inertance", -((2 * np.pi * AXIS) ** 2)),
    ):
        for point in range(3):
            check = check_drive_point(AXIS, value[:, point, point] * factor, form)
            assert check.is_sound, check.verdict
            assert len(check.resonance) == 3
    turned = check_drive_point(AXIS, -value[:, 0, 0], "receptance")
    assert turned.share == 1.0
    assert "energy comes out" in turned.verdict
    across = check_drive_point(AXIS, value[:, 0, 2], "receptance")
    assert across.unparted
    assert not across.is_sound


def test_drive_point_allows_for_noise() -> None:
    value = _frf()[:, 0, 0]
    rng = np.random.default_rng(1)
    sigma = 1e-3 * np.max(np.abs(value))
    noisy = value + sigma / np.sqrt(2) * (rng.normal(size=len(AXIS)) + 1j * rng.normal(size=len(AXIS)))
    assert check_drive_point(AXIS, noisy, "receptance").share > 0.1
    # Three standard deviations of the whole value are 4.2 of its imaginary part: once in 10⁵ lines.
    assert check_drive_point(AXIS, noisy, "receptance", noise=sigma).share < 2e-3


def test_frac_and_fdac() -> None:
    value = _frf()
    np.testing.assert_allclose(frac(value, (3 - 2j) * value), 1.0, rtol=1e-12)
    stiffer = receptance(
        SecondOrderSystem(MASS, 2e-4 * STIFFNESS, 1.1 * STIFFNESS, ("a", "b", "c")),
        np.eye(3),
        np.eye(3),
        AXIS,
    )
    assert np.all(frac(value, stiffer) < 0.9)
    # Stiffness times 1.21 and damping times 1.1: the same FRFs over 1.21 at 1.1 times the frequency.
    scaled = SecondOrderSystem(MASS, 1.1 * 2e-4 * STIFFNESS, 1.21 * STIFFNESS, ("a", "b", "c"))
    shifted = receptance(scaled, np.eye(3), np.eye(3), 1.1 * AXIS)
    matrix = fdac(value[:, :, 0], shifted[:, :, 0])
    np.testing.assert_allclose(np.diag(matrix), 1.0, rtol=1e-10)
    np.testing.assert_allclose(fdac(value[:5, :, 0], -value[:5, :, 0]).diagonal(), -1.0, rtol=1e-12)


def test_reciprocity() -> None:
    value = _frf()
    assert np.max(reciprocity(value[:, 0, 2], value[:, 2, 0])) < 1e-9  # rounding of the solve
    np.testing.assert_allclose(reciprocity(value[:, 0, 2], 1.1 * value[:, 0, 2]), 0.1 / 1.05, rtol=1e-9)


def test_bad_input_is_named() -> None:
    bad = np.full(8, np.nan + 0j)
    with pytest.raises(InvalidRequest, match="not finite"):
        antiresonances(np.arange(1.0, 9.0), bad)
    with pytest.raises(InvalidRequest, match="zeros"):
        frac(np.zeros((8, 1), dtype=complex), np.ones((8, 1), dtype=complex))
    with pytest.raises(InvalidRequest, match="five lines"):
        check_drive_point(np.arange(1.0, 4.0), np.ones(3, dtype=complex), "mobility")

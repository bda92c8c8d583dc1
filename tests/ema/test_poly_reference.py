"""FRFs of several references: two modes at one frequency, participation factors, and a matrix that has
holes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.ema import Measured, stabilise
from flexmodal.errors import InvalidRequest

from .truth import real_modes

AXIS = np.linspace(5.0, 120.0, 300)
SHAPES = np.array([[1.0, 0.4, -0.7], [0.3, -0.9, 1.0], [-0.6, 1.0, 0.5], [0.8, 0.2, 0.9]])
HAMMER = np.array([[1.0, 0.5, -0.8], [-0.4, 1.0, 1.0]])


def of_two_references(level: float = 0.0, seed: int = 0) -> Measured:
    """Two modes at 51 Hz, one of 2 % and one of 2.001 % damping, and one at 90 Hz: four responses, two
    hammers."""
    amplitude = np.einsum("om,im->oim", SHAPES, HAMMER).reshape(8, 3)
    truth = real_modes([51.0, 51.0, 90.0], [0.02, 0.02001, 0.01], amplitude)
    value = truth.frf(AXIS)
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(2, *value.shape)) / np.sqrt(2) * level * np.max(np.abs(value), axis=0)
    ends = tuple((f"response {o}", f"hammer {i}") for o in range(4) for i in range(2))
    return Measured(AXIS, value + noise[0] + 1j * noise[1], "mobility", ends=ends)


def alike(one: np.ndarray, other: np.ndarray) -> float:
    """MAC of two vectors."""
    return float(abs(np.vdot(one, other)) ** 2 / (np.vdot(one, one) * np.vdot(other, other)).real)


@pytest.mark.parametrize("level", [0.0, 1e-3])
def test_two_modes_at_one_frequency_are_two_poles(level: float) -> None:
    data = of_two_references(level)
    diagram = stabilise(data, highest=12)
    last = (diagram.order == 8) & (np.abs(diagram.frequency - 51) < 0.2) & (diagram.damping_ratio < 0.03)
    assert np.count_nonzero(last) == 2
    # A common denominator has one pole there, whatever its order.
    plain = stabilise(replace(data, ends=()), highest=12)
    near = (plain.order == 8) & (np.abs(plain.frequency - 51) < 0.2) & (plain.damping_ratio < 0.03)
    assert np.count_nonzero(near) == 1


def test_participation_factors_are_those_of_the_references() -> None:
    diagram = stabilise(of_two_references(), highest=12)
    pole = np.flatnonzero((diagram.order == 8) & (np.abs(diagram.frequency - 90) < 0.01))
    assert len(pole) == 1
    factor = diagram.participation[:, pole[0]]
    assert np.max(np.abs(factor)) == pytest.approx(1.0)
    assert alike(factor, HAMMER[:, 2]) == pytest.approx(1.0, abs=1e-8)
    # The two at one frequency share a plane that no third vector has: together they span both references.
    pair = np.flatnonzero((diagram.order == 8) & (np.abs(diagram.frequency - 51) < 0.01))
    assert np.linalg.matrix_rank(diagram.participation[:, pair], tol=0.1) == 2


def test_the_side_with_fewer_places_is_the_reference() -> None:
    data = of_two_references()
    turned = replace(data, ends=tuple((into, out) for out, into in data.ends))
    assert data.matrix is not None
    assert turned.matrix is not None
    np.testing.assert_array_equal(turned.matrix, data.matrix)


def test_a_matrix_with_a_hole_is_fitted_by_a_common_denominator() -> None:
    data = of_two_references()
    part = Measured(AXIS, data.value[:, :7], "mobility", ends=data.ends[:7])
    assert part.matrix is None
    assert stabilise(part, highest=12).participation.shape[0] == 1
    assert data.only(3).matrix is None


def test_ends_are_one_pair_for_each_frf() -> None:
    data = of_two_references()
    with pytest.raises(InvalidRequest, match="ends"):
        replace(data, ends=data.ends[:3])
    with pytest.raises(InvalidRequest, match="ends"):
        replace(data, ends=(data.ends[0],) * 8)


def test_agrees_with_the_matrix_fraction_written_out() -> None:
    """The normal equations of order 6 by another route: all equations of all lines stacked, one least
    squares."""
    data = of_two_references(1e-3, seed=4)
    problem = stabilise(data, highest=6).problem
    order, size = 6, 2
    matrix = data.matrix
    assert matrix is not None
    value = data.value[:, matrix] / problem.scale
    z = np.exp(-1j * problem.delay * (problem.omega - problem.omega[0]))
    powers = z[:, None] ** np.arange(order + 1)
    ours = problem.coefficients(order)

    # With the denominator as found, the best numerators leave equations that no small change of it improves.
    def left(coefficients: np.ndarray) -> float:
        total = 0.0
        for row in range(value.shape[1]):
            product = np.einsum("lk,li,kij->lj", powers, value[:, row], coefficients) / rows[row]
            best = powers @ np.linalg.lstsq(powers, product, rcond=None)[0]
            total += float(np.sum(np.abs(product - best) ** 2))
        return total

    rows = row_scales(data)
    least = left(ours)
    rng = np.random.default_rng(0)
    for _ in range(5):
        change = np.zeros_like(ours)
        change[:order] = 1e-4 * (
            rng.normal(size=(order, size, size)) + 1j * rng.normal(size=(order, size, size))
        )
        assert left(ours + change) > least
        slope = (left(ours + change) - left(ours - change)) / (
            left(ours + change) + left(ours - change) - 2 * least
        )
        assert abs(slope) < 1e-2  # 0 at the minimum of a quadratic


def row_scales(data: Measured) -> np.ndarray:
    """Root of the noise of each response, as the fit weighs it: the geometric mean over the references."""
    from flexmodal.ema.methods.noise import noise_levels

    matrix = data.matrix
    assert matrix is not None
    levels = np.log(noise_levels(data))[matrix]
    scale: np.ndarray = np.exp(levels.mean(axis=1) - levels.mean() / 2)
    return scale

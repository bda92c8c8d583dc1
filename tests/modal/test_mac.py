"""MAC, COMAC, phase collinearity and tracking: closed forms, invariances, failures."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest
from flexmodal.modal import auto_mac, comac, mac, phase_collinearity, track, track_all


def _shapes(seed: int, rows: int = 6, modes: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(rows, modes)) + 1j * rng.normal(size=(rows, modes))


def test_mac_of_known_angles() -> None:
    one = np.array([[1.0], [0.0]])
    for angle in (0.0, 0.3, 1.0, np.pi / 2):
        other = np.array([[np.cos(angle)], [np.sin(angle)]])
        assert mac(one, other)[0, 0] == pytest.approx(np.cos(angle) ** 2, abs=1e-15)


def test_mac_is_blind_to_scale_and_phase() -> None:
    shapes = _shapes(1)
    scaled = shapes * np.array([1e-170, 3j, -2.0, 1e150 * np.exp(0.7j)])
    np.testing.assert_allclose(mac(shapes, scaled), auto_mac(shapes), atol=1e-13)
    np.testing.assert_allclose(np.diag(auto_mac(shapes)), 1.0, rtol=1e-14)
    unitary = np.linalg.qr(_shapes(2, 4, 4))[0]
    np.testing.assert_allclose(auto_mac(unitary), np.eye(4), atol=1e-15)


def test_comac_finds_the_point_that_disagrees() -> None:
    shapes = _shapes(3)
    wrong = shapes.copy()
    wrong[2] *= np.array([0.1, 3.0, 0.2, 2.0])
    found = comac(shapes, wrong)
    assert np.argmin(found) == 2
    assert np.all(np.delete(found, 2) > found[2])
    np.testing.assert_allclose(comac(shapes, 5j * shapes), 1.0, rtol=1e-14)
    still = np.vstack([shapes, np.zeros(4)])
    assert comac(still, still)[-1] == 1.0


def test_phase_collinearity_agrees_with_the_eigenvalues_of_the_scatter() -> None:
    shapes = _shapes(4)
    for mode, found in zip(shapes.T, phase_collinearity(shapes), strict=True):
        parts = np.stack([mode.real, mode.imag])
        low, high = np.linalg.eigvalsh(parts @ parts.T)
        assert found == pytest.approx(((high - low) / (high + low)) ** 2, rel=1e-12)
    real = np.random.default_rng(5).normal(size=(6, 2)) * np.exp(0.4j)
    np.testing.assert_allclose(phase_collinearity(real), 1.0, rtol=1e-13)
    circle = np.exp(2j * np.pi * np.arange(8) / 8)[:, None]
    assert phase_collinearity(circle)[0] == pytest.approx(0, abs=1e-25)


def test_tracking_is_the_best_of_all_pairings() -> None:
    """Against every permutation, by the formula of the docstring."""
    rng = np.random.default_rng(6)
    for _ in range(10):
        first, second = rng.uniform(5, 100, 4), rng.uniform(5, 100, 4)
        one, other = rng.normal(size=(5, 4)), rng.normal(size=(5, 4))
        cost = 0.7 * (1 - mac(one, other))
        cost += 0.3 * (1 - np.exp(-((np.log(second[None] / first[:, None]) / 0.1) ** 2)))
        best = min(itertools.permutations(range(4)), key=lambda p: sum(cost[i, p[i]] for i in range(4)))
        found = track(first, one, second, other, worst=1.0)
        assert sum(cost[i, found[i]] for i in range(4)) == pytest.approx(
            sum(cost[i, best[i]] for i in range(4))
        )


def test_tracking_follows_shapes_through_a_crossing() -> None:
    shapes = np.eye(3)
    tracks = track_all(
        [np.array([8.0, 50.0, 55.0]), np.array([8.1, 52.0, 53.0]), np.array([8.2, 50.0, 56.0])],
        [shapes, shapes, shapes[:, [0, 2, 1]]],
    )
    np.testing.assert_array_equal(tracks, [[0, 1, 2], [0, 1, 2], [0, 2, 1]])


def test_a_mode_without_a_partner_ends_its_track_and_a_new_one_begins() -> None:
    tracks = track_all([np.array([8.0, 50.0]), np.array([8.1, 90.0])])
    np.testing.assert_array_equal(tracks, [[0, 1, -1], [0, -1, 1]])
    assert track(np.array([8.0]), None, np.empty(0), None).tolist() == [-1]


def test_bad_shapes_are_named() -> None:
    with pytest.raises(InvalidRequest, match="zero"):
        mac(np.array([[0.0], [0.0]]), np.ones((2, 1)))
    with pytest.raises(InvalidRequest, match="not finite"):
        phase_collinearity(np.array([[np.nan], [1.0]]))
    with pytest.raises(InvalidRequest) as caught:
        track(np.array([-1.0]), None, np.array([0.0]), None, worst=2.0)
    assert len(caught.value.faults) == 3

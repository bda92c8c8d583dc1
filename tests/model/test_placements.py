"""Placements of links against Pinocchio's own frames, a hand calculation, and the Jacobian."""

import numpy as np
import pytest

from flexmodal.errors import InvalidPosture
from flexmodal.model import load
from flexmodal.model.placements import link_placements


@pytest.fixture(scope="module")
def arm():
    return load("fanuc_s360")


def test_every_link_is_placed_and_rigidly(arm):
    placed = link_placements(arm, {"q1": 0.3})
    assert set(placed) == {link.name for link in arm.urdf.links}
    for matrix in placed.values():
        np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-14)
        np.testing.assert_array_equal(matrix[3], [0, 0, 0, 1])


def test_root_stands_at_the_origin(arm):
    np.testing.assert_array_equal(link_placements(arm, {"q1": 1.0})[arm.urdf.root], np.eye(4))


def test_planar_chain_by_hand(arm):
    # Lengths from the URDF; angles add up, and a pseudo-joint turns like any other.
    q1, q2, rho, q3 = 0.7, -0.4, 0.05, 0.2
    lengths, sums = np.array([0.85, 0.29, 0.78, 0.23]), np.cumsum([q1, q2, rho, q3])
    expected = [lengths @ np.cos(sums), 0, lengths @ np.sin(sums)]
    tool = link_placements(arm, {"q1": q1, "q2": q2, "rho": rho, "q3": q3})["tool"]
    np.testing.assert_allclose(tool[:3, 3], expected, atol=1e-14)


def test_agrees_with_the_posed_robot(arm):
    posed = arm.at("configuration_1")
    placed = link_placements(arm, posed.posture.values)
    for link in placed:
        np.testing.assert_allclose(placed[link][:3, 3], posed.position(link), atol=1e-14)


def test_small_deflection_follows_the_jacobian(arm):
    posed = arm.at("configuration_2")
    step = 1e-6  # error of second order: 1e-12
    values = dict(posed.posture.values)
    moved = link_placements(arm, values | {"rho": step})["tool"][:3, 3] - posed.position("tool")
    column = posed.jacobian("tool")[:3, list(arm.joints).index("rho")]
    np.testing.assert_allclose(moved, step * column, atol=2e-12)


def test_limits_are_not_looked_at(arm):
    assert link_placements(arm, {"rho": 1.0})  # ten times its limit


def test_bad_values_are_named_all_at_once(arm):
    with pytest.raises(InvalidPosture) as caught:
        link_placements(arm, {"q9": 0.0, "q1": float("nan")})
    assert len(caught.value.faults) == 2
    assert "q9" in str(caught.value)

"""Receptance where it can be written down, and where the measurement-space route breaks off."""

from __future__ import annotations

import numpy as np
import pytest

import flexmodal

from ..model.writing import planar
from .planar_chain import (
    FANUC,
    FANUC_DAMPING,
    FANUC_STIFFNESS,
    SIX_LINK,
    SIX_LINK_DAMPING,
    SIX_LINK_STIFFNESS,
)

LINES = np.array([0.0, 0.5, 3.0, 11.0, 40.0, 150.0])


def test_single_joint(tmp_path):
    """α_zz = (l cos q)² / (k − ω²I + iωb), with I = i + m c² about the joint."""
    length, mass, inertia, com, k, b, q = 0.8, 5.0, 0.2, 0.35, 3e4, 40.0, 0.6
    path = planar(tmp_path / "one.urdf", [length], [mass], [inertia], [com])
    posed = flexmodal.load(path, stiffness=k, damping=b).at({"q1": q})
    omega = 2 * np.pi * LINES
    swing = 1 / (k - omega**2 * (inertia + mass * com**2) + 1j * omega * b)
    directions = ["tool:+x", "tool:+z", "tool:+ry", "tool:+y"]
    lever = np.array([-length * np.sin(q), length * np.cos(q), -1.0, 0.0])
    found = posed.frf(LINES, response=directions)
    expected = swing[:, None, None] * np.outer(lever, lever)
    np.testing.assert_allclose(found.value, expected, rtol=1e-13, atol=1e-20)  # a dozen roundings
    np.testing.assert_allclose(
        posed.frf(LINES, response=directions, form="inertance").value,
        -((omega**2)[:, None, None]) * expected,
        rtol=1e-13,
        atol=1e-16,
    )


def test_two_joints(tmp_path):
    """Z inverted by hand: α = (a² z22 − 2ab z12 + b² z11) / det Z."""
    l1, l2, m1, m2, i1, i2, c1, c2 = 0.7, 0.45, 6.0, 3.5, 0.31, 0.12, 0.33, 0.17
    path = planar(tmp_path / "two.urdf", [l1, l2], [m1, m2], [i1, i2], [c1, c2])
    k, b, q1, q2 = (2e4, 6e3), (15.0, 3.0), 0.5, -1.1
    robot = flexmodal.load(path, stiffness={"q1": k[0], "q2": k[1]}, damping={"q1": b[0], "q2": b[1]})
    coupling = m2 * (c2**2 + l1 * c2 * np.cos(q2)) + i2
    first = m1 * c1**2 + i1 + m2 * (l1**2 + c2**2 + 2 * l1 * c2 * np.cos(q2)) + i2
    omega = 2 * np.pi * LINES
    z11 = k[0] - omega**2 * first + 1j * omega * b[0]
    z22 = k[1] - omega**2 * (m2 * c2**2 + i2) + 1j * omega * b[1]
    z12 = -(omega**2) * coupling
    lever_2 = l2 * np.cos(q1 + q2)
    lever_1 = l1 * np.cos(q1) + lever_2
    expected = (lever_1**2 * z22 - 2 * lever_1 * lever_2 * z12 + lever_2**2 * z11) / (z11 * z22 - z12**2)
    found = robot.frf({"q1": q1, "q2": q2}, LINES).value[:, 0, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-12)  # the determinant cancels a digit or two


@pytest.mark.parametrize(
    ("name", "posture", "chain", "stiffness", "damping"),
    [
        ("fanuc_s360", "configuration_4", FANUC, FANUC_STIFFNESS, FANUC_DAMPING),
        ("fanuc_s360", "configuration_1", FANUC, FANUC_STIFFNESS, FANUC_DAMPING),
        ("six_link", "start_2", SIX_LINK, SIX_LINK_STIFFNESS, SIX_LINK_DAMPING),
    ],
)
def test_the_thesis_robots(name, posture, chain, stiffness, damping):
    robot = flexmodal.load(name)
    posed = robot.at(posture)
    angles = np.array([posed.posture.values.get(joint, 0.0) for joint in robot.moving])
    x, z, turn = chain.tool(angles)
    rows, mass = np.array([x, z, -turn]), chain.mass_matrix(angles)
    found = posed.frf(LINES, response=["tool:+x", "tool:+z", "tool:+ry"]).value
    for line, omega in enumerate(2 * np.pi * LINES):
        dynamic = np.diag(stiffness) - omega**2 * mass + 1j * omega * np.diag(damping)
        expected = rows @ np.linalg.solve(dynamic, rows.T)
        # rounding times the condition of Z, up to a few hundred
        np.testing.assert_allclose(found[line], expected, atol=1e-12 * np.abs(expected).max())


def test_rigid_joints_on_paper():
    """A joint without compliance takes its row and column out of D; the others keep theirs."""
    robot = flexmodal.load("six_link")
    soft = ["q2", "q3", "q5"]
    partly = flexmodal.load(
        robot.urdf.path, stiffness={name: robot.joints[name].stiffness for name in soft}, damping=0.0
    )
    posed = partly.at(dict(robot.postures["start_2"]))
    angles = np.array(list(robot.postures["start_2"].values()))
    pick = [1, 2, 4]
    np.testing.assert_allclose(
        posed.system.mass, SIX_LINK.mass_matrix(angles)[np.ix_(pick, pick)], rtol=1e-12
    )
    row = SIX_LINK.tool(angles)[1, pick]
    omega = 2 * np.pi * 3.0
    dynamic = np.diag(SIX_LINK_STIFFNESS[pick]) - omega**2 * posed.system.mass
    found = posed.frf([3.0]).value[0, 0, 0]
    assert found == pytest.approx(row @ np.linalg.solve(dynamic, row), rel=1e-11)


# The thesis's route: mass matrix in measurement space, M_z = TR⁻ᵀ D TR⁻¹ [2.48–2.50].

HEIGHTS = [(0, 0.85), (1, 0.29), (2, 0.78), (3, 0.23)]
"""Where it measures: the far end of every bar, along z."""


def through_measurement_space(angles: np.ndarray, omega: float) -> complex:
    """Receptance of the tool along z with the heights of four places as coordinates instead of angles."""
    transform = np.array([FANUC.rows(angles, bar, along)[1] for bar, along in HEIGHTS])
    inverse = np.linalg.inv(transform)
    mass = inverse.T @ FANUC.mass_matrix(angles) @ inverse
    stiffness = inverse.T @ np.diag(FANUC_STIFFNESS) @ inverse
    damping = inverse.T @ np.diag(FANUC_DAMPING) @ inverse
    return complex(np.linalg.inv(stiffness - omega**2 * mass + 1j * omega * damping)[-1, -1])


@pytest.mark.parametrize("degrees", [45.0, 50, 70, 80, 85, 95, 100, 110, 123, 135])
def test_measurement_space_away_from_90_degrees(degrees):
    robot = flexmodal.load("fanuc_s360")
    q1 = np.radians(degrees)
    lines = [0.0, 8.0, 30.0, 51.0, 94.0]
    found = robot.frf({"q1": q1, "q2": -q1}, lines).value[:, 0, 0]
    expected = [through_measurement_space(np.array([q1, -q1, 0, 0]), 2 * np.pi * f) for f in lines]
    # The transform's own condition, some 1 / cos q1 ≤ 12 and squared on the way, costs it three digits.
    np.testing.assert_allclose(found, expected, rtol=1e-11)


def test_nothing_happens_at_90_degrees():
    """88° to 92° in steps of 0.01°, where the seed had to interpolate: finite, smooth, and exact at 90°."""
    robot = flexmodal.load("fanuc_s360")
    lines = np.array([0.0, 4.0, 8.0, 51.0, 94.0, 200.0])
    degrees = np.linspace(88, 92, 401)
    found = np.array([robot.frf({"q1": q, "q2": -q}, lines).value[:, 0, 0] for q in np.radians(degrees)])
    assert np.all(np.isfinite(found))
    size = np.abs(found).max(axis=0)
    # α depends on q1 through sines and cosines: a step of 1.7e-4 rad changes it by some 1e-3 of its size
    # at most (near a lightly damped resonance), and the second difference is smaller again by as much.
    assert np.all(np.abs(np.diff(found, axis=0)) <= 2e-3 * size)
    assert np.all(np.abs(np.diff(found, 2, axis=0)) <= 5e-6 * size)
    right = np.array([np.pi / 2, -np.pi / 2, 0, 0])
    row, mass = FANUC.tool(right)[1], FANUC.mass_matrix(right)
    for line, omega in enumerate(2 * np.pi * lines):
        dynamic = np.diag(FANUC_STIFFNESS) - omega**2 * mass + 1j * omega * np.diag(FANUC_DAMPING)
        assert found[200, line] == pytest.approx(row @ np.linalg.solve(dynamic, row), rel=1e-11)
    with np.errstate(all="ignore"):
        transform = np.array([FANUC.rows(right, bar, along)[1] for bar, along in HEIGHTS])
    assert np.linalg.cond(transform) > 1e15  # what the other route would have had to invert

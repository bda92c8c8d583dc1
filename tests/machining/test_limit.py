"""Depth without regard to speed: closed forms, a brute search."""

import numpy as np
import pytest

from flexmodal.machining import average, limiting_depth, unconditional_depth


def test_one_mode_in_closed_form(benchmark):
    """Smallest width 2 k ζ (1 + ζ) / K of one mode (Tlusty), K its directional force per depth."""
    cut, tip = benchmark()
    force = -average(cut)[0, 0]
    stiffness, ratio = tip.system.stiffness[0, 0], 0.011
    depth, frequency = unconditional_depth(tip, cut)
    assert depth == pytest.approx(2 * stiffness * ratio * (1 + ratio) / force, rel=1e-9)
    assert frequency == pytest.approx(922 * np.sqrt(1 + 2 * ratio), rel=1e-5)  # a flat minimum


def test_against_a_dense_search(two_modes):
    cut, tip = two_modes
    lines = np.linspace(300, 1200, 90001)
    dense = limiting_depth(tip.receptance(lines), average(cut))
    depth, frequency = unconditional_depth(tip, cut)
    assert depth == pytest.approx(dense.min(), rel=1e-7)
    assert depth <= dense.min() * (1 + 1e-12)
    assert frequency == pytest.approx(lines[dense.argmin()], abs=0.02)


@pytest.mark.slow
def test_no_speed_is_unstable_below_it(two_modes):
    """The determinant at three quarters of the depth never encircles the origin at any tooth period."""
    cut, tip = two_modes
    depth, _ = unconditional_depth(tip, cut)
    lines = np.linspace(1, 5000, 20001)
    product = tip.receptance(lines) @ average(cut)
    for part, clear in ((0.75, True), (1.25, False)):
        turns = []
        for period in np.geomspace(1e-3, 6e-3, 150):
            delay = part * depth * (1 - np.exp(-2j * np.pi * lines * period))
            value = np.linalg.det(np.eye(3) - delay[:, None, None] * product)
            turns.append(abs(np.sum(np.angle(value[1:] / value[:-1]))) > 3)
        assert any(turns) != clear


def test_where_nothing_limits_the_depth():
    """A force that only damps: every eigenvalue on the left."""
    receptance = np.diag([1e-6, 2e-6, 0]).astype(complex)[None]
    directional = -1e8 * np.eye(3)
    assert limiting_depth(receptance, directional)[0] == np.inf

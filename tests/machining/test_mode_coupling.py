"""Mode coupling: two routes, and Tlusty's undamped pair of modes in closed form."""

import math

import numpy as np
import pytest

from flexmodal.machining import (
    Cut,
    CutFrame,
    Cutter,
    CuttingForce,
    Engagement,
    ModelTip,
    average,
    mode_coupling,
    tool_tip,
)
from flexmodal.modal import SecondOrderSystem


def pair(stiffness, damping, mass=20.0):
    system = SecondOrderSystem(mass * np.eye(2), damping * np.eye(2), np.diag(stiffness), ("1", "2"))
    return ModelTip(system, np.eye(3, 2))


def make(entry, leaving, radial=0.3):
    return Cut(
        Cutter(4, 0.02),
        CuttingForce(7e8, radial),
        Engagement(math.radians(entry), math.radians(leaving), (1000.0, 9000.0)),
        CutFrame("tool", "+z", "+x"),
    )


def process_poles(tip, cut, depth):
    """Poles of the system with the mean cutting force as a stiffness beside its own [rad/s]."""
    inverse = np.linalg.inv(tip.system.mass)
    stiffness = tip.system.stiffness - depth * tip.rows.T @ average(cut) @ tip.rows
    none, one = np.zeros_like(inverse), np.eye(len(inverse))
    return np.linalg.eigvals(np.block([[none, one], [-inverse @ stiffness, -inverse @ tip.system.damping]]))


@pytest.mark.parametrize("engagement", [(0, 90), (0, 180), (60, 140)])
@pytest.mark.parametrize("ratio", [1.05, 1.5])
def test_an_undamped_pair_in_closed_form(engagement, ratio):
    """K − aW has a pair of complex roots ω² once (S₁₁ − S₂₂)² + 4 S₁₂ S₂₁ < 0: a quadratic for a."""
    cut = make(*engagement)
    first, second = 1e6, ratio * 1e6
    w = average(cut)[:2, :2]
    # ((k₁ − k₂) − a (w₁₁ − w₂₂))² + 4 a² w₁₂ w₂₁ = 0
    square = (w[0, 0] - w[1, 1]) ** 2 + 4 * w[0, 1] * w[1, 0]
    roots = np.roots([square, -2 * (first - second) * (w[0, 0] - w[1, 1]), (first - second) ** 2])
    expected = min(root.real for root in roots if abs(root.imag) < 1e-12 * abs(root) and root.real > 0)
    tip = pair((first, second), 1e-4)  # next to none: the limit tends to the closed form with its root
    found = mode_coupling(tip, cut)
    assert found.depth == pytest.approx(expected, rel=1e-4)
    natural = np.sqrt(np.array([first, second]) / 20) / (2 * np.pi)
    assert 0.8 * natural[0] < found.frequency < 1.2 * natural[1]


@pytest.mark.parametrize("posture", ["configuration_1", "configuration_4", "configuration_7"])
def test_receptance_and_poles_agree_on_a_robot(fanuc, across, posture):
    cut = across()
    tip = tool_tip(fanuc.at(posture), cut)
    found = mode_coupling(tip, cut)
    assert 0 < found.depth < 0.1
    for part, stable in ((0.5, True), (1 - 1e-6, True), (1 + 1e-6, False)):
        assert (process_poles(tip, cut, part * found.depth).real.max() < 0) == stable
    poles = process_poles(tip, cut, found.depth)
    crossing = poles[np.argmax(poles.real)]
    assert abs(crossing.imag) / (2 * np.pi) == pytest.approx(found.frequency, rel=1e-6)
    assert 30 < found.frequency < 80  # the arm's own


def test_one_mode_does_not_couple(benchmark):
    """A slot pushes its single mode back: no mode coupling, no divergence, whatever the depth."""
    cut, tip = benchmark()
    found = mode_coupling(tip, cut)
    assert found.depth == np.inf
    assert np.isnan(found.frequency)
    for depth in (1e-3, 1.0):
        assert process_poles(tip, cut, depth).real.max() < 0


def test_divergence_is_found_at_0_hz():
    """A cut that pulls a soft direction along: stiffness lost, no vibration."""
    cut = make(100, 180, radial=0.0)
    w = average(cut)[:2, :2]
    assert w[0, 0] > 0
    tip = pair((1e5, 1e9), 500.0)
    found = mode_coupling(tip, cut)
    assert found.frequency == 0
    # det(K − aW) = 0
    roots = np.roots([np.linalg.det(w), -(1e5 * w[1, 1] + 1e9 * w[0, 0]), 1e14])
    assert found.depth == pytest.approx(min(root.real for root in roots if root.real > 0), rel=1e-9)
    assert process_poles(tip, cut, 1.001 * found.depth).real.max() > 0
    assert process_poles(tip, cut, 0.999 * found.depth).real.max() < 0


def test_modes_that_lie_near_couple_sooner():
    """What Pan and others tell of robots: nearly equal stiffness is worst."""
    cut = make(0, 90)
    depths = [mode_coupling(pair((1e6, ratio * 1e6), 20.0), cut).depth for ratio in (1.02, 1.2, 2.0, 5.0)]
    assert depths == sorted(depths)
    assert depths[-1] > 10 * depths[0]

"""Directional matrices: against the formulas in print, against quadrature, and against what must be."""

import math

import numpy as np
import pytest

from flexmodal.machining import Cut, CutFrame, Cutter, CuttingForce, Engagement, average
from flexmodal.machining.stability.directional import (
    at,
    edge_vectors,
    harmonics,
    helix_lag,
    static_force_harmonics,
    tooth_matrix,
    window_mean,
)


def make(entry, leaving, *, teeth=3, approach=math.pi / 2, helix=0.0, radial=0.3, axial=0.15, **more):
    return Cut(
        Cutter(teeth, 0.02, helix=helix, approach=approach),
        CuttingForce(7e8, radial, axial, **more.pop("edge", {})),
        Engagement(entry, leaving, (1000.0, 9000.0), **more),
        CutFrame("tool", "+z", "+x"),
    )


CUTS = {
    "up, half": make(0.0, math.pi / 2),
    "down, tenth": make(math.acos(2 * 0.1 - 1), math.pi, teeth=2),
    "slot": make(0.0, math.pi, teeth=4),
    "face mill": make(0.7, 2.6, teeth=5, approach=math.radians(45)),
}


@pytest.mark.parametrize("name", [name for name in CUTS if name != "face mill"])
def test_mean_against_the_formulas_of_altintas_and_budak(name):
    """Their coefficients α, printed for an end mill: W₀ = N K_t / (4π) [α]."""
    cut = CUTS[name]
    r = cut.force.radial_ratio

    def between(f):
        return f(cut.engagement.exit) - f(cut.engagement.entry)

    alpha = 0.5 * np.array(
        [
            [
                between(lambda p: math.cos(2 * p) - 2 * r * p + r * math.sin(2 * p)),
                between(lambda p: -math.sin(2 * p) - 2 * p + r * math.cos(2 * p)),
            ],
            [
                between(lambda p: -math.sin(2 * p) + 2 * p + r * math.cos(2 * p)),
                between(lambda p: -math.cos(2 * p) - 2 * r * p - r * math.sin(2 * p)),
            ],
        ]
    )
    expected = cut.cutter.teeth * cut.force.tangential / (4 * math.pi) * alpha
    np.testing.assert_allclose(average(cut)[:2, :2], expected, atol=1e-6 * np.abs(expected).max())
    assert np.all(average(cut)[:, 2] == 0)  # nothing along the axis changes the chip of an end mill


@pytest.mark.parametrize("name", CUTS)
def test_harmonics_against_quadrature(name):
    cut = CUTS[name]
    angle = np.linspace(cut.engagement.entry, cut.engagement.exit, 40001)
    orders = np.array([-3, -1, 0, 1, 2, 7])
    for k, found in zip(orders, harmonics(cut, orders), strict=True):
        wave = np.exp(-1j * k * cut.cutter.teeth * angle)[:, None, None]
        expected = (
            np.trapezoid(tooth_matrix(cut, angle) * wave, angle, axis=0) * cut.cutter.teeth / (2 * np.pi)
        )
        # The trapezoidal rule on 40000 steps: 1e-7 of the largest.
        np.testing.assert_allclose(found, expected, atol=1e-6 * cut.force.tangential)


@pytest.mark.parametrize("name", CUTS)
def test_the_fourier_series_gives_the_cutter_back(name):
    """Means over small windows, once from the instants, once from 4000 harmonics."""
    cut = CUTS[name]
    orders = np.arange(-4000, 4001)
    start, width = np.linspace(0, 6, 37), 0.05
    rate = 1j * orders * cut.cutter.teeth * width
    smear = np.where(orders == 0, 1, np.expm1(rate) / np.where(orders == 0, 1, rate))
    wave = np.exp(1j * np.outer(start, orders * cut.cutter.teeth)) * smear
    expected = np.tensordot(wave, harmonics(cut, orders), axes=1).real
    found = window_mean(cut, start, width)
    np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(found).max())  # what 4000 harmonics leave


def test_a_helix_is_a_mean_over_its_lag():
    cut = make(0.0, 1.2, helix=math.radians(35))
    depth = 0.011
    lag = helix_lag(cut, depth)
    assert lag == pytest.approx(2 * depth * math.tan(math.radians(35)) / 0.02)
    straight = make(0.0, 1.2)
    angle = np.linspace(-1, 7, 23)
    slices = (np.arange(2000) + 0.5) / 2000
    expected = np.mean([at(straight, angle - lag * part) for part in slices], axis=0)
    np.testing.assert_allclose(at(cut, angle, depth), expected, atol=1e-3 * 7e8)
    orders = np.array([0, 1, 5])
    turn = np.linspace(0, 2 * np.pi / 3, 6001)[:-1]
    series = [np.mean(at(cut, turn, depth) * np.exp(-3j * k * turn)[:, None, None], axis=0) for k in orders]
    np.testing.assert_allclose(harmonics(cut, orders, depth), series, atol=1e-4 * 7e8)


def test_a_slot_of_four_teeth_cuts_evenly():
    """sin² and sin cos of four teeth at right angles add up to constants."""
    cut = make(0.0, math.pi, teeth=4, axial=0.0)  # the axial force goes with sin alone
    every = at(cut, np.linspace(0.01, 1.5, 50))
    np.testing.assert_allclose(every, np.broadcast_to(average(cut), every.shape), atol=1e-6 * 7e8)


def test_chips_and_forces_point_the_way_they_must():
    """A tooth goes clockwise; its outward normal thickens the chip; the force on the tool resists both."""
    cut = make(0.0, math.pi, approach=math.radians(60))
    angle = np.linspace(0.1, 3.0, 9)
    path, normal, edge = edge_vectors(cut, angle)
    outward = np.stack([np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    later = np.stack([np.sin(angle + 1e-6), np.cos(angle + 1e-6), 0 * angle], axis=1)
    np.testing.assert_allclose((later - outward) / 1e-6, path, atol=1e-5)
    for one in (path, normal, edge):
        np.testing.assert_allclose(np.linalg.norm(one, axis=1), 1)
    np.testing.assert_allclose(np.cross(path, normal), edge, atol=1e-12)
    assert np.all(np.sum(normal * outward, axis=1) > 0)
    assert np.all(normal[:, 2] < 0)  # the edge faces down into the work
    assert np.all(edge[:, 2] > 0)
    push = np.einsum("aij,aj->ai", tooth_matrix(cut, angle), normal)  # a chip one metre thick
    assert np.all(np.sum(push * path, axis=1) < 0)
    assert np.all(np.sum(push * normal, axis=1) < 0)


def test_static_force_of_a_slot_in_closed_form():
    """Mean forces of a slot: F_x = −N a (K_r f / 4 + K_te... ), after Altintas; signs of his axes."""
    edge = {"tangential_edge": 2e4, "radial_edge": 1e4, "axial_edge": 3e3}
    cut = make(0.0, math.pi, teeth=2, edge=edge, feed_per_tooth=1e-4, depth=2e-3)
    kt, kr, ka = cut.force.specific
    kte, kre, kae = cut.force.edge
    n, a, c = 2, 2e-3, 1e-4
    expected = [
        -n * a / 4 * kr * c - n * a / math.pi * kre,
        n * a / 4 * kt * c + n * a / math.pi * kte,
        -n * a / math.pi * ka * c - n * a / 2 * kae,
    ]
    found = static_force_harmonics(cut, np.array([0]), 2e-3)[0]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_up_and_down_milling_are_mirror_images():
    """Turned round the feed the other way: sine stays, cosine changes sign."""
    up, down = make(0.0, 1.1, axial=0.0), make(math.pi - 1.1, math.pi, axial=0.0)
    mirror = np.diag([1.0, -1.0, 1.0])
    swapped = mirror @ average(down) @ mirror
    # The tangential part changes its sense under the mirror, the radial part does not.
    rad_up, rad_down = (
        average(make(e, x, axial=0.0, radial=0.0)) for e, x in ((0.0, 1.1), (math.pi - 1.1, math.pi))
    )
    np.testing.assert_allclose(average(up) - rad_up, swapped - mirror @ rad_down @ mirror, atol=1e-3)
    np.testing.assert_allclose(rad_up, -mirror @ rad_down @ mirror, atol=1e-3)

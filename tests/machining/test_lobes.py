"""Lobes by three methods that share little, against closed forms, printed values and each other."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest, SingularResponse
from flexmodal.machining import (
    METHODS,
    Cut,
    CutFrame,
    Cutter,
    CuttingForce,
    Engagement,
    ModelTip,
    ToolMode,
    average,
    modal_tip,
    multipliers,
    single_direction,
    stability_lobes,
    tool_tip,
    unconditional_depth,
)
from flexmodal.modal import SecondOrderSystem

from .conftest import rpm

SPEEDS = rpm(5000, 7400, 9000, 11000, 15000, 17000, 21000, 23000)


def read_off(speed, depth, wanted):
    """Depths of a curve where it passes a speed, linear between its points; jumps are no passages."""
    cell = np.flatnonzero(((speed[1:] - wanted) * (speed[:-1] - wanted) <= 0) & (np.abs(np.diff(speed)) < 50))
    part = (wanted - speed[cell]) / (speed[cell + 1] - speed[cell])
    return depth[cell] + part * (depth[cell + 1] - depth[cell])


def printed_lobes(cut, tip, speeds):
    """Altintas and Budak's own recipe: a quadratic for Λ at each frequency, the speeds of many lobes."""
    frequency = np.linspace(400, 1500, 220001)
    phi = tip.receptance(frequency)
    alpha = average(cut)[:2, :2] * 4 * np.pi / (cut.cutter.teeth * cut.force.tangential)
    a0 = phi[:, 0, 0] * phi[:, 1, 1] * np.linalg.det(alpha)
    a1 = alpha[0, 0] * phi[:, 0, 0] + alpha[1, 1] * phi[:, 1, 1]
    lowest = np.full(len(speeds), np.inf)
    for sign in (1, -1):
        value = -(a1 + sign * np.sqrt(a1**2 - 4 * a0)) / (2 * a0)
        kappa = value.imag / value.real
        depth = -2 * np.pi * value.real / (cut.cutter.teeth * cut.force.tangential) * (1 + kappa**2)
        for lobe in range(12):
            period = (np.pi - 2 * np.arctan(kappa) + 2 * np.pi * lobe) / (2 * np.pi * frequency)
            speed = 60 / (cut.cutter.teeth * period)
            for place, wanted in enumerate(speeds):
                found = read_off(speed, depth, wanted)
                lowest[place] = min(lowest[place], np.min(found[found > 0], initial=np.inf))
    return lowest


def test_zero_order_against_the_printed_recipe(two_modes):
    cut, tip = two_modes
    speeds = rpm(3500, 4700, 6100, 8200, 10000, 12500, 15000, 19000)
    found = stability_lobes(tip, cut, speeds=speeds)
    # The recipe is read off a grid of 0.005 Hz.
    np.testing.assert_allclose(found.depth, printed_lobes(cut, tip, speeds), rtol=1e-5)


@pytest.mark.some(3)
@pytest.mark.parametrize("axes", ["x", "xy"])
@pytest.mark.parametrize("method", METHODS)
def test_four_teeth_in_a_slot_leave_nothing_to_average(benchmark, method, axes):
    """W is constant there, so the zero-order solution is exact and all three have to agree."""
    cut, tip = benchmark(teeth=4, axes=axes, speeds=(2500.0, 12500.0))
    speeds = SPEEDS / 2
    exact = stability_lobes(tip, cut, speeds=speeds)
    found = stability_lobes(tip, cut, method=method, speeds=speeds)
    # Brackets of 1e-3; semi-discretisation with some 130 intervals at the slow end is within 1 %.
    np.testing.assert_allclose(found.depth, exact.depth, rtol=1e-2 if "semi" in method else 1.1e-3)
    near = np.abs(found.chatter_frequency - exact.chatter_frequency)
    assert np.all(near < (8 if "semi" in method else 0.5))


def test_one_direction_without_interruption_against_tlusty(benchmark):
    cut, tip = benchmark(teeth=4, speeds=(2500.0, 12500.0))
    speeds = SPEEDS / 2
    force = -average(cut)[0, 0] / 4  # per tooth, as if each of four edges cut all the time
    line = np.linspace(922.01, 3000, 400001)
    closed = single_direction(line, tip.receptance(line)[:, 0, 0], 4 * force, teeth=4, lobes=12)
    expected = [
        min(read_off(speed, closed.width, one).min(initial=np.inf) for speed in closed.speed)
        for one in speeds
    ]
    found = stability_lobes(tip, cut, speeds=speeds)
    np.testing.assert_allclose(found.depth, expected, rtol=1e-5)  # the grid of the closed form


@pytest.mark.parametrize(
    ("depth", "reference"), [(2e-4, 0.8192), (5e-4, 1.0726), (7e-4, 1.2196), (1e-3, 1.4039)]
)
def test_multipliers_against_print(benchmark, depth, reference):
    """Ding et al. (2010), slot at 5000 rev/min: the reference values of their convergence study.

    With 200 intervals ours agree to three digits; with 800 they have moved by 0.2 %.
    """
    cut, tip = benchmark()
    found = abs(multipliers(tip, cut, 5000.0, depth, intervals=200)[0])
    assert found == pytest.approx(reference, abs=5e-4)


def test_semi_discretisation_converges_with_the_square_of_the_interval(benchmark):
    cut, tip = benchmark()
    exact = abs(multipliers(tip, cut, 5000.0, 1e-3, intervals=880)[0])
    errors = [abs(abs(multipliers(tip, cut, 5000.0, 1e-3, intervals=n)[0]) - exact) for n in (55, 110, 220)]
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    # Against 880 intervals, themselves in error by 1/16 of the last: 2 becomes up to 2.1.
    assert np.all((order > 1.8) & (order < 2.3))


INTERRUPTED = {
    "slot, one mode": ({}, 2e-3),
    "half immersion, up": ({"immersion": 0.5, "milling": "up", "axes": "xy"}, 2e-3),
    "a twentieth, down": ({"immersion": 0.05, "axes": "xy"}, 1e-2),
    "a twentieth, helix": ({"immersion": 0.05, "axes": "xy", "helix": 0.5}, 1e-2),
}


@pytest.mark.some(2)
@pytest.mark.parametrize("name", INTERRUPTED)
def test_two_routes_to_the_interrupted_cut(benchmark, name):
    """Semi-discretisation in time and Nyquist's criterion with harmonics: nothing in common but the model."""
    settings, tolerance = INTERRUPTED[name]
    cut, tip = benchmark(**settings)
    speeds = rpm(9000, 15000, 19000, 21000)
    in_time = stability_lobes(tip, cut, method="semi-discretisation", speeds=speeds)
    by_harmonics = stability_lobes(tip, cut, method="multi-frequency", speeds=speeds)
    # Sixteen intervals for a cycle leave some parts in a thousand, the brackets one; low immersion has the
    # slowest harmonics.
    np.testing.assert_allclose(by_harmonics.depth, in_time.depth, rtol=4e-3 + tolerance)
    np.testing.assert_array_equal(by_harmonics.flip, in_time.flip)
    np.testing.assert_allclose(by_harmonics.chatter_frequency, in_time.chatter_frequency, rtol=3e-3)


@pytest.mark.slow
def test_a_face_mill_that_bends_along_its_axis():
    """Approach 45°: the axial deflection changes the chip, three axes take part; time against harmonics."""
    modes = (
        ToolMode("x", 600.0, 0.03, 8e6), ToolMode("y", 660.0, 0.03, 9e6), ToolMode("z", 350.0, 0.04, 1.5e6)
    )  # fmt: skip
    cut = Cut(
        Cutter(5, 0.08, approach=np.pi / 4),
        CuttingForce(1.5e9, 0.4, 0.1),
        Engagement(0.6, 2.3, (500.0, 6000.0)),
        CutFrame("tool", "+z", "+x"),
        modes,
    )
    tip = modal_tip(modes)
    speeds = rpm(1500, 2600, 4500)
    found = {method: stability_lobes(tip, cut, method=method, speeds=speeds) for method in METHODS}
    np.testing.assert_allclose(found["multi-frequency"].depth, found["semi-discretisation"].depth, rtol=5e-3)
    # 1.35 teeth in the cut on average: hardly interrupted.
    np.testing.assert_allclose(found["zero-order"].depth, found["multi-frequency"].depth, rtol=0.08)
    flat = stability_lobes(tip, replace(cut, cutter=Cutter(5, 0.08)), speeds=speeds)
    assert np.max(np.abs(flat.depth / found["zero-order"].depth - 1)) > 0.2  # the axis does matter


def test_period_doubling_that_the_mean_cannot_know(benchmark):
    """Flip lobes of low immersion lie at half the tooth-passing frequency, far below the zero-order limit."""
    cut, tip = benchmark(immersion=0.05, axes="xy")
    speeds = rpm(19000)
    mean = stability_lobes(tip, cut, speeds=speeds)
    whole = stability_lobes(tip, cut, method="multi-frequency", speeds=speeds)
    assert whole.flip.tolist() == [True]
    assert whole.depth[0] < mean.depth[0] / 2
    passing = 2 * 19000 / 60
    assert (whole.chatter_frequency[0] / passing) % 1 == pytest.approx(0.5, abs=1e-6)


def test_the_three_on_a_robot(fanuc, across):
    modes = (ToolMode("x", 780.0, 0.03, 9e6), ToolMode("y", 850.0, 0.03, 1e7))
    cut = across(modes=modes)
    tip = tool_tip(fanuc.at("configuration_1"), cut)
    speeds = rpm(5000, 9000, 14500, 18000)
    found = {method: stability_lobes(tip, cut, method=method, speeds=speeds) for method in METHODS}
    np.testing.assert_allclose(
        found["multi-frequency"].depth, found["semi-discretisation"].depth, rtol=6e-3
    )  # forty-odd intervals
    # Half immersion: the mean is off by a tenth or so, no more.
    np.testing.assert_allclose(found["zero-order"].depth, found["multi-frequency"].depth, rtol=0.2)
    assert found["zero-order"].chatter_frequency[0] < 100 < found["zero-order"].chatter_frequency[-1]


@pytest.mark.slow
def test_peaks_and_dips_are_sharpened(benchmark):
    cut, tip = benchmark()
    found = stability_lobes(tip, cut)
    dense = stability_lobes(tip, cut, speeds=np.linspace(5000, 25000, 10001))
    assert found.critical_depth == pytest.approx(dense.critical_depth, rel=1e-5)
    inner = [(speed, depth) for speed, depth in found.best() if 5001 < speed < 24999]
    for speed, depth in inner:
        near = np.abs(dense.speed - speed) < 30
        assert depth == pytest.approx(dense.depth[near].max(), rel=0.01)
    assert [depth for _, depth in found.best()] == sorted((depth for _, depth in found.best()), reverse=True)
    assert found.at(12345.0) == found.depth[np.argmin(np.abs(found.speed - 12345.0))]


def test_below_the_limit_stable_above_it_not(benchmark):
    """The zero-order limit of a cut that is hardly interrupted, judged by multipliers."""
    cut, tip = benchmark(teeth=4, axes="xy", speeds=(2500.0, 12500.0))
    found = stability_lobes(tip, cut, speeds=rpm(3100, 5200, 9000))
    for speed, depth in zip(found.speed, found.depth, strict=True):
        assert abs(multipliers(tip, cut, float(speed), 0.97 * float(depth), intervals=200)[0]) < 1
        assert abs(multipliers(tip, cut, float(speed), 1.03 * float(depth), intervals=200)[0]) > 1


def test_a_mode_without_damping_is_no_cut(benchmark):
    cut, tip = benchmark()
    system = tip.system
    bare = SecondOrderSystem(system.mass, 0 * system.damping, system.stiffness, system.coordinates)
    with pytest.raises(SingularResponse, match="922 Hz has no damping"):
        stability_lobes(ModelTip(bare, tip.rows), cut)


def test_where_nothing_chatters(benchmark):
    """Flexible along the axis alone: the chip never changes, no method finds a limit."""
    cut, tip = benchmark(axes="z")
    for method in METHODS:
        found = stability_lobes(tip, cut, method=method, speeds=rpm(9000, 15000))
        assert np.all(np.isinf(found.depth))
        assert np.all(np.isnan(found.chatter_frequency))
        assert found.lobe.tolist() == [-1, -1]
    assert unconditional_depth(tip, cut)[0] == np.inf


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "guess"}, ["'guess'", "zero-order, multi-frequency"]),
        ({"speeds": 1}, ["speeds", "2 to 100,000"]),
        ({"speeds": True}, ["speeds"]),
        ({"speeds": np.array([3.0, 2.0])}, ["ascending"]),
        ({"speeds": np.array([np.nan])}, ["ascending"]),
        ({"speeds": np.array([-1.0, 2.0])}, ["above 0"]),
    ],
)
def test_bad_requests(benchmark, untyped, options, words):
    cut, tip = benchmark()
    with pytest.raises(InvalidRequest) as caught:
        stability_lobes(tip, cut, **options)
    for word in words:
        assert word in str(caught.value)


def test_too_slow_for_the_methods_that_count(benchmark):
    cut, tip = benchmark()
    with pytest.raises(InvalidRequest, match="intervals"):
        stability_lobes(tip, cut, method="semi-discretisation", speeds=rpm(100, 200))
    with pytest.raises(InvalidRequest, match="harmonics would be needed"):
        stability_lobes(tip, cut, method="multi-frequency", speeds=rpm(100, 200))

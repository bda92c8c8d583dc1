"""The simulated cut against Floquet multipliers, and what the limit means for it."""

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest
from flexmodal.machining import (
    MeasuredTip,
    ModelTip,
    multipliers,
    simulate,
    stability_lobes,
    tool_tip,
)

from .conftest import rpm

KICK = (1e-3, 7e-4, 0.0)
CASES = {
    "slot, unstable": ({}, 5000.0, 1e-3),
    "slot, stable": ({}, 5000.0, 4e-4),
    "half, up": ({"immersion": 0.5, "milling": "up", "axes": "xy"}, 9000.0, 1e-3),
    "a twentieth, period doubling": ({"immersion": 0.05, "axes": "xy", "helix": 0.5}, 19000.0, 1.3e-3),
}


@pytest.mark.some(2)
@pytest.mark.parametrize("name", CASES)
def test_growth_is_the_largest_multiplier(benchmark, name):
    settings, speed, depth = CASES[name]
    cut, tip = benchmark(**settings)
    found = simulate(tip, cut, speed, depth, periods=140, steps=200, kick=KICK, linear=True)
    expected = abs(multipliers(tip, cut, speed, depth, intervals=300)[0])
    # Both are of second order in their steps.
    assert found.growth(60) == pytest.approx(expected, abs=3e-3)


@pytest.mark.slow
def test_the_limit_divides_the_simulated_cuts(benchmark):
    """3 % below the depth of the lobes a kick dies away, 3 % above it grows: bisected in time, so to say."""
    cut, tip = benchmark(immersion=0.5, milling="up", axes="xy")
    limits = stability_lobes(tip, cut, method="multi-frequency", speeds=rpm(9000, 15000))
    for speed, depth in zip(limits.speed, limits.depth, strict=True):
        for part, grows in ((0.97, False), (1.03, True)):
            done = simulate(
                tip, cut, float(speed), part * float(depth), periods=160, steps=70, kick=KICK, linear=True
            )
            assert (done.growth(60) > 1) == grows


@pytest.mark.slow
def test_a_robot_in_time(fanuc, across):
    """The arm alone, at a speed where its 57 Hz mode chatters."""
    cut = across()
    tip = tool_tip(fanuc.at("configuration_4"), cut)
    limit = float(stability_lobes(tip, cut, method="multi-frequency", speeds=rpm(4000)).depth[0])
    kick = (1.0, 1.0, 0.0)
    # Six hundred periods of 7.5 ms: slow modes need their time to die away.
    for part, grows in ((0.93, False), (1.07, True)):
        done = simulate(tip, cut, 4000.0, part * limit, periods=600, steps=40, kick=kick, linear=True)
        assert (done.growth(200) > 1) == grows


@pytest.mark.slow
def test_chatter_is_bounded_because_teeth_leave_the_cut(benchmark):
    cut, tip = benchmark(feed_per_tooth=1e-4, depth=1e-3)
    bounded = simulate(tip, cut, 5000.0, 1e-3, periods=200, steps=120)
    free = simulate(tip, cut, 5000.0, 1e-3, periods=200, steps=120, linear=True, kick=KICK)
    late = np.abs(bounded.displacement[-2400:, 0])
    early = np.abs(bounded.displacement[-9600:-7200, 0])
    assert late.max() == pytest.approx(early.max(), rel=0.2)
    assert 1e-5 < late.max() < 1e-3  # of the order of the feed
    assert np.abs(free.displacement).max() > 1e3  # the linear theory knows no end
    assert np.all(bounded.force[np.linalg.norm(bounded.force, axis=1) > 0] != 0)
    assert np.any(np.all(bounded.force == 0, axis=1))  # in the air


@pytest.mark.slow
def test_a_stable_cut_settles(benchmark):
    cut, tip = benchmark(feed_per_tooth=1e-4, depth=1e-4)
    done = simulate(tip, cut, 5000.0, 1e-4, periods=250, steps=120)
    last, before = done.displacement[-120:], done.displacement[-240:-120]
    np.testing.assert_allclose(last, before, atol=1e-6 * np.abs(last).max())


def test_second_order_in_the_step(benchmark):
    cut, tip = benchmark(immersion=0.5, milling="up", axes="xy", feed_per_tooth=1e-4, depth=1e-4)
    ends = [
        simulate(tip, cut, 9000.0, 1e-4, periods=6, steps=n).displacement[-n] for n in (50, 100, 200, 800)
    ]
    errors = np.array([np.linalg.norm(end - ends[-1]) for end in ends[:-1]])
    # The steps at 45° of helix-less entry fall between the grid's: the order is two on the whole.
    assert errors[2] < errors[0] / 8


def test_measured_tips_are_not_simulated(benchmark):
    cut, tip = benchmark()
    table = MeasuredTip(np.array([1.0, 2.0]), np.zeros((2, 3, 3), dtype=complex))
    with pytest.raises(InvalidRequest, match="measured receptance"):
        simulate(ModelTip(tip.system, tip.rows, table), cut, 9000.0, 1e-4)
    with pytest.raises(InvalidRequest, match="use multi-frequency"):
        multipliers(ModelTip(tip.system, tip.rows, table), cut, 9000.0, 1e-4)

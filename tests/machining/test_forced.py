"""Forced vibration: against the simulated cut, and against what a stiff or a slow cut must do."""

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest
from flexmodal.machining import ModelTip, forced_sweep, forced_vibration, modal_tip, simulate
from flexmodal.machining.cut import Cut, ToolMode
from flexmodal.machining.stability.directional import static_force_harmonics

from .conftest import rpm

FED = {"feed_per_tooth": 1e-4, "depth": 1e-4}
EDGE = {"edge": {"tangential_edge": 1e4, "radial_edge": 5e3, "axial_edge": 2e3}}
CUTS = {
    "up": {"immersion": 0.3, "milling": "up"},
    "down, helix": {"immersion": 0.3, "helix": 0.6},
    "down, axial": {"immersion": 0.5, "axial_ratio": 0.2},
}


@pytest.mark.parametrize("name", CUTS)
@pytest.mark.slow
def test_against_the_simulated_cut(benchmark, name):
    """The last tooth period of a stable cut, teeth and chips one by one."""
    cut, tip = benchmark(axes="xyz" if "axial" in name else "xy", **CUTS[name], **FED, **EDGE)
    found = forced_vibration(tip, cut, 12000.0)
    history = simulate(tip, cut, 12000.0, 1e-4, periods=130, steps=240)
    last = history.displacement[-240:]
    angle = np.pi * np.arange(240) / 240
    # The simulation's jumps are spread over a step of 1/240; 60 harmonics carry the rest.
    np.testing.assert_allclose(found.at(angle), last, atol=3e-3 * np.abs(last).max())
    np.testing.assert_allclose(found.static, last.mean(axis=0), atol=1e-3 * np.abs(last).max())
    departure = np.abs(last - last.mean(axis=0)).max(axis=0)
    np.testing.assert_allclose(found.peak, departure, atol=4e-3 * np.abs(last).max())


def stiff(cut, frequency=50_000.0):
    """A tip so quick that it follows the force at once."""
    modes = tuple(ToolMode(axis, frequency, 0.7, 1e7) for axis in "xy")
    return modal_tip(modes)


def test_a_tip_that_follows_at_once(benchmark):
    """Displacement is force over stiffness at every instant; the wall sees the force of that moment."""
    cut, _ = benchmark(immersion=0.5, milling="down", teeth=4, **FED, **EDGE)
    found = forced_vibration(stiff(cut), cut, 60.0)
    angle = np.linspace(0.1, 1.4, 11)  # one tooth in the cut from 90° to 180°, at angle + 90°
    tooth = angle + np.pi / 2
    chip = 1e-4 * np.sin(tooth)
    kt, kr, _ = cut.force.specific
    tangential, radial = 1e-4 * (kt * chip + 1e4), 1e-4 * (kr * chip + 5e3)
    expected = np.stack(
        [
            -tangential * np.cos(tooth) - radial * np.sin(tooth),
            tangential * np.sin(tooth) - radial * np.cos(tooth),
        ],
        axis=1,
    )
    # 60 harmonics of a force that jumps at entry: Gibbs keeps some per cent near it, little away from it.
    np.testing.assert_allclose(
        found.at(angle)[:, :2], expected / 1e7, atol=0.02 * np.abs(expected).max() / 1e7
    )


@pytest.mark.parametrize(("milling", "sign"), [("up", 1), ("down", -1)])
def test_up_milling_cuts_too_much_and_down_milling_too_little(benchmark, milling, sign):
    """What every shop knows of a soft tool, here with eight teeth so that the mean force rules."""
    cut, _ = benchmark(immersion=0.2, milling=milling, teeth=8, helix=0.5, **FED)
    found = forced_vibration(stiff(cut), cut, 60.0)
    assert np.sign(found.surface_error) == sign
    assert (found.entry_wall is None) == (milling == "down")
    assert (found.exit_wall is None) == (milling == "up")
    wall = found.entry_wall if milling == "up" else found.exit_wall
    assert wall.shape == (21,)
    assert np.abs(found.surface_error) == np.abs(wall).max()
    without = wall - sign * found.static[1] if milling == "up" else wall + found.static[1]
    assert np.abs(found.dynamic_error) == pytest.approx(np.abs(without).max(), rel=1e-12)


def test_the_helix_reads_the_wall_later(benchmark):
    """At height z the wall is left when the tip has turned on by the lag."""
    cut, tip = benchmark(immersion=0.3, milling="down", helix=0.6, **FED)
    found = forced_vibration(tip, cut, 12000.0)
    lag = 2 * found.height * np.tan(0.6) / 0.01
    np.testing.assert_allclose(found.exit_wall, -found.at(np.pi + lag)[:, 1])


def test_a_slot_leaves_two_walls_and_a_middle_cut_none(benchmark):
    cut, tip = benchmark(**FED)
    found = forced_vibration(tip, cut, 12000.0)
    assert found.entry_wall is not None
    assert found.exit_wall is not None
    inner = Cut(cut.cutter, cut.force, type(cut.engagement)(0.5, 2.5, (1e3, 2e3), 1e-4, 1e-4), cut.frame)
    assert forced_vibration(tip, inner, 12000.0).surface_error is None
    sweep = forced_sweep(tip, inner, rpm(8000, 12000))
    assert np.all(np.isnan(sweep.surface_error))


def test_resonance_at_a_harmonic(benchmark):
    """Two teeth at 922 Hz · 60 / 2 / k rev/min shake the tool at its k-th harmonic."""
    cut, tip = benchmark(immersion=0.2, axes="xy", speeds=(6000.0, 30000.0), **FED)
    speed = np.linspace(6000, 30000, 601)
    sweep = forced_sweep(tip, cut, speed)
    peaks = speed[1:-1][
        (sweep.peak[1:-1, 1] > sweep.peak[:-2, 1]) & (sweep.peak[1:-1, 1] > sweep.peak[2:, 1])
    ]
    for order in (1, 2, 3, 4):
        assert np.min(np.abs(peaks - 922 * 30 / order)) < 80
    one = forced_vibration(tip, cut, 12000.0)
    place = int(np.argmin(np.abs(speed - 12000)))
    np.testing.assert_allclose(sweep.peak[place], one.peak)
    assert sweep.surface_error[place] == one.surface_error


def test_twice_the_depth_twice_the_force(benchmark):
    cut, tip = benchmark(immersion=0.3, **FED)
    small, large = (forced_vibration(tip, cut, 12000.0, depth) for depth in (1e-4, 2e-4))
    np.testing.assert_allclose(large.displacement, 2 * small.displacement)
    orders = np.arange(len(small.frequency))
    np.testing.assert_allclose(small.force, static_force_harmonics(cut, orders, 1e-4))
    assert small.frequency[1] == pytest.approx(400)
    assert isinstance(tip, ModelTip)


def test_a_cut_that_does_not_say_its_feed(benchmark):
    cut, tip = benchmark()
    with pytest.raises(InvalidRequest, match="feed_per_tooth"):
        forced_vibration(tip, cut, 12000.0)

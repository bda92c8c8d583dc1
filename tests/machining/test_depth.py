"""Postures by depth of cut, and when posture does not help."""

import numpy as np
import pytest

from flexmodal.errors import InvalidPosture, InvalidRequest
from flexmodal.machining import (
    Cut,
    CutFrame,
    Cutter,
    CuttingForce,
    Engagement,
    ToolMode,
    average,
    compare_family,
    compare_postures,
    critical_depth,
    limiting_depth,
    modal_tip,
    multipliers,
    stability_lobes,
    tool_tip,
    unconditional_depth,
)

from .conftest import rpm

FAMILY = "second_link_horizontal"


def test_a_list_of_postures(fanuc, across):
    cut = across(speeds=(2000.0, 9000.0))
    names = ["configuration_1", "configuration_4", "configuration_7"]
    found = compare_postures(fanuc, names, cut)
    depths = [one.critical_depth for one in found.postures]
    assert depths == pytest.approx([critical_depth(fanuc, name, cut) for name in names])
    assert found.best == int(np.argmax(depths))
    assert found.gain == pytest.approx(max(depths) / min(depths))
    for one, name in zip(found.postures, names, strict=True):
        tip = tool_tip(fanuc.at(name), cut)
        assert one.unconditional == unconditional_depth(tip, cut)
        assert one.unconditional[0] <= one.critical_depth
        assert one.posture.name == name


def test_one_speed(fanuc, across):
    cut = across(speeds=(2000.0, 9000.0))
    tip = tool_tip(fanuc.at("configuration_1"), cut)
    found = critical_depth(fanuc, "configuration_1", cut, spindle_speed=4321.0)
    assert found == stability_lobes(tip, cut, speeds=rpm(4321)).depth[0]
    assert found >= critical_depth(fanuc, "configuration_1", cut) * (1 - 1e-9)


def test_a_family(fanuc, across):
    cut = across(speeds=(2000.0, 9000.0))
    seen = []
    found = compare_family(fanuc, FAMILY, cut, members=5, advance=lambda: seen.append(1))
    assert len(seen) == 5
    card = fanuc.families[FAMILY]
    parameters = [one.parameter for one in found.postures]
    np.testing.assert_allclose(parameters, np.linspace(card.start, card.stop, 5))
    for one in found.postures:
        assert one.posture.values["q2"] == pytest.approx(-one.posture.values["q1"])
    third = critical_depth(fanuc, {"q1": parameters[2], "q2": -parameters[2]}, cut)
    assert found.postures[2].critical_depth == pytest.approx(third)


def test_a_quick_cut_over_a_quick_spindle(fanuc, across):
    """A softer spindle and a high speed: the spindle alone sets the limit, and posture gains nothing.

    At a slow speed the same postures differ.
    """
    spindle = (ToolMode("x", 780.0, 0.03, 1e6), ToolMode("y", 850.0, 0.03, 1.1e6))
    names = ["configuration_1", "configuration_4", "configuration_7"]
    slow, fast = across(modes=spindle, speeds=(3000.0, 4500.0)), across(modes=spindle, speeds=(1.4e4, 2e4))
    slow_gain = compare_postures(fanuc, names, slow).gain
    fast_gain = compare_postures(fanuc, names, fast).gain
    assert slow_gain > 1.2
    assert fast_gain < 1.03
    one = compare_postures(fanuc, names[:1], fast).postures[0]
    assert one.lobes.chatter_frequency[np.argmin(one.lobes.depth)] > 700


def test_fast_teeth_on_a_slow_mode_that_they_feed():
    """With ωT small the force is a T W₀ ṙ, a damper: negative along a mode with W > 0, which it feeds.

    The limit is then c / (T W), in proportion to the speed: one reason why the arm ceases to matter.
    """
    entry = np.radians(110.0)
    cut = Cut(
        Cutter(2, 0.016),
        CuttingForce(7e8),
        Engagement(entry, np.pi, (1e3, 1e5)),
        CutFrame("tool", "+z", "+x"),
    )
    tip = modal_tip((ToolMode("x", 50.0, 0.03, 2e6),))
    push = average(cut)[0, 0]
    assert push > 0
    damping = tip.system.damping[0, 0]
    speed = rpm(5e4, 1e5, 2e5)
    found = stability_lobes(tip, cut, speeds=speed)
    # ωT is 0.19, 0.09, 0.05: the next term of the series is a third of its square or less.
    np.testing.assert_allclose(found.depth, damping * speed * 2 / 60 / push, rtol=0.02)
    assert np.all(np.abs(found.chatter_frequency - 50) < 2)


@pytest.mark.parametrize("posture", ["configuration_1", "configuration_4", "configuration_7"])
def test_fast_teeth_damp_this_arm(fanuc, across, posture):
    """At 100000 rev/min no depth makes the arm chatter: the damper a T W₀ takes energy out of every mode."""
    cut = across(speeds=(5e4, 1e5))
    tip = tool_tip(fanuc.at(posture), cut)
    for method in ("zero-order", "multi-frequency"):
        found = stability_lobes(tip, cut, method=method, speeds=rpm(1e5))
        assert found.depth[0] == np.inf
    for depth in (1e-3, 1e-2):
        assert abs(multipliers(tip, cut, 1e5, depth)[0]) < 1


def test_the_plain_function_that_a_search_calls(fanuc, across):
    """Φ by the FRF of the robot, W₀ of the cut, no tip: the same limit."""
    cut = across()
    lines = np.geomspace(2, 300, 4000)
    value = fanuc.frf("configuration_1", lines, response=["tool:+x", "tool:-z", "tool:+y"]).value
    dense = limiting_depth(value, average(cut)).min()
    tip = tool_tip(fanuc.at("configuration_1"), cut)
    assert unconditional_depth(tip, cut)[0] == pytest.approx(dense, rel=1e-3)


def test_bad_requests(fanuc, across):
    cut = across()
    with pytest.raises(InvalidRequest, match="at least one"):
        compare_postures(fanuc, [], cut)
    with pytest.raises(InvalidRequest, match="members"):
        compare_family(fanuc, FAMILY, cut, members=1)
    with pytest.raises(InvalidRequest, match="sideways"):
        compare_family(fanuc, "sideways", cut)
    with pytest.raises(InvalidPosture):
        compare_postures(fanuc, ["configuration_1", {"q1": 99.0}], cut)
    with pytest.raises(InvalidRequest, match="above 0"):
        critical_depth(fanuc, "configuration_1", cut, spindle_speed=-1.0)

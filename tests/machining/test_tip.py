"""The receptance of the tip in the frame of the cut, from robots, tools and tables."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from flexmodal.cards import FrozenDict
from flexmodal.errors import FlexmodalError, InvalidCut, InvalidFrequencies, InvalidPoint
from flexmodal.frf import Frf, PointDirection
from flexmodal.frf.export import COLUMNS, write_csv
from flexmodal.machining import MeasuredTip, ToolMode, modal_tip, read_measured_tip, stability_lobes, tool_tip

from .conftest import STIFFNESS, rpm

LINES = np.array([0.0, 3.0, 17.0, 55.0])
ELBOW = {"shoulder_lift_joint": -1.1, "elbow_joint": 1.3, "wrist_1_joint": -0.5, "wrist_2_joint": 0.7}


def test_world_axes_are_those_of_the_frf(fanuc, across):
    """Axis +y and feed +x: the frame is x, −z, y of the world."""
    posed = fanuc.at("configuration_2")
    tip = tool_tip(posed, across())
    found = posed.frf(LINES, response=["tool:+x", "tool:-z", "tool:+y"]).value
    np.testing.assert_allclose(tip.receptance(LINES), found, rtol=1e-12, atol=1e-25)


def test_a_frame_that_turns_with_the_tool(ur10, across):
    """Its receptance is that of the world, turned; its trace is nobody's frame."""
    posed = ur10.at(ELBOW)
    with_world = tool_tip(posed, across(axis="+z", feed="+x"))
    with_tool = tool_tip(posed, across(relative_to="tool", axis="+z", feed="+x"))
    from flexmodal.model.placements import link_placements

    turn = link_placements(ur10, posed.posture.values)[ur10.tool][:3, :3]
    assert np.abs(turn - np.eye(3)).max() > 0.1
    expected = turn.T @ with_world.receptance(LINES) @ turn
    np.testing.assert_allclose(with_tool.receptance(LINES), expected, rtol=1e-9, atol=1e-20)


def test_a_tool_that_sticks_out(ur10, across):
    """A point further along the axis moves by what its link turns: u + θ × offset, forces alike."""
    posed = ur10.at(ELBOW)
    offset = (0.02, -0.05, 0.17)
    tip = tool_tip(posed, across(axis="+z", feed="+x", offset=offset))
    names = [f"{ur10.tool}:+{axis}" for axis in ("x", "y", "z", "rx", "ry", "rz")]
    six = posed.frf(LINES, response=names).value
    from flexmodal.model.placements import link_placements

    lever = link_placements(ur10, posed.posture.values)[ur10.tool][:3, :3] @ np.array(offset)
    x, y, z = lever
    arm = np.hstack([np.eye(3), -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])])
    np.testing.assert_allclose(tip.receptance(LINES), arm @ six @ arm.T, rtol=1e-9, atol=1e-20)


def test_points_and_links(fanuc, across):
    posed = fanuc.at("configuration_2")
    tip = tool_tip(posed, across(point="location_1"))
    np.testing.assert_allclose(tip.rows[0], posed.jacobian("location_1")[0])
    with pytest.raises(InvalidPoint) as caught:
        tool_tip(posed, across(point="location_9"))
    assert "cut: frame.point" in str(caught.value)
    assert "location_1" in str(caught.value)


def test_modes_of_the_tool_add_their_receptance(fanuc, across):
    posed = fanuc.at("configuration_2")
    modes = (
        ToolMode("x", 700.0, 0.03, 9e6),
        ToolMode("y", 800.0, 0.02, 8e6),
        ToolMode("x", 1500.0, 0.02, 3e7),
    )
    both = tool_tip(posed, across(modes=modes))
    frequency = np.array([0.0, 9.0, 690.0, 1500.0])
    alone = sum(
        np.outer(np.eye(3)["xyz".index(m.direction)], np.eye(3)["xyz".index(m.direction)])
        / (m.stiffness * (1 - r**2 + 2j * m.damping_ratio * r))[:, None, None]
        for m in modes
        for r in [frequency / m.frequency]
    )
    expected = tool_tip(posed, across()).receptance(frequency) + alone
    np.testing.assert_allclose(both.receptance(frequency), expected, rtol=1e-9, atol=1e-20)
    np.testing.assert_allclose(modal_tip(modes).receptance(frequency), alone, rtol=1e-9, atol=1e-20)
    assert both.system.dof == fanuc.at("configuration_2").system.dof + 3


@pytest.mark.parametrize("frequency", [None, 20.0])
def test_loss_factors_of_the_arm_reach_the_lobes(fanuc, across, frequency):
    """Z on paper, entry by entry, with and without modes of the tool; lobes as from a table of FRFs."""
    joints = {name: replace(joint, loss_factor=0.2) for name, joint in fanuc.joints.items()}
    posed = replace(fanuc, joints=FrozenDict(joints), loss_frequency=frequency).at("configuration_2")
    plain = fanuc.at("configuration_2")
    mode = ToolMode("x", 700.0, 0.03, 9e6)
    for cut in (across(), across(modes=(mode,))):
        tip, without = tool_tip(posed, cut), tool_tip(plain, cut)
        stiffness = np.diag(plain.system.stiffness)
        for line, found in zip(LINES, tip.receptance(LINES), strict=True):
            omega, beta = 2 * np.pi * line, 2 / np.pi * np.arctan(0.2)
            grown = 1 + 0.2j
            if frequency is not None:
                grown = (1j * max(line / frequency, 1e-3)) ** beta / np.cos(np.pi / 2 * beta)
            z = (
                without.system.stiffness
                - omega**2 * without.system.mass
                + 1j * omega * without.system.damping
            )
            for place, spring in enumerate(stiffness):
                z[place, place] += spring * (grown - 1)
            expected = without.rows @ np.linalg.solve(z, without.rows.T)
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-20)
    speeds, lines = rpm(1000, 2000), np.arange(0.1, 400.0, 0.1)
    table = MeasuredTip(lines, posed.frf(lines, response=["tool:+x", "tool:-z", "tool:+y"]).value)
    depth = stability_lobes(tool_tip(posed, across()), across(), speeds=speeds).depth
    np.testing.assert_allclose(stability_lobes(table, across(), speeds=speeds).depth, depth, rtol=3e-3)
    other = stability_lobes(tool_tip(plain, across()), across(), speeds=speeds).depth
    assert np.max(np.abs(np.log(depth / other))) > 0.02


def test_a_posture_that_nothing_moves(fanuc, across):
    with pytest.raises(FlexmodalError, match="rigid"):
        modal_tip(())
    tip = tool_tip(fanuc.at("configuration_2"), across())
    still = type(tip)(tip.system, np.zeros_like(tip.rows))
    with pytest.raises(FlexmodalError, match="nothing to chatter"):
        stability_lobes(still, across(), speeds=rpm(1000, 2000))


def table_of(tip, frequency, form="receptance"):
    axes = tuple(PointDirection("tip", axis) for axis in "xyz")
    return Frf(frequency, tip.receptance(frequency), axes, axes).to(form)


@pytest.mark.parametrize(
    "form",
    ["receptance", *(pytest.param(form, marks=pytest.mark.slow) for form in ("mobility", "inertance"))],
)
@pytest.mark.slow
def test_a_table_gives_the_lobes_of_its_model(benchmark, tmp_path, form):
    """Written as flexmodal frf writes it, read back as a measured spindle, in any form."""
    cut, tip = benchmark(axes="xy", immersion=0.5)
    path = tmp_path / "spindle.csv"
    frequency = np.arange(20, 4000.5, 0.5)
    write_csv(table_of(tip, frequency, form), path)
    measured = read_measured_tip(path)
    np.testing.assert_allclose(
        measured.receptance(frequency), tip.receptance(frequency), rtol=1e-9, atol=1e-22
    )
    speeds = rpm(9000, 15000)
    for method in ("zero-order", "multi-frequency"):
        expected = stability_lobes(tip, cut, method=method, speeds=speeds)
        found = stability_lobes(measured, cut, method=method, speeds=speeds)
        # Straight lines 0.5 Hz long across a resonance 20 Hz wide; the harmonics end at 4000 Hz.
        np.testing.assert_allclose(found.depth, expected.depth, rtol=3e-3)
        np.testing.assert_allclose(found.chatter_frequency, expected.chatter_frequency, rtol=1e-3)


def test_a_table_added_to_a_robot(fanuc, across, benchmark):
    posed = fanuc.at("configuration_2")
    modes = (ToolMode("x", 922.0, 0.03, STIFFNESS), ToolMode("y", 922.0, 0.03, STIFFNESS))
    frequency = np.arange(1, 3000.0, 1.0)
    table = MeasuredTip(frequency, modal_tip(modes).receptance(frequency))
    expected = tool_tip(posed, across(modes=modes))
    found = tool_tip(posed, across(), table)
    lines = np.array([0.0, 0.5, 8.0, 922.0, 2500.0])
    # Below the first line the table is a spring: 1e-3 of the way to its resonance.
    np.testing.assert_allclose(found.receptance(lines), expected.receptance(lines), rtol=1e-4, atol=1e-12)
    assert found.highest == 2999.0
    speeds = rpm(2000, 9000)
    wanted = stability_lobes(expected, across(), speeds=speeds)
    np.testing.assert_allclose(stability_lobes(found, across(), speeds=speeds).depth, wanted.depth, rtol=1e-3)


def test_what_a_table_does_not_know(benchmark):
    _, tip = benchmark(axes="xyz")
    frequency = np.arange(20, 2000.0, 1.0)
    table = MeasuredTip(frequency, tip.receptance(frequency))
    with pytest.raises(InvalidFrequencies, match="at most 1999 Hz"):
        table.receptance(np.array([2500.0]))
    assert table.receptance(np.array([0.0])).imag.max() == 0
    late = MeasuredTip(frequency[900:], tip.receptance(frequency[900:]))  # from 920 Hz: in the resonance
    with pytest.raises(InvalidFrequencies, match="no mere spring"):
        late.receptance(np.array([0.0]))


def write_rows(path, rows, header=COLUMNS):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    return path


GOOD = [[f, "tip:+y", "tip:+y", "receptance", "m/N", 1e-7, -1e-9] for f in (10.0, 20.0, 30.0)]


def test_signs_mirror_images_and_missing_pairs(tmp_path):
    rows = [*GOOD, *([f, "tip:-x", "tip:+y", "receptance", "m/N", 2e-8, 0.0] for f in (10.0, 20.0, 30.0))]
    found = read_measured_tip(write_rows(tmp_path / "t.csv", rows)).value
    np.testing.assert_allclose(found[:, 0, 1], -2e-8)
    np.testing.assert_allclose(found[:, 1, 0], -2e-8)
    assert np.all(found[:, 0, 0] == 0)


BAD = {
    "header": ([], ["line 1", "frequency_hz,response"]),
    "no lines": ([], ["no lines"]),
    "one line": (GOOD[:1], ["two frequencies or more"]),
    "not a number": ([*GOOD, ["x", *GOOD[0][1:]]], ["line 5", "two finite numbers"]),
    "nan": ([*GOOD, [40.0, *GOOD[0][1:5], "nan", 0]], ["line 5"]),
    "negative": ([*GOOD, [-40.0, *GOOD[0][1:]]], ["line 5"]),
    "rotation": ([*GOOD, [40.0, "tip:+rx", *GOOD[0][2:]]], ["line 5", "x, y or z"]),
    "short": ([*GOOD, [40.0, "tip:+y"]], ["line 5"]),
    "twice": ([*GOOD, GOOD[0]], ["line 5", "10 Hz again"]),
    "two forms": ([*GOOD, [40.0, "tip:+y", "tip:+y", "mobility", "", 1, 1]], ["mobility after receptance"]),
    "uneven": ([*GOOD, [10.0, "tip:+x", *GOOD[0][2:]]], ["x per y", "same frequencies"]),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_tables(tmp_path, kind):
    rows, words = BAD[kind]
    header = ("frequency", "value") if kind == "header" else COLUMNS
    path = write_rows(tmp_path / "t.csv", rows, header)
    with pytest.raises(InvalidCut) as caught:
        read_measured_tip(path)
    assert str(path) in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def test_tables_that_cannot_be_read(tmp_path):
    with pytest.raises(InvalidCut, match="no such file"):
        read_measured_tip(tmp_path / "nothing.csv")
    path = tmp_path / "t.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InvalidCut, match="UTF-8"):
        read_measured_tip(path)
    with pytest.raises(InvalidCut, match="two lines or more"):
        MeasuredTip(np.array([1.0]), np.zeros((1, 3, 3), dtype=complex))

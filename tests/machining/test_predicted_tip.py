"""A prediction as the tip of a cut: by the robot's own receptances, its lobes are the robot's."""

import json
from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidCut
from flexmodal.machining import lobes, lobes_of_tip, read_cut, read_predicted_tip, tool_tip
from flexmodal.model.placements import link_placements

POSTURE = {"q1": 1.0, "q2": -1.2, "q3": 0.2}
LINES = np.arange(1.0, 200.0, 0.5)


@pytest.fixture(scope="module")
def robot():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="module")
def cut():
    return read_cut("aluminium")


def predicted(robot, path, directions, *, turned=False, point="tool"):
    """What `flexmodal predict` would write if it were right, along the axes of the world or of the tool."""
    axes = link_placements(robot, POSTURE)[robot.tool][:3, :3] if turned else np.eye(3)
    whole = robot.frf(POSTURE, LINES, response=["tool:+x", "tool:+y", "tool:+z"],
                      reference=["tool:+x", "tool:+y", "tool:+z"]).value  # fmt: skip
    own = axes.T @ whole @ axes
    frfs = []
    for response, reference in directions:
        h = own[:, "xyz".index(response), "xyz".index(reference)]
        frfs.append({
            "response": f"{point}:+{response}", "reference": f"{point}:+{reference}", "re": h.real.tolist(),
            "im": h.imag.tolist(), "low": (np.abs(h) / 2).tolist(), "high": (np.abs(h) * 2).tolist(),
        })  # fmt: skip
    ways = {f"{point}:+{axis}": axes[:, k].tolist() for k, axis in enumerate("xyz")}
    content = {"posture": POSTURE, "frequency": LINES.tolist(), "frfs": frfs, "ways": ways}
    path.write_text(json.dumps(content))
    return path


EVERY = [("x", "x"), ("x", "z"), ("z", "x"), ("z", "z")]


@pytest.mark.parametrize(
    ("directions", "turned"), [(EVERY, False), (EVERY, True), (EVERY[:2] + EVERY[3:], False)]
)
def test_the_receptance_and_the_lobes_are_the_robots(robot, cut, tmp_path, directions, turned):
    """Along the world's axes and along the link's; a pair that is missing is its mirror image."""
    told = read_predicted_tip(predicted(robot, tmp_path / "p.json", directions, turned=turned), robot, cut)
    own = tool_tip(robot.at(POSTURE), cut).receptance(LINES)
    np.testing.assert_allclose(told.tip.value, own, atol=1e-9 * np.abs(own).max())
    assert told.rigid == 1
    found = lobes_of_tip(told.tip, told.posture, cut, forced=False)
    expected = lobes(robot, POSTURE, cut, forced=False)
    # linear between lines half a hertz apart
    assert found.critical_depth == pytest.approx(expected.critical_depth, rel=0.01)
    assert found.coupling.depth == pytest.approx(expected.coupling.depth, rel=0.01)


def test_the_band_is_twice_and_half(robot, cut, tmp_path):
    cut = replace(cut, modes=())  # those of the tool are not predicted
    told = read_predicted_tip(predicted(robot, tmp_path / "p.json", EVERY), robot, cut)
    depths = [lobes_of_tip(tip, told.posture, cut, forced=False).critical_depth
              for tip in (told.softer, told.tip, told.stiffer)]  # fmt: skip
    assert depths[0] == pytest.approx(depths[1] / 2, rel=1e-6)
    assert depths[2] == pytest.approx(depths[1] * 2, rel=1e-6)


def test_one_direction_leaves_two_rigid(robot, cut, tmp_path):
    cut = replace(cut, modes=())
    told = read_predicted_tip(predicted(robot, tmp_path / "p.json", [("z", "z")]), robot, cut)
    assert told.rigid == 2
    assert np.linalg.matrix_rank(told.tip.value[100]) == 1


def test_a_point_at_the_place_of_the_tool_will_do(robot, cut, tmp_path):
    gap = np.linalg.norm(robot.at(POSTURE).position("location_1") - robot.at(POSTURE).position("tool"))
    file = predicted(robot, tmp_path / "p.json", EVERY, point="location_1")
    if gap < 1e-3:
        assert read_predicted_tip(file, robot, cut).rigid == 1
    with pytest.raises(InvalidCut, match="FRFs at location_6; allowed: a cut at one of them"):
        read_predicted_tip(predicted(robot, tmp_path / "q.json", EVERY, point="location_6"), robot, cut)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda c: c.pop("ways"), "no prediction of FRFs"),
        (lambda c: c["frfs"][0]["re"].pop(), "no prediction of FRFs"),
        (lambda c: c["frfs"].clear(), "no prediction of FRFs"),
        (lambda c: c["frfs"][0].update(response="tool:+w"), "no prediction of FRFs"),
        (lambda c: c["ways"].update({"tool:+x": [1, 0]}), "no prediction of FRFs"),
        (lambda c: c["frfs"][0]["im"].__setitem__(3, float("nan")), "no prediction of FRFs"),
    ],
)
def test_what_is_no_prediction_is_refused(robot, cut, tmp_path, change, says):
    file = predicted(robot, tmp_path / "p.json", EVERY)
    content = json.loads(file.read_text())
    change(content)
    file.write_text(json.dumps(content))
    with pytest.raises(InvalidCut, match=says):
        read_predicted_tip(file, robot, cut)
    file.write_text("[1, 2]")
    with pytest.raises(InvalidCut, match=says):
        read_predicted_tip(file, robot, cut)


def test_a_tip_away_from_the_point_is_refused(robot, cut, tmp_path):
    away = replace(cut, frame=replace(cut.frame, offset=(0.0, 0.0, 0.1)))
    with pytest.raises(InvalidCut, match=r"frame\.offset"):
        read_predicted_tip(predicted(robot, tmp_path / "p.json", EVERY), robot, away)

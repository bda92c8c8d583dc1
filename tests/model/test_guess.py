"""A card for any URDF: sound, marked as guessed, of the size that the rule says; which link is the tool."""

import sys
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import example_arms, find_tool, read_card, read_urdf
from flexmodal.errors import InvalidRequest, OutputExists
from flexmodal.model.guess import DAMPING_RATIO, STIFFNESS_PER_TORQUE, guess_card

from .writing import body, joint

TOOLS = {
    "ur3": "ee_link", "ur5": "ee_link", "ur10": "ee_link", "panda": "panda_hand_tcp", "kinova":
    "j2s6s200_end_effector", "xarm7": "link_eef", "z1": "gripperMover", "so100": "jaw",
    "so101": "gripper_frame_link",
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(example_arms()))
def test_a_card_of_every_example_arm_is_sound(name, tmp_path):
    path = guess_card(name, tmp_path / name).write()
    assert flexmodal.check(path).faults == ()
    robot = flexmodal.load(path)
    assert robot.tool == TOOLS[name]
    assert "GUESSED" in path.read_text()
    assert read_card(path).source.startswith("guessed")
    assert all(joint.scale == 1.0 for joint in robot.joints.values())
    for posture in ("middle", "bent"):
        modes = robot.modes(posture)
        assert 1 < modes.frequency[0] < 300  # arms of this kind have their first mode at some 5 to 50 Hz
    direction = robot.frf("bent", [5.0], response="tool:+z").value
    assert np.array_equal(direction, robot.frf("bent", [5.0], response=f"{robot.tool}:+z").value)


def test_the_rule(tmp_path):
    robot = flexmodal.load(guess_card("ur5", tmp_path).write())
    effort = {"shoulder_pan_joint": 150, "wrist_1_joint": 28}
    for name, torque in effort.items():
        assert robot.joints[name].stiffness == pytest.approx(STIFFNESS_PER_TORQUE * torque)
    system = robot.at("middle").system
    ratio = np.diag(system.damping) / (2 * np.sqrt(np.diag(system.stiffness) * np.diag(system.mass)))
    assert ratio == pytest.approx(DAMPING_RATIO, rel=0.01)  # rounded to three digits


def _forked(path, left="left", right="right"):
    parts = (
        body("arm", 2.0, (0.2, 0, 0), (0.1, 0.1, 0.1, 0, 0, 0)), body(left), body(right),
        joint("q1", "revolute", "base", "arm"),
        joint("to_left", "fixed", "arm", left), joint("to_right", "fixed", "arm", right),
    )  # fmt: skip
    path.write_text("\n".join(['<robot name="fork">', body("base"), *parts, "</robot>"]))
    return path


def test_an_end_effector_that_could_be_several_is_asked_for(tmp_path):
    path = _forked(tmp_path / "fork.urdf")
    with pytest.raises(InvalidRequest, match="--tool FRAME, one of left, right"):
        guess_card(path, tmp_path / "out")
    assert guess_card(path, tmp_path / "out", tool="right").card.tool == "right"


def test_a_name_says_which_it_is(tmp_path):
    found = find_tool(read_urdf(_forked(tmp_path / "fork.urdf", "left", "my_tool0")))
    assert (found.link, found.sure) == ("my_tool0", True)


def test_nothing_is_overwritten(tmp_path):
    guess_card("ur5", tmp_path).write()
    with pytest.raises(OutputExists):
        guess_card("ur5", tmp_path).write()


def test_a_card_needs_no_card():
    with pytest.raises(InvalidRequest, match="has a card"):
        guess_card("six_axis", Path("anywhere"))


def test_a_new_folder_appears_with_both_files_in_it(tmp_path):
    """Killed at any file event it leaves no folder, or a whole one."""
    sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
    from killing import killed_everywhere

    target = tmp_path / "there" / "arm"
    target.parent.mkdir()
    guessed = guess_card(example_arms()["ur5"], target)
    found = killed_everywhere(guessed.write, target.parent, target, writers=8)
    assert len(found.events) >= 15
    assert found.broken() == []
    assert set(found.seen) == {found.old, found.new}
    guessed.write()
    assert sorted(path.name for path in target.iterdir()) == ["robot.toml", "ur5.urdf"]
    assert find_tool(read_urdf(target / "ur5.urdf")).link == guessed.card.tool

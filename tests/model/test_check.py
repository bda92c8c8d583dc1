import shutil

import pytest

import flexmodal
from flexmodal.cards import example_arms, shipped_cards
from flexmodal.errors import RobotNotFound

from .writing import body, joint, planar, save


@pytest.fixture
def folder(tmp_path):
    card = shipped_cards()["fanuc_s360"]
    (tmp_path / "robot.toml").write_text(card.read_text(encoding="utf-8").replace("../../urdf/", ""))
    shutil.copy(card.parent.parent.parent / "urdf" / "fanuc_s360.urdf", tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", sorted(shipped_cards()))
def test_every_card_is_sound(name):
    report = flexmodal.check(shipped_cards()[name])
    assert report.is_sound
    assert report.faults == ()


@pytest.mark.parametrize("name", sorted(example_arms()))
def test_every_example_arm_is_sound(name):
    assert flexmodal.check(example_arms()[name]).faults == ()


def test_a_sound_urdf(tmp_path):
    assert flexmodal.check(planar(tmp_path / "two.urdf", [1, 1], [1, 1], [0.1, 0.1], [0.5, 0.5])).is_sound


def test_there_is_nothing(tmp_path):
    with pytest.raises(RobotNotFound):
        flexmodal.check(tmp_path / "none.urdf")


def test_a_card_with_many_faults(folder):
    text = (folder / "robot.toml").read_text(encoding="utf-8")
    text = text.replace('tool = "tool"', 'tool = "hand"').replace("q1 = 0.8726646259971648", "q1 = 9.9")
    text = text.replace("[joint.q3]", "[joint.q33]")
    (folder / "robot.toml").write_text(text, encoding="utf-8")
    report = flexmodal.check(folder)
    assert not report.is_sound
    assert {fault.key for fault in report.faults} == {"tool", "posture.configuration_1.q1", "joint.q33"}


def test_numbers_that_only_the_urdf_reader_sees(folder):
    text = (folder / "fanuc_s360.urdf").read_text(encoding="utf-8")
    (folder / "fanuc_s360.urdf").write_text(text.replace('mass value="1.37"', 'mass value="-1"'))
    (fault,) = flexmodal.check(folder).faults
    assert fault.key == "link.link_3.inertial.mass"


def test_faults_of_a_card_do_not_hide_those_of_its_urdf(folder):
    text = (folder / "robot.toml").read_text(encoding="utf-8")
    (folder / "robot.toml").write_text(text.replace("stiffness = 559000.0", "stiffness = -1.0"))
    text = (folder / "fanuc_s360.urdf").read_text(encoding="utf-8")
    (folder / "fanuc_s360.urdf").write_text(text.replace('mass value="1.37"', 'mass value="-1"'))
    keys = [fault.key for fault in flexmodal.check(folder).faults]
    assert keys == ["joint.q1.stiffness", "link.link_3.inertial.mass"]


def test_a_mass_matrix_that_is_none(tmp_path, folder):
    """Only posing the robot finds it: a point mass exactly on its joint's axis."""
    path = save(
        tmp_path / "bare.urdf",
        body("arm", 1.0),
        joint("q", "revolute", "base", "arm"),
        joint("mount", "fixed", "arm", "tool", (1, 0, 0)),
    )
    (fault,) = flexmodal.check(path).faults
    assert fault.key == "link arm (moved by joint q)"
    text = (folder / "fanuc_s360.urdf").read_text(encoding="utf-8")
    text = text.replace('<origin xyz="0.115 0 0"/>\n      <mass', '<origin xyz="0 0 0"/>\n      <mass')
    old = '<inertia ixx="0.137" ixy="0" ixz="0" iyy="1.37" iyz="0" izz="1.37"/>'
    assert old in text
    zeros = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    (folder / "fanuc_s360.urdf").write_text(text.replace(old, zeros), encoding="utf-8")
    report = flexmodal.check(folder)
    assert [fault.key for fault in report.faults] == ["link link_3 (moved by joint q3)"]


def test_nothing_that_moves(tmp_path):
    report = flexmodal.check(save(tmp_path / "stone.urdf", joint("mount", "fixed", "base", "tool")))
    assert not report.is_sound


def test_warnings_are_no_faults(tmp_path):
    path = planar(
        tmp_path / "r.urdf", [1, 1], [1, 1], [0.1, 0.1], [0.5, 0.5], limits=[(-1.0, 1.0), (0.3, 0.3)]
    )
    report = flexmodal.check(path)
    assert report.is_sound
    assert any("q2 cannot move" in warning for warning in report.warnings)

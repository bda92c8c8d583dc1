"""A card in MuJoCo and back, a posture as a joint state and as robot programs, FRFs in a universal file."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import pyuff
import scipy.linalg
import yaml

import flexmodal
from flexmodal.cards.write import joint_state, krl, rapid
from flexmodal.errors import InvalidRequest
from flexmodal.model.mujoco_model import joints_of_mujoco, mujoco_text, write_mujoco

from .writing import mixed

ARMS = [("six_axis", "work"), ("fanuc_s360", "configuration_1"), ("six_link", "start_2")]


def _mass(model, data):
    mass = np.zeros((model.nv, model.nv))
    if hasattr(data, "qM"):
        mujoco.mj_fullM(model, mass, data.qM)
    else:  # since 4.0
        mujoco.mj_fullM(model, data, mass)
    return mass


def _there(text):
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize(("name", "posture"), ARMS)
def test_mujoco_has_the_same_matrices_there(name, posture):
    robot = flexmodal.load(name)
    posed = robot.at(posture)
    model, data = _there(mujoco_text(robot, posture))
    assert _mass(model, data) == pytest.approx(posed.system.mass, rel=1e-10, abs=1e-12)
    assert np.allclose(data.site(robot.tool).xpos, posed.position(robot.tool), atol=1e-12)
    assert np.max(np.abs(data.qfrc_passive)) < 1e-9  # the springs are at rest
    stiffness = np.empty((model.nv, model.nv))
    for joint in range(model.nv):
        moved = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, moved, 0)
        moved.qpos[joint] += 1e-3
        mujoco.mj_forward(model, moved)
        stiffness[:, joint] = -moved.qfrc_passive / 1e-3
    assert stiffness == pytest.approx(posed.system.stiffness, rel=1e-8, abs=1e-6)
    assert np.diag(posed.system.damping) == pytest.approx(np.ravel(model.dof_damping))
    squares = scipy.linalg.eigh(stiffness, _mass(model, data), eigvals_only=True)
    undamped = replace(posed.system, damping=np.zeros_like(stiffness))
    from flexmodal.modal import solve_modes

    assert np.sqrt(squares) / (2 * np.pi) == pytest.approx(solve_modes(undamped).frequency, rel=1e-6)


def test_joints_without_a_spring_stand_where_the_posture_has_them(tmp_path):
    robot = flexmodal.load(mixed(tmp_path / "m.urdf"), stiffness={"turn": 1e4, "lift": 2e4}, damping=3.0)
    pose = {"slide": 0.4, "turn": 0.3, "lift": -0.2, "wag": 0.5}
    posed = robot.at(pose)
    model, data = _there(mujoco_text(robot, pose))
    assert model.nv == 2
    # Inertias that are no multiple of one axis are turned to their principal axes there, in older releases to
    # some 1e-9 only.
    assert _mass(model, data) == pytest.approx(posed.system.mass, rel=1e-8)
    assert np.allclose(data.site("tool").xpos, posed.position("tool"), atol=1e-12)


def test_there_and_back(tmp_path):
    robot = flexmodal.load("six_axis")
    joints = {n: replace(joint, rotor_inertia=0.1 + k) for k, (n, joint) in enumerate(robot.joints.items())}
    path = tmp_path / "arm.xml"
    write_mujoco(replace(robot, joints=joints), "work", path)
    found = joints_of_mujoco(path)
    for name, joint in joints.items():
        assert (found[name].stiffness, found[name].damping) == (joint.stiffness, joint.damping)
        assert found[name].rotor_inertia == pytest.approx(joint.rotor_inertia, rel=1e-12)


def test_what_mujoco_does_not_have(tmp_path):
    robot = flexmodal.load("six_axis")
    joints = {name: replace(joint, loss_factor=0.1) for name, joint in robot.joints.items()}
    with pytest.raises(InvalidRequest, match="no loss factor"):
        mujoco_text(replace(robot, joints=joints), "work")
    path = tmp_path / "bad.xml"
    path.write_text("<mujoco><worldbody><body/></worldbody></mujoco")
    with pytest.raises(InvalidRequest, match="MuJoCo can read"):
        joints_of_mujoco(path)


def test_a_joint_state_is_read_by_a_yaml_reader():
    robot = flexmodal.load("six_axis")
    values = robot.posture("work").values
    found = yaml.safe_load(joint_state(values))
    assert dict(zip(found["name"], found["position"], strict=True)) == dict(values)
    assert set(found) == {"header", "name", "position", "velocity", "effort"}


def test_robot_programs_hold_the_angles_in_degrees():
    robot = flexmodal.load("six_axis")
    values = robot.posture("work").values
    wanted = np.degrees(list(values.values()))
    text = krl(values, robot.commanded, name="six-axis work")
    axes = dict(re.findall(r"(A\d) (-?[\d.]+)", text))
    assert [float(axes[f"A{k}"]) for k in range(1, 7)] == pytest.approx(wanted, abs=1e-6)
    assert "DEF six_axis_work( )" in text
    assert text.rstrip().endswith("END")
    text = rapid(values, robot.commanded, name="6 axes")
    inside, outside = re.search(r":= \[\[(.*?)\], \[(.*?)\]\];", text).groups()
    assert [float(part) for part in inside.split(",")] == pytest.approx(wanted, abs=1e-6)
    assert outside.split(", ") == ["9E+09"] * 6
    assert text.startswith("MODULE p_6_axes\n")


def test_axes_after_the_sixth_are_external():
    robot = flexmodal.load("panda", stiffness=1e4)
    values = robot.posture({"panda_joint4": -1.0, "panda_joint6": 1.0}).values
    assert re.search(r"A6 -?[\d.]+, E1 -?[\d.]+\}", krl(values, robot.commanded, name="panda"))
    assert rapid(values, robot.commanded, name="panda").count("9E+09") == 5


def test_frfs_in_a_universal_file_as_pyuff_reads_them(tmp_path):
    from flexmodal.campaign import write_frf

    robot = flexmodal.load("six_axis")
    found = robot.frf("work", np.arange(1.0, 50.0), response=["tool:+x", "wrist:-z"], reference="tool:+z")
    path = tmp_path / "frf.uff"
    write_frf(found, path, {"tool": 1, "wrist": 2})
    sets = pyuff.UFF(str(path)).read_sets()
    sets = [one for one in sets if one["type"] == 58]
    assert len(sets) == 2
    for one, direction in zip(sets, ("tool:+x", "wrist:-z"), strict=True):
        assert np.allclose(one["data"], found.between(direction, "tool:+z"), rtol=1e-6, atol=0)
        assert np.allclose(one["x"], found.frequency)

import copy
import os
import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.cards import read_urdf, shipped_cards
from flexmodal.errors import InvalidRequest, InvalidUrdf, RobotNotFound
from flexmodal.model.build import build_model

from .writing import body, joint, planar, save


@pytest.fixture
def card_folder(tmp_path: Path) -> Path:
    """A copy of the Fanuc's card beside its URDF."""
    source = shipped_cards()["fanuc_s360"]
    text = source.read_text(encoding="utf-8").replace("../../urdf/", "")
    (tmp_path / "robot.toml").write_text(text, encoding="utf-8")
    shutil.copy(source.parent.parent.parent / "urdf" / "fanuc_s360.urdf", tmp_path)
    return tmp_path


def test_name_path_and_folder_are_one_robot(card_folder):
    references = ["fanuc_s360", shipped_cards()["fanuc_s360"], str(card_folder), card_folder / "robot.toml"]
    found = [
        flexmodal.load(reference).frf("configuration_2", [0.0, 8.0, 51.0]).value for reference in references
    ]
    for value in found[1:]:
        np.testing.assert_array_equal(value, found[0])


def test_bare_urdf_says_what_a_card_would(fanuc):
    by_name = {name: joint.stiffness for name, joint in fanuc.joints.items()}
    losses = {name: joint.damping for name, joint in fanuc.joints.items()}
    bare = flexmodal.load(fanuc.urdf.path, stiffness=by_name, damping=losses)
    assert bare.tool == "tool"
    posture = fanuc.postures["configuration_2"]
    for response in ("tool:+z", "link_2:-x", "link_3:+ry"):
        found = bare.frf(posture, [0.0, 8.0, 51.0], response=response).value
        np.testing.assert_array_equal(found, fanuc.frf(posture, [0.0, 8.0, 51.0], response=response).value)


def test_one_number_for_all():
    robot = flexmodal.load("ur5", stiffness=7.0, damping=2.5)
    np.testing.assert_array_equal(robot.stiffness, 7 * np.eye(6))
    np.testing.assert_array_equal(robot.damping, 2.5 * np.eye(6))


def test_undamped_if_left_out():
    assert not np.any(flexmodal.load("ur5", stiffness=1e4).damping)


@pytest.mark.parametrize(
    ("options", "keys"),
    [
        ({}, ["stiffness"]),
        ({"stiffness": 0}, ["stiffness of q1", "stiffness of q2"]),
        ({"stiffness": float("nan")}, ["stiffness of q1", "stiffness of q2"]),
        ({"stiffness": float("inf")}, ["stiffness of q1", "stiffness of q2"]),
        ({"stiffness": True}, ["stiffness of q1", "stiffness of q2"]),
        ({"stiffness": "soft"}, ["stiffness of q1", "stiffness of q2"]),
        ({"stiffness": {}}, ["stiffness"]),
        ({"stiffness": {"q1": 1.0, "q9": 1.0, "mount": 1.0}}, ["stiffness", "stiffness"]),
        (
            {"stiffness": {"q1": -1.0, "q9": 1.0}, "damping": {"q1": -2.0}},
            ["damping of q1", "stiffness", "stiffness of q1"],
        ),
        # a rigid joint does not move, so its damping would be dropped without a word
        ({"stiffness": {"q1": 1.0}, "damping": {"q2": 1.0}}, ["damping"]),
        ({"stiffness": 1.0, "tool": "tol"}, ["tool"]),
    ],
)
def test_bad_stiffness_and_damping(tmp_path, untyped, options, keys):
    path = planar(tmp_path / "two.urdf", [1, 1], [1, 1], [0.1, 0.1], [0.5, 0.5])
    with pytest.raises(InvalidRequest) as caught:
        flexmodal.load(path, **options)
    assert sorted(fault.key for fault in caught.value.faults) == keys


def test_a_card_says_it_already():
    with pytest.raises(InvalidRequest) as caught:
        flexmodal.load("fanuc_s360", stiffness=1.0, damping=1.0)
    assert {fault.key for fault in caught.value.faults} == {"stiffness", "damping"}


def test_another_tool():
    assert flexmodal.load("fanuc_s360", tool="link_3").tool == "link_3"
    with pytest.raises(InvalidRequest, match="link_3"):
        flexmodal.load("fanuc_s360", tool="hand")


def test_unknown_robot():
    with pytest.raises(RobotNotFound, match="fanuc_s360"):
        flexmodal.load("fanuc_s36")


def test_nothing_moves(tmp_path):
    path = save(tmp_path / "stone.urdf", joint("mount", "fixed", "base", "tool"))
    with pytest.raises(InvalidRequest, match="none that moves"):
        flexmodal.load(path, stiffness=1.0)


def test_tool_of_a_tree_is_at_the_end_of_its_longest_branch(mixed_path):
    assert flexmodal.load(mixed_path, stiffness=1.0).tool == "tool"


def test_some_joints_rigid(arm, mixed_path, mixed_robot):
    """What a card or a caller leaves out is rigid: the submatrix of the others."""
    for whole, posture in (
        (arm, {"q1": 1.0, "q2": -0.4, "q4": 0.7}),
        (mixed_robot, {"turn": 1.0, "lift": 0.3}),
    ):
        for soft in (list(whole.joints)[::2], list(whole.joints)[1:2]):
            partly = flexmodal.load(whole.urdf.path, stiffness=dict.fromkeys(soft, 5.0), tool="tool")
            assert list(partly.joints) == soft
            assert list(partly.moving) == list(partly.commanded) == list(whole.moving)
            pick = [list(whole.joints).index(name) for name in soft]
            one, all_ = partly.at(posture), whole.at(posture)
            np.testing.assert_array_equal(one.system.mass, all_.system.mass[np.ix_(pick, pick)])
            np.testing.assert_array_equal(one.jacobian("tool"), all_.jacobian("tool")[:, pick])
            np.testing.assert_array_equal(one.full_jacobian("tool"), all_.full_jacobian("tool"))
            np.testing.assert_array_equal(one.position("tool"), all_.position("tool"))


def test_a_card_with_a_rigid_joint(card_folder, fanuc):
    text = (card_folder / "robot.toml").read_text(encoding="utf-8")
    text = text.replace("[joint.q2]\nstiffness = 20000.0\ndamping = 94.03\n", "")
    (card_folder / "robot.toml").write_text(text, encoding="utf-8")
    partly = flexmodal.load(card_folder)
    assert list(partly.joints) == ["q1", "rho", "q3"]
    assert list(partly.commanded) == ["q1", "q2", "q3"]
    pick = np.ix_([0, 2, 3], [0, 2, 3])
    for posture in ("configuration_1", "configuration_5"):
        found, whole = partly.at(posture).system, fanuc.at(posture).system
        np.testing.assert_array_equal(found.mass, whole.mass[pick])
        np.testing.assert_array_equal(found.stiffness, whole.stiffness[pick])
        np.testing.assert_array_equal(found.damping, whole.damping[pick])


def test_order_of_joints_is_the_chains_not_the_files(tmp_path):
    """A card may list joints in any order; names decide."""
    path = planar(tmp_path / "three.urdf", [1, 1, 1], [1, 1, 1], [0.1, 0.1, 0.1], [0.5, 0.5, 0.5])
    robot = flexmodal.load(path, stiffness={"q3": 3.0, "q1": 1.0, "q2": 2.0}, damping={"q2": 0.2, "q1": 0.1})
    assert list(robot.joints) == ["q1", "q2", "q3"]
    np.testing.assert_array_equal(np.diag(robot.stiffness), [1, 2, 3])
    np.testing.assert_array_equal(np.diag(robot.damping), [0.1, 0.2, 0])


def test_fixed_joints_stand_at_zero(mixed_path, mixed_robot):
    stiff = flexmodal.load(mixed_path, stiffness=2e4, damping=30.0, tool="tool", fixed=["wag", "slide"])
    assert list(stiff.moving) == ["turn", "lift"]
    posture = {"turn": 0.4, "lift": -0.8}
    pick = [list(mixed_robot.joints).index(name) for name in ("turn", "lift")]
    found, whole = stiff.at(posture), mixed_robot.at(posture)
    # the inertias of fixed links are summed in another order: rounding
    np.testing.assert_allclose(found.system.mass, whole.system.mass[np.ix_(pick, pick)], rtol=1e-12)
    np.testing.assert_allclose(found.position("tool"), whole.position("tool"), atol=1e-15)
    with pytest.raises(InvalidRequest, match="fixed"):
        flexmodal.load("fanuc_s360", fixed=["q1"])


def test_rotor_inertia_adds_to_the_diagonal(card_folder, fanuc):
    text = (card_folder / "robot.toml").read_text(encoding="utf-8")
    text = text.replace("[joint.q1]", "[joint.q1]\nrotor_inertia = 4.5")
    text = text.replace("[joint.q3]", "[joint.q3]\nrotor_inertia = 0.25")
    (card_folder / "robot.toml").write_text(text, encoding="utf-8")
    geared = flexmodal.load(card_folder)
    for posture in ("configuration_1", "configuration_6"):
        added = geared.at(posture).system.mass - fanuc.at(posture).system.mass
        # a sum of two numbers, rounded once, and their difference: 1e-15 of entries up to 20
        np.testing.assert_allclose(added, np.diag([4.5, 0, 0, 0.25]), atol=1e-14)


def test_one_joint_of_each_kind(tmp_path):
    """A single joint: Pinocchio hands back flat arrays where there is one column."""
    for kind in ("revolute", "continuous", "prismatic"):
        path = planar(tmp_path / f"{kind}.urdf", [0.8], [5.0], [0.2], [0.35], kind=kind)
        robot = flexmodal.load(path, stiffness=100.0, damping=1.0)
        assert robot.at({}).full_jacobian("tool").shape == (6, 1)
        assert robot.frf({}, [0.0, 1.0], response=["tool:+y", "tool:+z"]).value.shape == (2, 2, 2)
        assert robot.measures({}, direction="tool:+z" if kind != "prismatic" else "tool:+y").stiffness > 0


def test_what_the_library_drops_is_an_error(tmp_path):
    """Pinocchio writes a line to its standard error and goes on with a mass of 0."""
    parts = [body("a", 1.0, inertia=(1, 1, 1, 0, 0, 0)), joint("q", "revolute", "base", "a")]
    path = save(tmp_path / "r.urdf", *parts, joint("mount", "fixed", "a", "tool"))
    urdf = read_urdf(path)
    object.__setattr__(urdf, "text", urdf.text.replace('mass value="1.0"', 'mass value="heavy"'))
    with pytest.raises(InvalidUrdf) as caught:
        build_model(urdf, {}, {})
    assert caught.value.faults[0].allowed == "a URDF Pinocchio builds without complaint"
    object.__setattr__(urdf, "text", "<robot><nonsense")
    with pytest.raises(InvalidUrdf):
        build_model(urdf, {}, {})


def test_loading_leaves_standard_error_alone(capfd):
    flexmodal.load("fanuc_s360")
    os.write(2, b"still here\n")
    assert "still here" in capfd.readouterr().err


def test_a_robot_can_be_sent_elsewhere(fanuc, mixed_robot):
    """Pickled or copied, it gives the same numbers to the bit."""
    for robot, posture in ((fanuc, "configuration_3"), (mixed_robot, {"turn": 1.0})):
        there = [pickle.loads(pickle.dumps(robot)), copy.deepcopy(robot)]
        expected = robot.frf(posture, [0.0, 20.0]).value
        for other in there:
            np.testing.assert_array_equal(other.frf(posture, [0.0, 20.0]).value, expected)
            posture_there = pickle.loads(pickle.dumps(robot.posture(posture)))
            np.testing.assert_array_equal(other.frf(posture_there, [0.0, 20.0]).value, expected)

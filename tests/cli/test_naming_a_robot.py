"""ROBOT, --stiffness, --damping, --tool, --fix and --posture."""

import json
import math
import shutil

import pytest

import flexmodal

UR5 = "shoulder_lift_joint=-60deg,elbow_joint=80deg"


@pytest.mark.parametrize(
    "posture", [UR5, "shoulder_lift_joint=-1.0471975511965976, elbow_joint = 1.3962634015954636"]
)
def test_an_example_arm_by_name(cli, posture):
    ran = cli("modes", "ur5", "--stiffness", "2e4", "--damping", "30", "--posture", posture, "--json")
    arm = flexmodal.load("ur5", stiffness=2e4, damping=30.0)
    expected = arm.modes({"shoulder_lift_joint": math.radians(-60), "elbow_joint": math.radians(80)})
    assert [mode["frequency"] for mode in ran.json()["modes"]] == expected.frequency.tolist()


def test_the_fingers_of_an_example_arm_stay_where_they_are(cli):
    posture = "panda_joint4=-90deg,panda_joint6=90deg"
    ran = cli("modes", "panda", "--stiffness", "1e4", "--damping", "10", "--posture", posture, "--json")
    assert list(ran.json()["modes"][0]["shape"]) == [f"panda_joint{n}" for n in range(1, 8)]


def test_a_card_by_path_folder_and_name_is_one_robot(cli, card, monkeypatch):
    path = card()
    (path.parent / "box").mkdir()
    for name in ("robot.toml", "arm.urdf"):
        shutil.copy(path.parent / name, path.parent / "box" / name)
    monkeypatch.chdir(path.parent)
    found = [
        cli("modes", robot, "--posture", "bent", "--json").json()
        for robot in (path, path.parent, "robot.toml", "box", "./box/robot.toml")
    ]
    assert all(other == found[0] for other in found)


def test_a_bare_urdf_is_the_robot_of_its_card(cli, card):
    path = card()
    stiffness, damping = "q1=1000,bend=5000,q2=500", "q1=1, bend=2, q2=0.5"
    bare = cli(
        "frf", path.parent / "arm.urdf", "--stiffness", stiffness, "--damping", damping,
        "--posture", "q1=0.5,q2=-0.8", "--frequencies", "1:9:1", "--json",
    ).json()  # fmt: skip
    carded = cli("frf", path, "--posture", "bent", "--frequencies", "1:9:1", "--json").json()
    assert (bare["re"], bare["im"]) == (carded["re"], carded["im"])
    assert bare["response"] == "tool:+z"  # the last link


def test_one_number_is_for_all_joints(cli, urdf):
    path = urdf()
    every = "q1=700,bend=700,q2=700"
    one, named = (
        cli("modes", path, "--stiffness", text, "--posture", "q1=0.5", "--json").json()
        for text in ("700", every)
    )
    assert one == named


def test_joints_left_out_of_the_stiffness_are_rigid(cli, urdf):
    ran = cli("modes", urdf(), "--stiffness", "q2=700", "--posture", "q1=0.5", "--json")
    assert [list(mode["shape"]) for mode in ran.json()["modes"]] == [["q2"]]


def test_fix_takes_a_joint_out(cli, urdf):
    path = urdf()
    words = ("--stiffness", "700", "--fix", "bend, q2", "--posture", "q1=0.5")
    ran = cli("frf", path, *words, "--frequencies", "0", "--json")
    assert list(ran.json()["posture"]) == ["q1"]
    # By hand: three links of 1 m in line, lifted at 0.5 rad about q1, which stands 1 m from the origin.
    assert ran.json()["re"][0] == pytest.approx((3 * math.cos(0.5)) ** 2 / 700, rel=1e-12)


def test_tool_moves_the_end_effector(cli, urdf, card):
    path = urdf()
    ran = cli("measures", path, "--stiffness", "700", "--tool", "fore", "--posture", "q1=90deg", "--json")
    assert ran.json()["tool"] == pytest.approx([1, 0, 1], abs=1e-12)
    ran = cli("frf", card(), "--tool", "hand", "--posture", "bent", "--frequencies", "1", "--json")
    assert ran.json()["response"] == "hand:+z"


def test_a_catalogue_of_ones_own(cli, card, tmp_path, monkeypatch):
    path = card()
    home = tmp_path / "robots" / "mine"
    home.mkdir(parents=True)
    for name in ("robot.toml", "arm.urdf"):
        shutil.copy(path.parent / name, home / name)
    monkeypatch.setenv("FLEXMODAL_CATALOGUE", str(tmp_path))
    assert [robot["name"] for robot in json.loads(cli("robots", "--json").out)["robots"]] == ["arm"]
    assert cli("modes", "mine", "--posture", "bent").status == 0
    monkeypatch.setenv("FLEXMODAL_CATALOGUE", str(tmp_path / "nowhere"))
    cli("robots").refused("FLEXMODAL_CATALOGUE", "nowhere", "a folder with robots/ and urdf/")


def test_an_arm_whose_limits_leave_out_zero_is_shown(cli, tmp_path):
    """The Panda's elbow does not stretch out; without a posture it stands where its limits allow."""
    out = tmp_path / "panda.html"
    ran = cli("show", "panda", "--stiffness", "1e4", "--damping", "10", "--out", out)
    assert (ran.status, ran.out) == (0, "")
    assert "panda_joint4" in out.read_text(encoding="utf-8")

"""`flexmodal card new`, and what a bare URDF without a named end-effector is told."""


def test_a_card_is_written_and_every_command_takes_it(cli, tmp_path):
    out = tmp_path / "mine"
    ran = cli("card", "new", "ur5", "--out", out, "--width", 60)
    assert ran.status == 0
    assert "guessed" in ran.out
    assert "end-effector ee_link" in ran.out
    assert cli("check", out).status == 0
    for command in (("modes",), ("measures",), ("frf", "--frequencies", "5", "--response", "tool:+z")):
        assert cli(command[0], out, "--posture", "bent", *command[1:]).status == 0
    again = cli("card", "new", "ur5", "--out", out)
    again.refused("robot.toml", "existing file")
    assert cli("card", "new", "ur5", "--out", out, "--force").status == 0


def test_the_card_as_json(cli, tmp_path):
    found = cli("card", "new", "panda", "--out", tmp_path, "--json").json()
    assert found["tool"] == "panda_hand_tcp"
    assert found["guessed"] is True
    assert len(found["joints"]) == 7


def test_a_link_that_may_not_be_the_end_effector_is_said(cli):
    ran = cli("modes", "so101", "--stiffness", "100", "--posture", "shoulder_pan=0", "--fix", "gripper")
    assert ran.status == 0
    assert ran.err == ""  # gripper_frame_link says by its name that it is


def test_the_tool_of_any_arm_is_called_tool(cli, tmp_path):
    out = tmp_path / "tool.uff"
    asked = ("frf", "ur5", "--stiffness", "1e4", "--posture", "elbow_joint=1", "--frequencies", "5,6")
    assert cli(*asked, "--response", "tool:+z", "--out", out).status == 0
    one, other = cli(*asked, "--response", "tool:+z", "--json").json(), cli(*asked, "--json").json()
    assert one["re"] == other["re"]

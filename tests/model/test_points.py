import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidCard, InvalidFrequencies, InvalidPoint, InvalidRequest
from flexmodal.frf import PointDirection

from .writing import body, joint, save


def test_named_points_ride_on_their_links(fanuc):
    """A point of the card is its link's placement times the coordinates, whatever the posture."""
    for posture in ("configuration_1", "configuration_4"):
        posed = fanuc.at(posture)
        wrist, tip = posed.position("link_3"), posed.position("tool")
        np.testing.assert_allclose(posed.position("location_2"), wrist, atol=1e-15)
        np.testing.assert_allclose(posed.position("location_1"), tip, atol=1e-15)
        elbow = posed.position("link_2")
        np.testing.assert_allclose(posed.position("location_6"), elbow, atol=1e-15)
        # the second link is horizontal in these postures
        np.testing.assert_allclose(posed.position("location_3") - elbow, [0.29 + 0.57, 0, 0], atol=1e-15)
        np.testing.assert_array_equal(posed.jacobian("location_1"), posed.jacobian("tool"))


def test_points_on_fixed_links(mixed_robot):
    """A fixed link moves with what carries it; one fixed to the ground does not move at all."""
    posed = mixed_robot.at({"slide": 0.2, "turn": 0.9, "lift": -0.5, "wag": 0.3})
    np.testing.assert_array_equal(posed.jacobian("plinth"), 0)
    pack, arm = posed.full_jacobian("pack"), posed.full_jacobian("arm")
    np.testing.assert_allclose(pack[3:], arm[3:], atol=1e-15)
    lever = posed.position("pack") - posed.position("arm")
    np.testing.assert_allclose(pack[:3], arm[:3] + np.cross(arm[3:].T, lever).T, atol=1e-15)
    order = list(mixed_robot.moving)
    assert not np.any(pack[:, [order.index("lift"), order.index("wag")]])
    assert np.any(pack[:, order.index("slide")])


def test_unknown_point(fanuc):
    for call in (
        lambda: fanuc.at("configuration_1").position("location_9"),
        lambda: fanuc.at("configuration_1").jacobian("location_9"),
        lambda: fanuc.frf("configuration_1", [1.0], response="location_9:+z"),
        lambda: fanuc.frf("configuration_1", [1.0], reference="location_9:+z"),
        lambda: fanuc.measures("configuration_1", direction="location_9:+z"),
    ):
        with pytest.raises(InvalidPoint, match=r"did you mean location_\d\?.*location_1.*link_2_outer"):
            call()
    # Pinocchio's own frames are no points: the world, and those of the joints
    for name in ("universe", "q1", "tool_mount", "point location_1", ""):
        with pytest.raises(InvalidPoint):
            fanuc.frame_of(name)


@pytest.mark.parametrize("text", ["tool", "tool:", "tool:z+", "tool:+w", ":+z", "tool:rz ry", "tool:++z"])
def test_bad_direction(fanuc, text):
    with pytest.raises(InvalidPoint, match="such as tool:"):
        fanuc.frf("configuration_1", [1.0], response=text)


def test_no_directions_at_all(fanuc):
    with pytest.raises(InvalidPoint, match="at least one"):
        fanuc.frf("configuration_1", [1.0], response=[])


def test_other_bad_requests(fanuc):
    with pytest.raises(InvalidFrequencies):
        fanuc.frf("configuration_1", [2.0, 1.0])
    with pytest.raises(InvalidRequest, match="receptance, mobility, inertance"):
        fanuc.frf("configuration_1", [1.0], form="compliance")


def test_joints_and_links_may_share_a_name_and_points_may_not(tmp_path):
    """Each URDF joint is a frame too, and the frame of the link is meant; points are asked for like links."""
    inertia = (0.1, 0.1, 0.1, 0, 0, 0)
    path = save(
        tmp_path / "shared.urdf",
        body("arm", 1.0, (0.5, 0, 0), inertia),
        body("hand", 1.0, (0.5, 0, 0), inertia),
        joint("hand", "revolute", "base", "arm"),
        joint("arm", "revolute", "arm", "hand", (1, 0, 0)),
        joint("base", "fixed", "hand", "tool", (1, 0, 0)),
    )
    robot = flexmodal.load(path, stiffness=1.0)
    posed = robot.at({})
    assert [posed.position(name)[0] for name in ("base", "arm", "hand", "tool")] == [0, 0, 1, 2]
    card = (
        'format = 1\nname = "shared"\ntitle = "t"\nurdf = "shared.urdf"\ntool = "tool"\nsource = "s"\n'
        "[joint.hand]\nstiffness = 1.0\ndamping = 0.0\n"
        '[point.{}]\nlink = "hand"\nxyz = [0.25, 0, 0]\n'
    )
    (tmp_path / "robot.toml").write_text(card.format("palm"), encoding="utf-8")
    posed = flexmodal.load(tmp_path).at({})
    assert [posed.position(name)[0] for name in ("arm", "hand", "palm", "tool")] == [0, 1, 1.25, 2]
    (tmp_path / "robot.toml").write_text(card.format("hand"), encoding="utf-8")
    with pytest.raises(InvalidCard, match="the name of a link"):
        flexmodal.load(tmp_path)


def test_full_matrix_with_rotations(mixed_robot):
    """Six directions at the tool and six elsewhere: rows and columns, signs, symmetry, units."""
    axes = ["x", "y", "z", "rx", "ry", "rz"]
    tool, pack = [f"tool:+{axis}" for axis in axes], [f"pack:-{axis}" for axis in axes]
    posed = mixed_robot.at({"turn": 0.9, "lift": -0.5})
    lines = np.array([0.0, 5.0, 60.0])
    across, back = (
        posed.frf(lines, response=tool, reference=pack),
        posed.frf(lines, response=pack, reference=tool),
    )
    scale = np.abs(across.value).max()
    # reciprocity: Z is symmetric; the two solves round differently
    np.testing.assert_allclose(across.value, np.swapaxes(back.value, 1, 2), atol=1e-12 * scale)
    for line, frequency in enumerate(lines):
        omega = 2 * np.pi * frequency
        system = posed.system
        dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
        expected = posed.jacobian("tool") @ np.linalg.inv(dynamic) @ -posed.jacobian("pack").T
        np.testing.assert_allclose(across.value[line], expected, atol=1e-12 * scale)
    one = posed.frf(lines, response="tool:+ry", reference="pack:-x")
    np.testing.assert_allclose(across.between("tool:+ry", "pack:-x"), one.value[:, 0, 0], rtol=1e-14)
    assert [across.unit(0, 0), across.unit(4, 0), across.unit(0, 4), across.unit(4, 4)] == [
        "m/N",
        "rad/N",
        "m/(N·m)",
        "rad/(N·m)",
    ]
    assert one.to("inertance").unit() == "rad/(s²·N)"


def test_sign_flips_the_row(ur5):
    posed = ur5.at({"elbow_joint": 1.0})
    plus, minus = posed.frf([3.0], response=["tool0:+x", "tool0:-x"]).value[0]
    np.testing.assert_array_equal(plus, -minus)


def test_the_tool_along_z_if_nothing_is_said(fanuc):
    silent = fanuc.frf("configuration_1", [3.0])
    assert silent.response == silent.reference == (PointDirection("tool", "z"),)
    said = fanuc.frf("configuration_1", [3.0], response="tool:z")
    np.testing.assert_array_equal(silent.value, said.value)
    crossed = fanuc.frf("configuration_1", [3.0], response="location_3:+z")
    assert crossed.reference == crossed.response

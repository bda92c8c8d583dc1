from pathlib import Path

import pytest

from flexmodal.cards import check_consistency, check_masses, massless_joints, read_card, read_urdf
from flexmodal.errors import Fault, InvalidCard, InvalidUrdf


def check(folder: Path) -> None:
    card = read_card(folder / "robot.toml")
    check_consistency(card, read_urdf(card.urdf))


def faults_of(folder: Path) -> list[Fault]:
    with pytest.raises(InvalidCard) as caught:
        check(folder)
    return list(caught.value.faults)


def spoil(folder: Path, file: str, *changes: tuple[str, str]) -> None:
    path = folder / file
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path.write_text(text, encoding="utf-8")


def test_a_card_and_its_urdf(folder):
    check(folder)


CASES = [
    ("[point.end]", "[point.tool]", "point.tool", "the name of a link", "a name that no link has"),
    ("[point.end]", "[point.arm]", "point.arm", "the name of a link", "a name that no link has"),
    ("[joint.q1]", "[joint.q3]", "joint.q3", "does not have", "q1, bend, q2"),
    ("[joint.q1]", "[joint.mount]", "joint.mount", "a fixed joint", "q1, bend, q2"),
    ('tool = "tool"', 'tool = "tol"', "tool", '"tol"', 'did you mean "tool"'),
    ('link = "hand"', 'link = "hnad"', "point.end.link", '"hnad"', 'did you mean "hand"'),
    ("q1 = 0.5", "q9 = 0.5", "posture.bent.q9", "does not have", "q1, bend, q2"),
    ("q1 = 0.5", "mount = 0.5", "posture.bent.mount", "a fixed joint", "q1, bend, q2"),
    ("q1 = 0.5", "bend = 0.0", "posture.bent.bend", "a pseudo-joint", "commanded joints: q1, q2"),
    ("q1 = 0.5", "q1 = 2.1", "posture.bent.q1", "2.1", "-2 to 2, the limits of q1"),
    ('parameter = "q1"', 'parameter = "q7"', "family.sweep.parameter", '"q7"', "q1, bend, q2"),
    ('parameter = "q1"', 'parameter = "bend"', "family.sweep.parameter", "a pseudo-joint", "q1, q2"),
    ("from = -1.0", "from = -3.0", "family.sweep.from", "-3", "-2 to 2"),
    ("q2 = -1.0 }", "q2 = -2.5 }", "family.sweep.follow.q2", "puts q2 at", "-2 to 2"),
    ("q2 = -1.0 }", "bend = 1.0 }", "family.sweep.follow.bend", "a pseudo-joint", "q1, q2"),
]


@pytest.mark.parametrize(("old", "new", "key", "found", "allowed"), CASES)
def test_what_does_not_belong_is_named(folder, old, new, key, found, allowed):
    spoil(folder, "robot.toml", (old, new))
    faults = [fault for fault in faults_of(folder) if fault.key == key]
    assert faults
    assert faults[0].file == str(folder / "robot.toml")
    assert found in faults[0].found
    assert allowed in faults[0].allowed


def test_all_faults_come_at_once(folder):
    spoil(folder, "robot.toml", ('tool = "tool"', 'tool = "x"'), ("q1 = 0.5", "q1 = 9.0"))
    spoil(folder, "two_link.urdf", ('<mass value="2"/>', '<mass value="0"/>'))
    faults = faults_of(folder)
    assert [fault.key for fault in faults] == ["tool", "posture.bent.q1", "link.arm.inertial"]
    assert faults[2].file == str(folder / "two_link.urdf")
    assert "link arm has mass 0" in faults[2].found


def test_a_posture_that_leaves_a_joint_outside_its_limits(folder):
    text = (folder / "two_link.urdf").read_text()
    head, tail = text.split('<joint name="q2"')
    (folder / "two_link.urdf").write_text(
        head + '<joint name="q2"' + tail.replace('lower="-2"', 'lower="0.5"')
    )
    faults = {fault.key: fault for fault in faults_of(folder)}
    assert faults["posture.bent.q2"].found == "nothing, which means 0"
    assert faults["posture.bent.q2"].allowed.startswith("0.5 to 2")


def test_a_pseudo_joint_rests_at_zero(folder):
    text = (folder / "two_link.urdf").read_text()
    head, tail = text.split('<joint name="bend"')
    (folder / "two_link.urdf").write_text(
        head + '<joint name="bend"' + tail.replace('lower="-2"', 'lower="0.5"', 1)
    )
    (fault,) = faults_of(folder)
    assert fault.key == "joint.bend.pseudo"
    assert "0.5 to 2" in fault.found


def strip(folder: Path, link: str) -> Path:
    """Take the inertial element of a link out of the URDF."""
    path = folder / "two_link.urdf"
    lines = path.read_text().splitlines()
    path.write_text(
        "\n".join(f'<link name="{link}"/>' if f'<link name="{link}">' in line else line for line in lines)
    )
    return path


def test_a_flexible_joint_must_carry_mass(folder):
    urdf = read_urdf(strip(folder, "forearm"))
    (fault,) = massless_joints(urdf, ["q1", "bend", "q2"])
    assert (fault.file, fault.key) == (str(urdf.path), "link.forearm.inertial")
    assert "link forearm has no <inertial>" in fault.found
    assert "the flexible joint bend carries it" in fault.allowed
    with pytest.raises(InvalidUrdf, match="link forearm has no <inertial>"):
        check_masses(urdf, ["bend", "q2"])


def test_mass_behind_a_rigid_joint_counts(folder):
    urdf = read_urdf(strip(folder, "forearm"))
    check_masses(urdf, ["q1", "bend"])


def test_mass_behind_a_fixed_joint_counts(folder):
    path = strip(folder, "hand")
    (fault,) = massless_joints(read_urdf(path), ["q2"])
    assert "nor has any link fixed to it (tool)" in fault.found
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    )
    path.write_text(path.read_text().replace('<link name="tool"/>', f'<link name="tool">{inertial}</link>'))
    check_masses(read_urdf(path), ["q1", "bend", "q2"])

import copy
import pickle
from pathlib import Path

import pytest

from flexmodal.cards import JointCard, read_card
from flexmodal.errors import Fault, InvalidCard


def faults_of(path: Path) -> list[Fault]:
    with pytest.raises(InvalidCard) as caught:
        read_card(path)
    return list(caught.value.faults)


def spoil(folder: Path, *changes: tuple[str, str]) -> Path:
    path = folder / "robot.toml"
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path.write_text(text, encoding="utf-8")
    return path


def test_a_sound_card_is_read(folder):
    card = read_card(folder / "robot.toml")
    assert card.joints["q1"] == JointCard(1000.0, 1.0)
    assert card.joints["bend"] == JointCard(5000.0, 0.0, pseudo=True)
    assert card.pseudo_joints == ("bend",)
    assert card.points["end"].xyz == (0.5, 0.0, 0.0)
    assert card.postures == {"bent": {"q1": 0.5}}
    family = card.families["sweep"]
    assert (family.parameter, family.start, family.stop, dict(family.follow)) == ("q1", -1, 1, {"q2": -1})
    assert card.urdf == folder / "two_link.urdf"
    assert card.path == folder / "robot.toml"


def test_a_card_is_read_only_and_travels(folder):
    card = read_card(folder / "robot.toml")
    with pytest.raises(TypeError):
        card.joints["q1"] = card.joints["bend"]
    assert pickle.loads(pickle.dumps(card)) == card
    assert copy.deepcopy(card) == card


def test_optional_keys_of_a_joint(folder):
    extra = "damping = 1.0\nrotor_inertia = 0.2\nlower = 0.5\nupper = 2\nscale = 0.1"
    path = spoil(folder, ("damping = 1.0", extra))
    assert read_card(path).joints["q1"] == JointCard(1000.0, 1.0, False, 0.2, 0.5, 2.0, 0.1)


def test_points_postures_and_families_may_be_absent(folder, card_text):
    path = folder / "robot.toml"
    path.write_text(card_text[: card_text.index("[point")])
    card = read_card(path)
    assert not card.points
    assert not card.postures
    assert not card.families


def test_byte_order_mark_and_windows_lines(folder, card_text):
    path = folder / "robot.toml"
    path.write_bytes(b"\xef\xbb\xbf" + card_text.replace("\n", "\r\n").encode())
    assert read_card(path).name == "two_link"


def test_joint_names_need_not_be_ascii(folder):
    path = spoil(folder, ("[joint.q1]", '[joint."épaule 1"]'))
    assert "épaule 1" in read_card(path).joints


STIFFNESS = "a number in N·m/rad (N/m for a prismatic joint), above 0 (from 1e-12) and at most 1e18"
CASES = [
    ("stiffness = 1000.0", 'stiffness = "5e5 N"', "joint.q1.stiffness", '"5e5 N"', STIFFNESS),
    ("stiffness = 1000.0", "stiffness = true", "joint.q1.stiffness", "true", STIFFNESS),
    ("stiffness = 1000.0", "stiffness = nan", "joint.q1.stiffness", "nan", STIFFNESS),
    ("stiffness = 1000.0", "stiffness = inf", "joint.q1.stiffness", "inf", STIFFNESS),
    ("stiffness = 1000.0", "stiffness = -3.0", "joint.q1.stiffness", "-3.0", STIFFNESS),
    ("stiffness = 1000.0", "stiffness = 0", "joint.q1.stiffness", "0", STIFFNESS),
    ("stiffness = 1000.0", f"stiffness = 1{'0' * 400}", "joint.q1.stiffness", "too large", STIFFNESS),
    ("stiffness = 1000.0", "stiffness = [1.0]", "joint.q1.stiffness", "a list of 1", STIFFNESS),
    ("stiffness = 1000.0\n", "", "joint.q1.stiffness", "nothing", STIFFNESS),
    ("stiffness = 1000.0", "stiffness = 1979-05-27", "joint.q1.stiffness", "1979-05-27", STIFFNESS),
    ("damping = 1.0", "damping = 1e19", "joint.q1.damping", "1e+19", "from 0 to 1e18"),
    ("damping = 1.0", "damping = -1e-9", "joint.q1.damping", "-1e-09", "from 0 to 1e18"),
    ("damping = 1.0\n", "", "joint.q1.damping", "nothing", "N·m·s/rad"),
    ("pseudo = true", "pseudo = 1", "joint.bend.pseudo", "1", "true or false"),
    ("pseudo = true", "lower = 1.0", "joint.bend.lower", "1.0", "below 1"),
    ("pseudo = true", "upper = 0.9", "joint.bend.upper", "0.9", "above 1"),
    ("pseudo = true", "scale = 0", "joint.bend.scale", "0", "above 0"),
    ("pseudo = true", "rotor_inertia = -1", "joint.bend.rotor_inertia", "-1", "kg·m²"),
    (
        "stiffness = 1000.0",
        "stifness = 1000.0\nstiffness = 1.0",
        "joint.q1.stifness",
        "an unknown key",
        '"stiffness"',
    ),
    ("format = 1", "format = 2", "format", "2", "1"),
    ("format = 1", "format = true", "format", "true", "1"),
    ("format = 1", "format = 1.0", "format", "1.0", "1"),
    ("format = 1\n", "", "format", "nothing", "1"),
    ('name = "two_link"', 'name = "two/link"', "name", '"two/link"', "letters, digits"),
    ('source = "made up"\n', "", "source", "nothing", "where the numbers come from"),
    ('source = "made up"', 'source = ""', "source", '""', "not empty"),
    ('tool = "tool"', "tool = 3", "tool", "3", "the name of a URDF link"),
    ('title = "Two links"', 'titel = "x"\ntitle = "y"', "titel", "an unknown key", 'did you mean "title"'),
    ("[point.end]", '[point."über uns"]', "point.über uns", 'the name "über uns"', "letters, digits"),
    ("[posture.bent]", '[posture."a b"]', "posture.a b", 'the name "a b"', "letters, digits"),
    ("xyz = [0.5, 0, 0]", "xyz = [0.5, 0]", "point.end.xyz", "a list of 2", "three finite numbers"),
    ("xyz = [0.5, 0, 0]", "xyz = [0.5, 0, 0, 0]", "point.end.xyz", "a list of 4", "three finite numbers"),
    ("xyz = [0.5, 0, 0]", "xyz = [0.5, nan, 0]", "point.end.xyz[1]", "nan", "three finite numbers"),
    ("xyz = [0.5, 0, 0]", 'xyz = [0.5, 0, "0"]', "point.end.xyz[2]", '"0"', "three finite numbers"),
    ('link = "hand"\n', "", "point.end.link", "nothing", "URDF link"),
    ("q1 = 0.5", 'q1 = "50deg"', "posture.bent.q1", '"50deg"', "rad"),
    ("q1 = 0.5", "q1 = -inf", "posture.bent.q1", "-inf", "rad"),
    ("from = -1.0", "from = 1.0", "family.sweep.from", "1.0", "less than to"),
    ("from = -1.0", 'from = "a"', "family.sweep.from", '"a"', "rad"),
    ("q2 = -1.0 }", 'q2 = "x" }', "family.sweep.follow.q2", '"x"', "factor"),
    ("q2 = -1.0 }", "q1 = 1.0 }", "family.sweep.follow.q1", "the parameter itself", "other joints"),
    ('urdf = "two_link.urdf"', 'urdf = "absent.urdf"', "urdf", '"absent.urdf"', "relative to this file"),
    ('urdf = "two_link.urdf"', 'urdf = "."', "urdf", "no file", "relative to this file"),
    (
        'urdf = "two_link.urdf"',
        'urdf = "package://x/../../etc/passwd"',
        "urdf",
        "leaves its package",
        "package://",
    ),
    ('urdf = "two_link.urdf"', 'urdf = "package://nowhere/a.urdf"', "urdf", "nowhere", "package://"),
]


@pytest.mark.parametrize(("old", "new", "key", "found", "allowed"), CASES)
def test_one_fault_is_named(folder, old, new, key, found, allowed):
    path = spoil(folder, (old, new))
    (fault,) = faults_of(path)
    assert fault.file == str(path)
    assert fault.key == key
    assert found in fault.found
    assert allowed in fault.allowed
    assert not any(word in str(fault) for word in ("Input", "pydantic", "validat"))


def test_all_faults_come_at_once(folder):
    path = spoil(
        folder,
        ("format = 1", "format = 3"),
        ('urdf = "two_link.urdf"', 'urdf = "gone.urdf"'),
        ("stiffness = 1000.0", 'stiffness = "soft"'),
        ("damping = 0", "dampning = 0"),
        ("xyz = [0.5, 0, 0]", "xyz = [1]"),
        ("q1 = 0.5", "q1 = nan"),
        ("to = 1.0", "to = true"),
    )
    assert [fault.key for fault in faults_of(path)] == [
        "format",
        "urdf",
        "joint.q1.stiffness",
        "joint.bend.damping",
        "joint.bend.dampning",
        "point.end.xyz",
        "posture.bent.q1",
        "family.sweep.to",
    ]


@pytest.mark.parametrize("joints", ["", "[joint]\n"])
def test_a_card_needs_a_flexible_joint(folder, card_text, joints):
    path = folder / "robot.toml"
    path.write_text(card_text[: card_text.index("[joint")] + joints)
    (fault,) = faults_of(path)
    assert fault.key == "joint"
    assert fault.found in {"nothing", "no table"}
    assert fault.allowed == "at least one table [joint.<name>]"


def test_a_section_that_is_no_table(folder, card_text):
    path = folder / "robot.toml"
    path.write_text(card_text[: card_text.index("[joint")] + "joint = 3\n")
    (fault,) = faults_of(path)
    assert (fault.key, fault.found) == ("joint", "3")


BAD_BYTES = [
    (b"\xff\xfe\x00", "not UTF-8"),
    (b"format = ", "not TOML"),
    (b"format = 1\nformat = 1\n", "not TOML"),
    (b"\x00", "not TOML"),
    (b"a = " + b"[" * 100_000, "nested too deep"),
    (b"a = 1" + b"0" * 10_000, "not TOML"),
    (b"a." * 200_000 + b"a = 1", "more than 16 parts"),
    (b"[" + b"a . " * 200_000 + b"a]", "more than 16 parts"),
    (b"#" * 1_100_000, "more than 1 MB"),
    (b"a" * 900_000, "not TOML"),
]


@pytest.mark.parametrize(("content", "found"), BAD_BYTES, ids=lambda value: str(value)[:20])
def test_bytes_that_are_no_card(tmp_path, content, found):
    path = tmp_path / "robot.toml"
    path.write_bytes(content)
    (fault,) = faults_of(path)
    assert found in fault.found
    assert fault.file == str(path)


def test_an_empty_card_names_all_that_is_missing(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text("")
    keys = [fault.key for fault in faults_of(path)]
    assert keys == ["format", "name", "title", "urdf", "tool", "source", "joint"]


def test_what_is_no_regular_file(tmp_path, pipe):
    assert faults_of(tmp_path)[0].found == "a folder"
    assert faults_of(pipe)[0].found == "a pipe or device"
    assert faults_of(Path("/dev/zero"))[0].found == "a pipe or device"
    assert faults_of(tmp_path / "gone.toml")[0].found == "no such file"
    assert "cannot be opened" in faults_of(tmp_path / ("x" * 5000))[0].found


def test_package_address(folder, monkeypatch):
    path = spoil(folder, ('"two_link.urdf"', '"package://arms/urdf/arm.urdf"'))
    urdf = folder / "workspace" / "arms" / "urdf" / "arm.urdf"
    urdf.parent.mkdir(parents=True)
    (folder / "two_link.urdf").rename(urdf)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{folder / 'workspace'}")
    assert read_card(path).urdf == urdf
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(folder / "workspace" / "arms"))
    assert read_card(path).urdf == urdf
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    share = folder / "prefix" / "share"
    share.mkdir(parents=True)
    (folder / "workspace" / "arms").rename(share / "arms")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(folder / "prefix"))
    assert read_card(path).urdf == share / "arms" / "urdf" / "arm.urdf"

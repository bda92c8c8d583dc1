"""A card that is wrong gives every fault at once, each with file, key, found and allowed; exit 2."""

import pytest

STIFFNESS = "stiffness = 1000.0"

SPOILED = {
    "unknown key": ((STIFFNESS, f"{STIFFNESS}\nstifness = 3"), ["joint.q1.stifness", "stiffness"]),
    "unknown section": (("[point.end]", "[points.end]"), ["points", "point"]),
    "unit in a string": ((STIFFNESS, 'stiffness = "5e5 N"'), ["joint.q1.stiffness", '"5e5 N"', "N·m/rad"]),
    "negative stiffness": ((STIFFNESS, "stiffness = -1.0"), ["joint.q1.stiffness", "-1", "above 0"]),
    "stiffness 0": ((STIFFNESS, "stiffness = 0"), ["joint.q1.stiffness", "0", "above 0"]),
    "stiffness NaN": ((STIFFNESS, "stiffness = nan"), ["joint.q1.stiffness", "nan", "above 0"]),
    "stiffness inf": ((STIFFNESS, "stiffness = inf"), ["joint.q1.stiffness", "inf", "above 0"]),
    "stiffness true": ((STIFFNESS, "stiffness = true"), ["joint.q1.stiffness", "true", "above 0"]),
    "no stiffness": ((STIFFNESS, ""), ["joint.q1.stiffness", "nothing", "above 0"]),
    "negative damping": (("damping = 1.0", "damping = -1"), ["joint.q1.damping", "-1", "from 0 to 1e18"]),
    "unknown joint": (
        ("[joint.q2]", "[joint.q7]"),
        ["joint.q7", "a joint that the URDF does not have", "q1, bend, q2"],
    ),
    "a fixed joint": (("[joint.q2]", "[joint.mount]"), ["joint.mount", "a fixed joint"]),
    "unknown link of a point": (('link = "hand"', 'link = "hamd"'), ["point.end.link", '"hamd"', '"hand"?']),
    "a point in the plane": (("xyz = [0.5, 0.0, 0.0]", "xyz = [0.5, 0.0]"), ["point.end.xyz", "three"]),
    "unknown tool": (('tool = "tool"', 'tool = "gripper"'), ["tool", '"gripper"', "hand"]),
    "no URDF": (('urdf = "arm.urdf"', 'urdf = "other.urdf"'), ["urdf", '"other.urdf"', "no file"]),
    "posture of an unknown joint": (("q2 = -0.8", "q9 = -0.8"), ["posture.bent.q9", "q1, bend, q2"]),
    "posture of a pseudo-joint": (("q2 = -0.8", "bend = 0.1"), ["posture.bent.bend", "pseudo-joint"]),
    "posture outside the limits": (("q2 = -0.8", "q2 = -3"), ["posture.bent.q2", "-3", "-2 to 2"]),
    "posture NaN": (("q2 = -0.8", "q2 = nan"), ["posture.bent.q2", "nan", "finite"]),
    "family outside the limits": (("to = 1.0", "to = 3.0"), ["family.sweep.to", "3", "-2 to 2"]),
    "family backwards": (("to = 1.0", "to = -2.0"), ["family.sweep"]),
    "another format": (("format = 1", "format = 2"), ["format", "found 2", "allowed: 1"]),
    "not TOML": (('title = "An arm"', "title = An arm"), ["text that is not TOML"]),
}


@pytest.mark.parametrize("kind", SPOILED)
def test_spoiled(cli, card, kind):
    replacement, words = SPOILED[kind]
    path = card(replacement)
    lines = cli("modes", path, "--posture", "bent").refused(path, *words, ": found ", "; allowed: ")
    ran = cli("check", path)
    assert (ran.status, ran.err) == (1, "")
    assert ran.out.splitlines()[:-1] == [line.removeprefix("flexmodal: ") for line in lines]


def test_several_faults_at_once(cli, card):
    path = card(
        (STIFFNESS, 'stiffness = "5e5 N"'),
        ("damping = 1.0", "damping = nan"),
        ("damping = 0.5", "colour = 1"),
    )
    lines = cli("modes", path, "--posture", "bent").refused()
    keys = [line.removeprefix(f"flexmodal: {path}: ").split(": ")[0] for line in lines]
    assert sorted(keys) == ["joint.q1.damping", "joint.q1.stiffness", "joint.q2.colour", "joint.q2.damping"]


def test_faults_of_the_urdf_behind_a_card(cli, card, urdf):
    path = card()
    urdf(('<mass value="2"/>', '<mass value="0"/>'), ('lower="-2"', 'lower="9"'))
    cli("modes", path, "--posture", "bent").refused(path.parent / "arm.urdf", "joint.q1.limit", "lower 9")


@pytest.mark.parametrize(
    "content", [b"", b"\xff\xfe\x00", b"\x00" * 10, b"a" * 2_000_000, b"[" * 50_000], ids=str.__len__ and repr
)
def test_whole_files(cli, tmp_path, content):
    path = tmp_path / "robot.toml"
    path.write_bytes(content)
    cli("modes", path, "--posture", "bent").refused(path)


@pytest.mark.parametrize("option", ["--stiffness", "--damping", "--fix"])
def test_what_a_card_says_may_not_be_said_again(cli, card, option):
    path = card()
    cli("modes", path, "--posture", "bent", option, "3").refused(path, option.lstrip("-"), "bare URDF")

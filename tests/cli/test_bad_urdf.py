"""A URDF that is wrong gives one clear error: file, key, what was found, what is allowed; exit 2."""

import os
import resource

import pytest

MOVE = ("--stiffness", "1e4", "--posture", "q1=0.1")
MASS = '<mass value="2"/>'
HAND = '<link name="hand"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>'
INERTIA = 'ixx="0.1" ixy="0" ixz="0" iyy="0.1"'
MOUNT = '<joint name="mount" type="fixed"><parent link="hand"/>'

SPOILED = {
    "no inertial on a flexible link": (
        [('<link name="hand"><inertial>', '<link name="hand"/><link name="x"><inertial>')],
        ["robot", "2 links that no joint carries", "one root"],
    ),
    "no mass element": ([(MASS, "")], ["link.upper.inertial.mass", "found nothing", "in kg"]),
    "mass 0 on a flexible link": (
        [(HAND, HAND.replace('"2"', '"0"'))],
        ["link.hand.inertial", "mass 0", "a mass above 0, since the flexible joint q2 carries it"],
    ),
    "negative mass": ([(MASS, '<mass value="-2"/>')], ["link.upper.inertial.mass", '"-2"', "0 or more"]),
    "mass NaN": ([(MASS, '<mass value="NaN"/>')], ["link.upper.inertial.mass", '"NaN"', "finite mass"]),
    "mass 1e999": ([(MASS, '<mass value="1e999"/>')], ["link.upper.inertial.mass", '"1e999"', "finite mass"]),
    "mass with a unit": ([(MASS, '<mass value="2 kg"/>')], ["link.upper.inertial.mass", '"2 kg"']),
    "triangle inequality": (
        [(INERTIA, 'ixx="9" ixy="0" ixz="0" iyy="0.1"')],
        ["link.upper.inertial.inertia", "principal moments 0.1, 0.1 and 9", "none exceeds the sum"],
    ),
    "negative inertia": (
        [(INERTIA, 'ixx="-0.1" ixy="0" ixz="0" iyy="0.1"')],
        ["link.upper.inertial.inertia", "-0.1", "0 or more"],
    ),
    "inertia NaN": (
        [(INERTIA, 'ixx="nan" ixy="0" ixz="0" iyy="0.1"')],
        ["link.upper.inertial.inertia.ixx", '"nan"', "finite number in kg·m²"],
    ),
    "origin 1e999": (
        [('<origin xyz="1 0 0"/>', '<origin xyz="1e999 0 0"/>')],
        ["joint.q1.origin.xyz", '"1e999 0 0"', "three finite numbers"],
    ),
    "origin of two numbers": (
        [('<origin xyz="1 0 0"/>', '<origin xyz="1 0"/>')],
        ["joint.q1.origin.xyz", '"1 0"', "three finite numbers"],
    ),
    "axis 0": (
        [('<axis xyz="0 -1 0"/>', '<axis xyz="0 0 0"/>')],
        ["joint.q1.axis", '"0 0 0"', "a direction"],
    ),
    "limits the wrong way round": (
        [('lower="-2" upper="2"', 'lower="2" upper="-2"')],
        ["joint.q1.limit", "lower 2 above upper -2"],
    ),
    "no limits": (
        [('<limit lower="-2" upper="2" effort="1" velocity="1"/>', "")],
        ["joint.q1.limit", "found nothing", "<limit>"],
    ),
    "a loop": (
        [
            (
                '<joint name="q1" type="revolute"><parent link="base"/>',
                '<joint name="q1" type="revolute"><parent link="tool"/>',
            )
        ],
        ["a loop of links", "no link carries itself"],
    ),
    "two joints of one name": ([('name="q2"', 'name="q1"')], ["joint.q1", "a second joint of that name"]),
    "two links of one name": (
        [('<link name="hand">', '<link name="fore">')],
        ["link.fore", "a second link of that name"],
    ),
    "two parents": (
        [
            (
                "</robot>",
                MOUNT.replace("mount", "again").replace('"hand"', '"upper"')
                + '<child link="tool"/></joint></robot>',
            )
        ],
        ["joint.again.child", '"tool", which joint "mount" already carries', "one parent"],
    ),
    "a link that is not there": (
        [(MOUNT, MOUNT.replace('"hand"', '"hamd"'))],
        ["joint.mount.parent", '"hamd"', 'did you mean "hand"?'],
    ),
    "mimic": (
        [('<joint name="q2" type="revolute">', '<joint name="q2" type="revolute"><mimic joint="q1"/>')],
        ["joint.q2.mimic", "mimics another", "--fix"],
    ),
    "floating": (
        [('<joint name="q2" type="revolute">', '<joint name="q2" type="floating">')],
        ["joint.q2.type", '"floating", which has several degrees of freedom', "revolute"],
    ),
    "an unknown type": (
        [('<joint name="q2" type="revolute">', '<joint name="q2" type="hinge">')],
        ["joint.q2.type", '"hinge"', "revolute, continuous, prismatic or fixed"],
    ),
    "xacro": (
        [(MASS, '<mass value="${2*mass}"/>')],
        ["xacro that is not expanded", "xacro robot.xacro > robot.urdf"],
    ),
    "another root element": ([('<robot name="arm">', "<sdf>"), ("</robot>", "</sdf>")], ["<sdf>", "<robot>"]),
    "cut off": ([("</robot>", "")], ["text that is not XML"]),
}


@pytest.mark.parametrize("kind", SPOILED)
def test_spoiled(cli, urdf, kind):
    replacements, words = SPOILED[kind]
    path = urdf(*replacements)
    cli("modes", path, *MOVE).refused(path, *words, "; allowed: ")
    # `check` says the same on standard output: its answer is no.
    ran = cli("check", path)
    assert (ran.status, ran.err) == (1, "")
    for word in words:
        assert word in ran.out


WHOLE = {
    "empty": (b"", "an empty file"),
    "blank": (b" \n\t\n", "an empty file"),
    "not XML": (b"joint q1 revolute\n", "text that is not XML"),
    "binary": (bytes(range(256)) * 40, "text that is not XML"),
    "gzip": (b"\x1f\x8b\x08\x00" + bytes(100), "text that is not XML"),
    "no link": (b'<robot name="arm"/>', "no <link>"),
}


@pytest.mark.parametrize("kind", WHOLE)
def test_whole_files(cli, urdf, kind):
    content, words = WHOLE[kind]
    path = urdf(text=content)
    lines = cli("modes", path, *MOVE).refused(path, words)
    assert len(lines) == 1


def test_every_fault_at_once(cli, urdf):
    path = urdf(
        (MASS, '<mass value="-2"/>'),
        ('<axis xyz="0 -1 0"/>', '<axis xyz="0 0 0"/>'),
        ('<joint name="q2" type="revolute">', '<joint name="q2" type="floating">'),
    )
    lines = cli("modes", path, *MOVE).refused("link.upper.inertial.mass", "joint.q1.axis", "joint.q2.type")
    assert len(lines) == 3
    assert all(line.startswith(f"flexmodal: {path}: ") for line in lines)


def test_a_massless_link_is_no_fault_where_nothing_flexible_carries_it(cli, urdf):
    path = urdf((HAND, HAND.replace('"2"', '"0"')))
    assert cli("modes", path, "--stiffness", "q1=1e4", "--posture", "q1=0.1").status == 0


@pytest.fixture
def caged(shell):
    """As a process with a gigabyte and a half of memory and a minute: what might hang or crash."""

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (3 << 29, 3 << 29))

    def run(*words):
        return shell(*words, preexec_fn=limit)

    return run


def test_an_entity_bomb(caged, urdf):
    entities = '<!ENTITY a0 "ha">' + "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12))
    path = urdf(text=f'<!DOCTYPE robot [{entities}]><robot name="arm"><link name="&a11;"/></robot>')
    caged("modes", path, *MOVE).refused(path, "a document type declaration")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_an_external_entity_is_not_read(caged, urdf, tmp_path, encoding):
    canary = tmp_path / "secret.txt"
    canary.write_text("canary")
    text = (
        f'<?xml version="1.0" encoding="{encoding}"?>'
        f'<!DOCTYPE robot [<!ENTITY x SYSTEM "{canary.as_uri()}">]>'
        '<robot name="arm"><link name="&x;"/></robot>'
    )
    path = urdf(text=text.encode(encoding))
    for command in (("modes", path, *MOVE), ("check", path)):
        ran = caged(*command)
        assert ran.status == (1 if command[0] == "check" else 2)
        assert "document type declaration" in ran.out + ran.err or "external entity" in ran.out + ran.err
        assert "canary" not in ran.out + ran.err
        assert "Traceback" not in ran.err


@pytest.mark.parametrize("name", ["arm.urdf", "robot.toml"])
def test_a_pipe_that_nobody_writes_to(caged, tmp_path, name):
    path = tmp_path / name
    os.mkfifo(path)
    caged("modes", path, *MOVE).refused(path, "a pipe or device", "a regular file")


def test_a_chain_of_4000_joints(caged, urdf):
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    body = f'<inertial><mass value="1"/>{inertia}</inertial>'
    links = '<link name="l0"/>' + "".join(
        f'<link name="l{n}">{body}</link><joint name="q{n}" type="continuous">'
        f'<parent link="l{n - 1}"/><child link="l{n}"/><axis xyz="0 1 0"/></joint>'
        for n in range(1, 4001)
    )
    path = urdf(text=f'<robot name="worm">{links}</robot>')
    caged("modes", path, *MOVE).refused(path, "4001 links", "at most 1000")


def test_a_file_of_many_megabytes(caged, tmp_path):
    path = tmp_path / "arm.urdf"
    with path.open("wb") as file:
        file.write(b"<robot>")
        file.truncate(4 << 30)  # sparse: four gigabytes of zeros
    caged("modes", path, *MOVE).refused(path, "more than 10 MB")


def test_deep_nesting(caged, urdf):
    caged("modes", urdf(text="<robot>" + "<a>" * 100_000), *MOVE).refused("text that is not XML")


def test_a_folder_a_xacro_and_nothing(cli, tmp_path):
    cli("modes", tmp_path, *MOVE).refused("no such file")
    path = tmp_path / "arm.xacro"
    path.write_text("<robot/>")
    cli("modes", path, *MOVE).refused(path, "xacro robot.xacro > robot.urdf")
    cli("modes", "fanuc_s36", *MOVE).refused('did you mean "fanuc_s360"?', "six_link", "panda")
    cli("modes", "x" * 5000, *MOVE).refused("no robot of the name")

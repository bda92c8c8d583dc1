from pathlib import Path

import numpy as np
import pytest

from flexmodal.cards import read_urdf
from flexmodal.errors import Fault, InvalidUrdf

LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'


def write(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "arm.urdf"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def faults_of(path: Path) -> list[Fault]:
    with pytest.raises(InvalidUrdf) as caught:
        read_urdf(path)
    return list(caught.value.faults)


def test_a_sound_urdf_is_read(tmp_path, urdf_text):
    urdf = read_urdf(write(tmp_path, urdf_text))
    assert urdf.root == "base"
    assert [link.name for link in urdf.links] == ["base", "arm", "forearm", "hand", "tool"]
    assert urdf.movable_joints == ("q1", "bend", "q2")
    arm, base = urdf.link_by_name["arm"], urdf.link_by_name["base"]
    assert (arm.mass, base.mass, base.inertia) == (2.0, None, None)
    np.testing.assert_array_equal(arm.com, [0.5, 0, 0])
    np.testing.assert_array_equal(arm.inertia, 0.1 * np.eye(3))
    joint = urdf.joint_by_name["q2"]
    assert (joint.parent, joint.child, joint.lower, joint.upper, joint.velocity) == (
        "forearm",
        "hand",
        -2,
        2,
        1,
    )
    np.testing.assert_array_equal(joint.axis, [0, -1, 0])
    assert urdf.joint_by_name["mount"].upper == np.inf
    assert urdf.warnings == ()


def test_inertia_is_turned_into_the_axes_of_the_link(tmp_path, urdf_text):
    text = urdf_text.replace(
        '<origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.1"',
        '<origin xyz="0.5 0 0" rpy="0 0 1.5707963267948966"/><mass value="2"/><inertia ixx="0.05"',
    )
    inertia = read_urdf(write(tmp_path, text)).link_by_name["arm"].inertia
    np.testing.assert_allclose(inertia, np.diag([0.1, 0.05, 0.1]), atol=1e-15)


def test_axis_becomes_a_unit_vector_and_defaults_to_x(tmp_path, urdf_text):
    text = urdf_text.replace('<axis xyz="0 -1 0"/>', '<axis xyz="0 3 4"/>', 1).replace(
        '<axis xyz="0 -1 0"/>', "", 1
    )
    urdf = read_urdf(write(tmp_path, text))
    np.testing.assert_allclose(urdf.joint_by_name["q1"].axis, [0, 0.6, 0.8])
    np.testing.assert_array_equal(urdf.joint_by_name["bend"].axis, [1, 0, 0])


def test_names_need_not_be_ascii_and_other_encodings_are_read(tmp_path, urdf_text):
    text = urdf_text.replace('"arm"', '"ärm"').replace('version="1.0"', 'version="1.0" encoding="ISO-8859-1"')
    urdf = read_urdf(write(tmp_path, text.encode("latin-1")))
    assert "ärm" in urdf.link_by_name
    assert "ärm" in urdf.text
    assert not urdf.text.startswith("<?xml")


def test_comments_survive_in_the_text(tmp_path, urdf_text):
    text = urdf_text.replace("<robot", "<!-- licence -->\n<robot")
    assert "<!-- licence -->" in read_urdf(write(tmp_path, text)).text


@pytest.mark.parametrize("inertia", [(0, 0, 0), (1, 1, 2), (1, 1, 2 * (1 + 4e-7)), (0, 1, 1)])
def test_limiting_bodies_are_allowed(tmp_path, urdf_text, inertia):
    text = urdf_text.replace(
        'ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"',
        'ixx="{}" ixy="0" ixz="0" iyy="{}" iyz="0" izz="{}"'.format(*inertia),
        1,
    )
    read_urdf(write(tmp_path, text))


CASES = [
    ('mass value="2"', 'mass value="-2"', "link.arm.inertial.mass", '"-2"', "0 or more"),
    ('mass value="2"', 'mass value="nan"', "link.arm.inertial.mass", '"nan"', "finite"),
    ('mass value="2"', 'mass value="1e999"', "link.arm.inertial.mass", '"1e999"', "finite"),
    ('mass value="2"', 'mass value="2 kg"', "link.arm.inertial.mass", '"2 kg"', "finite"),
    ('mass value="2"', 'mass value="1_0"', "link.arm.inertial.mass", '"1_0"', "finite"),
    ('mass value="2"', "mass", "link.arm.inertial.mass", "nothing", "kg"),
    ('<mass value="2"/>', "", "link.arm.inertial.mass", "nothing", "kg"),
    ('ixx="0.1"', 'ixx="0,1"', "link.arm.inertial.inertia.ixx", '"0,1"', "kg·m²"),
    ('ixx="0.1" ', "", "link.arm.inertial.inertia.ixx", "nothing", "kg·m²"),
    ('ixx="0.1"', 'ixx="-0.1"', "link.arm.inertial.inertia", "-0.1", "0 or more"),
    ('ixx="0.1"', 'ixx="0.3"', "link.arm.inertial.inertia", "0.3", "none exceeds the sum"),
    ('ixy="0"', 'ixy="0.2"', "link.arm.inertial.inertia", "-0.1", "0 or more"),
    ('xyz="0.5 0 0"', 'xyz="0.5 0"', "link.arm.inertial.origin.xyz", '"0.5 0"', "three finite"),
    ('xyz="1 0 0"', 'xyz="1 0 inf"', "joint.q1.origin.xyz", '"1 0 inf"', "three finite"),
    ('axis xyz="0 -1 0"', 'axis xyz="0 0 0"', "joint.q1.axis", '"0 0 0"', "not all 0"),
    ('axis xyz="0 -1 0"', 'axis xyz="0 nan 0"', "joint.q1.axis", '"0 nan 0"', "three finite"),
    ('axis xyz="0 -1 0"', 'axis xyz="1e300 1e300 1e300"', "joint.q1.axis", "1e300", "at most 10000"),
    (LIMIT, "", "joint.q1.limit", "nothing", "lower, upper"),
    (LIMIT, LIMIT + LIMIT, "joint.q1.limit", "2 elements <limit>", "one"),
    ('lower="-2"', 'lower="3"', "joint.q1.limit", "lower 3 above upper 2", "lower below upper"),
    ('lower="-2"', 'lower="NaN"', "joint.q1.limit.lower", '"NaN"', "rad"),
    (' effort="1"', "", "joint.q1.limit.effort", "nothing", "finite"),
    (' velocity="1"', ' velocity="x"', "joint.q1.limit.velocity", '"x"', "finite"),
    ('type="revolute"', 'type="floating"', "joint.q1.type", "several degrees of freedom", "revolute"),
    ('type="revolute"', 'type="planar"', "joint.q1.type", "several degrees of freedom", "split it"),
    ('type="revolute"', 'type="hinge"', "joint.q1.type", '"hinge"', "revolute"),
    (' type="revolute"', "", "joint.q1.type", "nothing", "revolute"),
    (LIMIT, LIMIT + '<mimic joint="q2"/>', "joint.q1.mimic", "mimics", "by themselves"),
    ('<parent link="base"/>', "", "joint.q1.parent", "nothing", "<parent"),
    ('<child link="arm"/>', "<child/>", "joint.q1.child", "nothing", "<child"),
    ('parent link="base"', 'parent link="bass"', "joint.q1.parent", '"bass"', 'did you mean "base"'),
    ('child link="arm"', 'child link="leg"', "joint.q1.child", '"leg"', "a link of this file"),
    ('child link="tool"', 'child link="hand"', "joint.mount.child", "already carries", "one parent"),
    (
        '<link name="tool"/>',
        '<link name="tool"/><link name="tool"/>',
        "link.tool",
        "second link",
        "different",
    ),
    ('joint name="bend"', 'joint name="q1"', "joint.q1", "second joint", "different"),
    ('<link name="tool"/>', '<link name="tool"/><link/>', "link", "without a name", "a name"),
    ('<link name="tool"/>', '<link name="tool"/><link name="spare"/>', "robot", "base, spare", "one root"),
    ('joint name="q1"', 'joint name="universe"', "joint.universe", "Pinocchio", "another name"),
    ('parent link="base"', 'parent link="hand"', "robot", "loop", "tree"),
]


@pytest.mark.parametrize(("old", "new", "key", "found", "allowed"), CASES)
def test_one_fault_is_named(tmp_path, urdf_text, old, new, key, found, allowed):
    assert old in urdf_text
    path = write(tmp_path, urdf_text.replace(old, new, 1))
    faults = faults_of(path)
    (fault,) = [fault for fault in faults if fault.key == key]
    assert fault.file == str(path)
    assert found in fault.found
    assert allowed in fault.allowed
    others = {other.key for other in faults} - {key}
    assert others <= ({"robot"} if key in {"joint.mount.child"} else set())


def test_all_faults_come_at_once(tmp_path, urdf_text):
    text = (
        urdf_text.replace('mass value="2"', 'mass value="-2"', 1)
        .replace('axis xyz="0 -1 0"', 'axis xyz="0 0 0"', 1)
        .replace('lower="-2"', 'lower="9"', 1)
        .replace('izz="0.1"', 'izz="inf"', 1)
        .replace('child link="tool"', 'child link="tol"')
    )
    assert {fault.key for fault in faults_of(write(tmp_path, text))} == {
        "link.arm.inertial.mass",
        "link.arm.inertial.inertia.izz",
        "joint.q1.axis",
        "joint.q1.limit",
        "joint.mount.child",
    }


BOMB = '<!DOCTYPE robot [<!ENTITY a "ha">' + "".join(
    f'<!ENTITY {chr(98 + k)} "{f"&{chr(97 + k)};" * 10}">' for k in range(12)
)
LINK = '<link name="l{}"/>'
WHOLE = [
    ("", "an empty file", "a URDF"),
    (" \n", "an empty file", "a URDF"),
    ("hello", "not XML", "a URDF"),
    ("<robot><link name='a'>", "not XML", "a URDF"),
    ("<sdf/>", "<sdf>", "<robot>"),
    ("<robot/>", "no <link>", "at least one link"),
    (BOMB + "]><robot>&m;</robot>", "document type", "without DTD"),
    ('<!DOCTYPE r SYSTEM "file:///etc/passwd"><robot/>', "document type", "without DTD"),
    ((BOMB + "]><robot>&m;</robot>").encode("utf-16"), "not XML", "a URDF"),
    ('<!DOCTYPE r SYSTEM "a.dtd"><robot/>'.encode("utf-16"), "document type", "without DTD"),
    ("<robot>&undefined;</robot>", "not XML", "a URDF"),
    ("<robot " + " ".join(f'a{k}="b"' for k in range(400_000)) + "/>", "400000 attributes", "at most 100"),
    ("<robot>" + "<a>" * 5000 + "</a>" * 5000 + "</robot>", "not XML", "a URDF"),
    ("<robot>" + "<a/>" * 200_000 + "</robot>", "elements", "at most"),
    ("<robot>" + " " * 10_000_001, "more than 10 MB", "at most 10 MB"),
    ('<robot xmlns:xacro="http://x"><xacro:include filename="a"/></robot>', "xacro", "expand it first"),
    ('<robot><link name="${prefix}arm"/></robot>', "xacro", "expand it first"),
    ('<robot><link name="a"><mesh filename="$(find x)/a.stl"/></link></robot>', "xacro", "expand it first"),
    (f"<robot>{''.join(map(LINK.format, range(1001)))}</robot>", "1001 links", "at most 1000"),
    (b"<robot name='\xff'/>", "not XML", "a URDF"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "found", "allowed"), WHOLE, ids=lambda value: str(value)[:25])
def test_files_that_are_no_urdf(tmp_path, text, found, allowed):
    path = write(tmp_path, text)
    (fault,) = faults_of(path)
    assert fault.file == str(path)
    assert found in fault.found
    assert allowed in fault.allowed


def test_too_many_movable_joints(tmp_path):
    links = "".join(f'<link name="l{k}"/>' for k in range(102))
    joints = "".join(
        f'<joint name="q{k}" type="continuous"><parent link="l{k}"/><child link="l{k + 1}"/></joint>'
        for k in range(101)
    )
    (fault,) = faults_of(write(tmp_path, f"<robot>{links}{joints}</robot>"))
    assert fault.found == "101 movable joints"


def test_a_loop_beside_the_tree(tmp_path, urdf_text):
    ring = '<link name="a"/><link name="b"/>' + "".join(
        f'<joint name="{name}" type="fixed"><parent link="{name[0]}"/><child link="{name[1]}"/></joint>'
        for name in ("ab", "ba")
    )
    (fault,) = faults_of(write(tmp_path, urdf_text.replace("</robot>", ring + "</robot>")))
    assert "loop of links: " in fault.found


def test_what_is_no_regular_file(tmp_path, pipe):
    assert faults_of(tmp_path)[0].found == "a folder"
    assert faults_of(pipe)[0].found == "a pipe or device"
    assert faults_of(tmp_path / "gone.urdf")[0].found == "no such file"


def visual(address: str) -> str:
    return f'<link name="tool"><visual><geometry><mesh filename="{address}"/></geometry></visual></link>'


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("package://nobody/a.stl", "package nobody"),
        ("package://arm_description/../../../etc/passwd", "leaves its package"),
        ("package://arm_description/gone.stl", "no such file in the package"),
        ("gone.stl", "no such file"),
        ("https://example.org/a.stl", "not fetched"),
    ],
)
def test_missing_meshes_are_warnings(tmp_path, urdf_text, address, says):
    (tmp_path / "arm_description").mkdir()
    path = tmp_path / "arm_description" / "arm.urdf"
    path.write_text(urdf_text.replace('<link name="tool"/>', visual(address)))
    urdf = read_urdf(path)
    assert urdf.link_by_name["tool"].meshes == (address,)
    (warning,) = urdf.warnings
    assert address in warning
    assert says in warning


@pytest.mark.parametrize(
    "address", ["package://arm_description/meshes/a.stl", "meshes/a.stl", "file://{}/meshes/a.stl"]
)
def test_meshes_that_are_there(tmp_path, urdf_text, address):
    folder = tmp_path / "arm_description"
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "a.stl").write_text("solid")
    path = folder / "arm.urdf"
    path.write_text(urdf_text.replace('<link name="tool"/>', visual(address.format(folder))))
    assert read_urdf(path).warnings == ()


def test_a_joint_that_cannot_move_is_a_warning(tmp_path, urdf_text):
    text = urdf_text.replace('lower="-2" upper="2"', "", 1)
    assert "q1 cannot move" in read_urdf(write(tmp_path, text)).warnings[0]

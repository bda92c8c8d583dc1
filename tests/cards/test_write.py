"""Cards and URDFs written: every double as it was, what is not touched untouched, nothing unsound on disk."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from flexmodal.cards import FrozenDict, JointCard, PointCard, UrdfJoint, read_card, read_urdf, shipped_cards
from flexmodal.cards.write import UrdfDraft, write_robot
from flexmodal.errors import InvalidCard, InvalidUrdf, OutputExists

OWN = """
  <!-- the maker's licence -->
  <transmission name="t1"><type>SimpleTransmission</type><joint name="shoulder"/></transmission>
  <gazebo reference="arm"><mu1>0.2</mu1></gazebo>
  <material name="grey"><color rgba="0.1 0.2 0.3 1"/></material>
  <nobody:knows xmlns:nobody="urn:nobody">this</nobody:knows>
"""


@pytest.fixture
def urdf(tmp_path, urdf_text):
    text = urdf_text.replace("</robot>", f"{OWN}</robot>")
    path = tmp_path / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    return read_urdf(path)


def doubles(count, seed=0):
    """Numbers that need all their digits, of every size that a URDF may have."""
    random = np.random.default_rng(seed)
    return random.uniform(-1, 1, count) * 10.0 ** random.integers(-12, 5, count)


def sound(seed=0):
    """An inertia that a body can have, about no axis in particular."""
    spread = np.random.default_rng(seed).normal(size=(3, 3))
    spread = spread @ spread.T
    return np.trace(spread) * np.eye(3) - spread


def test_every_double_comes_back(urdf, tmp_path):
    draft = UrdfDraft(urdf)
    tip = urdf.links[-1].name
    for number in range(20):
        mass, *centre = np.abs(doubles(4, number))
        xyz, rpy, axis = doubles(3, number + 100), doubles(3, number + 200) / 1e6, doubles(3, number + 300)
        axis = axis / np.linalg.norm(axis)
        draft.add_link(f"new_{number}")
        draft.set_body(f"new_{number}", mass, np.array(centre), sound(number))
        draft.add_joint(
            UrdfJoint(f"j_{number}", "revolute", tip, f"new_{number}", axis, xyz, rpy, -0.1, 1 / 3, 1e3)
        )
        tip = f"new_{number}"
    draft.write(tmp_path / "new.urdf")
    found = read_urdf(tmp_path / "new.urdf")
    for number in range(20):
        link, joint = found.link_by_name[f"new_{number}"], found.joint_by_name[f"j_{number}"]
        mass, *centre = np.abs(doubles(4, number))
        assert link.mass == mass
        np.testing.assert_array_equal(link.com, centre)
        np.testing.assert_array_equal(link.inertia, (sound(number) + sound(number).T) / 2)
        np.testing.assert_array_equal(joint.xyz, doubles(3, number + 100))
        np.testing.assert_array_equal(joint.rpy, doubles(3, number + 200) / 1e6)
        assert (joint.lower, joint.upper, joint.velocity) == (-0.1, 1 / 3, 1e3)


@pytest.mark.parametrize("pitch", [np.pi / 2, 1.5707963, 1.5708, -np.pi / 2 + 1e-9])
def test_angles_survive_a_pitch_of_90_degrees(urdf, tmp_path, pitch):
    """Out of a matrix, roll and yaw would come back mixed, or half a turn off."""
    rpy = np.array([0.1, pitch, 0.7])
    draft = UrdfDraft(urdf)
    draft.add_link("new")
    draft.add_joint(
        UrdfJoint("j", "fixed", urdf.root, "new", np.array([1.0, 0, 0]), np.zeros(3), rpy, 0.0, 0.0, None)
    )
    draft.write(tmp_path / "new.urdf")
    np.testing.assert_array_equal(read_urdf(tmp_path / "new.urdf").joint_by_name["j"].rpy, rpy)


def test_what_is_not_touched_stays(urdf, tmp_path):
    draft = UrdfDraft(urdf)
    draft.set_body("arm", 1 / 3, np.zeros(3), np.eye(3))
    draft.write(tmp_path / "new.urdf")
    old, new = (etree.fromstring(one.text) for one in (urdf, read_urdf(tmp_path / "new.urdf")))

    def content(element):
        """Everything of an element but the spaces between its children."""
        texts = [(text or "").strip() for text in (element.text, element.tail)]
        return element.tag, dict(element.attrib), texts, [content(child) for child in element]

    for one in (old, new):
        for inertial in one.xpath("link[@name='arm']/inertial"):
            inertial.getparent().remove(inertial)
    assert content(new) == content(old)
    assert "the maker's licence" in (tmp_path / "new.urdf").read_text(encoding="utf-8")


def test_a_joint_in_between(urdf, tmp_path):
    """As a drive is put in: the new joint takes place and turn of the old one, which then sits on it."""
    old = next(joint for joint in urdf.joints if joint.movable)
    draft = UrdfDraft(urdf)
    draft.add_link("rotor")
    draft.set_body("rotor", 1e-9, np.zeros(3), 1e-11 * np.eye(3))
    draft.add_joint(replace(old, name="motor", child="rotor"), before=old.name)
    draft.change_joint(old.name, parent="rotor", xyz=np.zeros(3), rpy=np.zeros(3))
    draft.write(tmp_path / "new.urdf")
    found = read_urdf(tmp_path / "new.urdf")
    names = [joint.name for joint in found.joints]
    assert names.index("motor") == names.index(old.name) - 1
    np.testing.assert_array_equal(found.joint_by_name["motor"].xyz, old.xyz)
    assert found.joint_by_name[old.name].parent == "rotor"
    assert not found.joint_by_name[old.name].xyz.any()


@pytest.mark.parametrize(
    ("mass", "inertia", "key"),
    [
        (float("nan"), np.eye(3), "inertial.mass"),
        (float("inf"), np.eye(3), "inertial.mass"),
        (-1.0, np.eye(3), "inertial.mass"),
        (1.0, np.diag([1.0, 1.0, 3.0]), "inertial.inertia"),
        (
            1.0,
            np.eye(3) + np.triu(np.ones((3, 3)), 1) * 1e-3,
            "inertial",
        ),  # not symmetric: half would be lost
    ],
)
def test_nothing_unsound_is_written(urdf, tmp_path, mass, inertia, key):
    draft = UrdfDraft(urdf)
    draft.set_body("arm", mass, np.zeros(3), inertia)
    with pytest.raises(InvalidUrdf, match=f"link.arm.{key}"):
        draft.write(tmp_path / "new.urdf")
    assert not (tmp_path / "new.urdf").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["arm.urdf"]


def test_a_name_twice_is_refused(urdf, tmp_path):
    draft = UrdfDraft(urdf)
    draft.add_link("arm")
    with pytest.raises(InvalidUrdf, match="different names"):
        draft.write(tmp_path / "new.urdf")


def test_meshes_are_found_from_the_new_place(tmp_path, urdf_text):
    """Beside the old file by a relative address; packages and files elsewhere as they were."""
    (tmp_path / "old" / "meshes").mkdir(parents=True)
    (tmp_path / "old" / "meshes" / "part.stl").write_bytes(b"solid")
    addresses = ("meshes/part.stl", "package://arms/part.stl", "/no/where.stl")
    shapes = "".join(f'<visual><geometry><mesh filename="{one}"/></geometry></visual>' for one in addresses)
    path = tmp_path / "old" / "arm.urdf"
    path.write_text(urdf_text.replace('<link name="tool"/>', f'<link name="tool">{shapes}</link>'))
    (tmp_path / "new").mkdir()
    draft = UrdfDraft(read_urdf(path))
    draft.write(tmp_path / "new" / "arm.urdf", home=tmp_path / "a" / "far")
    meshes = read_urdf(tmp_path / "new" / "arm.urdf").link_by_name["tool"].meshes
    assert meshes == ("../../old/meshes/part.stl", *addresses[1:])
    draft = UrdfDraft(read_urdf(path))
    draft.drop_meshes()
    draft.write(tmp_path / "new" / "bare.urdf")
    assert read_urdf(tmp_path / "new" / "bare.urdf").link_by_name["tool"].meshes == addresses[1:2]


@pytest.mark.parametrize("name", sorted(shipped_cards()))
def test_every_shipped_card_comes_back(name, tmp_path):
    card = read_card(shipped_cards()[name])
    urdf = read_urdf(card.urdf)
    moved = replace(card, path=tmp_path / "robot.toml", urdf=tmp_path / "arm.urdf")
    write_robot(moved, UrdfDraft(urdf), notes=["a note\nof two lines"])
    assert read_card(tmp_path / "robot.toml") == moved
    found = read_urdf(tmp_path / "arm.urdf")
    assert [link.name for link in found.links] == [link.name for link in urdf.links]
    for one, other in zip(found.joints, urdf.joints, strict=True):
        np.testing.assert_array_equal(one.xyz, other.xyz)
    assert (tmp_path / "robot.toml").read_text(encoding="utf-8").startswith("# a note of two lines\n")


@pytest.fixture
def card(tmp_path):
    found = read_card(shipped_cards()["fanuc_s360"])
    folder = tmp_path / "robot"
    folder.mkdir()
    return replace(found, path=folder / "robot.toml", urdf=folder / "arm.urdf"), UrdfDraft(
        read_urdf(found.urdf)
    )


def test_everything_a_card_can_say_comes_back(card):
    one, urdf = card
    joints = {
        name: JointCard(1 / 3 + k, 0.1, False, 0.1, 0.5, 2.0, 0.3, 0.05) for k, name in enumerate(one.joints)
    }
    points = {"tip": PointCard(one.tool, (0.1, -1 / 3, 1e-17))}
    full = replace(
        one,
        title='"quoted" \\ title',
        joints=FrozenDict(joints),
        points=FrozenDict(points),
        loss_frequency=1 / 7,
    )
    assert read_card(write_robot(full, urdf)) == full


def test_nothing_is_written_over_unasked(card):
    one, urdf = card
    one.urdf.write_text("mine", encoding="utf-8")
    with pytest.raises(OutputExists, match="--force"):
        write_robot(one, urdf)
    assert one.urdf.read_text(encoding="utf-8") == "mine"
    assert not Path(one.path).exists()
    write_robot(one, urdf, overwrite=True)
    assert read_card(one.path) == one


@pytest.mark.parametrize(("key", "value"), [("stiffness", float("nan")), ("damping", -1.0)])
def test_a_card_that_is_not_sound_is_not_written(card, key, value):
    one, urdf = card
    name = next(iter(one.joints))
    wrong = replace(one, joints=FrozenDict({**one.joints, name: replace(one.joints[name], **{key: value})}))
    with pytest.raises(InvalidCard, match=f"joint.{name}.{key}"):
        write_robot(wrong, urdf)
    assert not one.path.exists()

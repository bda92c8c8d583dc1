import logging
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from lxml import etree

from flexmodal.cards import (
    check_consistency,
    check_masses,
    example_arms,
    gripper_joints,
    read_card,
    read_urdf,
    shipped_cards,
)

CARDS = shipped_cards()


@pytest.fixture(params=sorted(CARDS))
def name(request: pytest.FixtureRequest) -> str:
    return request.param


def test_the_five_cards_ship():
    planar = {"fanuc_s360", "fanuc_s360_rigid_link", "fanuc_s360_table_2_8", "six_link"}
    assert set(CARDS) >= planar | {"six_axis"}


def test_card_belongs_to_its_urdf(name):
    card = read_card(CARDS[name])
    urdf = read_urdf(card.urdf)
    check_consistency(card, urdf)
    assert urdf.warnings == ()
    assert card.name == urdf.name == name


def test_source_and_licence_are_stated(name):
    card = read_card(CARDS[name])
    made_up = "Made up for flexmodal; no arm that anybody built or measured"
    assert (made_up if name == "six_axis" else "thesis, University of Waterloo") in card.source
    header = card.urdf.read_text(encoding="utf-8").split("<robot")[0]
    assert "Source: " in header
    assert "Licence: " in header


def test_urdf_loads_in_pinocchio(name):
    card = read_card(CARDS[name])
    urdf = read_urdf(card.urdf)
    model = pin.buildModelFromXML(urdf.text)
    assert tuple(model.names)[1:] == urdf.movable_joints
    for link in urdf.links:
        assert model.existFrame(link.name, pin.FrameType.BODY)
    assert set(card.joints) == set(urdf.movable_joints)
    shapes = pin.buildGeomFromUrdfString(model, urdf.text, pin.GeometryType.VISUAL)
    assert shapes.ngeoms >= 2 * len(urdf.movable_joints)


def test_inertias_agree_with_pinocchio(name):
    urdf = read_urdf(read_card(CARDS[name]).urdf)
    model = pin.buildModelFromXML(urdf.text)
    for joint in urdf.joints:
        if joint.movable:
            link, body = urdf.link_by_name[joint.child], model.inertias[model.getJointId(joint.name)]
            assert body.mass == link.mass
            np.testing.assert_allclose(body.lever, link.com, atol=1e-12)
            np.testing.assert_allclose(body.inertia, link.inertia, rtol=1e-12, atol=1e-12)


def test_urdf_loads_in_yourdfpy(name, caplog):
    caplog.set_level(logging.WARNING)
    robot = yourdfpy.URDF.load(str(read_card(CARDS[name]).urdf), load_meshes=False)
    assert robot.validate()
    assert not caplog.records
    assert robot.actuated_joint_names == list(read_urdf(read_card(CARDS[name]).urdf).movable_joints)


def test_every_moving_link_can_be_seen(name):
    tree = etree.parse(read_card(CARDS[name]).urdf)
    colours = {material.get("name") for material in tree.findall("material")}
    for link in tree.findall("link"):
        materials = link.findall("visual/material")
        assert materials, link.get("name")
        assert {material.get("name") for material in materials} <= colours


def test_cards_are_plain_text(name):
    for path in (CARDS[name], read_card(CARDS[name]).urdf):
        text = path.read_text(encoding="utf-8")
        assert "\t" not in text
        assert text.endswith("\n")
        assert max(map(len, text.splitlines())) <= 120


ARMS = example_arms()


@pytest.mark.parametrize("arm", sorted(ARMS))
def test_example_arms_are_sound(arm):
    urdf = read_urdf(ARMS[arm], fixed=gripper_joints(ARMS[arm]))
    assert urdf.warnings == ()
    check_masses(urdf, urdf.movable_joints)
    carriers = [joint.parent for joint in urdf.joints if joint.movable]
    model = pin.buildModelFromXML(urdf.text)
    assert set(model.names) - {"universe"} == set(urdf.movable_joints)
    assert len(carriers) == model.njoints - 1
    for joint in urdf.joints:
        if joint.movable:
            assert model.existFrame(joint.child, pin.FrameType.BODY)


def test_example_arms_are_there():
    assert {"ur3", "ur5", "ur10", "kinova", "xarm7", "z1", "so100", "so101"} <= set(ARMS)
    assert all(isinstance(path, Path) for path in ARMS.values())

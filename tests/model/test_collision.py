"""Distances against closed forms, derivatives against differences, which pairs are watched, bad cards."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmodal
from flexmodal.cards import ObstacleCard
from flexmodal.errors import InvalidCard, InvalidUrdf
from flexmodal.model.collision import scene_of
from flexmodal.model.guess import guess_card


@pytest.fixture(scope="module")
def ur5(tmp_path_factory):
    return flexmodal.load(guess_card("ur5", tmp_path_factory.mktemp("ur5")).write())


@pytest.fixture(scope="module")
def around(ur5):
    box = ObstacleCard(box=(0.2, 0.3, 0.4), xyz=(0.6, 0.3, 0.4), rpy=(0.3, 0.2, 0.5))
    return replace(ur5, obstacles={"box": box, "ball": ObstacleCard(sphere=0.1, xyz=(0.2, -0.5, 0.6))})


def _random(robot, generator):
    return {n: generator.uniform(max(j.lower, -3), min(j.upper, 3)) for n, j in robot.commanded.items()}


def test_a_ball_carried_by_the_tool_against_boxes(tmp_path):
    """The distance of a point to a box has a closed form, in and out of it."""
    robot = flexmodal.load("six_axis")
    size, place, turn = np.array([0.4, 0.6, 0.3]), np.array([1.1, 0.2, 1.3]), (0.3, -0.2, 0.7)
    obstacles = {
        "block": ObstacleCard(box=tuple(size), xyz=tuple(place), rpy=turn),
        "ball": ObstacleCard(sphere=0.05, xyz=(0.02, 0.0, 0.01), link="tool"),
    }
    robot = replace(robot, obstacles=obstacles)
    scene = scene_of(robot)
    assert scene.pairs == (("block", "ball"),)
    generator, signs = np.random.default_rng(4), set()
    for _ in range(300):
        posed = robot.at(_random(robot, generator))
        centre = posed.position("tool") + posed.rotation("tool") @ [0.02, 0.0, 0.01]
        local = np.abs(Rotation.from_euler("xyz", turn).as_matrix().T @ (centre - place)) - size / 2
        wanted = np.linalg.norm(np.maximum(local, 0)) + min(np.max(local), 0.0) - 0.05
        found, names = scene.nearest(posed)
        signs.add(np.sign(wanted))
        assert names == ("block", "ball")
        assert found == pytest.approx(wanted, abs=1e-6)
    assert 1.0 in signs


def test_derivatives_by_differences(around):
    scene, generator, step = scene_of(around), np.random.default_rng(1), 1e-5
    names, good = list(around.commanded), []
    for _ in range(12):
        values = _random(around, generator)
        near = scene.within(around.at(values), 0.3)
        if not len(near.distance):
            continue
        slopes = np.empty_like(near.gradient)
        for column, name in enumerate(names):
            ends = []
            for sign in (1, -1):
                moved = values | {name: values[name] + sign * step}
                whole = dict(zip(scene.pairs, scene.distances(around.at(moved)), strict=True))
                ends.append([whole[pair] for pair in near.names])
            slopes[:, column] = (np.array(ends[0]) - np.array(ends[1])) / (2 * step)
        good += np.all(np.abs(slopes - near.gradient) < 1e-3, axis=1).tolist()
    assert len(good) > 20
    assert np.mean(good) > 0.95  # the nearest points of two hulls jump from face to face here and there


def test_neighbours_and_bodies_are_not_watched(around):
    watched = {frozenset(pair) for pair in scene_of(around).pairs}
    for one, other in (("upper_arm_link", "forearm_link"), ("wrist_3_link", "ee_link"), ("base_link", "box")):
        assert frozenset((one, other)) not in watched
    for one, other in (("upper_arm_link", "wrist_1_link"), ("forearm_link", "box"), ("ee_link", "ball")):
        assert frozenset((one, other)) in watched


def test_what_always_touches_is_left_out_and_told(ur5):
    stump = ObstacleCard(cylinder=(0.3, 0.5), xyz=(0.0, 0.0, 0.1))
    scene = scene_of(replace(ur5, obstacles={"stump": stump}))
    assert ("shoulder_link", "stump") in scene.left_out
    assert ("shoulder_link", "stump") not in scene.pairs


def test_an_srdf_says_which_links_may_touch(ur5, tmp_path):
    path = tmp_path / "ur5.srdf"
    pair = '<disable_collisions link1="upper_arm_link" link2="wrist_1_link" reason="Never"/>'
    path.write_text(f'<robot name="ur5">{pair}</robot>')
    pairs = {frozenset(pair) for pair in scene_of(replace(ur5, srdf=path)).pairs}
    assert frozenset(("upper_arm_link", "wrist_1_link")) not in pairs
    assert frozenset(("upper_arm_link", "wrist_2_link")) in pairs


def test_nothing_to_meet_is_no_scene():
    assert scene_of(flexmodal.load("six_axis")) is None


def test_a_mesh_is_taken_by_its_hull(ur5, tmp_path):
    import trimesh

    path = tmp_path / "block.stl"
    trimesh.creation.box((0.2, 0.3, 0.4)).export(path)
    place = {"xyz": (0.5, 0.2, 0.3), "rpy": (0.1, 0.0, 0.3)}
    posed = ur5.at("bent")
    found = [
        scene_of(replace(ur5, obstacles={"block": shape})).distances(posed)
        for shape in (ObstacleCard(mesh=path, **place), ObstacleCard(box=(0.2, 0.3, 0.4), **place))
    ]
    assert found[0] == pytest.approx(found[1], abs=1e-5)


def test_collision_meshes_that_are_missing(ur5, tmp_path):
    text = ur5.urdf.path.read_text().replace("meshes/ur5/collision/base.stl", "meshes/none.stl")
    text = text.replace("meshes/ur5/collision/base.dae", "meshes/none.stl")
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    with pytest.raises(InvalidUrdf, match="collision shape"):
        scene_of(flexmodal.load(path, stiffness=1e4))


CASES = {
    "box = [1.0, 2.0]": "obstacle.table.box",
    "box = [1.0, -2.0, 3.0]": "obstacle.table.box",
    "": "one of box, sphere, cylinder and mesh",
    "sphere = 0.1\nbox = [1.0, 1.0, 1.0]": "sphere",
    'mesh = "none.stl"': "where no file is",
    'sphere = 0.1\nlink = "nowhere"': "a link that the URDF does not have",
    "sphere = 0.1\nxyz = [0.0, 0.0]": "obstacle.table.xyz",
    'sphere = 0.1\ncolour = "red"': "colour",
}


@pytest.mark.parametrize("text", CASES)
def test_bad_obstacles_are_named(ur5, tmp_path, text):
    card = ur5.path.read_text().replace('urdf = "ur5.urdf"', f'urdf = "{ur5.urdf.path}"')
    path = tmp_path / "robot.toml"
    path.write_text(f"{card}\n[obstacle.table]\n{text}\n")
    with pytest.raises(InvalidCard) as error:
        flexmodal.load(path)
    assert CASES[text] in str(error.value)
    assert "obstacle.table" in str(error.value)


def test_a_card_with_obstacles_is_written_and_read_again(ur5, tmp_path):
    from flexmodal.cards import read_card
    from flexmodal.cards.write import UrdfDraft, write_robot
    from flexmodal.model.written import card_of

    srdf = tmp_path / "ur5.srdf"
    srdf.write_text('<robot name="ur5"/>')
    obstacles = {
        "box": ObstacleCard(box=(0.2, 0.3, 0.4), xyz=(0.6, 0.3, 0.4)),
        "ball": ObstacleCard(sphere=0.1),
    }
    robot = replace(ur5, obstacles=obstacles, srdf=srdf)
    (tmp_path / "out").mkdir()
    path = write_robot(card_of(robot, tmp_path / "out", source="made up"), UrdfDraft(ur5.urdf))
    found = read_card(path)
    assert dict(found.obstacles) == obstacles
    assert found.srdf == srdf

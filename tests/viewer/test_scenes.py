"""What is in a scene, and whether it stands where it should."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from flexmodal_viewer import live_scene, outcome_scene, robot_scene
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.commands import payload
from flexmodal_viewer.meshfile import load_mesh
from flexmodal_viewer.shapes import Box, Cylinder, Mesh, Sphere
from flexmodal_viewer.visuals import read_looks

from flexmodal.cards import read_urdf
from flexmodal.errors import InvalidFrequencies, InvalidPoint
from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.model.guess import guess_card
from flexmodal.model.placements import link_placements
from flexmodal.optimisation import (
    CombinedObjective,
    Optimum,
    Outcome,
    PostureProblem,
    ReceptanceObjective,
    RobustObjective,
    SeparationObjective,
    StiffnessObjective,
    TunedObjective,
    sample_robots,
)


def groups(scene):
    return {item.path.split("/")[0] for item in scene.items}


def words(scene):
    tables = [*scene.caption.tables, *(motion.table for motion in scene.motions if motion.table)]
    return "\n".join(
        [scene.caption.title, scene.caption.subtitle, *scene.caption.notes]
        + [swatch.text for swatch in scene.caption.legend]
        + [text for table in tables for row in table.rows for text in (table.heading, *row)]
    )


def place(scene, path):
    matrix = scene.nodes.get(path.rsplit("/", 1)[0], np.eye(4))
    (item,) = (item for item in scene.items if item.path == path)
    return matrix @ item.place


def test_parts_stand_where_the_urdf_says(fanuc):
    scene = robot_scene(fanuc, fanuc.posture("configuration_1"))
    arm = Arm(fanuc)
    forearm = [
        item for item in scene.items if item.path.startswith(arm.node("arm", "link_2_outer") + "/part")
    ]
    assert [type(item.shape) for item in forearm] == [Cylinder, Box]
    assert forearm[1].shape == Box((0.78, 0.112, 0.14))
    # The forearm is level in this posture; its middle is 0.29 + 0.39 m past the elbow.
    q1 = 0.8726646259971648
    expected = [0.85 * np.cos(q1) + 0.68, 0, 0.85 * np.sin(q1)]
    np.testing.assert_allclose(place(scene, forearm[1].path)[:3, 3], expected, atol=1e-12)


def test_own_colours_are_kept(fanuc):
    scene = robot_scene(fanuc, fanuc.posture("configuration_1"))
    (box,) = [item for item in scene.items if item.shape == Box((0.78, 0.112, 0.14))]
    assert box.colour == (0.78, 0.66, 0.44)  # "sand", named in the URDF


AROUND = """
[obstacle.table]
box = [0.8, 0.8, 0.1]
xyz = [0.0, 0.0, -0.2]
rpy = [0.0, 0.0, 0.5]
[obstacle.spindle]
cylinder = [0.02, 0.2]
xyz = [0.05, 0.0, 0.0]
link = "tool0"
[obstacle.stone]
mesh = "stone.stl"
scale = 0.001
[obstacle.ghost]
mesh = "ghost.3ds"
"""


@pytest.fixture
def beside_a_table(tmp_path):
    """A UR5 with a card, obstacles around it and one in its hand, seen by collision checks too."""
    path = guess_card("ur5", tmp_path / "arm").write()
    trimesh.creation.box((100, 200, 300)).export(path.parent / "stone.stl")
    (path.parent / "ghost.3ds").write_bytes(b"none")
    path.write_text(path.read_text(encoding="utf-8") + AROUND, encoding="utf-8")
    return load(path)


@pytest.mark.parametrize("draw", [robot_scene, live_scene])
def test_obstacles_stand_where_the_card_says(beside_a_table, draw):
    robot = beside_a_table
    posture = robot.posture("middle")
    scene = draw(robot, posture)
    shown = {item.path.rsplit("obstacle_", 1)[1]: item for item in scene.items if "/obstacle_" in item.path}
    table, spindle, stone = (shown[name] for name in ("0_0", "1_0", "2_0"))
    assert (table.shape, spindle.shape) == (Box((0.8, 0.8, 0.1)), Cylinder(0.02, 0.2))
    np.testing.assert_allclose(np.ptp(stone.shape.corners, axis=0), [0.1, 0.2, 0.3], atol=1e-9)
    np.testing.assert_allclose(place(scene, table.path)[:3, 3], [0, 0, -0.2], atol=1e-12)
    # A corner of the table, turned by half a radian about z.
    corner = place(scene, table.path) @ [0.4, 0.4, 0.05, 1.0]
    expected = [0.4 * (np.cos(0.5) - np.sin(0.5)), 0.4 * (np.sin(0.5) + np.cos(0.5)), -0.15]
    np.testing.assert_allclose(corner[:3], expected, atol=1e-12)
    hand = link_placements(robot, posture.values)["tool0"] @ [0.05, 0.0, 0.0, 1.0]
    np.testing.assert_allclose(place(scene, spindle.path)[:3, 3], hand[:3], atol=1e-12)
    assert {label.text for label in scene.labels} >= {"table", "spindle", "stone"}
    assert "obstacles" in words(scene)
    assert "Obstacle ghost is not shown: mesh ghost.3ds, a mesh of the kind .3ds" in words(scene)


def test_a_scene_without_obstacles_speaks_of_none(fanuc):
    assert "obstacle" not in words(robot_scene(fanuc, fanuc.posture("configuration_1")))


def test_measurement_points_ride_on_their_links(fanuc):
    posture = fanuc.posture("configuration_1")
    scene = robot_scene(fanuc, posture)
    dots = [item for item in scene.items if isinstance(item.shape, Sphere) and "/point_" in item.path]
    assert len(dots) == len(fanuc.points) == 6
    for name, dot in zip(fanuc.points, dots, strict=True):
        np.testing.assert_allclose(
            place(scene, dot.path)[:3, 3], fanuc.at(posture).position(name), atol=1e-12
        )
    assert [label.text for label in scene.labels if label.kind == "point"] == list(fanuc.points)


def test_a_plain_robot_has_no_motion(fanuc):
    scene = robot_scene(fanuc, fanuc.posture("configuration_1"))
    assert scene.motions == ()
    assert not groups(scene) & {"rest", "extreme", "force_0", "target"}


def test_planar_arm_is_seen_from_the_side(fanuc):
    view = robot_scene(fanuc, fanuc.posture("configuration_1")).view
    assert view.flat
    assert view.look == (0, 1, 0)  # y into the screen, so x to the right and z up


def test_force_arrow_points_along_the_force(fanuc):
    posture = fanuc.posture("configuration_1")
    scene = robot_scene(fanuc, posture, response="tool:-x", frequency=9.0)
    np.testing.assert_allclose(scene.nodes["force_0"][:3, 2], [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(scene.nodes["force_0"][:3, 3], fanuc.at(posture).position("tool"), atol=1e-12)
    head, shaft = place(scene, "force_0/head"), place(scene, "force_0/shaft")
    assert head[0, 3] < shaft[0, 3]


def test_moment_is_a_bent_arrow(fanuc):
    scene = robot_scene(fanuc, fanuc.posture("configuration_1"), response="tool:+ry", frequency=9.0)
    assert any(item.path == "force_0/ring" for item in scene.items)
    assert "rad/(N·m)" in words(scene)


def test_deflection_is_the_response_scaled(fanuc):
    posture = fanuc.posture("configuration_1")
    scene = robot_scene(fanuc, posture, frequency=9.0)
    (motion,) = scene.motions
    arm = Arm(fanuc)
    path = motion.tracks[arm.node("arm", "tool")][:, :3, 3] - fanuc.at(posture).position("tool")
    size = np.linalg.norm(path, axis=1)
    # A tenth of the reach of 2.15 m; rotations of some 0.1 rad are not quite linear.
    assert size.max() == pytest.approx(0.215, rel=0.05)
    # First harmonic of z over the cycle against the receptance, same phase and the stated factor.
    value = fanuc.frf(posture, [9.0], response="tool:+z").value[0, 0, 0]
    phases = 2 * np.pi * np.arange(len(path) - 1) / (len(path) - 1)
    harmonic = 2 * np.mean(path[:-1, 2] * np.exp(-1j * phases))
    factor = 0.215 / motion_farthest(fanuc, posture)
    assert abs(harmonic / (factor * value) - 1) < 0.02
    assert f"× {factor:.4g}" in words(scene)
    np.testing.assert_allclose(path[0], path[-1], atol=1e-12)


def motion_farthest(robot, posture):
    values = robot.frf(posture, [9.0], response=["tool:+x", "tool:+z"]).value[0, :, 1]
    swing = np.exp(2j * np.pi * np.linspace(0, 1, 20001))
    return np.max(np.linalg.norm((values[:, None] * swing).real, axis=0))


def test_extreme_is_where_the_tool_is_farthest(fanuc):
    posture = fanuc.posture("configuration_1")
    (motion,) = robot_scene(fanuc, posture, frequency=20.0).motions
    arm = Arm(fanuc)
    rest = fanuc.at(posture).position("tool")
    ghost = np.linalg.norm(motion.poses[arm.node("extreme", "tool")][:3, 3] - rest)
    path = np.linalg.norm(motion.tracks[arm.node("arm", "tool")][:, :3, 3] - rest, axis=1)
    assert ghost >= path.max() * 0.98  # the rotations are finite, so only nearly


def test_pseudo_joint_bends_its_link(fanuc):
    scene = robot_scene(fanuc, fanuc.posture("configuration_1"), modes=True)
    arm = Arm(fanuc)
    inner, outer = arm.node("arm", "link_2"), arm.node("arm", "link_2_outer")
    bends = [
        np.max(np.abs(motion.tracks[inner][:, :3, 0] - motion.tracks[outer][:, :3, 0]))
        for motion in scene.motions
    ]
    assert max(bends) > 0.05  # the two halves of the forearm are no longer in line


def test_each_mode_is_labelled(fanuc):
    posture = fanuc.posture("configuration_1")
    modes = fanuc.modes(posture)
    scene = robot_scene(fanuc, posture, modes=True)
    assert len(scene.motions) == len(modes.pole)
    for motion, frequency, ratio in zip(scene.motions, modes.frequency, modes.damping_ratio, strict=True):
        assert f"{frequency:.4g} Hz" in motion.name
        assert f"{100 * ratio:.3g} %" in motion.name


def test_overdamped_modes_say_so(six_link):
    scene = robot_scene(six_link, six_link.posture("start_1"), modes=True)
    modes = six_link.modes("start_1")
    said = [any("Overdamped" in note for note in motion.notes) for motion in scene.motions]
    assert said == list(modes.overdamped)


def test_a_mode_that_only_turns_the_tool_stays_in_bounds(bare):
    # The only joint's axis runs through the tool when the arm has no length: the tool cannot move.
    robot = bare()
    flat = robot_scene(robot, robot.posture({}), modes=True)
    for track in flat.motions[0].tracks.values():
        assert np.all(np.abs(track) < 2)


def test_outcome_shows_both_postures_target_and_direction(outcome, six_link):
    start = six_link.posture("start_3")
    scene = outcome_scene(outcome, start=start)
    assert {"optimised", "start", "target", "force_0"} <= groups(scene)
    arm = Arm(six_link)
    for group, posture in (("start", start), ("optimised", outcome.best.posture)):
        np.testing.assert_allclose(
            scene.nodes[arm.node(group, "tool")][:3, 3], six_link.at(posture).position("tool"), atol=1e-12
        )
    np.testing.assert_allclose(scene.nodes["target"][:3, 3], outcome.tool, atol=1e-12)
    clear = {item.opacity for item in scene.items if item.path.startswith("start/")}
    solid = {item.opacity for item in scene.items if item.path.startswith("optimised/")}
    assert max(clear) < 0.6
    assert solid == {1.0}
    text = words(scene)
    assert "1.299 mm/N" in text  # the objective before, with its unit
    assert "258.4 nm/N" in text
    assert "178.2°" in text  # q5 of the optimised posture
    assert "2 Hz" in text


def test_outcome_moves_both_arms_by_one_factor(outcome, six_link):
    start = six_link.posture("start_3")
    (motion,) = outcome_scene(outcome, start=start).motions
    arm = Arm(six_link)

    def swing(group):
        path = motion.tracks[arm.node(group, "tool")][:, :3, 3]
        return np.max(np.linalg.norm(path - path.mean(axis=0), axis=1))

    def farthest(posture):
        values = six_link.frf(posture, [2.0], response=["tool:+x", "tool:+z"]).value[0, :, 1]
        return np.linalg.norm(values)

    ratio = farthest(start) / farthest(outcome.best.posture)
    assert swing("start") / swing("optimised") == pytest.approx(ratio, rel=0.1)  # finite rotations


def test_outcome_without_start_or_frequency(outcome, six_link):
    objective = StiffnessObjective(PointDirection("tool", "z"))
    problem = PostureProblem(six_link, objective)
    best = outcome.best.posture
    plain = Outcome(problem, (Optimum(best, 1.5e6, 3),), None, True, 8, 0, "newton")
    scene = outcome_scene(plain, start=None)
    assert groups(scene) & {"start", "target"} == set()
    assert scene.motions == ()
    assert "1.5 MN/m" in words(scene)


def test_spatial_arm_gets_a_floor_and_axes():
    from flexmodal.model import load

    robot = load("ur5", stiffness=2e4, damping=20.0)
    scene = robot_scene(robot, robot.posture({}))
    assert not scene.view.flat
    assert any(item.path.startswith("axes/") for item in scene.items)
    assert sum(type(item.shape).__name__ == "Mesh" for item in scene.items) > 10
    # COLLADA meshes are in metres here: nothing of a UR5 is farther than its reach from the base.
    assert np.max(np.abs(scene.corners)) < 1.3


def test_bad_requests_are_refused(fanuc):
    posture = fanuc.posture("configuration_1")
    with pytest.raises(InvalidPoint):
        robot_scene(fanuc, posture, response="elbow:+z")
    with pytest.raises(InvalidFrequencies):
        robot_scene(fanuc, posture, frequency=-1.0)
    with pytest.raises(InvalidFrequencies):
        robot_scene(fanuc, posture, frequency=float("nan"))


def test_a_force_that_moves_nothing_says_so(fanuc):
    scene = robot_scene(fanuc, fanuc.posture("configuration_1"), response="tool:+y", frequency=9.0)
    assert any("moves nothing" in note for note in scene.motions[0].notes)


def test_static_deflection_at_zero_hertz(fanuc):
    (motion,) = robot_scene(fanuc, fanuc.posture("configuration_1"), frequency=0.0).motions
    assert motion.extreme == pytest.approx(0.5)  # in phase with the force; of both extremes the later


def test_arm_without_looks_is_drawn_as_sticks(bare):
    robot = bare()
    scene = robot_scene(robot, robot.posture({}))
    assert "sticks" in words(scene)
    assert any(isinstance(item.shape, Cylinder) for item in scene.items)


@pytest.mark.parametrize(
    "part",
    [
        '<visual><geometry><box size="1 nan 1"/></geometry></visual>',
        '<visual><geometry><sphere radius="-1"/></geometry></visual>',
        '<visual><geometry><cylinder radius="1e9" length="1"/></geometry></visual>',
        '<visual><geometry><capsule radius="1"/></geometry></visual>',
        '<visual><origin xyz="0 0 inf"/><geometry><sphere radius="1"/></geometry></visual>',
        "<visual/>",
    ],
)
def test_parts_that_cannot_be_shown_are_named(tmp_path, part):
    path = tmp_path / "odd.urdf"
    path.write_text(f'<robot name="odd"><link name="arm">{part}</link></robot>')
    looks = read_looks(read_urdf(path))
    assert looks.visuals == ()
    assert looks.notes[0].startswith("A part of arm is not shown: ")


Z, X = PointDirection("tool", "z"), PointDirection("tool", "x")
OTHERS = {
    "tuned": (lambda r: TunedObjective(Z, (0.5, 4.0)), "the best of 0.5 to 4 Hz", 1),
    "force": (
        lambda r: ReceptanceObjective((X, Z), np.array([5.0, 10.0]), "force", (1.0, 2.0)),
        "Receptance ‖αw‖ at tool:+x and tool:+z, 5 to 10 Hz",
        1,
    ),
    "robust": (
        lambda r: RobustObjective(ReceptanceObjective((Z,), np.array([5.0])), sample_robots(r, 3), "worst"),
        "Receptance |α| at tool:+z, 5 Hz, worst of 3 samples",
        1,
    ),
    "separation": (lambda r: SeparationObjective(5.0), "Distance from the poles, 5 Hz", 0),
    "poles apart": (lambda r: SeparationObjective(), "Distance from the poles", 0),
    "product": (
        lambda r: CombinedObjective((StiffnessObjective(Z), SeparationObjective(5.0))), "Objective", 0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", OTHERS)
def test_outcome_of_every_kind_of_objective(outcome, six_link, case):
    build, heading, motions = OTHERS[case]
    problem, best = PostureProblem(six_link, build(six_link)), outcome.best.posture
    value = problem.objective.value(six_link.at(best))
    first = replace(outcome.compared, objective=np.inf, held_objective=np.inf)
    found = replace(outcome, problem=problem, optima=(Optimum(best, value, 1),), compared=first)
    scene = outcome_scene(found, start=six_link.posture("start_3"))
    assert heading in words(scene)
    assert "infinite" in words(scene)  # as at the resonance of an undamped arm
    assert len(scene.motions) == motions
    json.dumps(payload(scene), allow_nan=False)


def test_payload_is_json_and_always_the_same(outcome, six_link):
    start = six_link.posture("start_3")
    texts = {json.dumps(payload(outcome_scene(outcome, start=start)), allow_nan=False) for _ in range(2)}
    assert len(texts) == 1
    data = json.loads(texts.pop())
    paths = [command["path"] for command in data["commands"]]
    assert len([path for path in paths if "/part_" in path]) == len(set(p for p in paths if "/part_" in p))
    drawn = {label["path"] for label in data["labels"]}
    assert all(path.startswith("/flexmodal/") for path in drawn)


@pytest.mark.slow
def test_meshes_of_several_arms_are_stored_once():
    from flexmodal.model import load

    robot = load("ur5", stiffness=2e4, damping=20.0)
    plain = payload(robot_scene(robot, robot.posture({})))
    modes = payload(robot_scene(robot, robot.posture({}), modes=True))
    meshes = [name for name, text in plain["arrays"].items() if len(text) > 2000]
    assert sum(map(len, modes["arrays"].values())) < 1.05 * sum(map(len, plain["arrays"].values()))
    assert set(meshes) <= set(modes["arrays"])


def test_arms_with_collada_meshes_are_drawn_whole():
    """Sixteen of the UR5's parts are COLLADA; without their reader it was a stick figure with notes."""
    looks = read_looks(load("ur5", stiffness=2e4).urdf)
    assert looks.notes == ()
    assert sum(isinstance(visual.shape, Mesh) for visual in looks.visuals) > 20


def test_a_missing_reader_is_named(monkeypatch, tmp_path):
    """A module set to None cannot be imported, as one that is not installed."""
    monkeypatch.setitem(sys.modules, "collada", None)
    path = tmp_path / "part.dae"
    path.write_text("<COLLADA/>")
    assert load_mesh(path) == "its reader is not installed: pip install pycollada"

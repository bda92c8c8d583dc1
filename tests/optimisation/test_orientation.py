"""Orientation held, tracks, and what is said when a hold cannot be kept."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmodal
from flexmodal.errors import InvalidRequest, SingularResponse, Unreachable
from flexmodal.frf import PointDirection
from flexmodal.optimisation import (
    Hold,
    PostureProblem,
    ReceptanceObjective,
    SeparationObjective,
    optimise,
)
from flexmodal.optimisation.hold.orientation import FixedOrientation, aligned

from ..model.writing import body, joint, planar, save
from .optimality import difference, gain_left


def problem(robot, hold, frequency=10.0):
    objective = ReceptanceObjective((PointDirection(robot.tool, "z"),), np.array([frequency]))
    return PostureProblem(robot, objective, hold)


HOLDS = {
    "roll, pitch, yaw": ("ur5", {"orientation": (3.0, 0.2, -0.5)}),
    "axis": ("ur5", {"axis": (0.1, -0.2, -1.0)}),
    "another axis": ("ur5", {"axis": (1.0, 0.0, 0.0), "tool_axis": "-y"}),
    "seven joints": ("xarm7", {"axis": (0.0, 0.0, -2.0)}),
    "angle in the plane": ("arm", {"orientation": (1.2,)}),
    "axis in the plane": ("arm", {"axis": (1.0, 0.0, 1.0), "tool_axis": "-x"}),
}


@pytest.mark.parametrize("case", HOLDS)
def test_jacobian_of_the_error(request, case):
    """Far from the target too, where the retraction needs it."""
    name, turned = HOLDS[case]
    robot = request.getfixturevalue(name)
    target = (0.4, 0.3) if robot.is_planar else (0.4, 0.2, 0.3)
    held, generator = problem(robot, Hold.at(robot, target, **turned)), np.random.default_rng(6)
    for _ in range(5):
        values = held.random_vector(generator)
        error, jacobian = held.held(values)
        if np.linalg.norm(error[len(target) :]) > 2.9:
            continue  # half a turn away the shortest way back is not one
        expected = difference(lambda v: held.held(v)[0], values, 1e-3)
        np.testing.assert_allclose(jacobian, expected, atol=1e-8)


@pytest.mark.some(3)
@pytest.mark.parametrize("case", HOLDS)
def test_retraction_turns_the_tool_as_asked(request, case):
    name, turned = HOLDS[case]
    robot = request.getfixturevalue(name)
    target = (0.4, 0.3) if robot.is_planar else (0.4, 0.2, 0.3)
    held, generator = problem(robot, Hold.at(robot, target, **turned)), np.random.default_rng(7)
    found = [held.retract(held.random_vector(generator)) for _ in range(20)]
    reached = [values for values in found if values is not None]
    assert len(reached) >= 8
    for values in reached:
        posed = held.posed(values)
        place = posed.position(robot.tool)
        np.testing.assert_allclose(place[[0, 2]] if robot.is_planar else place, target, atol=1e-9)
        axes = posed.rotation(robot.tool)
        if "axis" in turned:
            name = turned.get("tool_axis") or ("x" if robot.is_planar else "z")
            own = axes[:, "xyz".index(name[-1])] * (-1 if name[0] == "-" else 1)
            wanted = np.array(turned["axis"]) / np.linalg.norm(turned["axis"])
            np.testing.assert_allclose(own, wanted, atol=1e-9)
        elif robot.is_planar:
            np.testing.assert_allclose(axes[[0, 2], 0], [np.cos(1.2), np.sin(1.2)], atol=1e-9)
        else:
            expected = Rotation.from_euler("xyz", turned["orientation"]).as_matrix()
            np.testing.assert_allclose(axes, expected, atol=1e-9)


def test_errors_are_angles():
    generator = np.random.default_rng(8)
    for angle in (1e-9, 1e-5, 0.3, 1.5, 3.0):
        axis = generator.normal(size=3)
        axis /= np.linalg.norm(axis)
        turn = Rotation.from_rotvec(angle * axis).as_matrix()
        target = Rotation.random(random_state=int(1e3 * angle)).as_matrix()
        error = FixedOrientation(target).error(turn @ target)
        np.testing.assert_allclose(error, angle * axis, atol=1e-8)
        across = np.cross(axis, [1.0, 0.0, 0.0])
        across /= np.linalg.norm(across)
        tilted = aligned(np.array([0.0, 0.0, 1.0]), across, None)
        columns = np.array([axis, np.cross(across, axis), across]).T  # z along the target, turned about axis
        assert np.linalg.norm(tilted.error(turn @ columns)) == pytest.approx(angle, rel=1e-6)


@pytest.mark.slow
@pytest.mark.usefixtures("types_unchecked")
def test_a_six_axis_arm_with_the_tool_free_to_turn(ur5):
    """One joint's worth of freedom: the best of a dense walk along it is found, with the axis kept."""
    along = PointDirection("tool0", "x")
    objective = ReceptanceObjective((along,), np.array([20.0]))
    hold = Hold.at(ur5, (0.4, 0.2, 0.3), axis=(0.0, 0.3, -1.0))
    free = PostureProblem(ur5, objective, hold)
    outcome = optimise(free, starts=24, seed=3)
    assert outcome.converged
    best = free.vector(outcome.best.posture)
    assert free.held(best)[1].shape == (5, 6)
    assert gain_left(free, best) <= 2e-5
    walk = [values for values in (_turned(ur5, hold, turn) for turn in np.linspace(-3.1, 3.1, 25)) if values]
    scanned = [objective.value(free.posed(values)) for ends in walk for values in ends]
    assert len(scanned) > 40
    assert outcome.best.objective <= min(scanned) * (1 + 1e-9)


def _turned(robot, hold, turn):
    """Postures with the whole orientation held, the tool turned by an angle about the axis."""
    along = hold.orientation.target
    first = np.cross([1.0, 0.0, 0.0], along)
    first /= np.linalg.norm(first)
    base = np.array([first, np.cross(along, first), along]).T
    angles = Rotation.from_matrix(Rotation.from_rotvec(turn * along).as_matrix() @ base).as_euler("xyz")
    whole = problem(robot, Hold.at(robot, tuple(hold.target), orientation=tuple(angles)))
    generator = np.random.default_rng(11)
    found = [whole.retract(whole.random_vector(generator)) for _ in range(8)]
    return [values for values in found if values is not None]


@pytest.fixture
def track(tmp_path):
    """An arm of three links on a horizontal track."""
    parts = [
        body("carriage", 30.0, (0, 0, 0.1), (1, 1, 1, 0, 0, 0)),
        joint("slide", "prismatic", "base", "carriage", (0, 0, 0.4), (1, 0, 0), limits=(-1.0, 1.5)),
    ]
    parent = "carriage"
    for place, length in enumerate((0.8, 0.6, 0.3), start=1):
        inertia = (0.2, 0.2, 0.2, 0, 0, 0)
        parts.append(body(f"a{place}", 5.0, (length / 2, 0, 0), inertia))
        offset = (0, 0, 0.2) if place == 1 else ((0.8, 0.6)[place - 2], 0, 0)
        parts.append(joint(f"q{place}", "revolute", parent, f"a{place}", offset, limits=(-2.8, 2.8)))
        parent = f"a{place}"
    path = save(tmp_path / "track.urdf", *parts, joint("mount", "fixed", parent, "tool", (0.3, 0, 0)))
    stiffness = {"slide": 5e6, "q1": 3e4, "q2": 2e4, "q3": 5e3}
    return flexmodal.load(path, stiffness=stiffness, damping={"slide": 900.0, "q1": 20, "q2": 15, "q3": 4})


@pytest.mark.usefixtures("types_unchecked")
@pytest.mark.slow
def test_an_arm_on_a_track(track):
    """The carriage is a joint like the others, in metres: targets all along the track, best of 200 others."""
    for x in (-0.9, 0.3, 2.4):
        held = problem(track, Hold.at(track, (x, 0.9)), 8.0)
        outcome = optimise(held, starts=32, seed=1)
        assert outcome.converged
        np.testing.assert_allclose(outcome.tool, (x, 0, 0.9), atol=1e-9)
        values = held.vector(outcome.best.posture)
        assert np.all((held.lower <= values) & (values <= held.upper))
        assert gain_left(held, values) <= 2e-5
        generator = np.random.default_rng(2)
        for _ in range(200):
            other = held.retract(held.random_vector(generator))
            if other is not None:
                assert held.objective.value(held.posed(other)) >= outcome.best.objective * (1 - 1e-9)


def test_the_track_against_differences(track):
    held = problem(track, Hold.at(track, (0.3, 0.9)), 8.0)
    for seed in range(3):
        values = held.random_vector(np.random.default_rng(seed))
        _, gradient = held.cost_and_gradient(values)
        expected = difference(lambda v: np.array(held.cost_and_gradient(v)[0]), values, 2e-4)
        np.testing.assert_allclose(gradient, expected, atol=1e-8 + 1e-13 * np.linalg.norm(gradient) ** 5)


@pytest.mark.usefixtures("types_unchecked")
def test_a_singular_start(arm):
    """Stretched out along x there is no first-order way inwards; the search finds one all the same."""
    held = problem(arm, Hold.at(arm, (2.0, 0.0)), 5.0)
    stretched = dict.fromkeys(held.names, 0.0)
    assert held.retract(np.zeros(6)) is None
    outcome = optimise(held, start=stretched, starts=1)
    assert outcome.converged
    np.testing.assert_allclose(outcome.tool, (2, 0, 0), atol=1e-9)
    assert outcome.compared.objective == pytest.approx(held.objective.value(arm.at(stretched)))
    assert outcome.start == pytest.approx(held.objective.value(arm.at(outcome.compared.held)))


@pytest.mark.usefixtures("types_unchecked")
@pytest.mark.slow
def test_limits_in_the_way_are_named(tmp_path):
    """Two links whose elbow bends one way only, up to 0.5 rad, and a target that needs more."""
    path = planar(
        tmp_path / "two.urdf",
        [1.0, 1.0],
        [4.0, 3.0],
        [0.4, 0.3],
        [0.5, 0.5],
        limits=[(-3.1, 3.1), (0.0, 0.5)],
    )
    robot = flexmodal.load(path, stiffness=1e3, damping=2.0)
    with pytest.raises(Unreachable, match=r"could be reached if q2 went beyond the limits"):
        optimise(problem(robot, Hold.at(robot, (1.0, 0.5))), starts=1)
    with pytest.raises(Unreachable) as caught:
        optimise(problem(robot, Hold.at(robot, (3.0, 0.0))), starts=1)
    assert "beyond the limits" not in str(caught.value)
    with pytest.raises(Unreachable, match=r"turned as asked.* m away and .*° off"):
        optimise(problem(robot, Hold.at(robot, (1.9, 0.0), orientation=(2.0,))), starts=1)


def undamped(tmp_path):
    path = planar(tmp_path / "two.urdf", [1.0, 1.0], [4.0, 3.0], [0.4, 0.3], [0.5, 0.5])
    return flexmodal.load(path, stiffness={"q1": 3e3, "q2": 1e3})


@pytest.mark.usefixtures("types_unchecked")
def test_a_start_at_an_undamped_resonance(tmp_path):
    robot = undamped(tmp_path)
    start = {"q1": 0.3, "q2": 0.9}
    pole = float(robot.modes(start).frequency[0])
    free = problem(robot, None, pole)
    outcome = optimise(free, start=start, starts=6)
    assert outcome.start == np.inf
    assert np.isfinite(outcome.best.objective)
    with pytest.raises(SingularResponse, match="infinite"):
        optimise(free, start=start, starts=1)


@pytest.mark.slow
@pytest.mark.usefixtures("types_unchecked")
@pytest.mark.parametrize("case", ["position", "orientation", "axis", "angle", "axis in the plane"])
def test_compiled_and_plain_find_the_same(arm, ur5, case):
    """The best of 40 starts, and the answer where there is none."""
    place = (0.4, 0.2, 0.3)
    hold = {
        "position": lambda: Hold.at(arm, (-3.5, 1.0)),
        "orientation": lambda: Hold.at(ur5, place, orientation=(3.0, 0.2, -0.5)),
        "axis": lambda: Hold.at(ur5, place, axis=(0.1, -0.2, -1.0), tool_axis="-z"),
        "angle": lambda: Hold.at(arm, (-3.5, 1.0), orientation=(1.2,)),
        "axis in the plane": lambda: Hold.at(arm, (-3.5, 1.0), axis=(1.0, 0.0, 1.0), tool_axis="-x"),
    }[case]()
    held = problem(ur5 if hold.point == "tool0" else arm, hold, 3.0)
    both = [optimise(held, starts=40, seed=3, way=way) for way in ("compiled", "plain")]
    assert both[0].best.objective == pytest.approx(both[1].best.objective, rel=1e-6)
    values = held.vector(both[0].best.posture)
    assert np.linalg.norm(held.held(values)[0]) <= 1e-9
    assert gain_left(held, values) <= 2e-5
    far = problem(arm, Hold.at(arm, (7.0, 0.0)), 3.0)
    with pytest.raises(Unreachable, match="nearest was"):
        optimise(far, starts=40, way="compiled")
    with pytest.raises(InvalidRequest, match="does not apply"):
        optimise(PostureProblem(arm, SeparationObjective(5.0)), way="compiled")


def test_bad_orientations(arm, ur5):
    place = (0.4, 0.2, 0.3)
    for robot, target, given, says in (
        (ur5, place, {"orientation": (1.0,)}, "3 finite angles"),
        (ur5, place, {"orientation": (1.0, np.nan, 0.0)}, "3 finite angles"),
        (ur5, place, {"axis": (0.0, 0.0, 0.0)}, "not all 0"),
        (ur5, place, {"axis": (0.0, 1.0)}, "3 finite components"),
        (ur5, place, {"axis": (0.0, 0.0, 1.0), "orientation": (0.0, 0.0, 0.0)}, "one of them"),
        (ur5, place, {"axis": (0.0, 0.0, 1.0), "tool_axis": "w"}, "tool_axis"),
        (arm, (-2.0, 2.0), {"orientation": (1.0, 2.0, 3.0)}, "1 finite angle"),
        (arm, (-2.0, 2.0), {"axis": (0.0, 1.0, 0.0)}, "inside the plane"),
        (arm, (-2.0, 2.0), {"orientation": (1.0,), "tool_axis": "y"}, "inside the plane"),
    ):
        with pytest.raises(InvalidRequest, match=says):
            Hold.at(robot, target, **given)

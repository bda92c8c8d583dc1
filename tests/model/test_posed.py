import dataclasses
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidUrdf, SingularResponse
from flexmodal.frf import PointDirection
from flexmodal.model.gradient import receptance_and_gradient

from .writing import body, joint, save


def postures(robot, count, seed):
    generator = np.random.default_rng(seed)
    return [
        {
            name: float(generator.uniform(max(one.lower, -3.0), min(one.upper, 3.0)))
            for name, one in robot.commanded.items()
        }
        for _ in range(count)
    ]


def everything(posed):
    """All a posed robot says, as one flat array."""
    tool = posed.robot.tool
    value, slope = receptance_and_gradient(posed, [PointDirection(tool, "x")], np.array([0.0, 7.0]))
    parts = [
        posed.system.mass,
        posed.position(tool),
        posed.full_jacobian(tool),
        posed.mass_derivative(),
        posed.modes().pole,
        value,
        slope,
        np.array(dataclasses.astuple(posed.robot.measures(posed.posture, frequency=3.0))[:3]),
    ]
    return np.concatenate([np.ravel(part).astype(complex) for part in parts])


# A mass matrix that is not one.


def needle(path, *, on_axis: bool, com: float = 0.0):
    """Two links; the second is a point mass without moment, on its own joint's axis or off it."""
    moments = (0.1, 0.1, 0.1, 0, 0, 0)
    return save(
        path,
        body("arm", 2.0, (0.5, 0, 0), moments),
        body("needle", 1.0, (0.0 if on_axis else 0.3, com, 0)),
        joint("shoulder", "revolute", "base", "arm"),
        joint("elbow", "revolute", "arm", "needle", (1, 0, 0)),
        joint("mount", "fixed", "needle", "tool", (0.3, 0, 0)),
    )


@pytest.mark.parametrize("com", [0.0, 0.2])
def test_a_point_mass_on_its_axis(tmp_path, com):
    """It turns about itself without resistance: infinite frequency, and the link at fault is named."""
    robot = flexmodal.load(needle(tmp_path / "r.urdf", on_axis=True, com=com), stiffness=100.0)
    for call in (
        lambda: robot.at({}),
        lambda: robot.frf({"elbow": 0.3}, [1.0]),
        lambda: robot.modes({}),
        lambda: robot.measures({}),
    ):
        with pytest.raises(InvalidUrdf, match=r"link needle \(moved by joint elbow\)") as caught:
            call()
        assert caught.value.faults[0].file == str(robot.urdf.path)
    assert not flexmodal.check(robot.urdf.path).is_sound


def test_a_point_mass_off_its_axis_is_fine(tmp_path):
    robot = flexmodal.load(needle(tmp_path / "r.urdf", on_axis=False), stiffness=100.0)
    # m r² about its own joint
    assert robot.at({}).system.mass[1, 1] == pytest.approx(1.0 * 0.3**2, rel=1e-14)
    assert flexmodal.check(robot.urdf.path).is_sound


def test_a_rigid_joint_needs_no_mass_of_its_own(tmp_path):
    robot = flexmodal.load(needle(tmp_path / "r.urdf", on_axis=True), stiffness={"shoulder": 100.0})
    # about the shoulder: 0.1 + 2 × 0.5² + 1 × 1²
    assert robot.at({"elbow": 0.3}).system.mass[0, 0] == pytest.approx(1.6, rel=1e-14)


def test_mass_on_the_axis_in_one_posture_only(tmp_path):
    """What rounding leaves of cos 90° is still a mass to the solver; the receptance does not mind."""
    path = save(
        tmp_path / "r.urdf",
        body("arm", 1.0),
        body("hand", 1.0, (1.0, 0, 0)),
        joint("shoulder", "revolute", "base", "arm", axis=(0, 0, 1)),
        joint("elbow", "revolute", "arm", "hand", limits=(-2, 2)),
        joint("mount", "fixed", "hand", "tool", (2, 0, 0)),
    )
    posed = flexmodal.load(path, stiffness=100.0).at({"elbow": np.pi / 2})
    omega = 2 * np.pi
    found = posed.frf([1.0], response=["tool:+x", "tool:+y"]).value[0]
    # only the elbow moves the tool: 2 m above it, mass 1 kg at 1 m
    np.testing.assert_allclose(found, np.diag([4 / (100 - omega**2), 0]), atol=1e-15)


def test_undamped_at_resonance(tmp_path):
    robot = flexmodal.load(needle(tmp_path / "r.urdf", on_axis=False), stiffness=100.0)
    posed = robot.at({"elbow": 0.4})
    resonance = float(posed.modes().frequency[0])
    with pytest.raises(SingularResponse, match="natural frequency"):
        posed.frf([resonance])


def test_undamped_exactly_at_resonance_has_no_gradient_either(tmp_path):
    """k = 16π² and I = 1 put the resonance at 2 Hz exactly, in binary too: Z is 0."""
    path = save(
        tmp_path / "r.urdf",
        body("arm", 1.0, (0, 0, 0), (1, 1, 1, 0, 0, 0)),
        joint("shoulder", "revolute", "base", "arm"),
        joint("mount", "fixed", "arm", "tool", (1, 0, 0)),
    )
    posed = flexmodal.load(path, stiffness=float((2 * np.pi * 2.0) ** 2)).at({})
    with pytest.raises(SingularResponse):
        receptance_and_gradient(posed, [PointDirection("tool", "z")], np.array([2.0]))


# Nothing can be changed, and nothing is shared.


def test_a_robot_is_immutable(fanuc):
    with pytest.raises(dataclasses.FrozenInstanceError):
        fanuc.tool = "base"
    for array in (fanuc.stiffness, fanuc.damping, fanuc.task, fanuc.flexible_index):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    for mapping in (
        fanuc.joints,
        fanuc.points,
        fanuc.postures,
        fanuc.families,
        fanuc.moving,
        fanuc.commanded,
    ):
        with pytest.raises(TypeError):
            mapping["new"] = None
    with pytest.raises(TypeError):
        fanuc.postures["configuration_1"]["q1"] = 0.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        fanuc.joints["q1"].stiffness = 1.0


def test_a_posed_robot_is_immutable(fanuc):
    posed = fanuc.at("configuration_1")
    with pytest.raises(dataclasses.FrozenInstanceError):
        posed.posture = fanuc.posture("configuration_2")
    for matrix in (posed.system.mass, posed.system.stiffness, posed.system.damping):
        with pytest.raises(ValueError, match="read-only"):
            matrix[0, 0] = 1.0
    before = everything(posed)
    for array in (
        posed.position("tool"),
        posed.full_jacobian("tool"),
        posed.jacobian("tool"),
        posed.rows(posed.directions(None)),
        posed.mass_derivative(),
    ):
        array[...] = 1e9  # copies: theirs to spoil
    np.testing.assert_array_equal(everything(posed), before)


def test_two_robots_and_many_postures_keep_apart(fanuc, ur5):
    """Each posed robot says the same before and after any other was posed."""
    posed = [robot.at(values) for robot in (fanuc, ur5, fanuc) for values in postures(robot, 4, 11)]
    alone = [everything(one.robot.at(one.posture)) for one in posed]
    for one, expected in zip(reversed(posed), reversed(alone), strict=True):
        np.testing.assert_array_equal(everything(one), expected)
    # and not because nothing depends on the posture
    assert np.max(np.abs(alone[0] - alone[1])) > 0.1


def test_threads(fanuc, ur5, mixed_robot):
    """Posed by four threads at once, shared posed robots included: the same to the bit."""
    jobs = [(robot, values) for robot in (fanuc, ur5, mixed_robot) for values in postures(robot, 8, 12)]
    expected = [everything(robot.at(values)) for robot, values in jobs]
    shared = [robot.at(values) for robot, values in jobs]
    with ThreadPoolExecutor(4) as pool:
        own = list(pool.map(lambda job: everything(job[0].at(job[1])), jobs * 2))
        same = list(pool.map(everything, shared * 2))
    for found in (own, same):
        for value, wanted in zip(found, expected * 2, strict=True):
            np.testing.assert_array_equal(value, wanted)


def test_loading_in_threads(tmp_path):
    """Loading watches standard error, which belongs to the whole process."""
    path = needle(tmp_path / "r.urdf", on_axis=False)
    with ThreadPoolExecutor(8) as pool:
        robots = list(pool.map(lambda _: flexmodal.load(path, stiffness=100.0), range(40)))
    for robot in robots:
        np.testing.assert_array_equal(robot.at({}).system.mass, robots[0].at({}).system.mass)


@pytest.mark.parametrize("name", ["six_link", "fanuc_s360", "ur5", "mixed"])
def test_the_mass_matrix_is_symmetric_and_posture_in_posture_out(robots, name):
    robot = robots[name]
    for values in postures(robot, 5, 13):
        posed = robot.at(values)
        assert dict(posed.posture.values) == values
        mass = posed.system.mass
        np.testing.assert_array_equal(mass, mass.T)
        assert np.linalg.eigvalsh(mass)[0] > 0
        assert posed.system.coordinates == tuple(robot.joints)

"""Derivatives of the Jacobian and of the receptance. The complex step is in tests/agreement."""

import numpy as np
import pinocchio as pin
import pytest

import flexmodal
from flexmodal.frf import PointDirection
from flexmodal.model.gradient import jacobian_derivative, receptance_and_gradient

NAMES = ["six_link", "fanuc_s360", "ur5", "mixed"]


def inside(robot, generator):
    """A posture far enough from the limits for differences on both sides."""
    return np.array(
        [
            generator.uniform(max(one.lower + 0.01, -3.0), min(one.upper - 0.01, 3.0))
            for one in robot.commanded.values()
        ]
    )


def at(robot, values):
    return robot.at({name: float(value) for name, value in zip(robot.commanded, values, strict=True)})


def differences(function, values, step):
    """Fourth-order central differences along every entry, last axis."""
    slopes = []
    for unit in np.eye(len(values)):
        near = function(values + step * unit) - function(values - step * unit)
        far = function(values + 2 * step * unit) - function(values - 2 * step * unit)
        slopes.append((8 * near - far) / (12 * step))
    return np.stack(slopes, axis=-1)


def commanded_columns(robot):
    return [list(robot.moving).index(name) for name in robot.commanded]


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_derivative_against_differences(robots, name):
    robot, generator = robots[name], np.random.default_rng(21)
    links = [
        robot.tool,
        robot.urdf.links[3].name,
        *list(robot.points)[:3],
        *(["tail", "pack"] * (name == "mixed")),
    ]
    for point in links:
        values = inside(robot, generator)
        found = jacobian_derivative(at(robot, values).full_jacobian(point))[:, :, commanded_columns(robot)]
        # truncation (1e-3)⁴/30 ≈ 3e-14 of 6 m, rounding 1e-16 × 6 / 1e-3 ≈ 1e-12
        expected = differences(lambda v, p=point: at(robot, v).full_jacobian(p), values, 1e-3)
        np.testing.assert_allclose(found, expected, atol=1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_derivative_against_the_kinematic_hessian(robots, name):
    """Pinocchio's own ∂J/∂q in world axes at the point.

    Pinocchio 4.1 hands a column-major array over as row-major; where it does, the order is put right.
    """
    robot, generator = robots[name], np.random.default_rng(22)
    model = robot.pinocchio
    data = model.createData()
    for point in [robot.tool, *list(robot.points)[:2]]:
        posed = at(robot, inside(robot, generator))
        configuration = pin.integrate(
            model,
            pin.neutral(model),
            np.array([posed.posture.values.get(joint, 0.0) for joint in robot.moving]),
        )
        pin.computeJointJacobians(model, data, configuration)
        pin.updateFramePlacements(model, data)
        pin.computeJointKinematicHessians(model, data)
        hessian = pin.getFrameKinematicHessian(
            model, data, robot.frame_of(point), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        found = jacobian_derivative(posed.full_jacobian(point))
        orders = [hessian, hessian.reshape(-1).reshape(hessian.shape, order="F")]
        # a few products of numbers up to 6: 1e-15 each
        assert min(np.max(np.abs(found - order)) for order in orders) <= 1e-13


@pytest.mark.parametrize("name", NAMES)
def test_mass_derivative_against_differences(robots, name):
    robot, generator = robots[name], np.random.default_rng(23)
    values = inside(robot, generator)
    found = at(robot, values).mass_derivative()
    expected = differences(lambda v: at(robot, v).system.mass, values, 1e-3)
    # as above, of masses up to some hundred kg·m²
    scale = np.max(np.abs(at(robot, values).system.mass))
    np.testing.assert_allclose(found[:, :, commanded_columns(robot)], expected, atol=1e-11 * scale)
    np.testing.assert_allclose(found, np.swapaxes(found, 0, 1), atol=1e-13 * scale)


def directions_of(robot):
    texts = [f"{robot.tool}:+x", f"{robot.tool}:-z", f"{robot.urdf.links[-2].name}:+z", f"{robot.tool}:+ry"]
    return tuple(PointDirection.parse(text) for text in texts)


@pytest.mark.parametrize("rigid", [False, True], ids=["flexible", "some rigid"])
@pytest.mark.parametrize("name", NAMES)
def test_receptance_gradient_against_differences(robots, name, rigid):
    """All pairs of four directions, 0 Hz and on a resonance included."""
    robot, generator = robots[name], np.random.default_rng(24)
    if rigid:
        soft = list(robot.joints)[::2]
        robot = flexmodal.load(
            robot.urdf.path,
            stiffness={joint: robot.joints[joint].stiffness for joint in soft},
            damping={joint: robot.joints[joint].damping for joint in soft},
            tool=robot.tool,
        )
    directions = directions_of(robot)
    for _ in range(3):
        values = inside(robot, generator)
        posed = at(robot, values)
        resonance = float(posed.modes().frequency[0])
        lines = np.unique([0.0, 2.0, resonance, resonance * 1.01, 80.0])
        value, slope = receptance_and_gradient(posed, directions, lines)
        np.testing.assert_allclose(
            value, posed.frf(lines, response=directions).value, atol=1e-13 * np.abs(value).max()
        )
        expected = differences(
            lambda v, f=lines: at(robot, v).frf(f, response=directions).value, values, 2e-4
        )
        # Truncation step⁴ f⁽⁵⁾/30: near a resonance of damping ratio ζ every derivative brings some 1/ζ,
        # so (2e-4 / 0.02)⁴ ≈ 1e-8 of the slope at worst; rounding 1e-13 / 2e-4 ≈ 1e-9.
        for line in range(len(lines)):
            bound = 1e-8 * np.max(np.abs(expected[line]))
            assert np.max(np.abs(slope[line][..., commanded_columns(robot)] - expected[line])) <= bound


def test_the_first_joint_of_a_turntable_changes_no_mass(ur5):
    """Turning about the vertical leaves D as it is, and α_zz with it: exact zeros of the gradient."""
    posed = ur5.at({"shoulder_pan_joint": 0.4, "shoulder_lift_joint": -1.0, "elbow_joint": 1.3})
    assert np.max(np.abs(posed.mass_derivative()[:, :, 0])) <= 1e-14
    _, slope = receptance_and_gradient(posed, [PointDirection("tool0", "z")], np.array([0.0, 9.0]))
    assert np.all(np.abs(slope[..., 0]) <= 1e-14 * np.abs(slope).max())


def test_symmetry(mixed_robot):
    posed = mixed_robot.at({"turn": 0.7, "lift": 0.2})
    _, slope = receptance_and_gradient(posed, directions_of(mixed_robot), np.array([3.0]))
    np.testing.assert_allclose(slope, np.swapaxes(slope, 1, 2), atol=1e-14 * np.abs(slope).max())

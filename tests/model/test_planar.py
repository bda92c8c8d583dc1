import numpy as np
import pytest

import flexmodal

from .writing import body, joint, save

MOMENTS = (0.1, 0.2, 0.3, 0, 0, 0)


def chain(path, *joints, rpy=(0, 0, 0)):
    """Joints (kind, axis) one metre apart along x; `rpy` turns the whole chain."""
    parts, parent = [], "base"
    for number, (kind, axis) in enumerate(joints):
        name = f"a{number}"
        parts.append(body(name, 1.0, (0.5, 0.1, 0.2), MOMENTS))
        turned = rpy if number == 0 else (0, 0, 0)
        parts.append(joint(f"q{number}", kind, parent, name, (1, 0, 0), axis, turned))
        parent = name
    return flexmodal.load(
        save(path / "chain.urdf", *parts, joint("mount", "fixed", parent, "tool", (1, 0, 0))), stiffness=1.0
    )


Y, Z, X = (0, 1, 0), (0, 0, 1), (1, 0, 0)


@pytest.mark.parametrize(
    ("joints", "rows"),
    [
        # rows of the six: x y z rx ry rz
        ([("revolute", Y), ("revolute", (0, -1, 0))], [0, 2, 4]),
        ([("revolute", Z), ("continuous", Z)], [0, 1, 5]),
        ([("revolute", X), ("revolute", X)], [1, 2, 3]),
        ([("revolute", Y), ("prismatic", X), ("prismatic", Z)], [0, 2, 4]),
        ([("prismatic", X), ("revolute", Y)], [0, 2, 4]),
        ([("revolute", Y)], [0, 2, 4]),
    ],
)
def test_planes_along_the_axes(tmp_path, joints, rows):
    robot = chain(tmp_path, *joints)
    assert robot.is_planar
    np.testing.assert_allclose(robot.task, np.eye(6)[rows], atol=1e-15)


@pytest.mark.parametrize(
    "joints",
    [
        [("revolute", Y), ("revolute", Z)],
        [("revolute", Y), ("prismatic", Y)],  # along the normal
        [("revolute", Y), ("prismatic", (0.1, 1, 0))],
        [("revolute", Y), ("revolute", (0, 1, 1e-6))],
        [("prismatic", X), ("prismatic", Z)],  # nothing turns: no normal to speak of
        [("prismatic", X)],
    ],
)
def test_spatial_chains(tmp_path, joints):
    robot = chain(tmp_path, *joints)
    assert not robot.is_planar
    np.testing.assert_array_equal(robot.task, np.eye(6))


def test_the_catalogue():
    assert flexmodal.load("six_link").is_planar
    assert flexmodal.load("fanuc_s360").is_planar
    for name in ("ur5", "kinova", "xarm7"):
        assert not flexmodal.load(name, stiffness=1.0).is_planar


@pytest.mark.parametrize("rpy", [(0.3, 0.5, -0.7), (2.0, -1.0, 0.4), (np.pi / 4, 0, 0)])
def test_a_tilted_plane(tmp_path, rpy):
    """Rows are orthonormal, right-handed, span the motion, and the measures do not see the tilt."""
    joints = [("revolute", (0, -1, 0))] * 3
    upright, tilted = chain(tmp_path, *joints), chain(tmp_path, *joints, rpy=rpy)
    assert tilted.is_planar
    rows = tilted.task
    np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-15)
    normal = rows[2, 3:]
    np.testing.assert_array_equal(rows[:2, 3:], 0)
    np.testing.assert_array_equal(rows[2, :3], 0)
    np.testing.assert_allclose(np.cross(rows[0, :3], rows[1, :3]), normal, atol=1e-15)
    posture = {"q0": 0.4, "q1": -0.9, "q2": 1.2}
    jacobian = tilted.at(posture).full_jacobian("tool")
    np.testing.assert_allclose(rows.T @ rows @ jacobian, jacobian, atol=1e-15)  # nothing is left out
    # the same singular values, in whatever basis of the plane
    np.testing.assert_allclose(
        np.linalg.svd(rows @ jacobian, compute_uv=False),
        np.linalg.svd(upright.task @ upright.at(posture).full_jacobian("tool"), compute_uv=False),
        rtol=1e-13,
    )

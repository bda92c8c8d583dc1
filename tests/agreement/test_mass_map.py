"""The mass matrix as a linear map of masses and moments, against Pinocchio's regressor and the rigid-body
algorithm."""

import numpy as np
import pinocchio as pin
import pytest

import flexmodal
from flexmodal.structure.arm import Arm
from flexmodal.structure.mass_map import mass_map


def mass_regressor(posed):
    """Regressor of the mass matrix over the flexible joints, and the parameters it has now.

    Column by column: at rest and without gravity, the inverse dynamics of a unit acceleration is a column of
    D.

    Returns:
        R and π with D = R π but for rotor inertias: ten parameters for each joint that moves, those of what
        it carries up to the next: m, m c (3), and I_xx, I_xy, I_yy, I_xz, I_yz, I_zz about the joint's
        origin, axes of the joint.
    """
    model = posed.robot.pinocchio
    data = model.createData()
    velocity = np.array([posed.posture.values.get(name, 0.0) for name in posed.robot.moving])
    configuration = pin.integrate(model, pin.neutral(model), velocity)
    pick, zero, unit = posed.robot.flexible_index, np.zeros(model.nv), np.eye(model.nv)
    columns = [
        pin.computeJointTorqueRegressor(model, data, configuration, zero, unit[joint]).copy()[pick]
        for joint in pick
    ]
    parameters = np.concatenate([inertia.toDynamicParameters() for inertia in list(model.inertias)[1:]])
    return np.stack(columns, axis=1), parameters


def posture(robot, seed):
    random = np.random.default_rng(seed)
    values = {}
    for name, joint in robot.commanded.items():
        low, high = max(joint.lower, -1.0), min(joint.upper, 1.0)
        values[name] = float(random.uniform(low, high))
    return values


@pytest.fixture(params=["fanuc_s360", "six_link", "six_axis"])
def robot(request):
    return flexmodal.load(request.param)


def test_the_map_gives_the_mass_matrix_of_the_card(robot):
    q = posture(robot, 1)
    found = mass_map(Arm(robot, q))
    mass = robot.at(q).system.mass
    np.testing.assert_allclose(found.mass(found.card), mass, atol=1e-12 * np.abs(mass).max())


def test_the_regressor_gives_it_too(robot):
    posed = robot.at(posture(robot, 2))
    regressor, parameters = mass_regressor(posed)
    mass = posed.system.mass
    np.testing.assert_allclose(regressor @ parameters, mass, atol=1e-12 * np.abs(mass).max())


def test_both_agree_for_other_masses_and_moments(robot):
    """Parameters of Pinocchio's bodies from masses and moments of links, each link on a joint of its own."""
    q, random = posture(robot, 3), np.random.default_rng(7)
    found = mass_map(Arm(robot, q))
    count = len(found.links)
    mu = found.card * random.uniform(0.5, 2.0, 2 * count)
    regressor, parameters = mass_regressor(robot.at(q))
    order = [joint.child for joint in robot.moving.values()]
    pi = np.zeros_like(parameters)
    for k, name in enumerate(found.links):
        if name not in order:  # the base: it does not move
            continue
        link = robot.urdf.link_by_name[name]
        c, m = np.asarray(link.com), mu[k]
        moment = np.max(np.diag(link.inertia))
        tensor = link.inertia * mu[count + k] / moment + m * (c @ c * np.eye(3) - np.outer(c, c))
        pi[10 * order.index(name) : 10 * order.index(name) + 10] = [
            m, *(m * c), tensor[0, 0], tensor[0, 1], tensor[1, 1], tensor[0, 2], tensor[1, 2], tensor[2, 2]
        ]  # fmt: skip
    np.testing.assert_allclose(found.mass(mu), regressor @ pi, atol=1e-11 * np.abs(found.mass(mu)).max())


def test_masses_and_moments_follow_from_mass_matrices():
    """[ML] of some postures, solved for what it can tell: the matrices come back."""
    robot = flexmodal.load("fanuc_s360")
    maps = [mass_map(Arm(robot, posture(robot, seed))) for seed in range(6)]
    mu = maps[0].card * np.random.default_rng(5).uniform(0.7, 1.4, len(maps[0].card))
    stacked, entries = (
        np.vstack([one.matrix for one in maps]),
        np.concatenate([one.matrix @ mu for one in maps]),
    )
    back = np.linalg.lstsq(stacked, entries, rcond=None)[0]
    other = mass_map(Arm(robot, posture(robot, 99)))
    np.testing.assert_allclose(other.mass(back), other.mass(mu), atol=1e-9 * np.abs(other.mass(mu)).max())
    assert np.linalg.matrix_rank(stacked, tol=1e-9) < len(
        mu
    )  # the first link's mass and moment come together

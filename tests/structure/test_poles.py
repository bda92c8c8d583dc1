"""Poles and shapes against the modal room, their derivatives against central differences."""

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidSystem
from flexmodal.structure.arm import Arm
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.poles import poles
from flexmodal.structure.robot_terms import put_together
from flexmodal.structure.space import robot_space
from flexmodal.structure.structure import Structure

STEP = 1e-5


def structure(robot, q, values):
    assembly = Assembly(Arm(robot, q))
    put_together(assembly, values, assembly.arm.bodies)
    rows = assembly.rows([(robot.tool, np.zeros(3), way) for way in (np.eye(3)[2], np.eye(3)[0])])
    return assembly.close(rows, rows)


@pytest.fixture(params=["fanuc_s360", "six_link", "six_axis"])
def case(request):
    """A robot off its card; the six-link arm has real poles too."""
    robot = flexmodal.load(request.param)
    space = robot_space(robot)
    q = (
        dict(next(iter(robot.postures.values())))
        if robot.postures
        else {name: 0.3 for name in robot.commanded}
    )
    return robot, space, q, np.random.default_rng(3).normal(0, 0.05, len(space))


def test_frequencies_are_the_robots(case):
    robot, _, q, _ = case
    found = poles(structure(robot, q, {}))
    modes = robot.at(q).modes()
    np.testing.assert_allclose(found.frequency, modes.frequency, rtol=1e-9)
    np.testing.assert_allclose(found.damping_ratio, modes.damping_ratio, atol=1e-9)
    assert found.count == len(modes.pole)
    assert len(found.pole) == 2 * len(robot.joints)


def test_derivatives_are_those_of_central_differences(case):
    robot, space, q, x = case
    names = space.names

    def at(x):
        found = poles(structure(robot, q, space.values(x)), names)
        order = np.lexsort((found.pole.imag, found.pole.real))
        rows = structure(robot, q, space.values(x)).response
        return found, found.pole[order], ((rows[0] @ found.shape) * (rows[1] @ found.shape))[order], order

    middle, pole, residue, order = at(x)
    rows = structure(robot, q, space.values(x)).response
    u, v = rows[0] @ middle.shape, rows[1] @ middle.shape
    for k in range(len(space)):
        shift = STEP * np.eye(len(space))[k]
        up, down = at(x + shift), at(x - shift)
        numeric = (up[1] - down[1]) / (2 * STEP)
        np.testing.assert_allclose(middle.pole_slope[k][order], numeric, atol=2e-7 * np.abs(pole).max())
        du, dv = rows[0] @ middle.shape_slope[k], rows[1] @ middle.shape_slope[k]
        numeric = (up[2] - down[2]) / (2 * STEP)
        # residues do not depend on the sign of the shape; second order in the step
        np.testing.assert_allclose((du * v + u * dv)[order], numeric, atol=1e-6 * np.abs(residue).max())


def test_slopes_of_frequency_and_damping(case):
    robot, space, q, x = case

    def at(x):
        return poles(structure(robot, q, space.values(x)), space.names)

    middle = at(x)
    for k in range(0, len(space), 3):
        shift = STEP * np.eye(len(space))[k]
        up, down = at(x + shift), at(x - shift)
        numeric = np.log(up.frequency / down.frequency) / (2 * STEP)
        np.testing.assert_allclose(middle.log_frequency_slope[k], numeric, atol=1e-7)
        numeric = (up.damping_ratio - down.damping_ratio) / (2 * STEP)
        np.testing.assert_allclose(middle.damping_slope[k], numeric, atol=1e-7)


def test_poles_of_a_structure_with_a_negative_element_sum_to_its_receptance(case):
    """What a control loop does may take a negative Maxwell element, whose end has a negative inertia."""
    robot, _, q, _ = case
    one = structure(robot, q, {})
    n = one.dof
    mass, damping, stiffness = np.zeros((3, n + 1, n + 1))
    mass[:n, :n], damping[:n, :n], stiffness[:n, :n] = one.mass, one.damping, one.stiffness
    spring = -0.002 * one.stiffness[0, 0]  # so little that nothing rings up
    stretch = np.eye(n + 1)[0] - np.eye(n + 1)[n]
    stiffness += spring * np.outer(stretch, stretch)
    damping[n, n], mass[n, n] = 0.01 * spring, 1e-8 * spring
    row = np.pad(one.response, [(0, 0), (0, 1)])
    names = (*one.coordinates, "end")
    active = Structure(names, mass, damping, stiffness, np.zeros_like(mass), row, row)
    with pytest.raises(InvalidSystem):
        poles(active)
    found = poles(active, active=True)
    assert len(found.pole) == 2 * (n + 1)
    s = 2j * np.pi * 17.0
    exact = row @ np.linalg.solve(s**2 * mass + s * damping + stiffness, row.T)
    summed = (row @ found.shape / (s - found.pole)) @ (row @ found.shape).T
    np.testing.assert_allclose(summed, exact, rtol=1e-7)


def test_a_pole_without_a_shape_is_refused(case):
    """Of an end that nothing holds and nothing brakes both poles are 0: no number is passed on."""
    robot, _, q, _ = case
    one = structure(robot, q, {})
    n = one.dof
    mass, damping, stiffness = (np.pad(matrix, (0, 1)) for matrix in (one.mass, one.damping, one.stiffness))
    mass[n, n] = -1e-3
    row = np.pad(one.response, [(0, 0), (0, 1)])
    names = (*one.coordinates, "end")
    with pytest.raises(np.linalg.LinAlgError, match="shape"):
        poles(Structure(names, mass, damping, stiffness, np.zeros_like(mass), row, row), active=True)

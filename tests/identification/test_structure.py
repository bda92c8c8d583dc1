"""Mass matrix, receptance and derivatives of the identification, against Pinocchio and finite differences."""

import numpy as np
import pytest

import flexmodal
from flexmodal.identification.frf_fit import residual
from flexmodal.structure.arm import Arm
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.robot_terms import put_together
from flexmodal.structure.space import robot_space
from flexmodal.structure.structure import Axis, Change, Structure, receptance

PLACES = [("link_3", np.array([0.2, 0.0, 0.01]), np.array([0.0, 0.0, 1.0])),
          ("link_1", np.array([0.5, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))]  # fmt: skip
AXIS = Axis(np.array([2.0, 7.7, 38.0, 51.3, 120.0]), 30.0, 0.4)
PAIRS = np.array([[0, 0], [0, 1], [1, 1]])


def structure_at(robot, q, values=None, loss=0.0):
    assembly = Assembly(Arm(robot, q))
    put_together(assembly, values or {}, assembly.arm.bodies)
    for joint in robot.joints:
        if loss:
            assembly.loss_factor = loss
            k = values[f"stiffness.{joint}"]
            assembly.add_loss(assembly.row(joint), k, f"stiffness.{joint}")
    rows = assembly.rows(PLACES)
    return assembly.close(rows, rows)


@pytest.mark.parametrize("name", ["fanuc_s360", "six_link", "panda"])
def test_mass_matrix_is_pinocchios(name):
    robot = flexmodal.load(name, stiffness=1e4, damping=10.0) if name == "panda" else flexmodal.load(name)
    random = np.random.default_rng(4)
    q = {joint: float(random.uniform(-1, 1)) for joint in robot.commanded}
    if name == "panda":
        q = {j: float(np.clip(v, robot.commanded[j].lower, robot.commanded[j].upper)) for j, v in q.items()}
    assembly = Assembly(Arm(robot, q))
    put_together(assembly, {}, assembly.arm.bodies)
    made = assembly.close(np.zeros((1, len(robot.joints))), np.zeros((1, len(robot.joints))))
    posed = robot.at(q)
    np.testing.assert_allclose(made.mass, posed.system.mass, rtol=1e-12, atol=1e-12 * posed.system.mass.max())
    np.testing.assert_array_equal(made.stiffness, robot.stiffness)
    np.testing.assert_array_equal(made.damping, robot.damping)


def test_receptance_is_the_robots():
    robot = flexmodal.load("fanuc_s360")
    q = dict(robot.postures["configuration_2"])
    frequency = np.array([1.0, 7.7, 52.0, 150.0])
    assembly = Assembly(Arm(robot, q))
    put_together(assembly, {}, assembly.arm.bodies)
    point = robot.points["location_1"]
    rows = assembly.rows([(point.link, np.array(point.xyz), np.array([0.0, 0, 1]))])
    value, _ = receptance(assembly.close(rows, rows), Axis(frequency, 10.0), np.array([[0, 0]]))
    other = robot.frf(q, frequency, response="location_1:+z").value[:, 0, 0]
    np.testing.assert_allclose(value[0], other, rtol=1e-11)


def test_derivatives_are_those_of_the_complex_step():
    """Z = A + iB in real form, [A −B; B A], so that i is free for the step; no difference is taken.

    Every term of the assembly grows with the exponential of the coordinates it is named after.
    """
    robot = flexmodal.load("fanuc_s360")
    space = robot_space(robot)
    q, x = dict(robot.postures["configuration_2"]), np.random.default_rng(1).normal(0, 0.1, len(space))
    assembly = Assembly(Arm(robot, q))
    put_together(assembly, space.values(x), assembly.arm.bodies)
    rows = assembly.rows(PLACES)
    made = assembly.close(rows, rows)
    _, slopes = receptance(made, AXIS, PAIRS, space.names)
    n, step = made.dof, 1e-30
    for k, name in enumerate(space.names):
        total = {kind: np.zeros((n, n), complex) for kind in ("mass", "damping", "stiffness")}
        for kind, matrix, names in assembly.terms:
            total[kind] += matrix * np.exp(1j * step * (name in names))
        for line, s in enumerate(AXIS.s):
            square = s**2
            real = total["stiffness"] + s.real * total["damping"] + square.real * total["mass"]
            imaginary = s.imag * total["damping"] + square.imag * total["mass"]
            form = np.block([[real, -imaginary], [imaginary, real]])
            for pair, (u, v) in enumerate(PAIRS):
                y = np.linalg.solve(form, np.concatenate([rows[v], np.zeros(n)]).astype(complex))
                found = (rows[u] @ y[:n].imag + 1j * (rows[u] @ y[n:].imag)) / step
                # both are solutions of the same equations, 1e-16 times their condition of some thousands
                assert slopes[k, pair, line] == pytest.approx(found, rel=1e-9, abs=1e-20), name


def test_derivatives_are_those_of_central_differences():
    robot = flexmodal.load("fanuc_s360")
    space = robot_space(robot)
    q = dict(robot.postures["configuration_2"])
    x = np.random.default_rng(1).normal(0, 0.1, len(space))

    def at(x):
        return receptance(structure_at(robot, q, space.values(x), loss=0.05), AXIS, PAIRS, space.names)

    _, slopes = at(x)
    step = 1e-5
    for k, name in enumerate(space.names):
        shift = step * np.eye(len(space))[k]
        numeric = (at(x + shift)[0] - at(x - shift)[0]) / (2 * step)
        # second order in the step: 1e-10 relative, rounding 1e-16/1e-5 beside it
        scale = np.abs(at(x)[0])
        np.testing.assert_allclose(slopes[k] / scale, numeric / scale, atol=2e-8, err_msg=name)


@pytest.mark.parametrize("sides", [(4, 1), (1, 4), (3, 3)])
@pytest.mark.parametrize("loss_factor", [0.0, 0.1])
def test_receptance_and_slopes_are_those_of_the_formula(sides, loss_factor):
    """∂u y_v + y_uᵀ ∂vᵀ − y_uᵀ ∂Z y_v, entry by entry, whichever side has more rows."""
    random, n = np.random.default_rng(5), 4

    def symmetric():
        root = random.normal(size=(n, n))
        return root @ root.T

    rows = [random.normal(size=(count, n)) for count in sides]
    kinds = ("mass", "damping", "stiffness", "loss")
    total = {kind: symmetric() + np.eye(n) for kind in kinds}
    total["stiffness"] *= 1e4
    changes = {
        "all": Change(*(symmetric() for _ in kinds), random.normal(size=rows[0].shape), None, 0.3),
        "struck": Change(reference=random.normal(size=rows[1].shape)),
        "body": Change(mass=symmetric()),
        "spring": Change(stiffness=symmetric(), loss=symmetric()),
        "nothing": Change(),
    }
    made = Structure(tuple("abcd"), *(total[kind] for kind in kinds), *rows, changes, loss_factor)
    pairs = np.array([(u, v) for u in range(sides[0]) for v in range(sides[1]) if u + v != 2][::-1])
    names = ("absent", *changes)
    value, slopes = receptance(made, AXIS, pairs, names)
    grown, growth = AXIS.hysteresis(loss_factor)
    nothing = Change(*(np.zeros((n, n)) for _ in kinds), *(np.zeros_like(side) for side in rows), 0.0)
    for line, s in enumerate(AXIS.s):
        inverse = np.linalg.inv(made.dynamic_stiffness(AXIS)[line])
        for place, (u, v) in enumerate(pairs):
            left, right = inverse @ rows[0][u], inverse @ rows[1][v]
            assert value[place, line] == pytest.approx(rows[0][u] @ right, rel=1e-10)
            for k, name in enumerate(names):
                change = nothing + changes.get(name, Change())
                moved = s**2 * change.mass + s * change.damping + change.stiffness + grown[line] * change.loss
                moved = moved + change.loss_factor * growth[line] * made.loss
                expected = change.response[u] @ right + left @ change.reference[v] - left @ moved @ right
                size = np.linalg.norm(left) * np.linalg.norm(moved) * np.linalg.norm(right)
                assert abs(slopes[k, place, line] - expected) <= 1e-10 * (abs(expected) + size)


def test_residuals_are_complex_logarithms():
    random = np.random.default_rng(6)
    predicted, measured = (random.normal(size=(3, 50)) + 1j * random.normal(size=(3, 50)) for _ in range(2))
    found = residual(predicted, measured)
    np.testing.assert_allclose(found, np.log(predicted / measured), rtol=1e-13, atol=1e-15)
    predicted[1, 3], measured[2, 4] = 0, 0
    found = residual(predicted, measured)
    assert (found[1, 3], found[2, 4]) == (10.0, 10.0)
    np.testing.assert_array_equal(found[0], residual(predicted[0], measured[0]))
    assert predicted[1, 3] == 0


def test_several_rows_at_once_are_one_after_the_other():
    robot = flexmodal.load("fanuc_s360")
    random = np.random.default_rng(2)
    together, apart = (Assembly(Arm(robot, {})) for _ in range(2))
    rows = random.standard_normal((3, len(together.coordinates)))
    for kind, add in {
        "mass": apart.add_inertia, "damping": apart.add_damper, "stiffness": apart.add_spring,
    }.items():  # fmt: skip
        sizes = random.uniform(1.0, 9.0, 3)
        together.add_together(kind, rows, sizes)
        for row, size in zip(rows, sizes, strict=True):
            add(row, float(size))
    sums = apart.summed()
    for kind, found in together.summed().items():
        np.testing.assert_allclose(found, sums[kind], rtol=1e-12, atol=1e-12)

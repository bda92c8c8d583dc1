"""Values of the objectives against their definitions, gradients against differences of the cost."""

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidRequest
from flexmodal.optimisation import (
    MobilityObjective,
    PostureProblem,
    ReceptanceObjective,
    StiffnessObjective,
)

from .optimality import difference, directions

Z, XZ, XYZ = (
    directions("tool:+z"),
    directions("tool:+x", "tool:+z"),
    directions("tool:+x", "tool:+y", "tool:+z"),
)
BAND = np.linspace(3.0, 20.0, 6)


def at_tool(robot, items):
    """The same directions at this robot's tool."""
    texts = [str(item).replace("tool:", f"{robot.tool}:") for item in items]
    return directions(*texts)


OBJECTIVES = {
    "static": lambda r: ReceptanceObjective(at_tool(r, Z), np.array([0.0])),
    "single": lambda r: ReceptanceObjective(at_tool(r, Z), np.array([5.0])),
    "minus x": lambda r: ReceptanceObjective(at_tool(r, directions("tool:-x")), np.array([12.0])),
    "rotation": lambda r: ReceptanceObjective(at_tool(r, directions("tool:+ry")), np.array([7.0])),
    "two points": lambda r: ReceptanceObjective(
        directions(f"{r.tool}:+z", f"{r.urdf.links[3].name}:+x"), np.array([5.0])
    ),
    "worst": lambda r: ReceptanceObjective(at_tool(r, XZ), np.array([5.0]), "worst"),
    "worst of three": lambda r: ReceptanceObjective(at_tool(r, XYZ), np.array([9.0]), "worst"),
    "weighted": lambda r: ReceptanceObjective(at_tool(r, XZ), np.array([5.0]), "weighted", (2.0, -0.5)),
    "band, worst": lambda r: ReceptanceObjective(at_tool(r, Z), BAND, "worst"),
    "band, mean": lambda r: ReceptanceObjective(at_tool(r, Z), BAND),
    "band, worst of two": lambda r: ReceptanceObjective(at_tool(r, XZ), BAND, "worst"),
    "band, weighted": lambda r: ReceptanceObjective(at_tool(r, XZ), BAND, "weighted", (1.0, 3.0)),
    "stiffness": lambda r: StiffnessObjective(*at_tool(r, Z)),
    "stiffness, position": lambda r: StiffnessObjective(*at_tool(r, directions("tool:+x")), "position"),
    "mobility": lambda r: MobilityObjective(*at_tool(r, Z)),
    "mobility, rotation": lambda r: MobilityObjective(*at_tool(r, directions("tool:+ry"))),
}


@pytest.mark.some(4)
@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize("name", ["six_link", "fanuc_s360", "ur5"])
def test_gradient(robots, name, objective):
    robot = robots[name]
    problem = PostureProblem(robot, OBJECTIVES[objective](robot))
    generator = np.random.default_rng(31)
    tried = 0
    while tried < 3:
        values = problem.random_vector(generator)
        _, gradient = problem.cost_and_gradient(values)
        size = float(np.linalg.norm(gradient))
        if size > 30:
            continue  # beside a zero or a pole of the measure, where differences say little
        tried += 1
        expected = difference(lambda v: np.array(problem.cost_and_gradient(v)[0]), values, 2e-4)
        # The cost is a logarithm, of order 10 and known to 1e-15 × condition ≈ 1e-13: divided by the step
        # that is 1e-9. Truncation is step⁴ f⁽⁵⁾/30, and where the slope is g the fifth derivative comes to
        # some 4! g⁵ (as of a logarithm at distance 1/g from its pole): 1e-15 g⁵, at most 3e-8.
        assert np.max(np.abs(gradient - expected)) <= 1e-8 + 1e-14 * size**5


def matrix(robot, posed, items, frequency):
    """α by the formula."""
    omega = 2 * np.pi * frequency
    system = posed.system
    dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    rows = np.array([item.selector @ posed.jacobian(item.point) for item in items])
    return rows @ np.linalg.inv(dynamic) @ rows.T


def test_values_of_the_receptance(arm):
    posed = arm.at("start_2")
    alpha = matrix(arm, posed, XZ, 5.0)
    one = ReceptanceObjective(XZ[1:], np.array([5.0]))
    assert one.value(posed) == pytest.approx(abs(alpha[1, 1]), rel=1e-12)
    worst = ReceptanceObjective(XZ, np.array([5.0]), "worst")
    assert worst.value(posed) == pytest.approx(np.linalg.norm(alpha, 2), rel=1e-12)
    w = np.array([2.0, -0.5]) / np.hypot(2, 0.5)
    weighted = ReceptanceObjective(XZ, np.array([5.0]), "weighted", (2.0, -0.5))
    assert weighted.value(posed) == pytest.approx(abs(w @ alpha @ w), rel=1e-12)
    sizes = [abs(matrix(arm, posed, XZ[1:], f)[0, 0]) for f in BAND]
    assert ReceptanceObjective(XZ[1:], BAND, "worst").value(posed) == pytest.approx(max(sizes), rel=1e-12)
    assert ReceptanceObjective(XZ[1:], BAND).value(posed) == pytest.approx(np.mean(sizes), rel=1e-12)


def test_weighted_is_what_a_turned_axis_would_give(arm):
    """A unit vector of weights is a direction between the axes: no posture needed to see it."""
    posed = arm.at("start_1")
    angle = 0.7
    weighted = ReceptanceObjective(XZ, np.array([3.0]), "weighted", (np.cos(angle), np.sin(angle)))
    turned = posed.rows(XZ).T @ [np.cos(angle), np.sin(angle)]
    system, omega = posed.system, 6 * np.pi
    dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    assert weighted.value(posed) == pytest.approx(abs(turned @ np.linalg.solve(dynamic, turned)), rel=1e-12)
    # and scaled weights are the same direction
    twice = ReceptanceObjective(XZ, np.array([3.0]), "weighted", (2 * np.cos(angle), 2 * np.sin(angle)))
    assert twice.value(posed) == pytest.approx(weighted.value(posed), rel=1e-14)


def test_cost_is_the_logarithm(robots):
    for robot in robots.values():
        posture = {name: 0.3 for name in robot.commanded}
        posed = robot.at(posture)
        for name, build in OBJECTIVES.items():
            objective = build(robot)
            value, cost = objective.value(posed), objective.cost_and_gradient(posed)[0]
            if name.startswith("stiffness"):
                assert cost == pytest.approx(-np.log(value), abs=1e-10)
            elif "worst" in name:
                # the smooth maximum of the mean over lines and the sum over singular values, power 40
                assert np.log(value) - np.log(len(BAND)) / 40 - 1e-9 <= cost
                assert cost <= np.log(value) + np.log(3) / 40 + 1e-9
            else:
                assert cost == pytest.approx(np.log(value), abs=1e-10)


def test_the_largest_singular_value_meets_the_second(arm):
    """At the crossing |α| has a kink; the cost is smooth there: gradients on both sides agree."""
    problem = PostureProblem(arm, ReceptanceObjective(XZ, np.array([0.0]), "worst"))
    start, stop = (problem.vector(arm.posture(name)) for name in ("start_1", "e9_final"))

    def gap(share):
        """How much more the tool gives way along its softest axis than across it; signed by which that is."""
        posed = problem.posed(start + share * (stop - start))
        alpha = matrix(arm, posed, XZ, 0.0).real
        return alpha[0, 0] - alpha[1, 1], np.abs(alpha[0, 1])

    shares = np.linspace(0, 1, 400)
    gaps = np.array([gap(share) for share in shares])
    distance = np.hypot(gaps[:, 0], 2 * gaps[:, 1]) / np.abs(gaps).max()
    nearest = shares[int(np.argmin(distance))]
    values = start + nearest * (stop - start)
    _, gradient = problem.cost_and_gradient(values)
    expected = difference(lambda v: np.array(problem.cost_and_gradient(v)[0]), values, 2e-4)
    np.testing.assert_allclose(gradient, expected, atol=1e-5 * (1 + np.linalg.norm(gradient)))


def test_bad_objectives(arm):
    with pytest.raises(InvalidRequest, match="weighted, force, worst"):
        ReceptanceObjective(Z, np.array([1.0]), "best")
    for weights in ((1.0,), (0.0, 0.0), (np.nan, 1.0), (1.0, np.inf)):
        with pytest.raises(InvalidRequest, match="2 finite weights, not all 0"):
            ReceptanceObjective(XZ, np.array([1.0]), "weighted", weights)
    across = StiffnessObjective(*directions("tool:+y"))
    with pytest.raises(InvalidRequest, match="nothing moves"):
        across.cost_and_gradient(arm.at("start_1"))
    turning = StiffnessObjective(*directions("tool:+ry"), "position")
    with pytest.raises(InvalidRequest, match="position"):
        turning.cost_and_gradient(arm.at("start_1"))
    with pytest.raises(InvalidRequest, match="full or position"):
        StiffnessObjective(*Z, "angles").cost_and_gradient(arm.at("start_1"))


def test_units():
    assert ReceptanceObjective(Z, np.array([1.0])).unit == "m/N"
    assert ReceptanceObjective(directions("tool:+ry"), np.array([1.0])).unit == "rad/(N·m)"
    assert StiffnessObjective(*Z).unit == "N/m"
    assert MobilityObjective(*Z).unit == "m²/rad²"


def test_rigid_joints_move_the_objective_too(arm):
    """A joint without compliance still changes the posture: its entry of the gradient is not 0."""
    soft = flexmodal.load(arm.urdf.path, stiffness={"q2": 2e4, "q5": 1e4}, damping=100.0)
    problem = PostureProblem(soft, ReceptanceObjective(Z, np.array([4.0])))
    values = np.array([0.9, -0.4, 0.6, 0.3, 1.0, -0.7])
    _, gradient = problem.cost_and_gradient(values)
    expected = difference(lambda v: np.array(problem.cost_and_gradient(v)[0]), values, 2e-4)
    np.testing.assert_allclose(gradient, expected, atol=1e-8 * (1 + np.linalg.norm(gradient)))
    assert np.all(np.abs(gradient[[0, 2, 3, 5]]) > 1e-3)

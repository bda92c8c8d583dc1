"""Mass matrix and Jacobian by four routes: on paper, Pinocchio, finite differences, MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from lxml import etree

import flexmodal
from flexmodal.cards import shipped_cards
from flexmodal.model import PosedRobot, Robot
from flexmodal.model.placements import link_placements

from ..model.writing import mixed, planar
from .planar_chain import FANUC, SIX_LINK, PlanarChain

# Both sides do the same few dozen products of numbers of order one and ten; what differs is rounding, some
# 1e-15 of the largest entry. 1e-12 leaves room for the inertias that MuJoCo diagonalises.
ROUNDING = 1e-12


@pytest.fixture
def mixed_robot(tmp_path: Path) -> Robot:
    return flexmodal.load(mixed(tmp_path / "mixed.urdf"), stiffness={"turn": 2e4, "lift": 1e4}, tool="tool")


@pytest.fixture
def robots(mixed_robot: Robot) -> dict[str, Robot]:
    return {
        "six_link": flexmodal.load("six_link"),
        "fanuc_s360": flexmodal.load("fanuc_s360"),
        "ur5": flexmodal.load("ur5", stiffness=1e4),
        "mixed": mixed_robot,
    }


NAMES = ["six_link", "fanuc_s360", "ur5", "mixed"]


def random_posture(robot: Robot, generator: np.random.Generator) -> PosedRobot:
    draw = {
        name: float(generator.uniform(max(joint.lower, -3.0), min(joint.upper, 3.0)))
        for name, joint in robot.commanded.items()
    }
    return robot.at(draw)


def whole(robot: Robot) -> Robot:
    """The same URDF with every joint flexible, so that its D is that of all joints that move."""
    return flexmodal.load(robot.urdf.path, stiffness=1.0, tool=robot.tool)


# On paper.


def test_two_links_on_paper(tmp_path):
    """The 2 × 2 matrix of every textbook, with link lengths, mass centres and moments all different."""
    l1, l2, m1, m2, i1, i2, c1, c2 = 0.7, 0.45, 6.0, 3.5, 0.31, 0.12, 0.33, 0.17
    robot = flexmodal.load(
        planar(tmp_path / "two.urdf", [l1, l2], [m1, m2], [i1, i2], [c1, c2]), stiffness=1.0
    )
    for q1, q2 in [(0.0, 0.0), (0.4, -1.3), (2.0, np.pi / 2), (-1.0, np.pi)]:
        elbow = m2 * (c2**2 + l1 * c2 * np.cos(q2)) + i2
        first = m1 * c1**2 + i1 + m2 * (l1**2 + c2**2 + 2 * l1 * c2 * np.cos(q2)) + i2
        paper = np.array([[first, elbow], [elbow, m2 * c2**2 + i2]])
        posed = robot.at({"q1": q1, "q2": q2})
        np.testing.assert_allclose(posed.system.mass, paper, rtol=ROUNDING)
        s1, c1_, s12, c12 = np.sin(q1), np.cos(q1), np.sin(q1 + q2), np.cos(q1 + q2)
        rows = [[-l1 * s1 - l2 * s12, -l2 * s12], [0, 0], [l1 * c1_ + l2 * c12, l2 * c12]]
        turns = [[0, 0], [-1, -1], [0, 0]]  # the axis is −y
        np.testing.assert_allclose(posed.jacobian("tool"), rows + turns, atol=ROUNDING)


@pytest.mark.parametrize(("name", "chain"), [("six_link", SIX_LINK), ("fanuc_s360", FANUC)])
def test_planar_formula(name: str, chain: PlanarChain):
    robot, generator = flexmodal.load(name), np.random.default_rng(1)
    for _ in range(20):
        posed = random_posture(robot, generator)
        angles = np.array([posed.posture.values.get(joint, 0.0) for joint in robot.moving])
        mass = chain.mass_matrix(angles)
        np.testing.assert_allclose(posed.system.mass, mass, atol=ROUNDING * mass.max())
        x, z, turn = chain.tool(angles)
        nothing = np.zeros_like(x)
        np.testing.assert_allclose(
            posed.jacobian("tool"), [x, nothing, z, nothing, -turn, nothing], atol=ROUNDING * 6
        )
        last = len(angles) - 1
        np.testing.assert_allclose(
            posed.position("tool")[[0, 2]],
            chain.position(angles, last, chain.lengths[last]),
            atol=ROUNDING * 6,
        )


def test_points_along_the_fanuc():
    """The six places of the hammer test, on paper: bar, and distance along it."""
    robot = flexmodal.load("fanuc_s360")
    places = [(3, 0.23), (2, 0.78), (2, 0.57), (2, 0.38), (2, 0.01), (0, 0.85)]
    posed = robot.at("configuration_2")
    angles = np.array([posed.posture.values.get(joint, 0.0) for joint in robot.moving])
    for number, (bar, along) in enumerate(places, start=1):
        rows = FANUC.rows(angles, bar, along)
        found = posed.jacobian(f"location_{number}")
        np.testing.assert_allclose(found[[0, 2, 4]], rows * [[1], [1], [-1]], atol=ROUNDING)


# Finite differences: of positions for the Jacobian, of kinetic energy for the mass matrix.


def placements(robot: Robot, values: np.ndarray) -> Any:
    return link_placements(robot, dict(zip(robot.moving, values, strict=True)))


def central(function: Callable[[float], Any], step: float = 1e-3) -> Any:
    """Fourth-order central difference at 0; truncation step⁴ f⁽⁵⁾/30, rounding 1.5e-16 f / step."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_against_moved_positions(robots, name):
    robot, generator = robots[name], np.random.default_rng(2)
    posed = random_posture(robot, generator)
    values = np.array([posed.posture.values.get(joint, 0.0) for joint in robot.moving])
    turned = placements(robot, values)[robot.tool][:3, :3]
    for column, unit in enumerate(np.eye(len(values))):
        rate = central(lambda h, unit=unit: placements(robot, values + h * unit)[robot.tool])
        spin = rate[:3, :3] @ turned.T
        expected = [*rate[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]]
        # step⁴/30 ≈ 3e-14 times a reach of 6 m, and 1e-16 × 6 / 1e-3 ≈ 1e-12 of rounding
        np.testing.assert_allclose(posed.full_jacobian(robot.tool)[:, column], expected, atol=1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_mass_matrix_against_kinetic_energy(robots, name):
    """T = ½ q̇ᵀ D q̇, with the speeds of every link's mass centre and frame by finite differences."""
    robot, generator = whole(robots[name]), np.random.default_rng(3)
    posed = random_posture(robot, generator)
    values = np.array([posed.posture.values.get(joint, 0.0) for joint in robot.moving])
    here = placements(robot, values)
    for _ in range(4):
        speed = generator.normal(size=len(values))
        rates = {
            link.name: central(lambda h, n=link.name, s=speed: placements(robot, values + h * s)[n])
            for link in robot.urdf.links
        }
        energy = 0.0
        for link in robot.urdf.links:
            if link.mass is None:
                continue
            rate, turned = rates[link.name], here[link.name][:3, :3]
            centre = rate[:3, :3] @ link.com + rate[:3, 3]
            spin = rate[:3, :3] @ turned.T
            omega = turned.T @ np.array([spin[2, 1], spin[0, 2], spin[1, 0]])  # in the axes of the link
            energy += 0.5 * link.mass * centre @ centre + 0.5 * omega @ link.inertia @ omega
        # velocities come to about 1e-11 of their size, and enter twice
        assert 0.5 * speed @ posed.system.mass @ speed == pytest.approx(energy, rel=1e-10)


# MuJoCo.


class Mujoco:
    """MuJoCo's view of the same URDF.

    It compiles URDF itself. Visuals and collisions are taken out (no mesh files wanted), fixed links stay
    bodies of their own, and inertias are taken as written: with balanceinertia MuJoCo would mend them.
    """

    def __init__(self, robot: Robot) -> None:
        root = etree.fromstring(robot.urdf.text.encode())
        for link in root.iter("link"):
            for shape in [*link.findall("visual"), *link.findall("collision")]:
                link.remove(shape)
        options = {"fusestatic": "false", "discardvisual": "true", "balanceinertia": "false"}
        etree.SubElement(etree.SubElement(root, "mujoco"), "compiler", options)
        self.model = mujoco.MjModel.from_xml_string(etree.tostring(root, encoding="unicode"))
        self.data = mujoco.MjData(self.model)
        assert [self.model.joint(number).name for number in range(self.model.njnt)] == list(robot.moving)
        assert not np.any(self.model.dof_armature)

    def pose(self, posed: PosedRobot) -> None:
        self.data.qpos[:] = [posed.posture.values.get(name, 0.0) for name in posed.robot.moving]
        mujoco.mj_forward(self.model, self.data)

    @property
    def mass(self) -> np.ndarray:
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        return full

    def jacobian(self, link: str) -> np.ndarray:
        linear, angular = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        mujoco.mj_jacBody(self.model, self.data, linear, angular, self.model.body(link).id)
        return np.vstack([linear, angular])


@pytest.mark.parametrize("name", [*NAMES, "xarm7", "kinova"])
def test_mujoco(robots, name):
    robot = whole(robots[name]) if name in robots else flexmodal.load(name, stiffness=1e4)
    other, generator = Mujoco(robot), np.random.default_rng(4)
    for _ in range(5):
        posed = random_posture(robot, generator)
        other.pose(posed)
        mass = posed.system.mass
        np.testing.assert_allclose(mass, other.mass, atol=ROUNDING * mass.max())
        for link in (robot.tool, robot.urdf.links[-2].name):
            np.testing.assert_allclose(posed.full_jacobian(link), other.jacobian(link), atol=ROUNDING * 6)
            np.testing.assert_allclose(posed.position(link), other.data.body(link).xpos, atol=ROUNDING * 6)


def test_rotor_inertia_is_mujocos_armature(tmp_path, robots):
    """The card's rotor inertia and MuJoCo's armature are the same thing."""
    base = robots["fanuc_s360"].urdf.path
    card = shipped_cards()["fanuc_s360"].read_text(encoding="utf-8")
    card = card.replace('urdf = "../../urdf/fanuc_s360.urdf"', f'urdf = "{base}"')
    card = card.replace("[joint.q2]", "[joint.q2]\nrotor_inertia = 0.75")
    (tmp_path / "robot.toml").write_text(card, encoding="utf-8")
    robot = flexmodal.load(tmp_path)
    other = Mujoco(robot)
    other.model.dof_armature[1] = 0.75
    posed = robot.at("configuration_3")
    other.pose(posed)
    np.testing.assert_allclose(posed.system.mass, other.mass, atol=ROUNDING * other.mass.max())


@pytest.mark.parametrize("name", NAMES)
def test_receptance_from_mujocos_matrices(robots, name):
    """Nothing of flexmodal but the card: α = J Z⁻¹ Jᵀ with numpy, 3 × 3, all lines."""
    robot, generator = robots[name], np.random.default_rng(5)
    other = Mujoco(robot)
    posed = random_posture(robot, generator)
    other.pose(posed)
    order = list(robot.moving)
    pick = [order.index(joint) for joint in robot.joints]
    stiffness = np.diag([joint.stiffness for joint in robot.joints.values()])
    damping = np.diag([joint.damping for joint in robot.joints.values()])
    mass, rows = other.mass[np.ix_(pick, pick)], other.jacobian(robot.tool)[:3, pick]
    lines = np.array([0.0, 1.0, 7.3, 20.0, 55.5, 200.0])
    axes = [f"{robot.tool}:{axis}" for axis in "xyz"]
    found = posed.frf(lines, response=axes).value
    for line, frequency in enumerate(lines):
        omega = 2 * np.pi * frequency
        expected = rows @ np.linalg.inv(stiffness - omega**2 * mass + 1j * omega * damping) @ rows.T
        # rounding, amplified by the condition of Z: some 1e3, the spread of the stiffnesses
        np.testing.assert_allclose(found[line], expected, atol=1e-11 * np.abs(expected).max())

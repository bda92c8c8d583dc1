"""The page's own mechanics against Python's, to nine digits: two programs that share no line."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from flexmodal_viewer import show_robot
from flexmodal_viewer.live_numbers import live_numbers
from flexmodal_viewer.live_outcome import judged

from flexmodal.campaign import CampaignPoint
from flexmodal.frf import PointDirection
from flexmodal.frf.receptance import dynamic_stiffness
from flexmodal.model import load
from flexmodal.model.placements import link_placements
from flexmodal.optimisation import (
    MobilityObjective,
    ReceptanceObjective,
    SeparationObjective,
    StiffnessObjective,
)

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)

LINES = np.linspace(0, 120, 60)
CLOSE = 1e-9

LOSSY = """
format = 1
name = "lossy"
title = "Springs that lose energy"
source = "made up"
urdf = "{urdf}"
tool = "tool"
{frequency}
[joint.q1]
stiffness = 5.5e5
damping = 0.0
loss_factor = 0.05
[joint.q2]
stiffness = 8e5
damping = 300.0
loss_factor = 0.02
[joint.q3]
stiffness = 4e5
damping = 180.0
[joint.q5]
stiffness = 4.5e4
damping = 0.0
loss_factor = 0.1
"""


LINK = """<link name="{0}"><inertial><mass value="{1}"/><origin xyz="0.1 0.02 0.3" rpy="0.2 0.1 0"/>
  <inertia ixx="0.3" iyy="0.25" izz="0.1" ixy="0.01" ixz="0.02" iyz="0"/></inertial>
  <visual><origin xyz="0 0 0.2"/><geometry><box size="0.1 0.1 0.4"/></geometry></visual></link>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="{4}"/>
  <origin xyz="{5}" rpy="0.1 0.3 -0.2"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""


def branching(folder):
    """A trunk with two arms on it, one of which slides; the tool is on the second."""
    links = [("trunk", 20), ("left", 8), ("left_hand", 3), ("right", 7), ("tip", 2)]
    joints = [
        ("turn", "revolute", "ground", "trunk", "0 0 1", "0 0 0.2"),
        ("lift", "revolute", "trunk", "left", "0 1 0", "0 0.3 0.8"),
        ("reach", "prismatic", "left", "left_hand", "0 0 1", "0 0 0.4"),
        ("lower", "revolute", "trunk", "right", "1 0 0", "0 -0.3 0.8"),
        ("bend", "revolute", "right", "tip", "0 1 0", "0 0 0.5"),
    ]
    parts = [LINK.format(*one) for one in links] + [JOINT.format(*one) for one in joints]
    path = folder / "two_arms.urdf"
    path.write_text(f'<robot name="two_arms"><link name="ground"/>{"".join(parts)}</robot>')
    return load(path, stiffness=3e4, damping=15.0, tool="tip")


@pytest.fixture(scope="module")
def browser():
    with live.chromium() as found:
        yield found


def _lossy(folder, frequency):
    path = folder / "robot.toml"
    urdf = Path(__file__).parents[2] / "urdf" / "six_axis.urdf"
    path.write_text(LOSSY.format(urdf=urdf, frequency=frequency))
    return load(path)


@pytest.fixture(
    params=["six_axis", "fanuc_s360", "six_link", "xarm7", "lossy", "lossy at a frequency", "branching"],
    scope="module",
)
def robot(request, tmp_path_factory):
    if request.param.startswith("lossy"):
        given = "loss_frequency = 10.0" if "frequency" in request.param else ""
        return _lossy(tmp_path_factory.mktemp("lossy"), given)
    if request.param == "branching":
        return branching(tmp_path_factory.mktemp("tree"))
    bare = {"stiffness": 2e4, "damping": 2.0} if request.param == "xarm7" else {}
    return load(request.param, **bare)


@pytest.fixture(scope="module")
def tab(browser, tmp_path_factory):
    """One page; the robots are put into it as they would come with their own."""
    arm = load("six_axis")
    out = tmp_path_factory.mktemp("live") / "page.html"
    path = show_robot(arm, arm.posture("work"), out=out, announce=lambda _: None)
    with live.opened(browser, path, width=400, height=300) as found:
        yield found


@pytest.fixture(scope="module")
def page(robot, tab):
    tab.evaluate("(numbers) => { window.robot = flexmodalLive.make(numbers); }", live_numbers(robot))
    return tab


def _postures(robot, count=6):
    rng = np.random.default_rng(7)
    for _ in range(count):
        values = {
            name: rng.uniform(max(joint.lower, -np.pi), min(joint.upper, np.pi))
            for name, joint in robot.commanded.items()
        }
        yield robot.at(values), [values.get(name, 0.0) for name in robot.moving]


def _complex(pairs):
    return np.array(pairs) @ [1, 1j]


def _off(found, wanted, axis=None):
    size = np.max(np.abs(wanted), axis=axis)
    return float(np.max(np.max(np.abs(found - wanted), axis=axis) / np.where(size > 0, size, 1)))


def test_mass_places_and_receptance(robot, page):
    script = """([q, lines]) => {
      const at = robot.at(q);
      const h = at.frf(lines, robot.direction("tool:+z"), robot.direction("tool:-x"));
      return { mass: [...at.system.mass], re: [...h.re], im: [...h.im], place: at.position("tool"),
               turn: at.turned("tool"), jacobian: at.jacobian("tool").map((row) => [...row]) };
    }"""
    for posed, q in _postures(robot):
        found = page.evaluate(script, [q, LINES.tolist()])
        mass = posed.system.mass
        assert _off(np.array(found["mass"]).reshape(mass.shape), mass) < CLOSE
        wanted = posed.frf(LINES, response="tool:+z", reference="tool:-x").value[:, 0, 0]
        assert _off(np.array(found["re"]) + 1j * np.array(found["im"]), wanted) < CLOSE
        assert _off(np.array(found["place"]), posed.position("tool")) < CLOSE
        assert _off(np.array(found["turn"]).reshape(3, 3), posed.rotation("tool")) < CLOSE
        assert _off(np.array(found["jacobian"]), posed.full_jacobian("tool")) < CLOSE


def test_modes_and_shares_of_energy(robot, page):
    script = """(q) => {
      const at = robot.at(q), modes = at.modes();
      return { pole: modes.map((m) => m.pole), shares: modes.map((m) => at.shares(m.shape)),
               shape: modes.map((m) => m.shape.re.map((x, i) => [x, m.shape.im[i]])) };
    }"""
    for posed, q in _postures(robot):
        found, modes = page.evaluate(script, q), posed.modes()
        assert len(found["pole"]) == len(modes.pole)
        assert np.max(np.abs(_complex(found["pole"]) - modes.pole) / np.abs(modes.pole)) < CLOSE
        assert _off(_complex(found["shape"]).T, modes.shape, axis=0) < CLOSE
        elastic = np.array([(u.conj() * (posed.system.stiffness @ u)).real for u in modes.shape.T])
        assert _off(np.array(found["shares"]), elastic / elastic.sum(axis=1, keepdims=True)) < CLOSE


def test_ellipsoid(robot, page):
    script = "([q, hertz]) => robot.at(q).ellipsoid('tool', hertz)"
    for posed, q in _postures(robot, 3):
        for hertz in (0.0, 7.0):
            found = page.evaluate(script, [q, hertz])
            alpha = posed.frf([hertz], response=["tool:+x", "tool:+y", "tool:+z"]).value[0]
            # a force along its longest axis moves the tool as far as that is long, and no other does more
            answered = np.linalg.norm(alpha @ np.array(found["axes"][2]))
            assert answered == pytest.approx(found["lengths"][2], rel=CLOSE)
            forces = np.random.default_rng(0).normal(size=(200, 3))
            forces /= np.linalg.norm(forces, axis=1, keepdims=True)
            assert np.max(np.linalg.norm(forces @ alpha.T, axis=1)) <= answered * (1 + CLOSE)


SLANTED = ((0.6, 0.8, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 1.0))


@pytest.mark.parametrize(("axes", "frame"), [(None, "link"), (SLANTED, "link"), (SLANTED, "world")])
def test_a_point_with_axes_of_its_own(tab, axes, frame):
    robot = load("six_axis")
    point = CampaignPoint(1, "cell", "link_4", (0.1, 0.05, 0.2), axes, frame)
    script = """([numbers, q, lines]) => {
      const robot = flexmodalLive.make(numbers), at = robot.at(q);
      const h = at.frf(lines, robot.direction("cell:+x"), robot.direction("cell:-y"));
      return { re: [...h.re], im: [...h.im], along: at.along(robot.direction("cell:-y")) };
    }"""
    for posed, q in _postures(robot, 3):
        found = tab.evaluate(script, [live_numbers(robot, (), {"cell": point}), q, LINES.tolist()])
        place = link_placements(robot, posed.posture.values)["link_4"]
        moved, lever = posed.jacobian("link_4"), place[:3, :3] @ np.array(point.xyz)
        whole = moved[:3] + np.cross(moved[3:], lever, axis=0)
        rows = [point.way(one, place[:3, :3]) @ whole for one in (1, -2)]
        wanted = [rows[0] @ np.linalg.solve(z, rows[1]) for z in dynamic_stiffness(posed.system, LINES)]
        assert _off(np.array(found["re"]) + 1j * np.array(found["im"]), np.array(wanted)) < CLOSE
        assert np.allclose(found["along"], point.way(-2, place[:3, :3]), atol=1e-12)


WAYS = tuple(PointDirection("tool", axis) for axis in "xyz")
JUDGES = {
    f"{combine}, {over}": ReceptanceObjective(
        WAYS,
        np.array([7.0, 14.0, 21.0]),
        combine,
        (1.0, -2.0, 0.5),
        (0.0, 0.0, 1.0) if combine == "weighted" else (),
        over,
        (1.0, 0.7, 0.4),
    )
    for combine in ("weighted", "force", "worst")
    for over in ("mean", "largest")
} | {
    "stiffness": StiffnessObjective(WAYS[2]),
    "stiffness of the position": StiffnessObjective(WAYS[0], task="position"),
    "mobility": MobilityObjective(WAYS[1]),
    "separation": SeparationObjective(),
    "separation from a frequency": SeparationObjective(20.0),
}


@pytest.mark.parametrize("name", JUDGES)
def test_what_a_search_judges_by(tab, name):
    robot = load("six_axis")
    judge = JUDGES[name]
    script = """([told, numbers, q]) => {
      const robot = flexmodalLive.make(numbers);
      return flexmodalLive.judge(robot, told)(robot.at(q));
    }"""
    for posed, q in _postures(robot, 3):
        found = tab.evaluate(script, [judged(judge, robot), live_numbers(robot), q])
        assert found == pytest.approx(judge.value(posed), rel=CLOSE)


def test_links_stand_where_python_puts_them(tab):
    robot = load("six_axis")
    script = """(q) => {
      const { robot, picture } = flexmodalLive;
      picture.arm("arm", robot.at(q).placed);
      return robot.numbers.links.map((_, i) => {
        const node = flexmodalPage.node("/flexmodal/arm/link_" + i);
        node.updateMatrix();
        return [...node.matrix.elements];
      });
    }"""
    for posed, q in _postures(robot, 2):
        found = np.array(tab.evaluate(script, q)).reshape(-1, 4, 4).transpose(0, 2, 1)
        placed = link_placements(robot, posed.posture.values)
        wanted = np.array([placed[link.name] for link in robot.urdf.links])
        assert _off(found, wanted) < 1e-8  # three.js keeps turns as quaternions


@pytest.mark.slow
def test_an_arm_that_branches_is_moved_too(browser, tmp_path):
    robot = branching(tmp_path)
    page = show_robot(robot, robot.posture({}), out=tmp_path / "page.html", announce=lambda _: None)
    with live.opened(browser, page) as tab:
        slider = "(range) => { range.value = 0.7; range.dispatchEvent(new Event('input')); }"
        tab.get_by_label("lift").evaluate(slider)  # of the arm that does not carry the tool
        q = dict(zip(robot.moving, map(float, tab.evaluate("flexmodalLive.state.q")), strict=True))
        assert q["lift"] == pytest.approx(0.7)
        lines, re, im = tab.evaluate(
            "(({ curve, lines }) => [lines, curve.re, curve.im].map((x) => [...x]))(flexmodalLive.found())"
        )
        wanted = robot.at(q).frf(lines).value[:, 0, 0]
        assert _off(np.array(re) + 1j * np.array(im), wanted) < CLOSE
        links = tab.evaluate(
            """() => flexmodalLive.robot.numbers.links.map((_, i) => {
              const node = flexmodalPage.node("/flexmodal/arm/link_" + i);
              node.updateMatrix();
              return [...node.matrix.elements];
            })"""
        )
        placed = link_placements(robot, q)
        wanted = np.array([placed[link.name] for link in robot.urdf.links])
        assert _off(np.array(links).reshape(-1, 4, 4).transpose(0, 2, 1), wanted) < 1e-8


def test_self_motion_leaves_the_tool(robot, page):
    script = """(q) => {
      const way = Hold.selfMotion(robot, q, "tool", false, robot.numbers.commanded.map((_, k) => 1 + k));
      return way.map((stop) => stop.q);
    }""".replace("Hold.", "flexmodalLive.hold.")
    moved = []
    for posed, q in _postures(robot, 2):
        stops = page.evaluate(script, q)
        names = list(robot.moving)
        for stop in stops[:: max(1, len(stops) // 4)]:
            values = {name: stop[names.index(name)] for name in robot.commanded}
            off = robot.at(values).position("tool") - posed.position("tool")
            assert np.linalg.norm(off) < 1e-8
        moved.append(np.ptp(np.array(stops), axis=0).max())
    assert max(moved) > 0.05

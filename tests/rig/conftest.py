from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.model import Robot
from flexmodal.rig import ParameterError
from flexmodal.rig.believed import true_robot
from flexmodal.rig.effects import Effect, Site, Stand
from flexmodal.rig.forms import find
from flexmodal.rig.hammer_test import Conduct, h1, strike_posture
from flexmodal.rig.integration.laws import LAWS
from flexmodal.rig.plan import make_plan
from flexmodal.rig.plant.build import build
from flexmodal.rig.simulate import make_stand

_LINK = """
  <link name="link_{k}"><inertial><origin xyz="0.5 0 0"/><mass value="4"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.33333333333333333" iyz="0"
    izz="0.33333333333333333"/></inertial></link>
  <joint name="q{k}" type="revolute"><parent link="{parent}"/><child link="link_{k}"/>
    <origin xyz="{x} 0 0"/><axis xyz="0 -1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>"""

_CARD = """format = 1
name = "bars"
title = "uniform bars of 4 kg and 1 m"
urdf = "bars.urdf"
tool = "link_{last}"
source = "made up for a test"
{joints}
[point.middle]
link = "link_{last}"
xyz = [0.5, 0.0, 0.0]
[point.tip]
link = "link_{last}"
xyz = [1.0, 0.0, 0.0]
[posture.flat]
{first} = 0.0
[posture.raised]
{first} = 0.7
"""


@pytest.fixture
def bars(tmp_path: Path) -> Callable[..., Robot]:
    """A planar chain of uniform bars: mass 4 kg, length 1 m, all along x at rest."""

    def make(count: int = 1, stiffness: float = 4e4, damping: float = 4.0) -> Robot:
        links = "".join(
            _LINK.format(k=k, parent="base" if k == 1 else f"link_{k - 1}", x=0 if k == 1 else 1)
            for k in range(1, count + 1)
        )
        (tmp_path / "bars.urdf").write_text(f'<robot name="bars"><link name="base"/>{links}</robot>')
        joints = "".join(
            f"[joint.q{k}]\nstiffness = {stiffness!r}\ndamping = {damping!r}\n" for k in range(1, count + 1)
        )
        (tmp_path / "robot.toml").write_text(_CARD.format(last=count, joints=joints, first="q1"))
        return flexmodal.load(tmp_path / "robot.toml")

    return make


@pytest.fixture
def stand() -> Callable[..., Stand]:
    """A stand without parameter errors; keywords go to the plan."""

    def make(robot: Robot, error: float = 0.0, **given: object) -> Stand:
        plan = {
            "postures": 1, "points": None, "references": 1, "axes": None, "frame": "world", "trials": 1,
            "averages": 1,
            "peaks": (60.0, 240.0), "tip": "soft", "band": (2.0, 100.0), "record_length": 2.0,
            "random": np.random.default_rng(0),
        } | given  # fmt: skip
        true = true_robot(robot, ParameterError.all(error), np.random.default_rng([0, 4]))
        return make_stand(robot, make_plan(robot, **plan), true)

    return make


@pytest.fixture
def hidden() -> Callable[..., tuple[Effect, Site]]:
    """An effect at a place, with given parameters over drawn ones."""

    def make(stand: Stand, name: str, where: str, **given: float) -> tuple[Effect, Site]:
        effect = find(*name.split(":"))
        drawn = effect.draw(stand, where, np.random.default_rng(1))
        assert set(given) <= set(drawn)
        return effect, Site(stand, where, {**drawn, **given})

    return make


@pytest.fixture
def bench(bars, stand):
    """One bar, struck at its tip."""
    return stand(bars(), references=["tip:+z"], postures=["flat"])


@pytest.fixture
def stiff(bars, stand):
    """The same with a locked joint."""
    return stand(bars(stiffness=1e13, damping=0.0), references=["tip:+z"], postures=["flat"])


@pytest.fixture
def pair(bars, stand):
    """Two bars."""
    return stand(bars(count=2), references=["tip:+z"], postures=["flat"])


K, B, I = 4e4, 4.0, 4.0 / 3  # the bar: joint stiffness and damping, moment about the joint  # noqa: E741
FREQUENCY = np.linspace(2, 100, 300)
S = 2j * np.pi * FREQUENCY


def put(bench, *specs):
    """The plant in the first posture, with effects in it."""
    return build(bench, bench.plan.postures[0], specs)


def pulled(bench, spec, path, speed=1e-4) -> np.ndarray:
    """Torque of the elements along a path from rest, so many seconds from place to place."""
    total = np.zeros(len(path))
    for element in put(bench, spec).elements:
        law, numbers, memory, old = LAWS[element.kind], np.array(element.parameters), np.zeros(1), np.zeros(1)
        for number, place in enumerate(path):
            new = np.array([place])
            pull, memory = law(numbers, old, new, (new - old) / speed, memory)
            total[number], old = total[number] + pull[0], new
    return total


def measured(bench, *specs) -> np.ndarray:
    """Clean FRFs [point, line] of one hammer position and one axis."""
    posture, quiet = bench.plan.postures[0], Conduct(noise=0.0, scatter=0.0)
    return h1(strike_posture(bench, posture, specs, quiet))[0][0, 0, :, 0]


def tip(plant, place=1.0) -> np.ndarray:
    return plant.row("link_1", np.array([place, 0, 0]), np.array([0, 0, 1.0]))


def inertance(plant) -> np.ndarray:
    return plant.inertance(tip(plant)[None], tip(plant)[None], FREQUENCY)[:, 0, 0]

"""Pictures: they show the numbers of the search, and name what is on their axes."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.optimisation import (
    CombinedObjective,
    Hold,
    PostureProblem,
    ReceptanceObjective,
    SeparationObjective,
    StiffnessObjective,
    TunedObjective,
    optimise,
)
from flexmodal.optimisation.objectives import RobustObjective, sample_robots
from flexmodal.optimisation.pictures.plot import draw_postures, draw_receptances, draw_self_motion

pytestmark = pytest.mark.usefixtures("types_unchecked")


@pytest.fixture(scope="module")
def held(arm):
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([5.0]))
    return PostureProblem(arm, judge, Hold.at(arm, (-2.0, 2.0)))


@pytest.fixture(scope="module")
def found(held):
    return optimise(held, start="start_2", starts=1)


def test_receptances(arm, found):
    frequencies = np.array([1.0, 5.0, 20.0])
    figure = draw_receptances(found, arm.posture("start_2"), frequencies)
    after = figure.axes[0].lines[1].get_ydata()
    assert after[1] == pytest.approx(found.best.objective, rel=1e-9)
    assert "[Hz]" in figure.axes[1].get_xlabel()


def test_receptance_of_several_directions_is_drawn_as_judged(arm, held):
    directions = tuple(PointDirection("tool", axis) for axis in "xz")
    judge = ReceptanceObjective(directions, np.array([5.0, 10.0]), "force", (1.0, 2.0))
    outcome = optimise(replace(held, objective=judge), start="start_2", starts=1)
    figure = draw_receptances(outcome, outcome.compared.held, np.array([5.0, 10.0]))
    before, after = (line.get_ydata() for line in figure.axes[0].lines[:2])
    assert np.mean(after) == pytest.approx(outcome.best.objective, rel=1e-9)
    assert np.mean(before) == pytest.approx(outcome.start, rel=1e-9)
    assert "‖αw‖ [m/N]" in figure.axes[0].get_ylabel()


@pytest.mark.parametrize(
    "judge",
    [
        StiffnessObjective(PointDirection("tool", "z")),
        TunedObjective(PointDirection("tool", "z"), (1.0, 6.0)),
        SeparationObjective(5.0),
        pytest.param(
            CombinedObjective((SeparationObjective(5.0), StiffnessObjective(PointDirection("tool", "x")))),
            marks=pytest.mark.slow,
        ),
    ],
    ids=["stiffness", "tuned", "separation", "product"],
)
def test_receptance_of_other_objectives(arm, held, judge):
    """Along their direction, over an axis with the modes inside."""
    sample = RobustObjective(judge, sample_robots(arm, 2))
    outcome = optimise(replace(held, objective=sample), start="start_2", starts=1)
    figure = draw_receptances(outcome, None)
    (line,) = figure.axes[0].lines
    modes = arm.modes(outcome.best.posture).frequency
    assert line.get_xdata()[0] < modes.min()
    assert line.get_xdata()[-1] > modes.max()
    assert np.all(np.isfinite(line.get_ydata()))


def test_postures(arm, ur5, held, found):
    figure = draw_postures(arm, {"best": found.best.posture}, target=held.hold)
    line, cross = figure.axes[0].lines
    np.testing.assert_allclose(np.array(line.get_xydata())[-1], [-2, 2], atol=1e-9)
    np.testing.assert_allclose(cross.get_xydata()[0], [-2, 2])
    assert len(line.get_xdata()) == 8  # base, six joints, tool
    assert [axes.get_ylabel() for axes in draw_postures(ur5, {"zero": ur5.posture({})}).axes] == [
        "z [m]",
        "y [m]",
    ]


def test_self_motion(arm, held, found):
    """The middle of the map is the optimum, and nothing on it is less."""
    mesh = draw_self_motion(held, found.best.posture, reach=0.4, count=9).axes[0].collections[0]
    values = np.asarray(mesh.get_array()).reshape(9, 9)
    assert values[4, 4] == pytest.approx(found.best.objective, rel=1e-9)
    assert values.min() == values[4, 4]
    turned = replace(held, hold=Hold.at(arm, (-2.0, 2.0), orientation=(1.0,)))
    once = optimise(turned, starts=2, seed=4)
    assert draw_self_motion(turned, once.best.posture, reach=0.2, count=5).axes


def test_long_joint_names_fit_the_picture():
    """Of an arm whose joints are named at length, the labels of both axes are broken."""
    robot = load("ur5", stiffness=2e4)
    bench = {
        "shoulder_lift_joint": -1.6,
        "elbow_joint": 1.2,
        "wrist_1_joint": -1.1708,
        "wrist_2_joint": -1.5708,
    }
    judge = ReceptanceObjective((PointDirection(robot.tool, "z"),), np.array([10.0]))
    place = tuple(float(x) for x in robot.at(bench).position(robot.tool))
    problem = PostureProblem(robot, judge, Hold.at(robot, place))
    figure = draw_self_motion(problem, robot.posture(bench), count=3)
    axes = figure.axes[0]
    for label in (axes.get_xlabel(), axes.get_ylabel()):
        assert max(len(line) for line in label.splitlines()) <= 42  # in one line it had a hundred

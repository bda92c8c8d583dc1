"""Pictures: they show the numbers of the search, and name what is on their axes."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.frf import PointDirection
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, optimise
from flexmodal.optimisation.descent import descend
from flexmodal.optimisation.null_space import null_space_descent
from flexmodal.optimisation.plot import (
    Trace,
    draw_postures,
    draw_receptances,
    draw_self_motion,
    draw_traces,
    draw_workspace,
    workspace_map,
)

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


def test_workspace(held):
    """Nothing at 8 m from the base of an arm of 6 m, and the best of a search where there is."""
    first, second = np.array([-2.0, 8.0]), np.array([2.0])
    grid = workspace_map(held, first, second, starts=6)
    assert np.isnan(grid[0, 1])
    assert grid[0, 0] == pytest.approx(optimise(held, starts=6).best.objective, rel=1e-9)
    assert draw_workspace(held, first, second, grid).axes[0].get_xlabel() == "x [m]"


def test_traces(arm, held, found):
    start, traces = held.vector(arm.posture("start_2")), {}
    for search, rest in ((descend, {}), (null_space_descent, {"iterations": 20})):
        steps = []
        search(
            held, start, watch=lambda values, cost, steps=steps: steps.append((values.copy(), cost)), **rest
        )
        values, costs = zip(*steps, strict=True)
        traces[search.__name__] = Trace(np.array(values), np.exp(np.array(costs)))
    ours = traces["descend"].objective
    assert np.all(np.diff(ours) <= 0)
    assert ours[-1] == pytest.approx(found.best.objective, rel=1e-6)
    figure = draw_traces(held, traces)
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_ydata(), ours)

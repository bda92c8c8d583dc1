"""The map of the workspace: what a search at each place gives, and nothing where nothing reaches."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, StiffnessObjective, optimise
from flexmodal.optimisation.pictures.workspace import draw_workspace, extent, workspace_map

pytestmark = pytest.mark.usefixtures("types_unchecked")


@pytest.fixture
def held(arm):
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([5.0]))
    return PostureProblem(arm, judge, Hold.at(arm, (-2.0, 2.0)))


def test_workspace(held):
    """Nothing at 8 m from the base of an arm of 6 m, and the best of a search where there is."""
    first, second, told = np.array([-2.0, 8.0]), np.array([2.0]), []
    grid = workspace_map(held, first, second, starts=6, advance=lambda: told.append(1))
    assert len(told) == 2
    assert np.isnan(grid[0, 1])
    assert grid[0, 0] == pytest.approx(optimise(held, starts=6).best.objective, rel=1e-9)
    assert draw_workspace(held, first, second, grid).axes[0].get_xlabel() == "x [m]"


def test_height_and_orientation_stay(ur5):
    """In space the map is a slice; the tool stays turned as it was held."""
    judge = ReceptanceObjective((PointDirection("tool0", "z"),), np.array([20.0]))
    hold = Hold.at(ur5, (0.4, 0.2, 0.3), axis=(0.0, 0.0, -1.0))
    problem = PostureProblem(ur5, judge, hold)
    grid = workspace_map(problem, np.array([0.3]), np.array([0.35]), starts=4)
    there = replace(problem, hold=Hold.at(ur5, (0.3, 0.35, 0.3), axis=(0.0, 0.0, -1.0)))
    assert grid[0, 0] == pytest.approx(optimise(there, starts=4).best.objective, rel=1e-9)
    low, high = extent(problem).T
    assert np.all(low < -0.5)
    assert np.all(high > 0.5)
    figure = draw_workspace(problem, np.array([0.3, 0.4]), np.array([0.35, 0.4]), np.full((2, 2), 1e-5))
    assert "z = 0.3 m" in figure.axes[0].get_title(loc="left")


def test_zeros_do_not_swamp_the_others(held):
    """Straight above its base the arm can hang so that a vertical force does not move it."""
    first = second = np.array([-1.0, 1.0])
    figure = draw_workspace(held, first, second, np.array([[1e-5, 2e-5], [np.nan, 1e-16]]))
    low, high = figure.axes[0].collections[0].get_clim()
    assert (low, high) == pytest.approx((1e-5, 2e-5))
    assert "zero" in figure.legends[0].get_texts()[0].get_text()


def test_values_without_bound_do_not_swamp_the_others(held):
    judge = StiffnessObjective(PointDirection("tool", "z"))
    first = second = np.array([-1.0, 1.0])
    grid = np.array([[1e5, 2e5], [np.nan, 1e19]])
    figure = draw_workspace(replace(held, objective=judge), first, second, grid)
    assert figure.axes[0].collections[0].get_clim() == pytest.approx((1e5, 2e5))
    assert "without bound" in figure.legends[0].get_texts()[0].get_text()


def test_refusals(held):
    with pytest.raises(InvalidRequest, match="a hold"):
        extent(replace(held, hold=None))
    with pytest.raises(InvalidRequest, match="within reach"):
        draw_workspace(held, np.zeros(1), np.zeros(1), np.full((1, 1), np.nan))

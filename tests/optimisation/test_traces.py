"""Descents followed step by step: they are those of the searches, and end where those end."""

import numpy as np
import pytest

from flexmodal.errors import Unreachable
from flexmodal.frf import PointDirection
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, StiffnessObjective, optimise
from flexmodal.optimisation.pictures.traces import draw_traces, follow

pytestmark = pytest.mark.usefixtures("types_unchecked")


@pytest.fixture
def held(arm):
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([5.0]))
    return PostureProblem(arm, judge, Hold.at(arm, (-2.0, 2.0)))


def test_traces(arm, held):
    start = arm.posture("start_2")
    traces = {
        "newton": follow(held, start),
        "null-space": follow(held, start, "null-space", iterations=20),
    }
    ours, theirs = traces["newton"], traces["null-space"]
    assert np.all(np.diff(ours.objective) <= 0)
    found = optimise(held, start="start_2", starts=1)
    assert ours.objective[-1] == pytest.approx(found.best.objective, rel=1e-6)
    np.testing.assert_array_equal(theirs.values[0], held.vector(start))
    assert len(theirs.values) == 20
    gap = arm.at("start_2").position("tool")[[0, 2]] - [-2.0, 2.0]
    assert theirs.deviation[0] == pytest.approx(np.linalg.norm(gap))
    assert np.all(ours.deviation <= 1e-9)
    figure = draw_traces(held, traces)
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_ydata(), ours.objective)
    assert figure.axes[0].get_ylabel() == "Objective [m/N]"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(held.names)


def test_a_value_to_be_large_is_shown_as_itself(arm, held):
    problem = PostureProblem(arm, StiffnessObjective(PointDirection("tool", "z")), held.hold)
    trace = follow(problem, arm.posture("start_2"), iterations=3)
    assert trace.objective[0] == pytest.approx(problem.objective.value(problem.posed(trace.values[0])))
    assert np.all(np.diff(trace.objective) >= 0)


@pytest.mark.slow
def test_a_stretched_arm_is_led_off(arm, held):
    """Stretched along the way to the target no first step leads there: a small kick does."""
    stretched = arm.posture({"q1": np.radians(135)})
    assert follow(held, stretched).deviation[-1] <= 1e-9
    far = PostureProblem(arm, held.objective, Hold.at(arm, (7.0, 0.0)))
    with pytest.raises(Unreachable, match="the nearest was"):
        follow(far, stretched)

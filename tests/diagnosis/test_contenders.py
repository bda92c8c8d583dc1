"""Which explanations a further measurement is to tell apart, from comparisons that were made up."""

from types import SimpleNamespace

import numpy as np
import pytest

from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.next_measurement.contenders import contenders
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.decision import Choice, Round


def told(scores, chosen=None, *, beliefs=False, names=None):
    """A comparison: nothing added first, then effects a, b, c … and a mode with no structure last."""
    keys = [(NONE, ""), *((name, "q1") for name in names or "abc"[: len(scores) - 2]), (UNSTRUCTURED, "")]
    table = np.array(scores, dtype=float)[:, None]
    models = [SimpleNamespace(key=key, hypothesis=None, x=None, parameters=0) for key in keys]
    return Round(Comparison(models, table[:, 0], table, beliefs=beliefs), Choice(chosen))


def names(found):
    return [one.key[0] for one, _ in found]


def test_what_is_tied_comes_first_and_what_came_near_behind_it():
    one = told([-30.0, -0.2, 0.0, -9.0, -5.0], chosen=2)
    models = one.comparison.models
    found = contenders([one], (models[2], models[1]), open_=False)
    assert names(found) == ["b", "a", "c", NONE]
    assert all(weight >= 0.05 for _, weight in found)
    assert found[0][1] == pytest.approx(np.exp(0.0) / (1 + np.exp(-0.2)), abs=0.01)


def test_rivals_of_a_comparison_that_was_taken_back_stand_for_themselves():
    one, other = told([-30.0, 0.0, -0.1, -2.0]), told([-30.0, 0.0, -0.1, -2.0])
    rivals = one.comparison.models[1], other.comparison.models[2]
    assert contenders([one], rivals, open_=False) == [(rivals[0], 1.0), (rivals[1], 1.0)]
    assert contenders([], rivals, open_=False) == [(rivals[0], 1.0), (rivals[1], 1.0)]


def test_sets_of_beliefs_have_no_weights():
    one = told([-30.0, 0.0, -0.1, -2.0], beliefs=True)
    rivals = one.comparison.models[1], one.comparison.models[2]
    assert [weight for _, weight in contenders([one], rivals, open_=False)] == [1.0, 1.0]


def test_nothing_added_though_something_is_likelier_is_a_question():
    assert names(contenders([told([0.0, 4.0, -9.0, -20.0])], None, open_=False))[:2] == ["a", NONE]


def test_of_an_unknown_the_nearest_are_told_apart():
    one = told([-90.0, -40.0, -20.0, -70.0, 0.0])
    assert names(contenders([one], None, open_=True)) == ["b", "a", "c"]


def test_one_that_stands_alone_needs_no_measurement():
    assert len(contenders([told([-90.0, 0.0, -40.0, -50.0], chosen=1)], None, open_=False)) < 2
    assert contenders([], None, open_=True) == []

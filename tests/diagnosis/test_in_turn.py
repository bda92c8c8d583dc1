"""Of effects that gain about as much a linear one comes first: beside torques everything takes longer."""

from types import SimpleNamespace

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.in_turn import ABOUT_AS_MUCH, linear_first
from flexmodal.diagnosis.time_domain.model import has_law
from flexmodal.structure import robot_space

FRICTION, COUPLING, MASS = ("coulomb_friction", "q2"), ("joint_coupling", "q1+q2"), ("added_mass", "link_3")
OTHER, MODE = ("coulomb_friction", "q1"), (UNSTRUCTURED, "")


def compared(context, gains, before=()):
    """Models with one effect more each, which gain so much over what is there before."""
    root = Hypothesis(context, robot_space(context.robot))
    for name, where in before:
        root = root.and_also(Placed(catalogue()[name], where))
    given = {"x": None, "parameters": 0}
    models, scores = [SimpleNamespace(key=("none", ""), hypothesis=root, **given)], [0.0]
    for key, gain in gains.items():
        placed = root if key == MODE else root.and_also(Placed(catalogue()[key[0]], key[1]))
        models.append(SimpleNamespace(key=key, hypothesis=placed, **given))
        scores.append(gain)
    return Comparison(models, np.array(scores), np.tile(np.array(scores)[:, None], 3))


def is_slow(model):
    return has_law(model.hypothesis)


@pytest.mark.parametrize(
    ("gains", "first"),
    [
        ({FRICTION: 100.0, COUPLING: 90.0}, 2),
        ({FRICTION: 100.0, COUPLING: 90.0, MASS: 95.0}, 3),
        ({FRICTION: 100.0, COUPLING: 100 * ABOUT_AS_MUCH - 1}, 1),
        ({FRICTION: 100.0, OTHER: 99.0}, 1),
        ({FRICTION: 100.0, MODE: 99.0}, 1),
        ({COUPLING: 100.0, MASS: 99.0}, 1),
        ({FRICTION: 9.0, COUPLING: 7.5}, 1),
    ],
)
def test_the_best_linear_one_that_gains_about_as_much_comes_first(context, gains, first):
    """None that may not gain anything by itself, nor a mode that has no structure."""
    comparison = compared(context, gains)
    assert linear_first(comparison, 1, [Answer.YES] * (len(gains) + 1), {}, is_slow) == first


@pytest.mark.parametrize(
    ("before", "worth", "plausible"),
    [((), Answer.NO, {}), ((), Answer.YES, {1: 0.0}), ((OTHER,), Answer.YES, {})],
)
def test_where_nothing_is_won_by_it_the_best_comes_first(context, before, worth, plausible):
    """It explains everything, the other one takes too little, or there is such a torque already."""
    comparison = compared(context, {FRICTION: 100.0, COUPLING: 95.0}, before)
    assert linear_first(comparison, 1, [Answer.YES, Answer.YES, worth], plausible, is_slow) == 1

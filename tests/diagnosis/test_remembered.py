"""What was compared before is tried beside the effect that was added, before it is looked again."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection import frf_offers, in_its_stead
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.selection.frf_thresholds import REMEMBERED
from flexmodal.diagnosis.selection.looks_beside import LooksBeside
from flexmodal.diagnosis.setup import Setup
from flexmodal.structure import robot_space
from tests.diagnosis.conftest import known
from tests.diagnosis.test_follow import (
    BASE,
    DELAY,
    LINK,
    MASS,
    NOISE,
    PLAY,
    Model,
    Selection,
    World,
    fitted,
    steps,
)


class Remembering(World):
    """Where several are missing, which a look says that was taken."""

    several = True

    def __init__(self, left):
        super().__init__(left)
        self.tried = []

    def remembered(self, model, others):
        if not self.several or self.is_enough(model):
            return []
        keys = [one.key for one in others if one.keys and one.key not in model.keys]
        self.tried.append((model.keys, tuple(keys)))
        return [model, *(Model((*model.keys, key)) for key in keys)]


def followed(hidden, several=True):
    """Each that is missing leaves a factor of four."""
    data = Remembering(lambda keys: NOISE / 2 * 4.0 ** len(hidden - keys))
    data.several = several
    selection = Selection(data)
    selection.follow()
    return selection, data


@pytest.mark.parametrize("hidden", [{MASS, PLAY}, {MASS, DELAY, PLAY, BASE}, {MASS, DELAY, PLAY, BASE, LINK}])
def test_one_look_is_enough_for_several_effects(hidden):
    selection, data = followed(hidden)
    assert set(steps(selection)) == hidden
    assert data.looked == [()]
    assert len(data.tried) == len(hidden) - 1
    assert all(MASS not in keys for _, keys in data.tried[1:])


def test_where_one_place_explains_what_is_left_it_is_looked_again():
    selection, data = followed({MASS, PLAY}, several=False)
    assert set(steps(selection)) == {MASS, PLAY}
    assert len(data.looked) == 2


def test_what_takes_little_beside_the_others_waits_for_the_next_look():
    """A third of what is left at least."""
    left = {frozenset(): 20.0, frozenset({MASS}): 8.0, frozenset({MASS, BASE}): 6.0}

    def remaining(keys):
        return 0.5 if {MASS, BASE, DELAY} <= keys else min(left[one] for one in left if one <= keys)

    selection = Selection(Remembering(remaining))
    selection.follow()
    assert steps(selection) == [MASS, BASE, DELAY]
    assert selection.data.looked == [(), (MASS,)]


class Offered(FrfData):
    """Of FRFs, with looks as they are told."""

    def __init__(self, first=False, last=False, over=False, asked=None):
        self.asked, self.setup, self.over = asked, Mock(spec=Setup), over
        looks = Mock(one=Mock(spec=Findings, explains=first))
        self._candidates = Mock(spec=FrfCandidates, looks=looks, one_explained=last)

    def is_over(self, model):
        return self.over


def costing(cost, *keys):
    model = fitted(*keys)
    model.cost = cost
    return model


def test_the_nearest_of_those_that_were_compared_are_fitted_beside_it(monkeypatch):
    made = []

    def also(setup, model, other):
        made.append(other.key)
        return [] if other.key == PLAY else [costing(1.0, *model.hypothesis.keys, other.key)]

    monkeypatch.setattr(frf_offers, "also", also)
    before, mode = fitted(MASS), costing(0.0, (UNSTRUCTURED, ""))
    others = [
        costing(0.0),
        costing(5.0, BASE),
        costing(0.1, MASS),
        costing(2.0, PLAY),
        costing(3.0, DELAY),
        mode,
    ]
    others += [costing(9.0 + k, ("spare", str(k))) for k in range(REMEMBERED)]
    found = Offered().remembered(before, others)
    assert made == [PLAY, DELAY, BASE, ("spare", "0")]
    assert found[0] is before
    assert [one.key for one in found[1:]] == [DELAY, BASE, ("spare", "0")]


@pytest.mark.parametrize("given", [{"first": True}, {"last": True}, {"over": True}, {"asked": {"a": ()}}])
def test_nothing_is_tried_where_one_place_explains_what_is_left_or_nothing_is(monkeypatch, given):
    monkeypatch.setattr(frf_offers, "also", Mock(side_effect=AssertionError))
    assert Offered(**given).remembered(fitted(MASS), [costing(1.0, BASE)]) == []


def test_the_last_look_is_the_one_that_was_taken_last():
    looks = LooksBeside.__new__(LooksBeside)
    looks.looks, looks._beside = Mock(one=Mock(explains=True)), {}
    assert looks.one_explained
    looks._beside[frozenset("a")] = Mock(explains=True)
    looks._beside[frozenset("b")] = Mock(explains=False)
    assert not looks.one_explained


def test_one_effect_more_sets_out_from_where_each_was(context, monkeypatch):
    asked = []

    def closely(setup, hypothesis, start, *, near, steps):
        asked.append((hypothesis.keys, start, near, steps))
        return [one]

    monkeypatch.setattr(in_its_stead, "tried_closely", closely)
    root = Hypothesis(context, robot_space(context.robot))
    effects = known()
    mass = root.and_also(Placed(effects["added_mass"], "link_2"))
    damped = root.and_also(Placed(effects["structural_damping"], "joints"))
    one, other = (
        Mock(spec=FittedFrfs, hypothesis=which, x=np.arange(len(which.space)) + first)
        for which, first in ((mass, 0.0), (damped, 100.0))
    )
    assert in_its_stead.also(Mock(spec=Setup), one, other) == [one]
    ((keys, start, near, steps_),) = asked
    assert keys == (*mass.keys, *damped.keys)
    own = len(damped.space) - len(root.space)
    assert start.tolist() == [*one.x, *other.x[-own:]]
    assert (near, steps_) == (True, in_its_stead.A_FEW)

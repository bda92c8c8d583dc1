"""Every law at each of its levels: the right one is found where no narrow law and no look points to it."""

from dataclasses import replace
from itertools import pairwise, product
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.effects.held_tool import HELD_TOOL, stiffness_of
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search import every_law as searching
from flexmodal.diagnosis.search.close_fit import fitted_closely
from flexmodal.diagnosis.search.coarse import Candidate, Look
from flexmodal.diagnosis.search.every_law import Tried, every_law, followed, worth_following
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection import wider_laws
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.decision import Choice, Round
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.selection import ForwardSelection
from flexmodal.diagnosis.setup import Setup
from flexmodal.identification import predict
from flexmodal.structure import robot_space

from .beside_rig import seen_and_simulated
from .conftest import known

WHERE = "q1+q2"
NAMES = "joint_coupling", "added_mass"
"""Those that are tried: the whole catalogue takes half a minute."""


@pytest.fixture(scope="module")
def looked():
    """A setup in which two joints hold the tool along a direction, and the robot re-tuned to that."""
    context, observed, _ = seen_and_simulated("fanuc_s360", 4, points=4)
    root = Hypothesis(context, robot_space(context.robot))
    held = root.and_also(Placed(HELD_TOOL, WHERE))
    zero = np.zeros(len(root.space))
    values = {"held_stiffness": stiffness_of(context, WHERE), "elevation": 0.7}
    value = predict(held, held.start(held.placed[-1], values, zero), observed)
    seen = replace(observed, value=value)
    setup = Mock(
        spec=Setup, fitted=seen, observations=seen, held=np.zeros(len(seen), dtype=bool), context=context,
        effects=tuple(known()[name] for name in NAMES), advance=Mock(),
    )  # fmt: skip
    return setup, fitted_closely(setup, root, zero)


@pytest.fixture(scope="module")
def found(looked):
    setup, root = looked
    return every_law(setup, root, np.zeros(len(root.x)), with_force=False)


def test_the_law_that_is_there_comes_first_at_its_own_level(looked, found):
    """The narrow one in its place, of one ratio in all postures, is nowhere near it."""
    setup, _ = looked
    assert found[0].reached.key == ("joint_coupling", WHERE)
    own = [one.name for one in found[0].reached.hypothesis.placed[-1].effect.parameters(setup.context, WHERE)]
    assert "held_stiffness" in own
    narrow = [one for one in found if one.narrower is None and one.reached.key == found[0].reached.key]
    assert found[0].cost < 0.1 * narrow[0].cost
    tried = {(one.reached.key, one.reached.hypothesis.placed[-1].effect) for one in found}
    assert len(tried) == len(found)
    assert {name for (name, _), _ in tried} == {one.name for one in setup.effects if one.next_level}


def test_followed_closely_it_leaves_nothing(looked, found):
    setup, _ = looked
    close = followed(
        setup, worth_following(found), SetOut([]), lambda one: over_noise(setup, one) <= 1.0, anywhere=False
    )
    best = min(close, key=lambda one: one.cost)
    assert best.key == ("joint_coupling", WHERE)
    assert over_noise(setup, best) < 0.05


def test_what_depends_on_the_blow_is_tried_where_that_matters_and_what_is_there_is_not(looked):
    """Torques count as their stand-ins: nothing is integrated."""
    setup, root = looked
    friction = Mock(spec=Setup, wraps=setup, fitted=setup.fitted, held=setup.held, context=setup.context,
                    effects=(known()["coulomb_friction"],), advance=Mock())  # fmt: skip
    zero = np.zeros(len(root.x))
    assert every_law(friction, root, zero, with_force=False) == []
    found = every_law(friction, root, zero, with_force=True)
    assert {one.reached.key[1] for one in found} == set(setup.context.joints)
    there = replace(root, hypothesis=root.hypothesis.and_also(Placed(friction.effects[0], "q1")))
    x = np.zeros(len(there.hypothesis.space))
    there = replace(there, fitted=replace(root.fitted, x=x))
    found = every_law(friction, there, x, with_force=True)
    assert {one.reached.key[1] for one in found} == set(setup.context.joints) - {"q1"}


def tried(cost, key, narrower=None):
    return Tried(Mock(spec=Candidate, cost=cost, key=key), narrower)


def test_the_best_level_of_a_few_places_is_followed():
    """Where a wider law leaves far less than every narrow one does."""
    one, other, below = ("joint_coupling", "q1+q2"), ("added_mass", "link_2"), Mock(spec=Candidate)
    many = [tried(1.0, one, below), tried(1.1, one, below), tried(1.9, other, below)]
    many += [tried(2.1, ("added_mass", "link_3"), below), tried(2.4, other)]
    assert worth_following(many) == [many[0], many[2]]
    assert worth_following([*many, tried(2.3, one)]) == [many[0]]
    assert worth_following([tried(0.9, other), *many]) == []
    alike = [tried(1.0 + k / 10, ("added_mass", f"link_{k}"), below) for k in range(5)]
    assert worth_following(alike) == alike[:3]
    assert worth_following([]) == []


@pytest.mark.parametrize(
    ("enough", "anywhere", "fitted", "widened"),
    [
        ("reached", True, ["wide"], []),
        ("wider", True, ["wide", "below"], ["below"]),
        ("nothing", True, ["wide", "below", "alone", "below"], ["below", "below"]),
        ("reached", False, ["wide"], []),
        ("wider", False, ["wide", "alone"], []),
    ],
)
def test_what_is_enough_ends_it(monkeypatch, enough, anywhere, fitted, widened):
    """From where it has come to, and else perhaps by all starts from the level below on."""
    asked, further = [], []

    def closely(setup, hypothesis, x):
        asked.append(hypothesis)
        return [Mock(spec=FittedFrfs, told="reached" if hypothesis == "wide" else "none", name=hypothesis)]

    def next_ones(setup, model, set_out, is_enough):
        further.append(model._mock_name)
        return [Mock(spec=FittedFrfs, told="wider" if model._mock_name == "below" else "none")]

    monkeypatch.setattr(searching, "tried_closely", closely)
    monkeypatch.setattr(searching, "at_next_level", next_ones)
    below = Mock(spec=Candidate, hypothesis="below", x=None)
    many = [
        Tried(Mock(spec=Candidate, hypothesis="wide", x=None), below),
        Tried(Mock(spec=Candidate, hypothesis="alone", x=None), below),
    ]
    followed(Mock(spec=Setup), many, SetOut([]), lambda one: one.told == enough, anywhere=anywhere)
    assert (asked, further) == (fitted, widened)


def test_a_grid_of_starts_is_thinned_so_that_every_value_of_its_numbers_is_met():
    names = "abcde"
    few = [{"a": float(k)} for k in range(300)]
    grid = [dict(zip(names, map(float, one), strict=True)) for one in product(range(4), repeat=5)]
    assert searching._spread(few) == few
    some = searching._spread(grid)
    assert 150 < len(some) < 300
    assert [len({one[name] for one in some}) for name in names] == [4] * 5
    assert len({(one[name], one[other]) for one in some for name, other in pairwise(names)}) == 16


def test_what_is_far_behind_is_not_fitted_further(context):
    """More than three times what the best has left after its first steps."""
    costs = {"hinges": iter([100.0, 90.0]), "far": iter([301.0])}
    steps = []

    def fitted(one, floor, most):
        steps.append((one.hypothesis.keys[-1][0], most))
        return replace(one, cost=next(costs["far" if "coupling" in one.hypothesis.keys[-1][0] else "hinges"]))

    seen = Mock(spec=Look, fitted=fitted)
    seen.started = lambda hypothesis, starts, floor, most: [
        Candidate(hypothesis, one, 0.0) for one in starts[:1]
    ]
    trials = searching._Trials(seen, Hypothesis(context, robot_space(context.robot)), np.zeros(0))
    narrow = replace(known()["joint_coupling"], next_level=None), WHERE
    link = replace(known()["link_flexibility"], next_level=None), "link_2"
    found = list(trials.every([link, narrow], lambda doing, part: None))
    assert [one.cost for one in found] == [90.0, 301.0]
    first, further = searching.FIRST, searching.FURTHER
    assert steps == [("link_flexibility", first), ("joint_coupling", first), ("link_flexibility", further)]


@pytest.mark.parametrize(
    ("several", "over", "rest", "swept"),
    [
        (False, 3.0, 1.0, True),
        (False, 3.0, 0.5, None),
        (False, 1.9, 1.0, False),
        (True, 3.0, 0.9, True),
        (True, 3.0, 0.5, False),
    ],
)
@pytest.mark.parametrize("explains", [False, True])
def test_every_law_is_tried_where_none_takes_a_good_part(monkeypatch, several, over, rest, swept, explains):
    """Beside the robot alone where something is left at all; from the card there, and else from what is.

    There where one place explains everything whatever takes a good part, too. Beside effects all starts are
    followed only where one place explains everything.
    """
    swept = explains if swept is None else swept
    found = [Mock(spec=FittedFrfs, key=("added_mass", "a"), cost=3.0, over=over) for _ in range(2)]
    right = Mock(spec=FittedFrfs, key=("joint_coupling", WHERE), cost=0.1, over=1.0)
    asked, started = [], []
    monkeypatch.setattr(wider_laws, "over_noise", lambda setup, one: one.over)
    monkeypatch.setattr(wider_laws, "left", lambda *given: rest)
    monkeypatch.setattr(wider_laws, "starts", lambda *given: SetOut([np.zeros(1)]))
    monkeypatch.setattr(wider_laws, "every_law", lambda *given, with_force: asked.append(given[2]) or [])
    monkeypatch.setattr(wider_laws, "followed", lambda *given, anywhere: started.append(anywhere) or [right])
    candidates = FrfCandidates.__new__(FrfCandidates)
    candidates.setup, candidates.depends_on_force = Mock(spec=Setup), lambda before: False
    before = Mock(spec=FittedFrfs, hypothesis=Mock(placed=(1,) if several else ()), x=np.ones(1))
    told = candidates.with_wider_laws(before, found, Mock(spec=Findings, explains=explains))
    assert (right in told) == swept
    assert started == [explains or not several] * swept
    assert [one.tolist() for one in asked] == ([[float(several)]] if swept else [])


@pytest.mark.parametrize("one", [True, False])
def test_a_wider_law_is_as_sure_as_it_is_among_what_the_narrow_one_was_compared_with(monkeypatch, one):
    """That a narrow law was hardly possible says nothing of it; of several each is judged apart."""
    key = ("joint_coupling", WHERE)
    keys = [(), (("added_mass", "link_3"),), (key,), (key,)]
    root, other, narrow, wide = [Mock(hypothesis=Mock(keys=own)) for own in keys]
    compared, described = [], []
    selection = ForwardSelection.__new__(ForwardSelection)
    selection.data = Mock(spec=Data, compare=lambda models: compared.append(models) or "compared")
    monkeypatch.setattr(selection, "describe", lambda *given: described.append(given) or "told")
    selection.current, selection.steps = wide, ["step"] if one else ["step", "step"]
    every = [Mock(spec=Comparison, models=some) for some in ((root, other, narrow), (root,))]
    selection.rounds = [Round(every[0], Choice(2)), Round(every[1], Choice(None))]
    selection._describe_wider()
    assert [[root, other, wide]] * one == compared
    assert described == [("compared", 2)] * one
    assert selection.steps == (["told"] if one else ["step", "step"])

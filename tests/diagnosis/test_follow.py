"""Several effects, each added where the data point beside those that are there; on a world made by hand."""

from dataclasses import dataclass, replace
from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.effects_at import PORT_OF
from flexmodal.diagnosis.lawfree.first_look import LooksWithoutLaw
from flexmodal.diagnosis.lawfree.look import SOUND
from flexmodal.diagnosis.lawfree.result import Curve, Findings, Found, Loss, PlaceTried
from flexmodal.diagnosis.lawfree.tells import told_by
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.outcome import Compared, Gaps, Step
from flexmodal.diagnosis.selection import (
    frf_by_look,
    frf_candidates,
    frf_data,
    frf_offers,
    in_its_stead,
    looks_beside,
    searches_beside,
    wider_laws,
)
from flexmodal.diagnosis.selection.comparison import Comparison
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.described import beside_others, shared_anew
from flexmodal.diagnosis.selection.exchange import without
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.selection.frf_starts import does_more, narrowest, nearer, swung
from flexmodal.diagnosis.selection.frf_thresholds import CLOSE, FLOOR_REACHED
from flexmodal.diagnosis.selection.in_its_stead import Refits, sure_beside
from flexmodal.diagnosis.selection.looks_beside import MOST_LOOKS
from flexmodal.diagnosis.selection.selection import MOST, ForwardSelection
from flexmodal.diagnosis.setup import Setup
from flexmodal.diagnosis.time_limit import OutOfTime

MASS, DELAY, PLAY, LINK, BASE = (
    ("added_mass", "a"),
    ("time_delay", "b"),
    ("play", "c"),
    ("link", "d"),
    ("base", "e"),
)
FEET = ("base_flexibility", "base")
PLAYS = ("nonlinear_stiffness", "q3")
RODS = ("joint_coupling", "q2+q3")
EVERY = (MASS, DELAY, PLAY, LINK, BASE, ("spare", "f"), ("spare", "g"))
NOISE = 1.0


@dataclass(frozen=True, eq=False)
class Model:
    """What is in it."""

    keys: tuple
    x = np.zeros(0)
    parameters = 0

    @property
    def hypothesis(self):
        return self

    @property
    def key(self):
        return self.keys[-1] if self.keys else ("none", "")


class World(Data):
    """Every set of effects leaves so much; 1 is the noise."""

    asked = None

    def __init__(self, left, named=(), sure=False):
        self.left, self.named, self.looked, self.sure = left, set(named), [], sure
        self._root = Model(())

    @property
    def root(self):
        return self._root

    def pointed(self, before, number):
        assert number == len(before.keys)
        self.looked.append(before.keys)
        return [before, *(Model((*before.keys, key)) for key in EVERY if key not in before.keys)]

    def compare(self, models):
        scores = -np.array([100.0 * self.left(frozenset(one.keys)) for one in models])
        return Comparison(models, scores, np.tile(scores[:, None], 3))

    def without(self, model, key):
        return Model(tuple(one for one in model.keys if one != key))

    def worth(self, before, after, number):
        taken = 1 - self.left(frozenset(after.keys)) / self.left(frozenset(before.keys))
        return Answer.YES if taken > (0.33 if number else 0.025) else Answer.NO

    def is_enough(self, model):
        return self.left(frozenset(model.keys)) <= NOISE

    def is_named(self, model):
        return model.keys in self.named

    def settles(self, model):
        return dict.fromkeys(model.keys, 0.83) if self.sure and len(model.keys) > 1 else {}

    def vouches(self, model):
        return False

    def wider(self, model, keys):
        return []

    def alike(self, one, other):
        return True

    def share(self, first, last):
        return 1 - self.left(frozenset(last.keys)) / self.left(frozenset(first.keys))


World.__abstractmethods__ = frozenset()


class Selection(ForwardSelection):
    def describe(self, comparison, chosen):
        effect, where = comparison.models[chosen].key
        return Step(effect, where, {}, {}, {}, 0.95, Mock(spec=Gaps), (), ties=(("spare", "f"),))

    def _compared(self, comparison, number):
        return Mock(spec=Compared)


def followed(left, named=(), sure=False):
    selection = Selection(World(left, named, sure))
    return selection, selection.follow()


def steps(selection):
    return [(one.effect, one.where) for one in selection.steps]


@pytest.mark.parametrize(
    "hidden", [{MASS}, {MASS, PLAY}, {MASS, DELAY, PLAY, BASE}, {MASS, DELAY, PLAY, BASE, LINK}]
)
def test_each_of_several_takes_less_than_a_further_one_would_have_to(hidden):
    selection, ended = followed(lambda keys: NOISE / 2 + 20 * len(hidden - keys) + len(keys - hidden))
    assert ended
    assert set(steps(selection)) == hidden
    assert set(selection.current.keys) == hidden


def test_what_was_considered_comes_in_place_of_an_earlier_effect_that_does_worse_beside_others():
    """Alone a link takes more than the foundation; beside a mass the foundation does."""
    left = {
        frozenset(): 100.0,
        frozenset({LINK}): 30.0,
        frozenset({BASE}): 40.0,
        frozenset({LINK, MASS}): 9.0,
        frozenset({BASE, MASS}): NOISE / 2,
    }

    class Considered(World):
        def instead(self, model, key):
            return [Model((*(one for one in model.keys if one != key), BASE))] if key == LINK else []

    selection = Selection(Considered(lambda keys: left.get(keys, 150.0)))
    assert selection.follow()
    assert set(steps(selection)) == {BASE, MASS}
    assert selection.data.looked == [(), (LINK,)]


@pytest.mark.parametrize(
    ("overs", "expected"), [((1.1, 1.2, 1.3, 1.4), 3), ((1.2, 3.0), 1), ((3.0, 4.0), 1), ((), 0)]
)
def test_how_sure_one_is_is_asked_beside_those_that_were_near_or_the_nearest(monkeypatch, overs, expected):
    data, asked = settling(monkeypatch, {MASS: 0.83}), []
    data.near = [(fitted(BASE), over) for over in overs]
    data._refits.instead = lambda model, key, others: asked.extend(others) or []
    assert data.surely(fitted(MASS, DELAY), MASS) == 0.83
    assert asked == [one for one, _ in data.near[:expected]]


def test_only_what_was_not_far_behind_is_tried_in_its_stead(monkeypatch):
    """In the last search where the effect was found; what the model has anyway is not."""
    over = {MASS: 4.0, BASE: 6.0, LINK: 11.0, DELAY: 5.0, PLAY: 3.0}
    monkeypatch.setattr(frf_candidates, "over_noise", lambda setup, model: over[model.key])
    found = [fitted(key) for key in (MASS, BASE, LINK, DELAY)]
    candidates = FrfCandidates(Mock(spec=Setup, advance=Mock()), fitted(), with_force=False)
    candidates._placed = {("first",): (9.0, [fitted(MASS), fitted(PLAY)]), ("last",): (1.0, found)}
    model = fitted(MASS, DELAY)
    assert candidates.considered(model, MASS) == [found[1], found[2]]
    assert candidates.considered(model, MASS, 2.0) == [found[1]]


class Tolerant(World):
    """How the test was set up can be seen beside what does best, of which some go on."""

    def __init__(self, left, several, moves=True):
        super().__init__(left)
        self.several, self.moves, self.first = several, moves, []

    def at_first(self, before, number):
        self.first.append(before.keys)
        return [before, *(Model((*before.keys, key)) for key in (MASS, LINK) if key not in before.keys)]

    def lacks_several(self, model):
        return self.several

    def set_up_anew(self, models):
        return (self, [Model(one.keys) for one in models]) if self.moves else None


@pytest.mark.parametrize(
    ("several", "moves", "takes", "looked"),
    [(True, True, 70, 0), (False, True, 70, 2), (True, False, 70, 2), (True, True, 20, 1)],
)
def test_what_takes_a_good_part_as_the_test_is_set_up_then_is_added_at_once(several, moves, takes, looked):
    """Where several are missing; elsewhere it is looked for more beside what was there before."""
    left = {frozenset(): 100.0, frozenset({MASS}): 100.0 - takes, frozenset({LINK}): 99.0}
    left[frozenset({MASS, LINK})] = NOISE / 2
    selection = Selection(Tolerant(lambda keys: left.get(keys, 150.0), several, moves))
    assert selection.follow()
    assert set(steps(selection)) == {MASS, LINK}
    assert selection.data.first == [(), (MASS,)]
    assert len(selection.data.looked) == looked


class TooLate(World):
    """Time is up whenever it is looked for how the test was set up."""

    def set_up_anew(self, models):
        raise OutOfTime


def test_what_was_fitted_is_compared_though_time_is_up_while_the_set_up_is_looked_for():
    left = {frozenset(): 100.0, frozenset({MASS}): NOISE / 2}
    selection = Selection(TooLate(lambda keys: left.get(keys, 150.0)))
    assert selection.follow()
    assert steps(selection) == [MASS]


class Stuck(World):
    """With the narrow law of one effect nothing takes anything; with a wider one a mass takes the rest."""

    def __init__(self, takes):
        super().__init__(lambda keys: 10.0 if LINK in keys else 100.0)
        self.takes, self.wide = takes, None

    def wider(self, model, keys):
        self.wide = Model(model.keys)
        return [self.wide] if LINK in keys else []

    def share(self, first, last):
        if last is not self.wide:
            return super().share(first, last)
        self.left = lambda keys: NOISE / 2 if {LINK, MASS} <= keys else 10.0 if LINK in keys else 100.0
        return self.takes


@pytest.mark.parametrize(("takes", "found"), [(0.5, {LINK, MASS}), (0.05, set())])
def test_a_wider_law_is_tried_where_nothing_leads_on(takes, found):
    selection = Selection(Stuck(takes))
    assert selection.follow() is bool(found)
    assert set(steps(selection)) == found


class Narrow(World):
    """One effect more than a wide law has need of, which takes a share or comes close to the noise."""

    def __init__(self, *, close, share, alone=True):
        super().__init__(lambda keys: {0: 40.0, 1: 3.0 if alone else 30.0, 2: 3.0, 3: 1.0}[len(keys)])
        self.close, self.taken, self.widened, self.wide = close, share, [], None

    def is_close(self, model):
        return self.close and model is self.wide

    def wider(self, model, keys):
        self.widened.append(tuple(keys))
        self.wide = Model(model.keys)
        return [self.wide]

    def share(self, first, last):
        return self.taken if last is self.wide else super().share(first, last)


@pytest.mark.parametrize(
    ("share", "close", "does"), [(0.9, False, True), (0.0, True, True), (0.0, False, False)]
)
@pytest.mark.parametrize("others", [(MASS, DELAY), (MASS,)])
def test_a_wider_law_of_one_may_do_what_another_one_was_taken_for(share, close, does, others):
    data = Narrow(close=close, share=share)
    less = without(data, Model((*others, PLAY)), PLAY)
    assert less.keys == others
    assert (less is data.wide) is does
    assert data.widened == [others]


def test_what_takes_most_itself_is_no_remainder_of_a_law_of_several():
    data = Narrow(close=False, share=0.9, alone=False)
    data.left = lambda keys: 30.0 if PLAY not in keys else 1.0
    data._root = Model(())
    assert without(data, Model((MASS, DELAY, PLAY)), PLAY).keys == (MASS, DELAY)
    assert data.widened == []


class Border(World):
    """A tenth of the noise is clear; besides, the data point to what they are told."""

    def besides(self, before, number):
        clear = self.left(frozenset(before.keys)) <= 0.1 * NOISE
        return [] if clear else World.pointed(self, before, number)


class Beside(Border):
    """What hides in the noise shows that the link was taken for the foundation."""

    def instead(self, model, key):
        return [Model((*(one for one in model.keys if one != key), BASE))] if key == LINK else []


def test_what_hides_in_the_noise_may_show_what_the_first_effect_was_taken_for():
    left = {
        frozenset(): 50.0,
        frozenset({LINK}): NOISE,
        frozenset({LINK, MASS}): 0.5 * NOISE,
        frozenset({BASE, MASS}): 0.05 * NOISE,
    }
    selection = Selection(Beside(lambda keys: left.get(keys, 40.0)))
    assert selection.follow()
    assert set(steps(selection)) == {BASE, MASS}


class Searched(Border):
    """Where no look points anywhere, and a search finds the first effect."""

    def pointed(self, before, number):
        return [before]

    def candidates(self, before, number):
        return World.pointed(self, before, number)


@pytest.mark.parametrize("first", [0.9, 3.0])
def test_what_hides_in_the_noise_is_looked_for_beside_what_a_search_found_too(first):
    def left(keys):
        if not keys:
            return 40.0
        return {True: first, False: 20.0}[MASS in keys] * (0.5 if BASE in keys else 1.0)

    selection = Selection(Searched(left))
    selection.run()
    assert set(selection.current.keys) >= ({MASS, BASE} if first < NOISE else {MASS})


def test_nearer_than_what_was_found_is_what_it_cannot_be_told_from_and_leaves_less():
    """All bearings alike are simpler than one of them, which leaves less; a link does so elsewhere."""
    every = [
        ("bearing", "q1", 1.2),
        ("base", "base", 1.8),
        ("bearing", "joints", 1.5),
        ("link", "link_1", 1.0),
    ]
    places = [Mock(spec=PlaceTried, port=port, where=where, judged=judged) for port, where, judged in every]
    alike = (("bearing", "joints"), ("bearing", "q1"), ("base", "base"))
    one = Mock(spec=Found, port="bearing", where="joints", alike=alike)
    look = Mock(spec=Findings, places=places, found=(one,))
    effects = [
        Mock(spec=Effect, law=None, places=lambda context, here=here: here, untestable=lambda context: None)
        for here in (("q1", "q2", "joints"), ("base",), ("link_1",))
    ]
    for effect, name in zip(
        effects, ("bearing_flexibility", "base_flexibility", "link_flexibility"), strict=True
    ):
        effect.name = name
    setup = Mock(spec=Setup, effects=effects, context=None)
    assert nearer(setup, fitted(), look) == [("bearing_flexibility", "q1")]
    assert nearer(setup, fitted(("bearing_flexibility", "q1")), look) == []


@pytest.mark.parametrize(
    ("first", "curve", "torque", "explains", "expected"),
    [
        ("blows", None, SOUND, True, [("nonlinear_stiffness", "q2")]),
        ("blows", None, 1.1 * SOUND, True, []),
        ("blows", None, SOUND, False, []),
        ("torque", None, SOUND, True, []),
        ("body", "a mass", SOUND, True, []),
    ],
)
def test_a_joint_may_be_to_blame_that_the_blows_of_one_hammer_point_swing_far(
    first, curve, torque, explains, expected
):
    """Where their directions, posture for posture, do best, and it does well; what is linear cannot be."""
    every = [(first, "tip", 0.6), ("torque", "q2", torque), ("torque", "q1", SOUND)]
    places = [Mock(spec=PlaceTried, port=port, where=where, judged=judged) for port, where, judged in every]
    one = Mock(spec=Found, port=first, where="tip", curve=curve)
    look = Mock(
        spec=Findings, places=places if torque <= SOUND else places[:2], found=(one,), explains=explains
    )
    effects = [
        Mock(
            spec=Effect, law=law, by_force=law is not None, places=lambda context: ("q1", "q2"),
            untestable=lambda context: None,
        )
        for law in (Mock(), None)
    ]  # fmt: skip
    for effect, name in zip(effects, ("nonlinear_stiffness", "servo_compliance"), strict=True):
        effect.name = name
    setup = Mock(spec=Setup, effects=effects, context=None)
    assert swung(setup, fitted(), look) == expected


@pytest.mark.parametrize(
    ("least", "found"),
    [(0.05, {MASS, DELAY}), (0.75, {MASS})],
    ids=["it takes a good part", "it takes little"],
)
def test_what_hides_in_what_counts_as_noise_is_looked_for(least, found):
    """One more, as long as it takes as much of what is left as a further effect has to."""
    left = {frozenset(): 50.0, frozenset({MASS}): NOISE, frozenset({MASS, DELAY}): least}
    selection = Selection(Border(lambda keys: left.get(keys, 40.0)))
    assert selection.follow()
    assert set(steps(selection)) == found


def test_no_more_than_so_many():
    selection, ended = followed(lambda keys: 200.0 - 20 * len(keys))
    assert not ended
    assert max(len(keys) for keys in selection.data.looked) == MOST - 1
    assert selection.current is selection.root
    assert steps(selection) == []


def wrong_first(keys):
    """The base alone passes for the mass while the delay is missing."""
    if {MASS, DELAY} <= keys and BASE not in keys:
        return NOISE / 2
    return 100.0 - 30 * (MASS in keys) - 40 * (BASE in keys and MASS not in keys) - 35 * (DELAY in keys)


def test_what_took_up_another_is_exchanged():
    selection, ended = followed(wrong_first)
    assert ended
    assert selection.data.looked[0] == ()
    assert selection.data.looked[1] == (BASE,)
    assert steps(selection) == [DELAY, MASS]
    assert selection.current.keys == (DELAY, MASS)


def test_an_exchange_that_takes_little_is_none():
    selection, ended = followed(
        lambda keys: (
            100.0 - 60 * (BASE in keys) - 62 * (MASS in keys and BASE not in keys) - (DELAY in keys) * 30
        )
    )
    assert not ended
    assert steps(selection) == []


@pytest.mark.parametrize("more", [False, True])
def test_what_is_named_stays_whatever_comes_after(more):
    """The law of the delay may leave what looks like something else, unless that takes all of it."""

    def left(keys):
        return 90.0 - 85 * (DELAY in keys) - (4.5 if more else 1.0) * (MASS in keys and DELAY in keys)

    selection, ended = followed(left, named=[(DELAY,)])
    assert ended
    assert steps(selection) == ([DELAY, MASS] if more else [DELAY])


def test_what_is_sure_stays_though_something_is_missing_besides():
    selection, ended = followed(lambda keys: 100.0 - 60 * (BASE in keys) - 30 * (MASS in keys), sure=True)
    assert ended
    assert steps(selection) == [BASE, MASS]
    assert [(one.confidence, one.ties) for one in selection.steps] == [(0.83, ())] * 2


def test_what_can_do_more_than_is_needed_is_left_out():
    coupling, servo = ("joint_coupling", "q1+q2"), ("servo_compliance", "q2")
    other = ("servo_compliance", "q3")
    assert does_more(coupling, servo)
    assert does_more(("sensor_misalignment", "tip"), ("sensor_gain", "tip"))
    assert not does_more(coupling, other)
    assert not does_more(servo, coupling)
    assert not does_more(("tip_mass", "link_2"), servo)
    found = [Mock(spec=FittedFrfs, key=key) for key in (coupling, servo, other)]
    assert narrowest(found, lambda model: model.key != other) == found[1:]
    assert narrowest(found, lambda model: model.key == coupling) == found


def fitted(*keys):
    """A model of FRFs with some effects."""
    placed = [Mock(effect=name, where=where) for name, where in keys]
    hypothesis = Mock(keys=keys, placed=placed)
    return Mock(spec=FittedFrfs, hypothesis=hypothesis, key=keys[-1] if keys else ("none", ""))


@pytest.mark.parametrize(
    ("closely", "over", "expected"),
    [
        (False, FLOOR_REACHED, True),
        (False, FLOOR_REACHED + 0.01, False),
        (True, CLOSE, True),
        (True, CLOSE + 0.01, False),
    ],
)
def test_a_law_that_follows_its_kind_closely_has_to_leave_less(monkeypatch, closely, over, expected):
    """What it leaves above that counts as something else, so that its wider law is tried first."""
    monkeypatch.setattr(wider_laws, "over_noise", lambda *given: over)
    candidates = FrfCandidates(Mock(spec=Setup, effects=(), advance=Mock()), fitted(), with_force=False)
    model = fitted(DELAY, MASS)
    model.hypothesis.placed[-1].effect = Mock(spec=Effect, comes_close=closely)
    assert candidates.is_enough(model) is expected


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, True),
        ({"others": 9.0}, False),
        ({"share": 0.9}, False),
        ({"apart": False}, False),
        ({"explains": True}, False),
        ({"keys": (MASS, DELAY)}, False),
        ({"at": "another"}, False),
    ],
)
def test_a_strong_effect_is_named_where_its_place_leaves_far_less_than_any_other(given, expected):
    at = Mock(spec=Found, port="body", where="a", is_apart=given.get("apart", True))
    places = [
        Mock(port="body", where="a", judged=5.0),
        Mock(port="joint", where="q1", judged=given.get("others", 18.0)),
    ]
    met = Mock(spec=Found) if given.get("at") else at
    look = Mock(
        spec=Findings, needed=True, explains=given.get("explains", False), found=(at,), places=places,
        met=lambda keys: {MASS: met},
    )  # fmt: skip
    data = FrfData.__new__(FrfData)
    data._candidates = Mock(spec=FrfCandidates, looks=Mock(one=look), looked=lambda model: Mock(place="tip"))
    data._root, data.modes, data.is_named = fitted(), None, lambda model: False
    data.share = lambda first, last: given.get("share", 0.98)
    model = fitted(*given.get("keys", (MASS,)))
    assert data.dominates(model) is expected
    if expected:
        assert data.standing(model) == ((MASS,), ("tip",))


class Settling(FrfData):
    """What each effect takes of what the others leave, and how sure it is."""

    def __init__(self, sure, takes=0.9, share=0.95):
        self._settled, self._root, self.near = ((), (), ()), fitted(), []
        self.taken, self._candidates = share, self
        self.sure, self.takes, self.setup = sure, takes, Mock(spec=Setup, advance=Mock())
        self._refits = Mock(spec=Refits, instead=lambda model, key, others: [])

    def considered(self, model, key, within=np.inf):
        return [one for one, over in self.near if over <= within]

    def looked(self, model):
        return Mock(place="tip")

    def without(self, model, key):
        return fitted(*(one for one in model.hypothesis.keys if one != key))

    def share(self, first, last):
        return self.taken if first is self._root else self.takes

    def compare(self, models):
        (key,) = set(models[1].hypothesis.keys) - set(models[0].hypothesis.keys)
        return key

    def lacking(self, model):
        return {}

    def is_named(self, model):
        return False

    def dominates(self, model):
        return False


def settling(monkeypatch, sure, **given):
    monkeypatch.setattr(frf_by_look, "sure_beside", lambda key: sure.get(key, 0.3))
    monkeypatch.setattr(frf_by_look, "with_last", lambda model, key: model)
    return Settling(sure, **given)


def test_effects_that_nothing_else_stands_for_are_named_whatever_else_is_missing(monkeypatch):
    data, model = settling(monkeypatch, {MASS: 0.83, DELAY: 0.81}), fitted(MASS, BASE, DELAY)
    assert data.settles(model) == {MASS: 0.83, DELAY: 0.81}
    assert data.standing(model) == ((MASS, DELAY), ("tip",))
    assert data.standing(fitted(MASS, BASE)) == ((MASS,), ("tip",))


@pytest.mark.parametrize(
    ("sure", "given"),
    [
        ({}, {}),
        ({MASS: 0.83}, {}),
        ({MASS: 0.83, BASE: 0.79}, {}),
        ({MASS: 0.83, BASE: 0.83}, {"takes": 0.5}),
        ({MASS: 0.83, BASE: 0.83}, {"share": 0.4}),
    ],
)
def test_what_is_not_sure_settles_nothing(monkeypatch, sure, given):
    """One alone neither: what one takes any other may take, too."""
    data = settling(monkeypatch, sure, **given)
    assert data.settles(fitted(MASS, BASE)) == {}
    assert data._settled == ((), (), ())


def test_one_is_enough_where_all_of_them_take_all_but_little(monkeypatch):
    assert settling(monkeypatch, {MASS: 0.83}, share=0.98).settles(fitted(MASS, BASE)) == {MASS: 0.83}


def test_one_effect_alone_settles_nothing(monkeypatch):
    assert settling(monkeypatch, {MASS: 0.83}, share=0.99).settles(fitted(MASS)) == {}


@pytest.mark.parametrize(("other", "sure"), [(3.0, 0.83), (1.002, 0.6), (1.0, 0.45), (0.9, 0.0)])
def test_how_sure_is_what_nothing_in_its_stead_fits_as_well_as(other, sure):
    """Costs over that with the effect; the others alone leave ten times as much."""
    models = [fitted(), *(fitted(key) for key in (MASS, DELAY))]
    for model, cost in zip(models, (10.0, 1.0, other), strict=True):
        model.costs, model.strong, model.prior, model.parameters = np.full(200, cost), 3, 0.0, 3
    found = sure_beside(Mock(spec=Comparison, models=models, probability=np.array([0.0, 1.0, 1.0])))
    assert found == pytest.approx(sure, abs=0.03)


class Alone(FrfData):
    """One effect, and a look for one place that leaves so much."""

    def __init__(self, *, named=True, share=0.99, left=0.7):
        self._root, self.named, self.taken = fitted(), named, share
        self._candidates = Mock(spec=FrfCandidates, looks=Mock(one=Mock(left=left)))
        self._candidates.can_look.side_effect = AssertionError("no further look is needed")

    def is_named(self, model):
        return self.named

    def share(self, first, last):
        return self.taken


def test_no_second_effect_is_looked_for_where_one_place_leaves_nothing():
    model = fitted(BASE)
    assert Alone().pointed(model, 1) == [model]


@pytest.mark.parametrize("given", [{"named": False}, {"share": 0.8}, {"left": 0.9}])
def test_a_second_effect_is_looked_for_where_it_may_be_missing(given):
    with pytest.raises(AssertionError, match="further look"):
        Alone(**given).pointed(fitted(BASE), 1)


def test_a_third_effect_is_looked_for_whatever_one_place_leaves():
    with pytest.raises(AssertionError, match="further look"):
        Alone().pointed(fitted(BASE, MASS), 2)


@pytest.mark.parametrize(
    ("over", "met", "tried"), [(1.3, True, False), (1.5, True, True), (1.3, False, True), (1.5, False, True)]
)
def test_where_nothing_is_left_no_effect_is_exchanged(monkeypatch, over, met, tried):
    """A wider one in its place would always do a little better; unless none is where a look points."""
    other = fitted(MASS, BASE)
    other.cost = 1.0
    data = FrfData.__new__(FrfData)
    data.setup, data.modes = Mock(spec=Setup, held=np.zeros(1, dtype=bool), context=Mock(spec=Context)), None
    place = dict.fromkeys([MASS], Mock(spec=Found)) if met else {}
    found = Mock(spec=Found, port="body", where="elsewhere")
    data._look = Mock(spec=Findings, explains=True, found=(found,), met=lambda keys: place)
    data._candidates = Mock(spec=FrfCandidates, considered=lambda *given: [other])
    less = fitted(MASS)
    data._refits = Mock(spec=Refits, instead=lambda *given: [other], without=lambda *given: less)
    for module in (frf_data, frf_by_look, frf_offers):
        monkeypatch.setattr(module, "over_noise", lambda setup, model, *given: 9.0 if model is less else over)
    assert data.instead(fitted(MASS, DELAY), DELAY) == ([other] if tried else [])


@pytest.mark.parametrize(
    ("keys", "over", "contradicted"),
    [
        ([("local_absorber", "link_1"), ("servo_compliance", "q3")], 1.1, False),
        ([("local_absorber", "link_1"), ("servo_compliance", "q3")], 2.5, True),
        ([("local_absorber", "link_2"), ("servo_compliance", "q3")], 1.1, True),
        ([("servo_compliance", "q3")], 1.1, False),
        ([("servo_compliance", "q3")], 2.5, True),
    ],
)
def test_a_coupling_does_not_contradict_effects_in_its_joints(monkeypatch, context, keys, over, contradicted):
    """Unless they fail on what was held out."""
    assert contradicts(monkeypatch, context, keys, over, over_without=9.0) is contradicted


def contradicts(monkeypatch, context, keys, over, over_without, found=("coupling", "q1+q3")):
    """Whether one place speaks against some effects; how far they are, and each without one."""
    model = fitted(*keys)
    for module in (frf_data, frf_by_look):
        monkeypatch.setattr(
            module, "over_noise", lambda setup, one, *given: over if one is model else over_without
        )
    data = FrfData.__new__(FrfData)
    data.setup = Mock(spec=Setup, held=np.ones(1, dtype=bool), context=context)
    data.modes, data._refits = None, Mock(spec=Refits, without=lambda *given: fitted())
    place = Mock(spec=Found, port=found[0], where=found[1])
    data._look = Mock(spec=Findings, explains=True, found=(place,), met=lambda keys: {})
    return data.is_contradicted(model)


@pytest.mark.parametrize(
    ("keys", "over", "contradicted"),
    [
        ([("servo_compliance", "q1"), ("link_flexibility", "link_1")], 1.05, False),
        (
            [("servo_compliance", "q1"), ("link_flexibility", "link_1")],
            1.2,
            True,
        ),  # a law of it may do better
        ([("servo_compliance", "q2"), ("link_flexibility", "link_1")], 1.05, True),
        ([("servo_compliance", "q1"), ("added_mass", "link_3")], 1.05, True),
    ],
)
def test_a_foundation_does_not_contradict_what_sits_in_the_joint_on_it(
    monkeypatch, context, keys, over, contradicted
):
    """Its function does what these do together; where they leave nothing they are no more than it."""
    found = contradicts(monkeypatch, context, keys, over, 9.0, ("base", "base"))
    assert found is contradicted


@pytest.mark.parametrize(
    ("key", "asked", "tried"),
    [
        (FEET, None, {("servo_compliance", "q1"), ("bearing_flexibility", "q1")}),
        (FEET, {"base_flexibility": ("base",)}, set()),
        (("bearing_flexibility", "q1"), None, set()),
    ],
)
def test_in_the_stead_of_a_foundation_what_sits_in_the_first_joint_is_tried(context, key, asked, tried):
    every = [
        *(("servo_compliance", f"q{k}") for k in (1, 2)), *(("bearing_flexibility", f"q{k}") for k in (1, 2)),
        ("coulomb_friction", "q1"), ("link_flexibility", "link_1"), FEET,
    ]  # fmt: skip

    def also_at(less, number, found, ports):
        assert (number, found) == (1, [])
        return [fitted(MASS, one) for one in every if (PORT_OF[one[0]], one[1]) in ports]

    data = FrfData.__new__(FrfData)
    data.setup, data.asked, data.effects = (
        Mock(spec=Setup, context=context),
        asked,
        tuple(catalogue().values()),
    )
    data._candidates = Mock(spec=FrfCandidates, also_at=also_at)
    assert {one.key for one in data.plainer(fitted(MASS), key)} == tried


@pytest.mark.parametrize(
    ("key", "asked", "tried"),
    [
        (("local_absorber", "link_2"), None, {("added_mass", "link_2")}),
        (("local_absorber", MASS[1]), None, set()),  # there already
        (("local_absorber", "link_2"), {"local_absorber": ("link_2",)}, set()),
        (("bearing_flexibility", "q1"), None, set()),
    ],
)
def test_in_the_stead_of_an_absorber_a_mass_in_its_place_is_tried(context, key, asked, tried):
    """Below its band an absorber is a mass, so that it hangs on rounding which of both a fit ends in."""
    every = [("added_mass", "link_1"), ("added_mass", "link_2"), MASS, ("sensor_mass", "sensor")]

    def searched(less, number, allowed):
        assert number == 1
        return [fitted(MASS, one) for one in every if allowed(*one)]

    data = FrfData.__new__(FrfData)
    data.setup, data.asked, data.effects = (
        Mock(spec=Setup, context=context),
        asked,
        tuple(catalogue().values()),
    )
    data._candidates = Mock(spec=FrfCandidates, searched=searched)
    assert {one.key for one in data.plainer(fitted(MASS), key)} == tried


@pytest.mark.parametrize(("over_without", "contradicted"), [(1.3, False), (1.5, True)])
def test_what_was_found_where_the_others_were_enough_does_not_contradict(
    monkeypatch, context, over_without, contradicted
):
    """A foundation that leaves 1.2 times the noise is named; a mass found in the rest takes no name away."""
    keys = [("base_flexibility", "base"), ("added_mass", "link_2")]
    assert contradicts(monkeypatch, context, keys, 1.06, over_without) is contradicted


@pytest.mark.parametrize(("over", "asked"), [(4.0, [[BASE], []]), (2.5, [[BASE], [BASE]])])
def test_what_was_far_behind_in_the_stead_of_an_effect_is_not_tried_there_again(monkeypatch, over, asked):
    other, model = fitted(MASS, BASE), fitted(MASS, DELAY)
    other.cost, tried = 1.0, Mock(return_value=[other])
    data = FrfData.__new__(FrfData)
    data.setup, data.modes = Mock(spec=Setup), None
    data._candidates = Mock(spec=FrfCandidates, considered=lambda *given: [other])
    data._refits = Mock(spec=Refits, instead=tried)
    monkeypatch.setattr(frf_data, "over_noise", lambda setup, one: 2.0)
    monkeypatch.setattr(frf_offers, "over_noise", lambda setup, one: over if one is other else 2.0)
    data.instead(model, DELAY)
    data.instead(model, DELAY)
    assert [[one.key for one in call.args[2]] for call in tried.call_args_list] == asked


def test_a_model_is_fitted_once_with_an_effect_less_or_another_in_its_stead(monkeypatch):
    """Not that of before, once another one is asked for."""
    less, instead = Mock(side_effect=lambda *given: [fitted()]), Mock(side_effect=lambda *given: [fitted()])
    monkeypatch.setattr(in_its_stead, "tried_closely", less)
    monkeypatch.setattr(in_its_stead, "in_its_stead", instead)
    refits, models = Refits(Mock(spec=Setup)), [fitted(MASS, DELAY), fitted(MASS, DELAY)]
    for one in models:
        one.hypothesis.space.names, one.x = ("mass.link_1", "added_mass@tip.mass"), np.ones(2)
    others = [
        Mock(spec=FittedFrfs, hypothesis=Mock(placed=(Mock(effect=DELAY, where=where),))) for where in "ab"
    ]
    found = [refits.without(models[0], MASS), refits.instead(models[0], MASS, others)]
    assert [refits.without(models[0], MASS), refits.instead(models[0], MASS, others)] == found
    assert refits.instead(models[0], MASS, others[1:]) == found[1][1:]
    assert (less.call_count, instead.call_count) == (1, 2)
    assert refits.without(models[1], MASS) is not found[0]
    assert refits.instead(models[1], DELAY, others) != found[1]


@pytest.mark.parametrize(
    ("over", "left", "explains", "at", "tried"),
    [
        (1.3, 0.7, True, False, True),
        (1.1, 0.7, True, False, False),
        (1.3, 1.9, False, False, False),
        (1.3, 0.7, True, True, False),
        (1.3, 1.4, True, False, False),
    ],
    ids=["elsewhere", "near enough", "nowhere", "at the same place", "not quite"],
)
def test_what_may_hide_in_the_noise_is_tried_at_the_place_a_look_finds(
    monkeypatch, over, left, explains, at, tried
):
    look = Mock(
        spec=Findings, left=left, explains=explains, is_at=lambda keys: at,
        met=lambda keys: {key: None for key in keys if key == DELAY},
    )  # fmt: skip
    met, other = fitted(MASS, DELAY), fitted(MASS, BASE)
    data = FrfData.__new__(FrfData)
    data.setup, data.asked = Mock(spec=Setup), None
    data._candidates = Mock(
        spec=FrfCandidates, can_look=lambda model: True, look_beside=lambda model: look,
        at_places=lambda *given, only_met: [met] if only_met else [other, met],
        hidden_in_card=lambda before, number: [],
    )  # fmt: skip
    monkeypatch.setattr(frf_data, "over_noise", lambda setup, model: over)
    before = fitted(MASS)
    assert data.besides(before, 1) == ([before, met] if tried else [])


@pytest.mark.parametrize("stands", [True, False])
def test_where_no_effect_stands_for_what_was_found_those_are_tried_that_leave_nothing(stands):
    """Something between a link and its surroundings is no effect, and a mass on it does as well."""
    before, near, far = fitted(MASS), fitted(MASS, DELAY), fitted(MASS, BASE)
    before.cost, asked = 1.0, []
    first = Mock(spec=Found, port="body", could_be=lambda effect, where: False)
    look = Mock(
        spec=Findings,
        explains=True,
        found=(first, first),
        worth_trying=lambda effect, where: effect == DELAY[0],
    )

    def searched(before, number, allowed, **more):
        asked.append(allowed(*DELAY))
        return [near, far] if stands or len(asked) > 1 else []

    candidates = FrfCandidates(Mock(spec=Setup, advance=Mock()), fitted(), with_force=False)
    candidates.searched = searched
    found = candidates.at_places(before, 1, look, lambda model: model is near, only_met=True)
    assert found == ([near, far] if stands else [near])
    assert asked == [False, *([] if stands else [True])]


@pytest.mark.parametrize(
    ("keys", "over", "explains", "done"),
    [
        ((MASS, DELAY), 1.7, True, True),
        ((MASS, DELAY), 1.9, True, False),
        ((MASS, DELAY), 1.7, False, False),
        ((DELAY,), 1.7, True, False),
        ((DELAY,), 1.3, False, True),
    ],
)
def test_what_one_of_several_leaves_of_its_place_is_all_that_it_has_to_do(
    monkeypatch, keys, over, explains, done
):
    """What is left may be due to the law of another one."""
    monkeypatch.setattr(frf_candidates, "over_noise", lambda setup, model: over)
    candidates = FrfCandidates(Mock(spec=Setup, advance=Mock()), fitted(), with_force=False)
    look = Mock(spec=Findings, explains=explains, left=0.9)
    assert candidates.does(fitted(*keys), look, lambda model: over < 1.4) is done


@pytest.mark.parametrize(
    ("keys", "alone", "explained", "rests"),
    [
        ((MASS, DELAY), 1.5, True, True),
        ((MASS, DELAY), 1.7, True, False),
        ((MASS, DELAY), 1.5, False, False),
        ((MASS,), 1.5, True, False),
        ((MASS, DELAY), None, True, False),
    ],
)
def test_nothing_is_added_where_by_a_look_beside_several_nothing_is_missing(
    monkeypatch, keys, alone, explained, rests
):
    """What is left is due to their laws."""
    monkeypatch.setattr(frf_offers, "explains", lambda data, model: explained)
    data, look = FrfData.__new__(FrfData), None if alone is None else Mock(alone=alone)
    data._candidates = Mock(spec=FrfCandidates, looked=lambda model: look)
    assert data.is_at_rest(fitted(*keys)) is rests


class Doubtful(World):
    """What a foundation gains is not sure while something else is missing."""

    def compare(self, models):
        found = super().compare(models)
        known = [k for k, one in enumerate(models) if k and one.key == BASE and MASS in one.keys[:-1]]
        for k in known:
            found.table[k, 0] = found.table[0, 0] - 1.0
        return found


@pytest.mark.parametrize("takes", [0.5, 0.2])
def test_an_effect_that_is_not_sure_yet_is_followed_where_it_takes_a_good_part(takes):
    """Beside it the next one explains the rest."""

    def left(keys):
        with_base = {MASS, BASE} <= keys
        return (
            NOISE / 2
            if with_base and PLAY in keys
            else 40.0 * (1 - takes * with_base)
            if MASS in keys
            else 99.0
        )

    selection = Selection(Doubtful(left))
    assert selection.follow() is (takes > 0.33)
    assert takes < 0.33 or set(steps(selection)) == {MASS, BASE, PLAY}


def test_effects_at_rest_are_asked_which_are_sure():
    """More might be added, and nothing is."""

    class Resting(World):
        def is_at_rest(self, model):
            return len(model.keys) == 2

    selection = Selection(Resting(lambda keys: 10.0 / 2 ** len(keys), sure=True))
    assert selection.follow()
    assert len(steps(selection)) == 2
    assert [one.confidence for one in selection.steps] == [0.83, 0.83]


@pytest.mark.parametrize(
    ("explained", "number", "leaves", "everywhere"),
    [(False, 1, 0.3, True), (True, 1, 0.3, False), (False, 2, 0.3, False), (False, 2, 0.6, True)],
)
def test_every_place_is_tried_only_beside_what_does_not_count_as_explained(
    monkeypatch, explained, number, leaves, everywhere
):
    """Nor beside several effects where what was found takes half of what they leave."""
    look, tried = Mock(spec=Findings, explains=True, needed=True), []
    data = FrfData.__new__(FrfData)
    data.setup, data.asked, data._root = Mock(spec=Setup), None, fitted()
    data.is_named = data.is_over = data.is_alone = data.dominates = lambda model: False
    data._candidates = Mock(
        spec=FrfCandidates, can_look=lambda model: True, look_beside=lambda model: look,
        at_places=lambda *given, only_met: [fitted(MASS, DELAY)],
        everywhere=lambda before, number: tried.append(number) or [],
        does=lambda model, look, is_over: is_over(model),
    )  # fmt: skip
    monkeypatch.setattr(frf_data, "over_noise", lambda setup, model: 1.8)
    monkeypatch.setattr(frf_data, "explains", lambda data, model: explained)
    monkeypatch.setattr(frf_data, "best_of_each", list)
    monkeypatch.setattr(frf_data, "left", lambda *given: leaves)
    assert [one.hypothesis.keys for one in data.pointed(fitted(MASS), number)] == [(MASS,), (MASS, DELAY)]
    assert tried == ([number] if everywhere else [])


@pytest.mark.parametrize(
    ("explains", "at", "tried"), [(True, False, True), (True, True, False), (False, False, False)]
)
def test_beside_a_strong_effect_only_what_one_other_place_stands_for_is_tried(explains, at, tried):
    """What it leaves may be due to its law: two masses made up for that of a beam that shears."""
    look = Mock(spec=Findings, explains=explains, needed=True, is_at=lambda keys: at)
    met, other = fitted(MASS, DELAY), fitted(MASS, BASE)
    data = FrfData.__new__(FrfData)
    data.setup, data.asked, data._root = Mock(spec=Setup), None, fitted()
    data.is_named = data.is_over = data.is_alone = lambda model: False
    data.dominates = lambda model: True
    data._candidates = Mock(
        spec=FrfCandidates, can_look=lambda model: True, look_beside=lambda model: look,
        at_places=lambda *given, only_met: [met] if only_met else [other, met],
    )  # fmt: skip
    before = fitted(MASS)
    assert data.pointed(before, 1) == ([before, met] if tried else [before])


@pytest.mark.parametrize(
    ("key", "hinted"),
    [(MASS, ["rod"]), (("joint_coupling", "q1+q2"), ["body"]), (DELAY, ["rod", "body"])],
)
def test_what_did_best_alone_is_tried_at_once_beside_effects_elsewhere(monkeypatch, key, hinted):
    """A rod is rare, and what is no rod may do well enough for none to be tried."""
    made = []

    def looks(setup, model, by_force, advance, hinted):
        made.append(hinted)
        return Mock(spec=LooksWithoutLaw, one=Mock(spec=Findings), depends_on_force=False)

    monkeypatch.setattr(looks_beside, "LooksWithoutLaw", looks)
    candidates = FrfCandidates.__new__(FrfCandidates)
    candidates.setup, candidates.root, candidates.with_force = Mock(spec=Setup, advance=Mock()), None, False
    first, second = (Mock(spec=Found, alike=alike) for alike in ((("rod", "q1+q2"), ("body", "a")), ()))
    candidates.looks = Mock(one=Mock(spec=Findings, found=(first, second)))
    candidates._beside, candidates._order, candidates._forced = {}, {}, {}
    candidates.look_beside(fitted(key))
    assert [[port for port, _ in one] for one in made] == [hinted]


def test_so_many_looks_and_no_more():
    candidates = FrfCandidates.__new__(FrfCandidates)
    candidates.root = fitted()
    found = Mock(spec=Findings)
    candidates._beside = {frozenset([("added_mass", str(number))]): found for number in range(MOST_LOOKS)}
    candidates._order = {}
    assert candidates.can_look(candidates.root)
    assert candidates.can_look(fitted(("added_mass", "3")))
    assert candidates.look_beside(fitted(("added_mass", "3"))) is found
    assert not candidates.can_look(fitted(DELAY))


@pytest.mark.parametrize(
    ("places", "explains", "expected"), [(1, True, True), (2, True, False), (1, False, False)]
)
def test_fits_start_from_elsewhere_only_where_one_place_explains(monkeypatch, places, explains, expected):
    seen = []

    def searched(*given, one_is_enough, **more):
        seen.append(one_is_enough)
        return []

    monkeypatch.setattr(searches_beside, "explanations", searched)
    monkeypatch.setattr(frf_candidates, "from_each_start", lambda *given: [])
    bare = Mock(base=(), placed=(), keys=())
    root = Mock(spec=FittedFrfs, hypothesis=bare, x=np.zeros(0), cost=1.0)
    candidates = FrfCandidates(Mock(spec=Setup, effects=(), advance=Mock()), root, with_force=False)
    one = Mock(spec=Found, port="link", where="1", alike=(), curve=None, has=lambda *key: False)
    look = Mock(
        spec=Findings, explains=explains, found=(one,) * places, needed=True, fitted=None, left=1.0, places=()
    )
    candidates.looks = Mock(one=look)
    candidates.with_wider_laws = lambda before, found, look: found
    candidates.at_places(root, 0, look, lambda model: False)
    candidates.everywhere(root, 1)
    assert seen == [expected, *([False] if places == 1 else []), False]


@pytest.mark.parametrize("beside", [True, False])
def test_beside_effects_what_was_found_in_time_goes_on(monkeypatch, beside):
    """Of what comes after a search nothing but better fits is expected."""

    def cut_off(*given):
        raise OutOfTime

    found, before = [fitted(DELAY, MASS)], fitted(DELAY) if beside else fitted()
    found[0].hypothesis.placed[-1].effect = Mock(spec=Effect, comes_close=False)
    before.cost = 1.0
    monkeypatch.setattr(searches_beside, "explanations", lambda *given, **more: found)
    monkeypatch.setattr(frf_candidates, "from_each_start", cut_off)
    for module in (frf_candidates, searches_beside, wider_laws):
        monkeypatch.setattr(module, "starts", lambda *given: None)
    monkeypatch.setattr(frf_candidates, "pointed_to", lambda *given: [])
    monkeypatch.setattr(frf_candidates, "nearer", lambda *given: [])
    for module in (frf_candidates, wider_laws):
        monkeypatch.setattr(module, "over_noise", lambda *given: 9.0)
    candidates = FrfCandidates(Mock(spec=Setup, effects=(), advance=Mock()), fitted(), with_force=False)
    alone = Mock(spec=Found, port="body", where=MASS[1], alike=(), curve=None, has=lambda *key: True)
    look = Mock(spec=Findings, explains=True, found=(alone,), needed=True, fitted=None, left=1.0, places=())
    candidates.looks = Mock(one=look)
    if beside:
        assert candidates.at_places(before, 1, look, is_over) == found
    else:
        with pytest.raises(OutOfTime):
            candidates.at_places(before, 0, look, is_over)


@pytest.mark.parametrize(("cost", "again"), [(1.0, False), (1.2, False), (0.9, True)])
def test_beside_the_same_effects_is_searched_again_only_from_nearer(monkeypatch, cost, again):
    made = []

    def searched(*given, **more):
        made.append(given[1])
        return [Mock(spec=FittedFrfs, key=("added_mass", str(len(made))), cost=1.0)]

    monkeypatch.setattr(searches_beside, "explanations", searched)
    monkeypatch.setattr(wider_laws, "left", lambda *given: 1.0)
    monkeypatch.setattr(wider_laws, "over_noise", lambda *given: 1.0)
    first, other = (
        Mock(spec=FittedFrfs, hypothesis=Mock(base=(), placed=(), keys=keys), x=np.zeros(0), cost=each)
        for keys, each in (((MASS, DELAY), 1.0), ((DELAY, MASS), cost))
    )
    candidates = FrfCandidates(Mock(spec=Setup, effects=(), advance=Mock()), fitted(), with_force=False)
    look = Mock(spec=Findings, explains=False, found=(None, None), needed=True, fitted=None, left=1.0)
    before = candidates.at_places(first, 2, look, is_over)
    assert (candidates.at_places(other, 2, look, is_over) is before) is not again
    assert made == [first, other] if again else [first]


def is_over(model):
    return False


def begins(*given):
    return [x.tolist() for x in frf_candidates.starts(*given).before]


def test_a_search_sets_out_from_the_card_and_from_where_a_look_has_come_to():
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=("mass",), placed=()), x=np.array([0.3]))
    look = Mock(spec=Findings, needed=True, fitted=np.array([0.1]))
    assert begins(root) == [[0.0]]
    assert begins(root, look) == [[0.0], [0.1]]
    look.needed = False
    assert begins(root, look) == [[0.0]]
    beside = Mock(spec=FittedFrfs, hypothesis=Mock(base=("mass",), placed=(None,)), x=np.array([0.3, 2.0]))
    look = Mock(spec=Findings, needed=True, fitted=np.array([0.1, 1.5]))
    assert begins(beside, look) == [[0.0, 2.0], [0.3, 2.0], [0.1, 1.5]]
    several = Mock(base=("mass",), placed=(None, None))
    beside = Mock(spec=FittedFrfs, hypothesis=several, x=np.array([0.3, 2.0, 4.0]))
    look = Mock(spec=Findings, needed=True, fitted=np.array([0.1, 1.5, 4.5]))
    assert begins(beside, look) == [[0.3, 2.0, 4.0], [0.1, 1.5, 4.5]]


def test_a_search_sets_out_from_what_a_look_tells_too_and_asks_once():
    root = Mock(spec=FittedFrfs, hypothesis=Mock(base=("mass",), placed=()), x=np.array([0.3]))
    told = Mock(side_effect=lambda *given: [({"mass": 3.0}, np.array([0.1]))])
    look = Mock(spec=Findings, needed=True, fitted=np.array([0.1]), told=told)
    set_out = frf_candidates.starts(root, look)
    effect = Mock(spec=Effect, starts=lambda context, where: [{"mass": 1.0}, {"mass": 2.0}])
    hypothesis = Mock(spec=Hypothesis, context=None, placed=[Mock(effect=effect, where="link_2")])
    hypothesis.start = lambda placed, values, x: np.append(x, values["mass"])
    found = [[one.tolist() for one in some] for some in set_out.starts(hypothesis)]
    assert found == [[[0.0, 1.0], [0.0, 2.0]], [[0.1, 1.0], [0.1, 2.0]], [[0.1, 3.0]]]
    set_out.starts(hypothesis)
    assert told.call_count == 1


def test_a_look_is_known_for_the_same_laws_and_told_in_the_order_that_they_come_in():
    """What it found beside is coordinates by name; a wider law is another model."""
    free = FreeFunction(np.ones(1), np.ones((1, 1), dtype=complex), {}, np.array([1.0, 2.0, 3.0]))
    place = PlaceTried("joint", "q1", "a joint", 1.0, None, 1, free)
    look = Findings(9.0, 1.0, (place,), (), True, True, "", np.array([1.0, 2.0, 3.0]))
    candidates = FrfCandidates.__new__(FrfCandidates)
    candidates.root = fitted()
    candidates._beside = {frozenset([MASS, DELAY]): look}
    candidates._order = {frozenset([MASS, DELAY]): ("k", "mass", "delay")}
    same, turned, wide = fitted(MASS, DELAY), fitted(DELAY, MASS), fitted(MASS, DELAY)
    same.hypothesis.space = Mock(names=("k", "mass", "delay"))
    turned.hypothesis.space = Mock(names=("k", "delay", "mass"))
    wide.hypothesis.placed[0].effect = "another level"
    assert candidates.looked(same) is look
    assert candidates.looked(wide) is None
    found = candidates.look_beside(turned)
    np.testing.assert_array_equal(found.fitted, [1.0, 3.0, 2.0])
    np.testing.assert_array_equal(found.places[0].free.fitted, [1.0, 3.0, 2.0])


def test_an_effect_at_whose_place_a_look_finds_what_is_left_is_doubted():
    candidates = FrfCandidates.__new__(FrfCandidates)
    candidates.root = fitted()
    at_mass = Mock(has=lambda effect, where: (effect, where) == MASS)
    look = Mock(spec=Findings, needed=True, found=(at_mass,), explains=True)
    candidates._beside = {frozenset(keys): look for keys in ([MASS, DELAY], [DELAY, PLAY], [MASS])}
    candidates._order = {}
    assert candidates.doubted(fitted(DELAY, MASS)) == MASS
    assert candidates.doubted(fitted(DELAY, PLAY)) is None
    assert candidates.doubted(fitted(MASS)) is None  # alone, its law may be to blame
    assert candidates.one_explains(fitted(DELAY, PLAY))
    look.needed = look.explains = False
    assert candidates.doubted(fitted(DELAY, MASS)) is None
    assert not candidates.one_explains(fitted(DELAY, PLAY))


class Afresh(Model):
    """Fitted afresh beside the others."""


class Doubting(World):
    """The mass, fitted while the delay was missing, ended beside the truth."""

    def __init__(self):
        super().__init__(self.rest)
        self.fresh = set()

    def rest(self, keys):
        return 100.0 - 60 * (MASS in keys) - 35 * (DELAY in keys)

    def doubted(self, model):
        return MASS if {MASS, DELAY} <= set(model.keys) and not isinstance(model, Afresh) else None

    def pointed(self, before, number):
        found = super().pointed(before, number)
        return (
            [before, *(Afresh(one.keys) for one in found[1:])]
            if MASS not in before.keys and number
            else found
        )

    def compare(self, models):
        scores = -np.array([100.0 * self.of(one) for one in models])
        return Comparison(models, scores, np.tile(scores[:, None], 3))

    def of(self, model):
        return NOISE / 2 if isinstance(model, Afresh) and MASS in model.keys else self.rest(set(model.keys))

    def is_enough(self, model):
        return self.of(model) <= NOISE

    def share(self, first, last):
        return 1 - self.of(last) / self.of(first)


def test_what_is_doubted_is_fitted_afresh_beside_the_others():
    selection = Selection(Doubting())
    assert selection.follow()
    assert selection.current.keys == (DELAY, MASS)
    assert isinstance(selection.current, Afresh)


class TooNarrow(Doubting):
    """Fitted afresh it is the same; with a wider law it is not."""

    def pointed(self, before, number):
        return World.pointed(self, before, number)

    def wider(self, model, keys):
        self.widened = keys
        return [Afresh(model.keys)]


def test_what_is_doubted_gets_a_wider_law_where_it_is_the_same_again():
    selection = Selection(TooNarrow())
    assert selection.follow()
    assert set(selection.current.keys) == {DELAY, MASS}
    assert isinstance(selection.current, Afresh)
    assert selection.data.widened == [MASS]


class Short(World):
    """One effect, in whose place a look finds all that its narrow law leaves; a mass besides does it too."""

    def __init__(self, found):
        super().__init__(self.rest)
        self.found = found

    def rest(self, keys):
        return NOISE / 2 if {LINK, MASS} <= set(keys) else 1000.0 - 900 * (LINK in keys) - 50 * (MASS in keys)

    def falls_short(self, model):
        return LINK if self.found and model.keys == (LINK,) and not isinstance(model, Afresh) else None

    def wider(self, model, keys):
        return [Afresh(model.keys)] if LINK in keys else []

    def of(self, model):
        return NOISE / 2 if isinstance(model, Afresh) else self.rest(set(model.keys))

    def is_enough(self, model):
        return self.of(model) <= NOISE

    def share(self, first, last):
        return 1 - self.of(last) / self.of(first)


@pytest.mark.parametrize(("found", "keys"), [(True, (LINK,)), (False, (LINK, MASS))])
def test_one_effect_gets_its_wider_law_before_another_one_in_its_place(found, keys):
    """Of a thin beam that swings on a link an absorber and a mass had been named."""
    selection = Selection(Short(found))
    assert selection.follow()
    assert selection.current.keys == keys
    assert isinstance(selection.current, Afresh) == found


@pytest.mark.parametrize(
    ("keys", "takes", "explains", "at", "short"),
    [
        ([MASS], 0.3, True, True, MASS), ([MASS], 0.6, True, True, None), ([MASS], 0.3, False, True, None),
        ([MASS], 0.3, True, False, None), ([MASS, DELAY], 0.3, True, True, None),
    ],
)  # fmt: skip
def test_one_effect_falls_short_where_all_that_is_left_is_in_its_place(
    monkeypatch, keys, takes, explains, at, short
):
    place = Mock(spec=Found, has=lambda *key: at)
    look = Mock(spec=Findings, needed=True, explains=explains, found=(place,))
    data = FrfData.__new__(FrfData)
    data.setup, data._root = Mock(spec=Setup), fitted()
    data.is_enough = data.is_alone = lambda model: False
    data._candidates = Mock(spec=FrfCandidates, can_look=lambda model: True, look_beside=lambda model: look)
    monkeypatch.setattr(frf_by_look, "left", lambda *given: takes)
    assert data.falls_short(fitted(*keys)) == short


def step_of(confidence, ties):
    other = Compared("play", "c", 1.0, None, -1.0, 0.4, 2)
    return Step("added_mass", "a", {}, {}, {}, confidence, Mock(spec=Gaps), (other,), ties)


def test_one_of_several_is_as_sure_as_it_is_beside_the_others():
    found = beside_others(step_of(0.2, (DELAY,)), 0.9, [MASS, DELAY])
    assert (found.confidence, found.ties) == (0.9, ())
    assert found.alternatives[0].confidence == pytest.approx(0.4 * 0.1 / 0.8)
    alone = beside_others(step_of(0.0, (DELAY, (UNSTRUCTURED, ""))), 0.9, [MASS, DELAY])
    assert (alone.confidence, alone.ties) == (0.9, ())
    kept = beside_others(step_of(0.2, (DELAY, PLAY)), 0.9, [MASS, DELAY])
    assert (kept.confidence, kept.ties) == (0.2, (PLAY,))
    assert kept.alternatives[0].confidence == 0.4


class Tied(World):
    """Every effect was tied with something that is not in the model; what that does beside the others."""

    def __init__(self, left, again):
        super().__init__(left)
        self.again = again

    def surely(self, model, key):
        return self.again


class Rivalled(World):
    """Every effect was tied with one that is not there, and that may be more plausible beside the others."""

    more = 0.0

    def instead(self, model, key, *, anyway=False):
        rest = tuple(one for one in model.keys if one != key)
        return [Model((*rest, ("spare", name))) for name in "gf"] if anyway and key == DELAY else []

    def plausible(self, comparison):
        return {
            k: self.more * (one.key == ("spare", "f")) + 2 * self.more * (one.key == ("spare", "g"))
            for k, one in enumerate(comparison.models)
            if self.is_enough(one)
        }


@pytest.mark.parametrize(
    ("more", "confidence", "expected"),
    [
        (0.0, 0.95, DELAY),
        (3.0, 0.95, DELAY),
        (9.0, 0.95, ("spare", "f")),
        (9.0, 0.6, ("spare", "f")),
        (9.0, 0.4, ("spare", "g")),
        (0.0, 0.4, DELAY),
    ],
)
def test_what_was_tied_with_an_effect_takes_its_place_if_it_is_clearly_more_plausible_there(
    more, confidence, expected
):
    """Only what was tied, not another one that was looked at; unless the effect is less sure than not."""
    hidden = [MASS, expected]

    def left(keys):
        others = keys - {MASS, DELAY, ("spare", "f"), ("spare", "g")}
        does = [MASS in keys, bool(keys & {DELAY, ("spare", "f"), ("spare", "g")})]
        return NOISE / 2 + 20 * (2 - sum(does)) + len(others) + 0.01 * (DELAY not in keys)

    selection = Selection(Rivalled(left))
    selection.data.more = more
    assert selection.follow()
    assert set(steps(selection)) == {MASS, DELAY}
    selection.steps[:] = [replace(step, confidence=confidence) for step in selection.steps]
    selection.drop_needless()
    assert set(steps(selection)) == set(hidden)
    assert set(selection.current.keys) == set(hidden)


def test_what_an_effect_takes_is_told_anew_where_one_before_it_has_gone():
    """The second took little beside the first, which nobody misses."""
    left = {frozenset(): 40.0, frozenset({LINK}): 4.0, frozenset({LINK, MASS}): 1.0, frozenset({MASS}): 1.0}
    data, gaps = World(lambda keys: left[keys]), Mock(spec=Gaps)
    data.gaps = lambda before, after: gaps
    told = [Step(*key, {}, {}, {}, 0.95, Mock(spec=Gaps), (), share=0.07) for key in (LINK, MASS)]
    found = shared_anew(data, data.root, Model((LINK, MASS)), told)
    assert [one.share for one in found] == pytest.approx([0.9, 0.075])
    (alone,) = shared_anew(data, data.root, Model((MASS,)), told[1:])
    assert alone.share == pytest.approx(0.975)
    assert alone == replace(told[1], share=alone.share, gaps=gaps)


@pytest.mark.parametrize(("again", "ties"), [(0.96, ()), (0.5, (("spare", "f"),)), (None, (("spare", "f"),))])
def test_what_was_tied_with_an_effect_is_put_in_its_place_beside_the_others(again, ties):
    """There it may be far behind; if not, the effect is no surer than it was and stays tied."""
    selection = Selection(Tied(lambda keys: 4.0 ** -len(keys & {MASS, DELAY, PLAY}) * 64, again))
    selection.follow()
    selection.drop_needless()
    assert set(steps(selection)) == {MASS, DELAY, PLAY}
    assert {one.ties for one in selection.steps} == {ties}
    assert {one.confidence for one in selection.steps} == {0.95 if again is None or again < 0.95 else 0.96}


@pytest.mark.parametrize(
    ("least", "sure", "kept"),
    [(0.0, True, [MASS, DELAY]), (0.0, False, [MASS, DELAY, PLAY]), (0.02, True, [MASS, DELAY, PLAY])],
)
def test_an_effect_less_plausible_than_nothing_is_left_out_if_the_others_are_sure_without_it(
    least, sure, kept
):
    """It may be what the others' laws leave; the model with it may still predict better."""
    selection = Selection(World(lambda keys: 4.0 ** -len(keys & {MASS, DELAY, PLAY}) * 64))
    selection.follow()
    whole, selection.data.sure = selection.current, sure
    selection.steps[:] = [
        replace(one, confidence=0.95 if (one.effect, one.where) != PLAY else least) for one in selection.steps
    ]
    selection.drop_hardly_possible()
    assert steps(selection) == kept
    assert list(selection.current.keys) == kept
    assert selection.furthest is (whole if len(kept) == 2 else None)
    assert len(kept) == 3 or {one.confidence for one in selection.steps} == {0.83}


@pytest.mark.parametrize(("narrow", "wide", "kept"), [(0.9, 5.0, 1), (5.0, 0.9, 1), (5.0, 5.0, 2)])
def test_an_effect_less_plausible_than_nothing_goes_if_a_wider_law_of_the_others_is_enough(
    narrow, wide, kept
):
    class Wider(World):
        def wider(self, model, keys):
            assert keys == (MASS,)
            return [Model((MASS, "wide"))]

    left = {(): 40.0, (MASS,): narrow * NOISE, (MASS, "wide"): wide * NOISE, (MASS, PLAY): 0.5 * NOISE}
    data = Wider(lambda keys: next(size for names, size in left.items() if set(names) == set(keys)))
    selection = Selection(data)
    selection.current, none = Model((MASS, PLAY)), (("spare", "f"),)
    selection.steps[:] = [
        Step(*key, {}, {}, {}, sure, Mock(spec=Gaps), (), ties=none)
        for key, sure in ((MASS, 0.9), (PLAY, 0.0))
    ]
    told = []
    selection._describe_anew = lambda: told.append(selection.current.keys)
    selection.drop_hardly_possible()
    assert len([key for key in selection.current.keys if key != "wide"]) == kept
    assert told == ([] if kept == 2 else [(MASS,) if narrow < 1 else (MASS, "wide")])


def test_what_a_function_alone_tells_is_named_where_no_law_is():
    """Nothing takes anything by its law, or two effects do though one place explains everything."""

    class Told(World):
        def by_function(self, model, tried, hardly=()):
            assert (MASS,) in [one.keys for one in tried]
            return Model((PLAY,)), {PLAY: 0.83}

        def candidates(self, before, number):
            return self.pointed(before, number)

    selection = Selection(Told(lambda keys: 20.0))
    selection.run()
    assert [(one.effect, one.where, one.confidence, one.ties) for one in selection.steps] == [
        (*PLAY, 0.83, ())
    ]
    assert selection.current.keys == (PLAY,)
    both = Selection(Told(lambda keys: 3.0 + 20 * len({DELAY, LINK} - keys), sure=True))
    both.run()
    assert steps(both) == [PLAY]
    assert set(both.furthest.keys) >= {DELAY, LINK}  # which stands for what has no name


class ByFunction(FrfData):
    """One place explains everything, or several do together; laws leave so much."""

    asked, setup = None, None

    def __init__(self, *found, stands=(), explained=(), alike=()):
        found = tuple(replace(one, alike=(*one.alike, *alike)) for one in found)
        found = tuple(replace(one, tells=told_by(one)) for one in found)
        look = Findings(8.0, 0.7, (), found, explains=True, needed=True, says="")
        one = look if len(found) == 1 else replace(look, found=found[:1], explains=False)
        self._root, self.stands, self.done = fitted(), stands, explained
        self._candidates = Mock(spec=FrfCandidates, looks=Mock(one=one, several=look))
        self._candidates.searched = lambda before, number, allowed, by_force: [
            fitted(*before.hypothesis.keys, key) for key in (RUBS, WEIGHS, PLAYS, MASS) if allowed(*key)
        ]

    def standing(self, model):
        return super().standing(model) if self.told else (self.stands, ())

    def is_contradicted(self, model):
        return False


RUBS, WEIGHS = ("coulomb_friction", "q3"), ("sensor_mass", "sensor")
TORQUE = Found("torque", "q3", "", 8.0, (("torque", "q3"),), None, (), Loss(0.5, 0.5))
CARRIED = Found("carried", "sensor", "", 8.0, (("carried", "sensor"),), Mock(spec=Curve), ())
ODD = Found("rod", "q1+q3", "", 8.0, (("rod", "q1+q3"),), Mock(spec=Curve), ())


@pytest.mark.parametrize(
    ("found", "given", "keys", "left"),
    [
        ([TORQUE], {}, (RUBS,), ("q3",)),
        ([TORQUE], {"stands": (RUBS, ("bearing_flexibility", "q3"))}, (RUBS,), ("q3",)),
        ([TORQUE], {"stands": (RUBS,)}, None, ()),  # by its law already
        ([TORQUE], {"stands": (PLAYS,)}, None, ()),
        ([TORQUE], {"alike": (("torque", "q1"),)}, None, ()),
        ([TORQUE], {"explained": (RUBS,)}, None, ()),
        ([TORQUE], {"explained": (PLAYS,)}, (RUBS,), ("q3",)),  # wide laws do what no such thing does
        ([TORQUE], {"explained": (RUBS, PLAYS)}, (RUBS,), ("q3",)),
        ([TORQUE], {"explained": (PLAYS, MASS)}, (RUBS, MASS), ("q3",)),
        ([TORQUE], {"explained": (RUBS, MASS)}, None, ()),
        ([TORQUE], {"explained": (MASS,)}, None, ()),
        ([CARRIED, TORQUE], {"explained": (PLAYS,)}, None, ()),
        ([ODD], {}, None, ()),
        ([CARRIED, TORQUE], {}, (WEIGHS, RUBS), ("sensor", "q3")),
        ([CARRIED, ODD], {}, (WEIGHS,), ("q1+q3",)),
        ([CARRIED, TORQUE], {"stands": (MASS,)}, (MASS, WEIGHS, RUBS), ("sensor", "q3")),
        ([CARRIED, TORQUE], {"stands": (RUBS, MASS)}, (RUBS, MASS, WEIGHS), ("sensor", "q3")),
        ([CARRIED, TORQUE], {"stands": (PLAYS,)}, None, ()),
        ([CARRIED, ODD], {"stands": (WEIGHS,)}, None, ()),
    ],
)
def test_functions_tell_effects_whose_laws_are_unknown(monkeypatch, found, given, keys, left):
    data, model = ByFunction(*found, **given), fitted(*given.get("explained", (BASE,)))
    monkeypatch.setattr(frf_by_look, "explains", lambda data, model: bool(data.done))
    monkeypatch.setattr(frf_by_look, "over_noise", lambda setup, one: 6.0)
    got = data.by_function(model, [fitted(), model])
    assert data.told == (keys or ())
    if keys is None:
        assert got is None
        return
    assert got[0].hypothesis.keys == keys
    assert list(got[1].values()) == pytest.approx([1 / 1.2] * len(got[1]))
    assert data.standing(got[0]) == (keys, left)


def test_the_best_of_the_models_that_were_tried_stands_for_what_is_told(monkeypatch):
    data, wide = ByFunction(TORQUE), fitted(RUBS)
    monkeypatch.setattr(frf_by_look, "explains", lambda data, model: False)
    odd = fitted(RUBS)
    odd.key = (UNSTRUCTURED, "")  # the same and a mode with no structure, which comes nearer
    monkeypatch.setattr(frf_by_look, "over_noise", lambda setup, one: {wide: 2.0, odd: 0.7}.get(one, 6.0))
    assert data.by_function(fitted(BASE), [fitted(RUBS), wide, odd, fitted(RUBS, BASE)])[0] is wide


@pytest.mark.parametrize(("hardly", "told"), [((RUBS,), (RUBS,)), ((), ())])
def test_what_its_law_makes_hardly_possible_has_its_name_by_its_function(monkeypatch, hardly, told):
    """Numbers that nobody believes make up for a law that is not that of what is there."""
    data, model = ByFunction(TORQUE, stands=(RUBS,)), fitted(RUBS)
    monkeypatch.setattr(frf_by_look, "explains", lambda data, model: False)
    monkeypatch.setattr(frf_by_look, "over_noise", lambda setup, one: 6.0)
    got = data.by_function(model, [fitted(), model], hardly)
    assert data.told == told
    assert got == ((model, {RUBS: pytest.approx(1 / 1.2)}) if told else None)


def test_what_has_no_fit_is_not_told(monkeypatch):
    data = ByFunction(TORQUE)
    data._candidates.searched = lambda *given, **more: []
    monkeypatch.setattr(frf_by_look, "explains", lambda data, model: False)
    assert data.by_function(fitted(BASE), []) is None
    assert data.told == ()


def test_who_asks_for_effects_gets_no_others():
    data = ByFunction(TORQUE)
    data.asked = {"added_mass": ()}
    assert data.by_function(fitted(BASE), []) is None


class Places(World):
    """Effects are found together, if there are any, and what is followed leads nowhere, or not to the end."""

    def __init__(self, left, keys, followed=()):
        super().__init__(left, named=[followed])
        self.all, self.first, self.wanted = keys, followed, []

    def pointed(self, before, number):
        further = self.first[number : number + 1]
        return [before, *(Model((*before.keys, key)) for key in further)]

    def candidates(self, before, number):
        return [before, Model((*before.keys, ("spare", "f")))]

    def gaps(self, before, after):
        return Gaps(1.0, 0.5, None, None, 0.1)

    def together(self, known=None):
        self.wanted.append(known and known.keys)
        every = {key: [Model((*(one for one in self.all if one != key), key))] for key in self.all}
        return (Model(self.all), every) if self.all else None


def test_effects_that_are_found_together_are_compared_each_and_those_that_nobody_misses_go():
    hidden = {MASS, DELAY, PLAY}
    selection = Selection(Places(lambda keys: NOISE / 2 + 20 * len(hidden - keys), (MASS, DELAY, PLAY, BASE)))
    selection.run()
    assert selection.data.wanted == [None]
    assert set(steps(selection)) == hidden
    assert set(selection.current.keys) == hidden
    first, *others = selection.rounds[-5:]
    assert [one.keys for one in first.comparison.models] == [(), (MASS, DELAY, PLAY, BASE)]
    assert [one.comparison.models[1].key for one in others] == [MASS, DELAY, PLAY, BASE]


@pytest.mark.parametrize(
    ("followed", "together", "asked", "expected"),
    [
        ((MASS,), (MASS, DELAY), [(MASS,)], {MASS, DELAY}),  # named, and more than noise is left
        ((MASS,), (), [(MASS,)], {MASS}),
        ((MASS, DELAY), (MASS, LINK), [], {MASS, DELAY}),  # nothing is left
        ((), (), [None], set()),
    ],
)
def test_effects_come_together_where_those_that_are_followed_leave_something(
    followed, together, asked, expected
):
    hidden = {MASS, DELAY}
    selection = Selection(Places(lambda keys: NOISE / 2 + 20 * len(hidden - keys), together, followed))
    selection.run()
    assert selection.data.wanted == asked
    assert set(steps(selection)) == expected


@pytest.mark.parametrize(
    ("alone", "needed", "asked", "known", "enough", "named", "taken"),
    [
        (False, True, None, None, True, False, True),
        (False, True, None, None, False, True, True),
        (False, True, None, None, False, False, False),
        (False, True, None, (MASS,), False, True, True),
        (False, True, None, (LINK,), False, True, False),
        (False, True, None, (DELAY, MASS), False, True, False),
        (False, True, None, (LINK,), True, False, True),
        (True, True, None, None, True, True, False),  # one place explains everything
        (False, False, None, None, True, True, False),
        (False, True, {"added_mass": ()}, None, True, True, False),
    ],
)
def test_effects_come_together_where_one_place_does_not_do_and_they_are_enough_or_sure(
    monkeypatch, alone, needed, asked, known, enough, named, taken
):
    """Beside what is sure already, what is sure and more."""
    data, model = Mock(spec=FrfData, asked=asked, setup=Mock(spec=Setup), root=fitted()), fitted(MASS, DELAY)
    one, several = Mock(spec=Findings, explains=alone, needed=needed), Mock(spec=Findings)
    data._look = one
    data._candidates = Mock(spec=FrfCandidates, looks=Mock(spec=LooksWithoutLaw, one=one, several=several))
    data.is_enough.return_value, data.is_named.return_value = enough, named
    found = model, {MASS: (fitted(DELAY, MASS),)}
    monkeypatch.setattr(frf_by_look, "Together", lambda *given: Mock(found=lambda: found))
    assert FrfData.together(data, known and fitted(*known)) == (found if taken else None)
    assert data._look is (several if taken else one)
    assert data._candidates.remember.call_count == taken


def test_what_was_fitted_together_is_considered_in_place_of_what_is_named(monkeypatch):
    monkeypatch.setattr(frf_candidates, "over_noise", lambda setup, model: 1.0)
    candidates = FrfCandidates(Mock(spec=Setup, advance=Mock()), fitted(), with_force=False)
    itself, other = fitted(DELAY, MASS), fitted(DELAY, BASE)
    candidates.remember([itself, other])
    assert candidates.considered(itself, MASS) == [other]

"""Looking that is cut off: what was found by then is said, and that it was cut off."""

from unittest.mock import Mock

import pytest

from flexmodal.diagnosis import diagnose
from flexmodal.diagnosis.report.frf_sections import frf_headline
from flexmodal.diagnosis.selection import described
from flexmodal.diagnosis.selection.exchange import without
from flexmodal.diagnosis.time_limit import FOR_EFFECTS, OutOfTime, TimeLimit, limit_of
from flexmodal.errors import InvalidRequest
from tests.diagnosis.test_follow import BASE, DELAY, MASS, Model, Selection, World, fitted, settling, steps
from tests.diagnosis.test_workflow import campaign


class Clock:
    """Tells what it is set to."""

    now = 100.0

    def __call__(self):
        return self.now


class Slow(World):
    """Each look takes a second, and asks for the time at its end."""

    def __init__(self, left, seconds, sure):
        super().__init__(left, sure=sure)
        self.clock = Clock()
        self.limit = TimeLimit(seconds, self.clock)

    def pointed(self, before, number):
        self.clock.now += 1.0
        self.limit.check()
        return super().pointed(before, number)

    def candidates(self, before, number):
        return self.pointed(before, number)


def test_what_comes_late_has_its_part_in_any_case():
    """From when it begins; nobody else has any more."""
    clock = Clock()
    limit = TimeLimit(10.0, clock)
    clock.now += 12.0
    with limit.counting(at_least=0.15):
        clock.now += 1.4
        limit.check()
        clock.now += 0.2
        with pytest.raises(OutOfTime):
            limit.check()
    with limit.counting(), pytest.raises(OutOfTime):
        limit.check()


@pytest.mark.parametrize("seconds", [None, 100.0])
def test_time_that_nothing_counts_does_not_run_out(seconds):
    clock = Clock()
    limit = TimeLimit(seconds, clock)
    clock.now += 1e6
    limit.check()
    assert not limit.was_hit
    assert limit.words() == ()


def test_it_asks_whenever_something_is_told():
    clock, told = Clock(), Mock()
    limit = TimeLimit(10.0, clock)
    advance = limit.watching(told)
    with limit.counting(FOR_EFFECTS):
        clock.now += 9.9 * FOR_EFFECTS
        advance("fitting", 0.5)
        clock.now += 0.2 * FOR_EFFECTS
        with pytest.raises(OutOfTime):
            advance("fitting", 1.0)
    advance("writing", 0.0)
    assert [call.args for call in told.call_args_list] == [("fitting", 0.5), ("writing", 0.0)]
    assert limit.words() == ("Looking was cut off after 10 s: with more time more may be named.",)


class Kept(Selection):
    """Steps made by hand have nothing to be judged by once more."""

    def drop_needless(self):
        pass


def left_of_three(keys):
    return 100.0 - 60 * (BASE in keys) - 30 * (MASS in keys) - 9.5 * (DELAY in keys)


@pytest.mark.parametrize(
    ("seconds", "sure", "said"),
    [
        (None, False, [BASE, MASS, DELAY]),
        (3.5 / FOR_EFFECTS, False, [BASE, MASS, DELAY]),
        (2.5 / FOR_EFFECTS, True, [BASE, MASS]),
        (2.5 / FOR_EFFECTS, False, []),
        (0.5 / FOR_EFFECTS, True, []),
    ],
)
def test_of_several_those_that_are_sure_stand_when_the_time_is_up(seconds, sure, said):
    """Others might change what each takes: alone they are not named."""
    world = Slow(left_of_three, seconds, sure)
    selection = Kept(world, world.limit)
    selection.run()
    assert steps(selection) == said
    assert list(selection.current.keys) == said
    assert world.limit.was_hit == (len(said) < 3)
    assert selection.rounds, "what the verdict goes by"
    further = () if selection.furthest is None else selection.furthest.keys
    assert further == ((BASE, MASS) if not said and seconds > 1 / FOR_EFFECTS else ())


def test_which_effects_are_sure_is_asked_even_if_a_look_has_lasted_too_long():
    """The third one lasts ten times as long as there is time."""

    class Late(Slow):
        def pointed(self, before, number):
            self.clock.now += 100.0 if number == 2 else 0.0
            return super().pointed(before, number)

        def settles(self, model):
            self.clock.now += 1.0
            self.limit.check()
            return super().settles(model)

    world = Late(left_of_three, 10.0, True)
    selection = Kept(world, world.limit)
    selection.run()
    assert world.limit.was_hit
    assert steps(selection) == [BASE, MASS]


def test_those_that_were_asked_for_in_time_are_sure(monkeypatch):
    data, model, asked = (
        settling(monkeypatch, dict.fromkeys((MASS, BASE, DELAY), 0.83)),
        fitted(MASS, BASE, DELAY),
        [],
    )

    def without(model, key, less=data.without):
        asked.append(key)
        if len(asked) == 3:
            raise OutOfTime
        return less(model, key)

    monkeypatch.setattr(data, "without", without)
    assert data.settles(model) == {MASS: 0.83, BASE: 0.83}
    assert data.standing(model) == ((MASS, BASE), ("tip",))


@pytest.mark.parametrize("within", [0.0, -1.0, float("nan"), float("inf")])
def test_what_is_no_time_is_refused(within):
    with pytest.raises(InvalidRequest, match="within"):
        limit_of(within)


@pytest.mark.slow
def test_a_diagnosis_without_time_says_where_it_looked_and_that_it_was_cut_off():
    found = diagnose(*campaign("added_mass@link_3", postures=3, points=3, trials=2), within=1e-3)
    assert found.verdict.effects[0][0] == "unknown"
    assert not found.verdict.explained
    assert found.verdict.cut_off
    assert "cut off after 0.001 s" in found.verdict.says
    assert frf_headline(found) == "Something is missing that has no name yet"
    assert "nothing in the catalogue" not in found.verdict.says
    assert found.look.places


class Late(World):
    """Whose further fits ask for the time, which is up."""

    def wider(self, model, keys):
        raise OutOfTime

    def instead(self, model, key, *, anyway=False):
        raise OutOfTime

    def surely(self, model, key):
        raise OutOfTime


def test_once_time_is_up_effects_are_left_out_in_turn_without_wider_laws_or_others_in_their_stead():
    data = Late(lambda keys: 0.5 * 4.0 ** len({MASS, DELAY} - keys))
    model = Model((MASS, DELAY))
    assert without(data, model, DELAY).keys == (MASS,)
    selection = Selection(data)
    selection.current = model
    selection.steps[:] = [
        selection.describe(data.compare([data.root, Model((key,))]), 1) for key in model.keys
    ]
    selection.drop_needless()
    assert steps(selection) == [MASS, DELAY]
    assert selection.current is model


def test_once_time_is_up_in_the_midst_of_leaving_effects_out_the_rest_stays(monkeypatch):
    asked, told = [], []
    monkeypatch.setattr(described, "shared_anew", lambda data, root, last, steps: told.append(last) or steps)

    class Shorter(Late):
        def without(self, model, key):
            asked.append(key)
            if len(asked) > 1:
                raise OutOfTime
            return super().without(model, key)

    data = Shorter(lambda keys: 0.5 * 4.0 ** len({DELAY, BASE} - keys))
    selection = Selection(data)
    selection.current = Model((MASS, DELAY, BASE))
    alone = [data.compare([data.root, Model((key,))]) for key in selection.current.keys]
    selection.steps[:] = [selection.describe(one, 1) for one in alone]
    selection.drop_needless()
    assert asked == [MASS, DELAY]
    assert steps(selection) == [DELAY, BASE]
    assert selection.current.keys == (DELAY, BASE)
    assert told == [selection.current]

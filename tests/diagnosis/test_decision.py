"""No answer turns with the last digit: within a margin the simpler explanation stays, and that is told."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.outcome import Gaps, Step
from flexmodal.diagnosis.selection.comparison import MARGIN, TIED, Comparison
from flexmodal.diagnosis.selection.decision import (
    ASKED,
    MORE_PLAUSIBLE,
    SIGNIFICANT,
    Answer,
    Choice,
    Round,
    among_vouched,
    any_gains,
    choice,
    gains_enough,
    is_idle,
    reaches,
    rivals,
)
from flexmodal.diagnosis.selection.frf_thresholds import (
    ANOTHER,
    ANOTHER_MARGIN,
    CLOSE,
    EXPLAINED,
    FLOOR_MARGIN,
    FLOOR_REACHED,
    FROM_BEYOND,
    LEFT,
    WORTH,
    WORTH_MARGIN,
    at_the_noise,
    takes_enough,
)
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.diagnosis.verdict.undecided import undecided_words
from flexmodal.diagnosis.verdict.verdict import BORDER, DOUBTFUL, verdict

MIDDLE = 1 - FLOOR_MARGIN
"""Of the border of the noise, over its end."""
LAST_DIGIT = (-1e-9, 0.0, 1e-9)
KEYS = [("none", ""), ("added_mass", "link_2"), ("local_absorber", "link_3"), ("unstructured_mode", "")]


def compared(*gains, beliefs=False, table=None):
    """Models that gain so much over the first, under every setting unless a table is given."""
    scores = np.array([0.0, *gains])
    models = [
        SimpleNamespace(key=key, number=k, hypothesis=None, x=None, parameters=k)
        for k, key in enumerate(KEYS[: len(scores)])
    ]
    rows = np.tile(scores[:, None], 3) if table is None else np.array(table)
    return Comparison(models, scores, rows, beliefs=beliefs)


def chosen(comparison, asked=None, worth=Answer.YES):
    return choice(comparison, asked, [worth] * len(comparison.models))


@pytest.mark.parametrize("rounding", LAST_DIGIT)
def test_a_gain_at_its_threshold_is_undecided_whatever_the_rounding(rounding):
    found = chosen(compared(SIGNIFICANT + rounding))
    assert found == Choice(None, (1,))
    assert any_gains(compared(SIGNIFICANT + rounding)) is Answer.UNDECIDED


@pytest.mark.parametrize(
    ("gain", "expected"),
    [
        (SIGNIFICANT - 1.1 * MARGIN, Choice(None)),
        (SIGNIFICANT - 0.9 * MARGIN, Choice(None, (1,))),
        (SIGNIFICANT + 0.9 * MARGIN, Choice(None, (1,))),
        (SIGNIFICANT + 1.1 * MARGIN, Choice(1)),
    ],
)
def test_a_no_and_a_yes_lie_two_margins_apart(gain, expected):
    assert chosen(compared(gain)) == expected


def test_what_takes_too_little_does_not_bar_what_takes_enough():
    """However much evidence it has, as a torque that passes for a trifle of every line."""
    found = compared(20.0, 40.0)
    assert choice(found, None, [Answer.YES, Answer.YES, Answer.NO]) == Choice(1)
    assert choice(found, None, [Answer.YES, Answer.YES, Answer.UNDECIDED]) == Choice(None, (2,))
    assert choice(found, None, [Answer.YES, Answer.NO, Answer.NO]) == Choice(None)


def test_what_is_vouched_for_comes_first_if_it_gains_anything():
    """Of several effects each alone may take little; another that takes more may sit in a wrong place."""
    found = compared(2.0, 40.0)
    worth = [Answer.NO, Answer.NO, Answer.YES]
    assert choice(found, None, worth) == Choice(2)
    assert choice(found, None, worth, [False, True, False]) == Choice(1)
    assert choice(found, None, worth, [False, True, True]) == Choice(2)
    assert choice(compared(0.5 * MARGIN), None, [Answer.NO] * 2, [False, True]) == Choice(None)


@pytest.mark.parametrize(
    ("behind", "frequency", "expected"), [(0.5, 0.0, 1), (20.0, 0.0, 2), (20.0, 1.0, 1), (20.0, 0.99, 1)]
)
def test_what_the_best_comes_down_to_stands_in_its_place(behind, frequency, expected):
    """Where the two are tied, or the best swings no slower than what counts as a mass."""
    mass, absorber = ("added_mass", "link_2"), ("local_absorber", "link_2")
    placed = SimpleNamespace(effect=catalogue()["local_absorber"], label="local_absorber@link_2")
    space = SimpleNamespace(
        index={"local_absorber@link_2.frequency": 0}, bounds=(np.array([-1.0]), np.array([1.0]))
    )
    hypothesis = SimpleNamespace(placed=[placed], space=space)
    models = [
        SimpleNamespace(key=key, hypothesis=hypothesis, x=np.array([frequency]), parameters=1)
        for key in (("none", ""), mass, absorber)
    ]
    scores = np.array([0.0, 40.0 - behind, 40.0])
    assert chosen(Comparison(models, scores, np.tile(scores[:, None], 3))) == Choice(expected)


@pytest.mark.parametrize(
    ("plausible", "expected"),
    [
        ({}, 2),
        ({1: MORE_PLAUSIBLE + 1.1 * MARGIN, 2: 0.0}, 1),
        ({1: MORE_PLAUSIBLE - 1.1 * MARGIN, 2: 0.0}, 2),
        ({1: 90.0}, 2),  # the best leaves more than noise, and is not among them
    ],
)
def test_of_two_that_leave_only_noise_the_clearly_more_plausible_comes_first(plausible, expected):
    assert choice(compared(20.0, 30.0), None, [Answer.YES] * 3, (), plausible) == Choice(expected)


@pytest.mark.parametrize("rounding", LAST_DIGIT)
def test_at_the_border_of_being_more_plausible_the_best_stays_and_it_is_told(rounding):
    found = compared(20.0, 30.0)
    made = choice(found, None, [Answer.YES] * 3, (), {1: MORE_PLAUSIBLE + rounding, 2: 0.0})
    assert made == Choice(2, rival=1)
    (words,) = undecided_words([Round(found, made)])
    assert words.startswith("Whether it is ")
    assert "is undecided: both explain everything" in words


@pytest.mark.parametrize("rounding", LAST_DIGIT)
@pytest.mark.parametrize(("over", "confidence"), [(1.3, 0.0141), (CLOSE, 1e-20)])
def test_at_the_border_of_belief_it_is_explained_and_told(over, confidence, rounding):
    step = Step("added_mass", "link_3", {}, {}, {}, confidence, Gaps(1.0, 0.1, None, None, 0.1), ())
    facts = Facts(
        (step,),
        {"added_mass": "a mass"},
        step.gaps,
        over + rounding,
        Answer.YES,
        {},
        open_=False,
        place="tip",
    )
    found = verdict(facts)
    assert found.explained
    assert found.undecided == (DOUBTFUL,)


@pytest.mark.parametrize(
    ("over", "confidence", "explained"),
    [(1.1, 1e-20, True), (1.3, 1e-20, False), (1.8, 1e-20, False), (1.3, 0.3, True)],
)
def test_what_is_hardly_more_than_impossible_has_to_reach_the_noise(over, confidence, explained):
    gaps = Gaps(1.0, 0.1, None, None, 0.1)
    step = Step("added_mass", "link_3", {}, {}, {}, confidence, gaps, ())
    facts = Facts((step,), {"added_mass": "a mass"}, gaps, over, Answer.YES, {}, open_=False, place="link_1")
    found = verdict(facts)
    assert found.explained is explained
    assert found.effects == ((("added_mass", "link_3"),) if explained else (("unknown", "link_1"),))


@pytest.mark.parametrize(
    ("over", "share", "explained"),
    [(1.1, 0.1, True), (1.3, 0.44, False), (1.3, 0.56, True), (1.8, 0.3, False), (1.3, None, True)],
)
def test_what_takes_the_lesser_part_has_to_reach_the_noise(over, share, explained):
    """Play passed for a spring that took less than half of what the robot left."""
    gaps = Gaps(1.0, 0.1, None, None, 0.1)
    step = Step("added_mass", "link_3", {}, {}, {}, 0.95, gaps, (), share=share)
    facts = Facts((step,), {"added_mass": "a mass"}, gaps, over, Answer.YES, {}, open_=False, place="link_1")
    found = verdict(facts)
    assert found.explained is explained
    assert found.effects == ((("added_mass", "link_3"),) if explained else (("unknown", "link_1"),))


def test_of_several_effects_all_of_them_take_their_parts():
    """Whether or not each alone is sure: the shares of those that stand by themselves are fewer."""
    gaps = Gaps(1.0, 0.1, None, None, 0.1)
    shares = {"link_3": 0.17, "link_2": 0.7, "link_1": 0.12}
    steps = tuple(
        Step("added_mass", where, {}, {}, {}, 0.83, gaps, (), share=one) for where, one in shares.items()
    )
    facts = Facts(
        steps, {"added_mass": "a mass"}, gaps, 1.3, Answer.YES, {}, open_=False, place="tip",
        standing=(("added_mass", "link_3"),), share=0.99,
    )  # fmt: skip
    found, every = verdict(facts), tuple(("added_mass", where) for where in shares)
    assert found.explained
    assert found.effects == every
    assert found.share == pytest.approx(0.99)
    apart = verdict(replace(facts, reached=Answer.NO, over_noise=3.0))
    assert apart.effects == (("added_mass", "link_3"), ("unknown", "tip"))
    assert apart.share == pytest.approx(0.17)
    more = verdict(replace(facts, over_noise=1.49))
    assert more.effects == (*every, ("unknown", "tip"))
    assert more.share == pytest.approx(0.99)


@pytest.mark.parametrize(
    ("over", "comes_close", "explained"),
    [(1.27, True, False), (1.27, False, True), (CLOSE, True, True), (1.14, True, True)],
)
def test_what_leaves_nothing_where_it_is_right_has_to_come_closer(over, comes_close, explained):
    """Play was called a spring that is not straight, with 1.27 noise floors left."""
    facts = replace(_one_step(over, Answer.YES), comes_close=comes_close)
    found, name = verdict(facts), ("added_mass", "link_2")
    assert found.explained is explained
    assert found.effects == ((name,) if explained else (name, ("unknown", "link_2")))


@pytest.mark.parametrize("rounding", LAST_DIGIT)
def test_at_the_border_of_the_larger_part_it_is_explained_and_told(rounding):
    gaps = Gaps(1.0, 0.1, None, None, 0.1)
    step = Step("added_mass", "link_3", {}, {}, {}, 0.95, gaps, (), share=0.5 + rounding)
    facts = Facts((step,), {"added_mass": "a mass"}, gaps, 1.3, Answer.YES, {}, open_=False, place="tip")
    found = verdict(facts)
    assert found.explained
    assert found.undecided == (DOUBTFUL,)


def test_how_sure_is_what_is_vouched_for_is_asked_among_its_like():
    """What sits in the wrong place may take more alone; what is alone and best stays as it was compared."""
    every = compared(3.0, 40.0, 20.0)

    def vouches(model):
        return model.key == KEYS[1]

    def among(models):
        numbers = [model.number for model in models]
        return Comparison(models, every.scores[numbers], every.table[numbers])

    narrowed, number = among_vouched(every, 1, vouches, among)
    assert [one.key for one in narrowed.models] == KEYS[:2]
    assert narrowed.models[number].key == KEYS[1]
    assert every.probability[1] < 1e-9
    assert narrowed.probability[number] == pytest.approx(1 / (1 + np.exp(-3.0)))
    assert among_vouched(every, 2, vouches, among) == (every, 2)


def test_a_gain_that_few_draws_bear_out_is_none():
    table = [[0.0] * 3, [30.0, 30.0, SIGNIFICANT - 2 * MARGIN]]
    assert gains_enough(compared(30.0, table=table), 1) is Answer.NO
    # of sets of beliefs none may speak against it, but a tie's margin is enough
    assert gains_enough(compared(30.0, table=table, beliefs=True), 1) is Answer.UNDECIDED


@pytest.mark.parametrize("rounding", LAST_DIGIT)
def test_what_is_asked_for_by_its_place_needs_more_than_a_tie(rounding):
    asked = {"added_mass": ("link_2",)}
    assert chosen(compared(ASKED + rounding), asked) == Choice(None, (1,))
    assert chosen(compared(ASKED + 1.1 * MARGIN), asked) == Choice(1)
    assert chosen(compared(ASKED - 1.1 * MARGIN), asked) == Choice(None)
    assert chosen(compared(ASKED + 0.9 * MARGIN), {"added_mass": ()}) == Choice(None)


@pytest.mark.parametrize("rounding", LAST_DIGIT)
def test_what_is_as_far_behind_as_a_tie_may_be_is_tied_whatever_the_rounding(rounding):
    close = compared(40.0, 40.0 - TIED + rounding, beliefs=True)
    assert close.tied == [1, 2]
    assert chosen(close) == Choice(None)
    assert chosen(compared(40.0, 40.0 - TIED - 1.1 * MARGIN, beliefs=True)) == Choice(1)
    assert chosen(close, {"added_mass": ()}) == Choice(1)  # asked for, it is added with its ties


def test_the_best_with_a_structure_is_added_and_a_mode_without_never():
    assert chosen(compared(20.0, 30.0, 90.0)) == Choice(2)
    assert chosen(compared(2.0, 3.0, 90.0)) == Choice(None)
    assert chosen(compared(20.0, 30.0), worth=Answer.UNDECIDED) == Choice(None, (2,))


def test_rivals_are_tied_and_make_predictions():
    def alike(one, other):
        return one.number != other.number

    assert rivals(compared(40.0, 39.9, 39.8), 1, alike)[1].key == KEYS[2]
    assert rivals(compared(40.0), 1, alike) is None
    assert rivals(compared(40.0, -9.0, 39.9), 1, alike) is None  # a mode without structure predicts nothing
    both = rivals(compared(1.0), None, alike)
    assert [one.key for one in both] == [KEYS[1], KEYS[0]]


@pytest.mark.parametrize("rounding", LAST_DIGIT)
@pytest.mark.parametrize(
    ("over", "rest"), [(MIDDLE * FLOOR_REACHED, 1.0), (MIDDLE * EXPLAINED, LEFT / 2), (1.7, MIDDLE * LEFT)]
)
def test_at_the_border_of_the_noise_it_is_undecided(over, rest, rounding):
    assert at_the_noise(over + rounding, rest + rounding) is Answer.UNDECIDED


def _one_step(over, reached, share=0.99):
    step = Step("added_mass", "link_2", {}, {}, {}, 0.9, Gaps(1.0, 1.0, None, None, 1.0), ())
    return Facts(
        (step,),
        {"added_mass": "a mass"},
        step.gaps,
        over,
        reached,
        {},
        open_=False,
        place="link_2",
        share=share,
    )


def test_the_border_of_the_noise_is_explained_and_told():
    found = verdict(_one_step(MIDDLE * FLOOR_REACHED, Answer.UNDECIDED))
    assert found.explained
    assert found.effects == (("added_mass", "link_2"),)
    assert found.undecided == (BORDER,)
    assert BORDER in found.says


@pytest.mark.parametrize(("over", "noise"), [(0.98 * FLOOR_REACHED, True), (1.02 * FLOOR_REACHED, False)])
def test_what_a_strong_effect_leaves_above_the_noise_is_unknown_beside_it(over, noise):
    """Another machine on the same floor passed for a foundation that took 99 % and left 1.5 noise floors."""
    found = verdict(_one_step(over, Answer.YES))
    assert found.explained is noise
    assert found.effects == (
        (("added_mass", "link_2"),) if noise else (("added_mass", "link_2"), ("unknown", "link_2"))
    )
    assert (found.remaining is None) is noise
    assert ("takes 99 %" in found.says) is not noise


def test_beyond_the_border_nothing_is_explained():
    assert at_the_noise(FLOOR_REACHED * 1.01, 1.0) is Answer.NO
    assert at_the_noise(FLOOR_REACHED * (1 - 2.1 * FLOOR_MARGIN), 1.0) is Answer.YES
    assert at_the_noise(EXPLAINED * 0.9, LEFT * 1.01) is Answer.NO


@pytest.mark.parametrize("rounding", LAST_DIGIT)
@pytest.mark.parametrize(("number", "share"), [(0, WORTH), (1, ANOTHER)])
def test_what_an_effect_takes_away_has_a_margin_too(number, share, rounding):
    assert takes_enough(share + rounding, 0.0, 0.0, number) is Answer.UNDECIDED
    margin = 1.1 * (ANOTHER_MARGIN if number else WORTH_MARGIN)
    assert takes_enough(share + margin, 0.0, 0.0, number) is Answer.YES
    assert takes_enough(share - margin, 0.0, 0.0, number) is Answer.NO


@pytest.mark.parametrize("number", [0, 1])
def test_an_effect_may_bring_parameters_back_instead(number):
    gained = SIGNIFICANT + 1.1 * MARGIN
    assert takes_enough(0.0, gained, 0.0, number) is Answer.YES
    assert takes_enough(0.0, SIGNIFICANT - 1.1 * MARGIN, 0.0, number) is Answer.NO


def test_an_effect_beside_which_parameters_stay_beyond_belief_brings_nothing_back():
    assert takes_enough(0.0, 200.0, 20.0, 0) is Answer.YES
    assert takes_enough(0.0, 200.0, 160.0, 0) is Answer.NO


@pytest.mark.parametrize("rounding", LAST_DIGIT)
def test_how_much_it_brings_back_has_a_margin(rounding):
    assert takes_enough(0.0, 200.0, 200.0 * FROM_BEYOND + rounding, 0) is Answer.UNDECIDED
    assert takes_enough(0.0, 0.0, 0.0, 0) is Answer.NO


def test_no_number_reaches_nothing():
    assert reaches(float("nan"), 1.0, 0.1) is Answer.NO
    assert reaches(float("-inf"), 1.0, 0.1) is Answer.NO


def test_where_the_noise_is_reached_nothing_that_gains_leaves_it_open_but_a_lacking_mode_does():
    gaps = Gaps(1.0, 1.0, None, None, 1.0)
    facts = Facts((), {}, gaps, 1.0, Answer.YES, {}, open_=True, place="link_1")
    assert verdict(facts).effects == ()
    assert verdict(facts).explained
    lacks = verdict(replace(facts, lacking={2: 38.0}))
    assert (lacks.effects, lacks.explained) == ((("unknown", "link_1"),), False)
    assert "near 38 Hz" in lacks.says


@pytest.mark.parametrize(
    ("plausible", "expected"),
    [
        ({0: MORE_PLAUSIBLE + 1.1 * MARGIN, 1: 0.0}, True),
        ({0: MORE_PLAUSIBLE, 1: 0.0}, False),
        ({0: 0.0, 1: 20.0}, False),
        ({1: 0.0}, False),
        ({0: 50.0}, False),
    ],
)
def test_an_effect_without_which_everything_is_explained_more_plausibly_is_idle(plausible, expected):
    assert is_idle(plausible) is expected


@pytest.mark.parametrize(
    ("where", "says"),
    [
        ("link_3", "for its law is not quite the catalogue's, or something is missing besides at link_3"),
        ("tip", "for something is missing besides that nothing in the catalogue explains: look at tip"),
    ],
)
def test_what_a_strong_effect_leaves_is_its_law_or_something_besides(where, says):
    gaps = Gaps(1.0, 0.1, None, None, 0.1)
    step = Step("added_mass", "link_3", {}, {}, {}, 0.95, gaps, ())
    facts = Facts(
        (step,), {"added_mass": "a mass"}, gaps, 3.2, Answer.NO, {}, open_=False, place=where,
        standing=(("added_mass", "link_3"),), lacking_at=(where,), share=0.98,
    )  # fmt: skip
    found = verdict(facts)
    assert found.effects == (("added_mass", "link_3"), ("unknown", where))
    assert not found.explained
    assert says in found.says


def test_what_a_function_tells_is_named_whatever_its_law_leaves():
    gaps = Gaps(1.0, 0.9, None, None, 0.1)
    step = Step("sensor_gain", "tip", {}, {}, {}, 0.83, gaps, (), share=-0.02)
    facts = Facts(
        (step,), {"sensor_gain": "a gain"}, gaps, 7.1, Answer.NO, {}, open_=False, place="tip",
        standing=(("sensor_gain", "tip"),), lacking_at=("tip",), share=-0.02, told=True,
    )  # fmt: skip
    found = verdict(facts)
    assert found.effects == (("sensor_gain", "tip"), ("unknown", "tip"))
    assert not found.explained
    assert "So says its function without a law" in found.says
    assert "it takes < 1 % of the disagreement; the model leaves 7.1 × the noise" in found.says

"""A foundation, or a floor that goes up and down: by numbers put together by hand."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.effects import base_flexibility, foundation
from flexmodal.diagnosis.effects.floor import OVER_LEVEL, SAYS, UPRIGHT
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.outcome import Gaps, Step
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.verdict.facts import Facts
from flexmodal.diagnosis.verdict.unlike import Unlike, unlike
from flexmodal.diagnosis.verdict.verdict import verdict
from flexmodal.structure import ParameterSpace

EFFECT, BOLTED = base_flexibility.EFFECT, base_flexibility.BOLTED
KEY = ("base_flexibility", "base")


@pytest.fixture(scope="module")
def context(either_context):
    return either_context


def springs_alone(context, effect, upright, level, tilt):
    """Values whose compliances are those of springs that meet at the root's origin [m/N, m/N, m/N]."""
    length = foundation.length_of(context)
    values = {one.name: one.card for one in effect.parameters(context, "base")}
    still = {"aside": 0.0, "below": 0.0, "mass": 1e-9, "ahead": 0.0, "angle": 0.0}
    tiny = {name: 1e-9 for name in values if name.endswith("_damping")}
    turning = {"tilt_stiffness": length**2 / tilt, "twist_stiffness": 0.1 * length**2 / tilt}
    found = {"vertical_stiffness": 1 / upright, "horizontal_stiffness": 1 / level, **turning, **still, **tiny}
    return {**values, **{name: value for name, value in found.items() if name in values}}


@pytest.mark.parametrize("effect", [EFFECT, BOLTED], ids=["springs", "bolts"])
def test_the_lesser_of_two_ratios_counts(context, effect):
    """By hand: parts of the sum of compliances, however soft the twist about the upright axis."""
    both = 1 if context.normal is not None else 2
    for upright, level, tilt in ((3.0, 1.0, 4.0), (5.0, 0.1, 8.0), (1.0, 1.2, 10.0)):
        values = springs_alone(context, effect, upright * 1e-8, level * 1e-8, tilt * 1e-8)
        part = upright / (upright + both * (level + tilt))
        expected = np.log(min(part / UPRIGHT, upright / level / OVER_LEVEL))
        assert effect.unlike(context, values) == pytest.approx(expected, abs=1e-4)


def test_a_heavy_floor_counts_by_what_it_does_in_the_band(context):
    """By hand, one mass on each spring: at rest far softer level than upright, in the band not."""
    length, both = foundation.length_of(context), 1 if context.normal is not None else 2
    upright, level, tilt, mass, radius = 1e-9, 1e-4, 2e-10, 1e5, 0.2 * length
    values = springs_alone(context, EFFECT, upright, level, tilt)
    square = (2 * np.pi * np.linspace(*context.band, 100)) ** 2
    pairs = ((upright, mass), (level, mass), (tilt, mass * (radius / length) ** 2))
    rings = [np.mean(np.abs(1 / (1 / softness - square * heavy))) for softness, heavy in pairs]
    part = rings[0] / (rings[0] + both * (rings[1] + rings[2]))
    expected = np.log(min(part / UPRIGHT, rings[0] / rings[1] / OVER_LEVEL))
    centred = {"mass": mass, "gyration": radius, "mass_below": 0.0, "mass_aside": 0.0, "mass_ahead": 0.0}
    centred = {name: value for name, value in centred.items() if name in values}
    assert EFFECT.unlike(context, {**values, **centred}) == pytest.approx(expected, abs=1e-4)
    assert EFFECT.unlike(context, values) < expected - 3


def test_an_arm_that_moves_level_only_has_no_floor(context):
    level = replace(context)
    level.__dict__["normal"] = np.array([0.0, 0.0, 1.0])  # a cached property, as if the arm lay on its side
    assert EFFECT.unlike(level, {one.name: one.card for one in EFFECT.parameters(level, "base")}) == -np.inf


def placed_at(context, values):
    hypothesis = Hypothesis(context, ParameterSpace(()), (Placed(EFFECT, "base"),))
    label = hypothesis.placed[0].label
    x = hypothesis.space.coordinates({f"{label}.{name}": value for name, value in values.items()})
    return hypothesis, x


def test_what_the_data_do_not_tell_speaks_against_no_name(context):
    hypothesis, x = placed_at(context, springs_alone(context, EFFECT, 5e-8, 1e-9, 8e-8))
    (sure,) = unlike(hypothesis, x, 1e-6 * np.eye(len(x)))
    assert (sure.key, sure.answer, sure.says) == (KEY, Answer.YES, SAYS)
    assert unlike(hypothesis, x, np.diag([one.deviation**2 for one in hypothesis.space])) == ()


def test_at_the_limit_it_is_undecided(context):
    both = 1 if context.normal is not None else 2
    tilt = (1 / UPRIGHT - 1) / both - 0.01  # of an upright compliance of 1
    hypothesis, x = placed_at(context, springs_alone(context, EFFECT, 1e-8, 1e-10, tilt * 1e-8))
    (one,) = unlike(hypothesis, x, np.zeros((len(x), len(x))))
    assert one.answer is Answer.UNDECIDED


def told(answer, *more, over=1.0):
    """A verdict on a foundation that takes nearly everything, beside other effects."""
    gaps = Gaps(1.0, 0.1, None, None, 0.1)
    keys = (KEY, *more)
    steps = tuple(Step(*key, {}, {}, {}, 0.95, gaps, (), share=0.9 / len(keys)) for key in keys)
    facts = Facts(
        steps, {"base_flexibility": "the foundation gives way", "added_mass": "a mass"}, gaps, over,
        Answer.YES, {}, open_=False, place="tip", unlike=(Unlike(KEY, SAYS, answer),), share=0.9,
    )  # fmt: skip
    return verdict(facts)


def test_a_floor_is_no_foundation_however_well_it_explains():
    found = told(Answer.YES)
    assert found.effects == (("unknown", "base"),)
    assert not found.explained
    assert found.share is None
    assert found.remaining.where == "base"
    assert SAYS in found.says
    assert "which is not enough" not in found.says


def test_what_is_there_besides_keeps_its_name():
    found = told(Answer.YES, ("added_mass", "link_2"))
    assert found.effects == (("added_mass", "link_2"), ("unknown", "base"))
    assert found.share == pytest.approx(0.45)
    assert "look at base" in found.says


def test_what_may_be_a_floor_keeps_its_name_and_is_told():
    found = told(Answer.UNDECIDED)
    assert found.effects == (KEY,)
    assert found.explained
    assert SAYS in found.undecided[0]


def test_where_nothing_says_where_noise_begins_it_keeps_its_name_and_is_told():
    found = told(Answer.YES, over=None)
    assert found.effects == (KEY,)
    assert SAYS in found.undecided[0]

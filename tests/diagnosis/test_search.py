"""Coarse looks: which lines they see, and where effects set out."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search import explanations as module
from flexmodal.diagnosis.search.coarse import Candidate, Look, look_at
from flexmodal.diagnosis.search.explanations import A_FEW, BEHIND, FAR_BEHIND, explanations
from flexmodal.diagnosis.search.lines import WORST, some_lines, worst_lines
from flexmodal.diagnosis.search.search import narrowed, varied
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.identification import predict
from flexmodal.structure import robot_space


def test_worst_lines_lie_where_a_model_is_off(observed):
    observations = observed
    off = slice(60, 75)
    predicted = observations.value.copy()
    predicted[:, off] *= 1.5
    lines = worst_lines(observations, predicted)
    assert 2 <= len(lines) <= WORST
    assert np.all((lines >= off.start) & (lines < off.stop))
    predicted[:, 20] *= 1.5
    assert np.isin(20, worst_lines(observations, predicted))


def test_a_model_that_is_off_nowhere_adds_none(observed):
    observations = observed
    assert not worst_lines(observations, observations.value).size
    plain = look_at(observations)
    assert np.array_equal(plain.lines, some_lines(observations, 48))
    assert np.array_equal(look_at(observations, [3, 7]).lines, np.union1d(plain.lines, [3, 7]))


@pytest.mark.parametrize("mass", [0.1, 0.5])
def test_some_start_of_an_absorber_is_nearer_than_none(context, observed, mass):
    """A light one too: what it does must show through what the start does wrong."""
    observations = observed
    absorber = catalogue()["local_absorber"]
    placed = Placed(absorber, "link_3")
    root = Hypothesis(context, robot_space(context.robot))
    hypothesis = root.and_also(placed)
    zero = np.zeros(len(root.space))
    true = {"mass": mass, "frequency": 47.0, "damping_ratio": 0.05, "along": 0.6}
    there = np.log(predict(hypothesis, hypothesis.start(placed, true, zero), observations))

    def far(value):
        return float(np.sum(np.abs(np.log(value) - there) ** 2))

    starts = absorber.starts(context, "link_3")
    costs = [far(predict(hypothesis, hypothesis.start(placed, one, zero), observations)) for one in starts]
    best = starts[int(np.argmin(costs))]
    assert min(costs) < far(predict(root, zero, observations))
    assert 0.8 < best["frequency"] / 47.0 < 1.25
    assert 0.1 < best["mass"] / mass < 10


def test_some_start_of_a_stiff_loop_is_nearer_than_none(context, observed):
    """The rotor swings above the band: what is left of it there is a spring in series and its loss."""
    observations, high = observed, context.band[1]
    servo = catalogue()["servo_compliance"]
    placed = Placed(servo, "q2")
    root = Hypothesis(context, robot_space(context.robot))
    hypothesis = root.and_also(placed)
    zero = np.zeros(len(root.space))
    k = float(context.robot.joints["q2"].stiffness)
    true = {"gain": 50 * k, "frequency": 1.4 * high, "damping_ratio": 0.3}
    there = np.log(predict(hypothesis, hypothesis.start(placed, true, zero), observations))

    def far(value):
        return float(np.sum(np.abs(np.log(value) - there) ** 2))

    starts = servo.starts(context, "q2")
    costs = [far(predict(hypothesis, hypothesis.start(placed, one, zero), observations)) for one in starts]
    assert min(costs) < 0.5 * far(predict(root, zero, observations))


@pytest.mark.parametrize("enough", [False, True])
def test_what_is_far_behind_is_fitted_with_a_few_steps(monkeypatch, enough):
    """And less far once an explanation is enough: it can hardly come to be the best any more."""
    costs = [1.0, 1.1 * BEHIND, 1.1 * FAR_BEHIND]
    hypotheses = [Mock(spec=Hypothesis, placed=(), base=(), keys=(("effect", str(cost)),)) for cost in costs]
    finalists = [Candidate(one, np.zeros(0), cost) for one, cost in zip(hypotheses, costs, strict=True)]
    taken = []

    def closely(setup, hypothesis, start, *, near=False, steps=None):
        taken.append((hypothesis.keys[-1][1], steps))
        return [
            Mock(
                spec=FittedFrfs,
                prior=0.0,
                cost=1.0,
                key=hypothesis.keys[-1],
                hypothesis=hypothesis,
                fitted=Mock(),
            )
        ]

    for name, value in {
        "both_beside": lambda *given: (Mock(spec=Look),) * 2, "candidates": lambda *given: [],
        "narrowed": lambda found, seen, advance, *, late: finalists, "tried_closely": closely,
        "over_noise": lambda setup, model: 1.0 if enough else 9.0, "has_law": lambda hypothesis: False,
        "simpler": lambda *given: [],
    }.items():  # fmt: skip
        monkeypatch.setattr(module, name, value)
    nothing = np.zeros(0, dtype=bool)
    setup = Mock(spec=Setup, effects=[], fitted=None, held=nothing)
    before = Mock(spec=FittedFrfs, predicted=nothing, hypothesis=Mock(placed=(finalists[0],)))
    explanations(
        setup, before, SetOut([]), with_force=False, enough=1.4,
        advance=lambda part: None, one_is_enough=False,
    )  # fmt: skip
    few = {where for where, most in taken if most == A_FEW}
    assert few == {str(cost) for cost in (costs[1:] if enough else costs[2:])}


@pytest.mark.parametrize(
    ("placed", "over", "late"), [((), 1.3, True), ((), 1.5, False), (("effect",), 1.3, False)]
)
def test_beside_a_robot_that_counts_as_explained_small_errors_count_from_the_first_round_on(
    monkeypatch, placed, over, late
):
    """And fits set out from it: it has not run away from the truth as one does that lacks much."""
    told = {}

    def seen(root, set_out, *given):
        told["start"] = set_out.before
        return []

    def narrowed(found, look, advance, *, late):
        told["late"] = late
        return []

    for name, value in {
        "both_beside": lambda *given: (Mock(spec=Look),) * 2, "candidates": seen, "narrowed": narrowed,
        "over_noise": lambda setup, model: over,
    }.items():  # fmt: skip
        monkeypatch.setattr(module, name, value)
    card, fitted, looked = np.zeros(2), np.ones(2), np.full(2, 2.0)
    before = Mock(spec=FittedFrfs, hypothesis=Mock(placed=placed), x=fitted)
    explanations(
        Mock(spec=Setup, effects=[]), before, SetOut([card, looked]), with_force=False, enough=1.4,
        advance=lambda part: None, one_is_enough=False,
    )  # fmt: skip
    assert told["late"] is late
    assert [one.tolist() for one in told["start"]] == [(fitted if late else card).tolist(), [2.0, 2.0]]


@pytest.mark.parametrize(("effects", "over", "fits"), [(1, 1.5, 2), (2, 3.9, 2), (1, 4.1, 1), (3, 1.5, 1)])
def test_beside_several_effects_nothing_is_fitted_from_the_card_once_more(monkeypatch, effects, over, fits):
    """Nor far from the noise; with fewer effects the better one is taken, of a robot that nobody believes."""
    monkeypatch.setattr(module, "over_noise", lambda setup, model: over)
    hypothesis = Mock(spec=Hypothesis, placed=(None,) * effects, base=("mass",))
    made = [Mock(spec=FittedFrfs, prior=99.0, cost=cost, x=np.ones(3)) for cost in (2.0, 1.0)]
    closely = Mock(side_effect=[[one] for one in made])
    monkeypatch.setattr(module, "tried_closely", closely)
    monkeypatch.setattr(module, "has_law", lambda hypothesis: False)
    found = module.fitted_believably(Mock(spec=Setup), Candidate(hypothesis, np.ones(3), 2.0))
    assert found == [made[fits - 1]]
    assert closely.call_count == fits


@pytest.mark.parametrize(("several", "order"), [(False, "abcd"), (True, "abdc")])
def test_beside_effects_one_effect_does_not_take_all_places_among_the_best(several, order):
    """Absorbers on every link do a little of what each effect does that is missing."""
    keys = {"a": ("absorber", "1"), "b": ("absorber", "2"), "c": ("absorber", "3"), "d": ("foundation", "")}
    placed = (None,) * (1 + several)
    found = {
        name: Mock(spec=Candidate, key=key, hypothesis=Mock(placed=placed)) for name, key in keys.items()
    }
    assert varied(list(found.values())) == [found[name] for name in order]


@pytest.mark.parametrize(("law", "kept"), [(True, "bca"), (False, "bcdef")])
def test_what_was_best_before_any_fit_is_fitted_closely_where_fits_are_slow(law, kept):
    """Six effects of which the first is the last one after a few steps; by integrated torques three go on."""
    begun = [
        Candidate(Mock(spec=Hypothesis, keys=[(name, "q1")], placed=(None,)), np.zeros(1), float(cost))
        for cost, name in enumerate("abcdef")
    ]
    look = Mock(spec=Look, integrates=lambda hypothesis: law)
    look.fitted = lambda one, floor, steps: Candidate(one.hypothesis, one.x, one.cost or 9.0)
    assert "".join(one.key[0] for one in narrowed(begun, look)) == kept

"""What stands for something without a name predicts postures that no fit has seen, and never pushes."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.disagreement.gaps import over_noise
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.result import Findings, Found
from flexmodal.diagnosis.outcome import Gaps
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search import close_fit
from flexmodal.diagnosis.search.close_fit import LAST, NEAR, fitted_closely, tried_closely
from flexmodal.diagnosis.search.explanations import explanations, from_each_start
from flexmodal.diagnosis.search.set_out import SetOut
from flexmodal.diagnosis.selection.asked import asked_of
from flexmodal.diagnosis.selection.stand_in import NEARER, is_passive, stand_in, stands_in
from flexmodal.diagnosis.setup import prepare
from flexmodal.diagnosis.verdict.frf_words import stand_in_words
from flexmodal.errors import SingularResponse
from flexmodal.rig import Hide, simulate


def laid_out(campaign, robot, names):
    return prepare(campaign, robot, None, asked_of(names), None, 0, lambda doing, part: None)


def looked(where):
    found = Found("body", where, "a body", 5.0, (("body", where),), None, ())
    return Findings(9.0, 1.0, (), (found,), explains=True, needed=True, says="")


def starts(before):
    return SetOut([np.zeros(len(before.x)), before.x])


@pytest.fixture(scope="module")
def setup():
    """A mass of which the catalogue, cut down to absorbers, knows nothing."""
    hide = [replace(Hide.parse("added_mass@link_3"), height=15.0)]
    made = simulate(
        flexmodal.load("fanuc_s360"), hide=hide, seed=11, postures=4, points=3, references=2, trials=2,
        record_length=1.0, band=(2.0, 120.0),
    )  # fmt: skip
    return laid_out(made.campaign, made.robot, ["local_absorber", "joint_coupling"])


@pytest.fixture(scope="module")
def bare(setup):
    return fitted_closely(setup, Hypothesis(setup.context, setup.base), np.zeros(len(setup.base)))


@pytest.mark.slow
def test_at_its_place_it_brings_unseen_postures_nearer(setup, bare):
    found = stand_in(setup, looked("link_3"), bare, starts, with_force=False)
    assert found is not None
    assert found.hypothesis.keys[0] == ("local_absorber", "link_3")
    assert over_noise(setup, found, setup.held) < NEARER * over_noise(setup, bare, setup.held)
    assert is_passive(found)


@pytest.mark.slow
def test_what_was_come_to_on_the_way_stands_in_where_it_has_more_and_predicts_better(setup, bare):
    found = stand_in(setup, looked("link_3"), bare, starts, with_force=False)
    assert stands_in(setup, bare, found)
    assert not stands_in(setup, found, bare), "it has less"
    assert not stands_in(setup, found, found)
    worse = replace(found, predicted=bare.predicted)
    assert not stands_in(setup, bare, worse)


def test_without_a_posture_that_judges_there_is_none(setup, bare):
    blind = replace(setup, held=np.zeros_like(setup.held))
    assert stand_in(blind, looked("link_3"), bare, starts, with_force=False) is None
    assert not stands_in(blind, bare, fitted_closely(setup, bare.hypothesis, bare.x))


def test_couplings_that_push_together_are_refused(setup, bare):
    """Each holds, both do not: the eigenvalues of [[1, c, 0], [c, 1, c], [0, c, 1]] are 1 and 1 ± √2 c."""
    effect = next(one for one in setup.effects if one.name == "joint_coupling")
    for coupling, expected in ((0.6, True), (0.9, False)):
        hypothesis, x = bare.hypothesis, np.zeros(len(bare.x))
        for where in ("q1+q2", "q2+q3"):
            placed = Placed(effect, where)
            hypothesis = hypothesis.and_also(placed)
            x = hypothesis.start(placed, {"coupling": coupling}, x)
        model = replace(bare, hypothesis=hypothesis, fitted=replace(bare.fitted, x=x))
        assert is_passive(model) is expected


def test_the_words_say_that_nothing_is_named():
    gaps = Gaps(0.2, 0.1, 0.21, 0.12, 0.04)
    says = stand_in_words([("added_mass", "link_2"), ("local_absorber", "link_2")], gaps)
    assert "added_mass at link_2 and local_absorber at link_2 stand for it, without being named" in says
    assert "from 0.21 to 0.12" in says
    assert stand_in_words([("added_mass", "link_2")], replace(gaps, held_out_after=None)).endswith("named.")


@pytest.mark.parametrize(("over", "floors"), [(9.0, [NEAR]), (1.2, [NEAR, LAST])])
def test_a_trial_goes_to_its_end_only_near_the_noise(monkeypatch, setup, bare, over, floors):
    """Where it is far off something else is missing, beside which it is fitted again."""
    closely = Mock(return_value=bare)
    monkeypatch.setattr(close_fit, "fitted_closely", closely)
    monkeypatch.setattr(close_fit, "over_noise", lambda setup, model: over)
    assert tried_closely(setup, bare.hypothesis, bare.x, near=True) == [bare]
    assert [call.kwargs["floors"] for call in closely.call_args_list] == floors


@pytest.mark.slow
def test_what_ends_where_there_is_no_model_is_left_out_of_a_search(monkeypatch, setup, bare):
    """Torques that push make an integration grow without end; the other explanations remain."""

    def closely(setup, hypothesis, start, **more):
        if hypothesis.keys[-1][0] == "local_absorber":
            raise SingularResponse("the integration has no end")
        return fitted_closely(setup, hypothesis, start, **more)

    monkeypatch.setattr(close_fit, "fitted_closely", closely)
    found = explanations(
        setup, bare, starts(bare), with_force=False, enough=1.4, advance=lambda part: None,
        allowed=lambda effect, where: where in ("link_3", "q1+q2"), one_is_enough=True,
    )  # fmt: skip
    assert [one.key for one in found] == [("joint_coupling", "q1+q2")]
    keys = [("local_absorber", "link_3")]
    assert from_each_start(setup, bare, starts(bare), keys, lambda model: False) == []

"""How a test was set up, seen anew beside an effect: with it found, what was off is too."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import Tolerance
from flexmodal.diagnosis import diagnose
from flexmodal.diagnosis.disagreement.gaps import as_believed, over_noise
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.first_look import LooksWithoutLaw
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.search.close_fit import fitted_closely, fitted_to_everything
from flexmodal.diagnosis.search.unstructured import unstructured_mode
from flexmodal.diagnosis.selection import frf_data, set_up_anew
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.selection.set_up_anew import (
    TRIED,
    Elsewhere,
    is_set_up,
    nearest,
    over_seen,
    seen_anew,
    set_up_closely,
    with_everything,
)
from flexmodal.diagnosis.setup import prepare
from flexmodal.errors import SingularResponse
from flexmodal.identification import gap, observe, predict
from flexmodal.identification.gap import over_noise as averages_over_noise
from flexmodal.identification.sensitivities import Sensitivities, moved, nuisances_of
from flexmodal.rig import Hide, simulate

GIVEN = Tolerance(posture=0.01, position=0.004, direction=0.02, gain=0.03)
ABSORBER = ("local_absorber", "link_2")


@pytest.fixture(scope="module")
def made():
    """An absorber on an arm in a plane, set up wrongly within its tolerances."""
    robot = flexmodal.load("fanuc_s360_rigid_link")
    result = simulate(
        robot, postures=4, points=3, references=2, trials=2, averages=2, seed=7, record_length=2.0,
        band=(2.0, 120.0), hide=[Hide(*ABSORBER, height=20.0)], parameter_error=0.02, time=False,
    )  # fmt: skip
    campaign = replace(result.campaign, tolerance=GIVEN)
    seen, random = observe(campaign), np.random.default_rng(2)
    off = {one: float(one.deviation * random.normal()) for one in nuisances_of(seen)}
    told = moved(seen, [(one, -value) for one, value in off.items()])
    gains = (told.records.value / seen.records.value)[:, :1]  # the same on every line
    frfs = replace(campaign.frfs, value=campaign.frfs.value * gains)
    spoilt = replace(campaign, postures=told.campaign.postures, points=told.campaign.points, frfs=frfs)
    return spoilt, robot


@pytest.fixture(scope="module")
def fitted(made):
    """What a diagnosis works with, the robot re-tuned, and with an absorber in either of two places."""
    campaign, robot = made
    setup = prepare(campaign, robot, None, None, None, 0, lambda doing, part: None)
    bare = Hypothesis(setup.context, setup.base)
    every = [
        bare,
        *(bare.and_also(Placed(catalogue()["local_absorber"], link)) for link in ("link_2", "link_3")),
    ]
    return setup, [fitted_closely(setup, one, np.zeros(len(one.space))) for one in every]


@pytest.fixture(scope="module")
def anew(fitted):
    """These, and a mode without structure, where the test is thought to be set up beside them."""
    setup, models = fitted
    return seen_anew(setup, [*models, unstructured_mode(setup, models[0])])


def test_beside_the_effect_that_is_there_what_was_off_is_moved(fitted, anew):
    """As far as it can be seen: some of it does what other errors do."""
    setup, models = fitted
    now, (*again, _) = anew
    before, after = (
        [over_seen(one, model) for model in some] for one, some in ((setup, models), (now, again))
    )
    assert after[1] < 1.2
    assert after[1] < 0.9 * before[1]
    assert after[0] > 3 * after[1]  # what was moved does not stand for the absorber
    assert [one.key for one in again] == [one.key for one in models]
    assert len(now.moved) > len(setup.moved)
    assert all(abs(one.value) < 3 * one.nuisance.deviation for one in now.moved)
    assert now.context.postures != setup.context.postures
    assert again[1].hypothesis.context is now.context


def test_what_is_held_out_moves_nothing_until_everything_counts(fitted, anew):
    """And then its angles are found too, by which the model comes to the noise there."""
    setup, _ = fitted
    now, again = anew
    held = {now.observations.postures[int(k)].id for k in np.unique(now.observations.posture[now.held])}
    assert held
    assert not held & {one.nuisance.where for one in now.moved if one.nuisance.kind == "posture"}
    whole, (told,) = with_everything(now, [again[1]])
    assert held & {one.nuisance.where for one in whole.moved if one.nuisance.kind == "posture"}
    np.testing.assert_array_equal(whole.held, now.held)
    nearer = fitted_to_everything(whole, told)
    noise = setup.said.variance
    left = [
        over_noise(replace(one, observations=replace(one.observations, variance=noise)), model, now.held)
        for one, model in ((now, again[1]), (whole, nearer))
    ]
    assert left[1] < 1.25
    assert left[1] < 0.7 * left[0]


def test_in_the_end_all_models_are_seen_where_the_test_is_thought_to_be_set_up(anew):
    """The card too, and the model that the others are better than."""
    now, (before, after, *_) = anew
    data = FrfData.__new__(FrfData)
    data.setup, data.advance, data.force = now, now.advance, Answer.NO
    conclusion = data.conclude(before, after, again=True)
    last = conclusion.setup
    assert last is not now
    assert conclusion.before.hypothesis.context is last.context
    shown, seen = data.shown(conclusion), last.observations
    assert shown["frfs"] is seen
    bare = Hypothesis(last.context, last.base)
    card = predict(bare, np.zeros(len(last.base)), seen)
    np.testing.assert_array_equal(shown["predicted"]["believed"], card)
    assert np.abs(card - as_believed(now)).max() > 1e-3 * np.abs(card).max()
    assert conclusion.gaps.believed == gap(seen, card).value


@pytest.mark.parametrize(
    ("explains", "enough", "known"), [(False, 0.0, True), (False, 99.0, False), (True, 0.0, False)]
)
def test_the_look_beside_the_robot_stays_where_more_than_one_effect_is_missing(
    monkeypatch, fitted, explains, enough, known
):
    """Beside a test that is set up otherwise; where one may be all that is missing it is taken anew."""
    setup, models = fitted
    data, look = FrfData.__new__(FrfData), Mock(spec=Findings, explains=explains)
    data.setup, data.modes = setup, None
    data._candidates = Mock(spec=FrfCandidates, looks=Mock(spec=LooksWithoutLaw, one=look))
    monkeypatch.setattr(frf_data, "seen_anew", lambda setup, models: (setup, list(models)))
    monkeypatch.setattr(frf_data, "fitted_closely", lambda *told: models[0])
    monkeypatch.setattr(frf_data, "EXPLAINED", enough)
    anew = Mock(spec=Findings)
    monkeypatch.setattr(LooksWithoutLaw, "_alone", None)
    monkeypatch.setattr("flexmodal.diagnosis.lawfree.first_look.summed_up", lambda *told: anew)
    monkeypatch.setattr(LooksWithoutLaw, "_seen", None)
    other, again = data.set_up_anew(models)
    assert again == models
    assert other.look is (look if known else anew)
    two = models[1].hypothesis.and_also(models[2].hypothesis.placed[-1])
    beside = replace(models[1], hypothesis=two, key=two.keys[-1])
    assert other._candidates.considered(replace(beside, hypothesis=models[1].hypothesis), models[1].key) == [
        models[2]
    ]  # what may be in its place, where it is asked later how sure it is


@pytest.mark.parametrize(("near", "asked"), [(5.0, 1), (4.6, 1), (4.4, 2)])
def test_what_was_in_vain_is_not_asked_of_models_as_near(monkeypatch, fitted, near, asked):
    """Beside the same ones, and others that are hardly nearer; it takes as long as their fits."""
    setup, (bare, right, wrong) = fitted
    data, tried = FrfData.__new__(FrfData), Mock(spec=seen_anew, return_value=None)
    data.setup = setup
    sizes = {bare: 9.0, right: 5.0, wrong: near}
    monkeypatch.setattr(frf_data, "seen_anew", tried)
    monkeypatch.setattr(set_up_anew, "over_seen", lambda setup, model: sizes[model])
    assert data.set_up_anew([bare, right]) is None
    assert data.set_up_anew([bare, wrong]) is None
    assert tried.call_count == asked


@pytest.mark.slow
def test_a_diagnosis_names_what_it_could_not_tell_from_the_set_up(made):
    """And what it has for every posture in the end, the one held out too, is at the noise of the averages."""
    campaign, robot = made
    found = diagnose(campaign, robot, effects=["local_absorber", "sensor_gain", "joint_coupling"])
    assert found.verdict.effects == (ABSORBER,)
    plain = replace(found.observations, variance=observe(campaign).variance)
    assert averages_over_noise(plain, found.predicted["after"]) < 1.25
    assert averages_over_noise(plain, found.predicted["before"]) > 3
    assert len(found.moved) >= 8


def test_where_everything_is_exact_nothing_is_looked_at(fitted):
    setup, models = fitted
    exact = replace(setup, said=None)
    assert is_set_up(exact, models[0])
    assert seen_anew(exact, models) is None
    assert set_up_closely(exact) is exact
    assert with_everything(exact, models) == (exact, models)


def test_the_nearest_models_are_tried_but_none_without_a_law(fitted):
    setup, models = fitted
    odd = replace(models[1], key=(UNSTRUCTURED, ""))
    every = nearest(setup, [*models, odd])
    assert len(every) == TRIED
    assert every == sorted(models[1:], key=lambda one: over_seen(setup, one))
    assert nearest(setup, models, 1) == every[:1]
    assert odd not in every


def test_what_was_fitted_does_not_drown_in_the_tolerances_of_what_is_held_out(fitted):
    """Their variance is many times that of the noise; with it as one sum anything would leave nothing."""
    setup, (bare, *_) = fitted
    held, seen = setup.held, setup.observations
    wide = replace(seen, variance=seen.variance * np.where(held, 1e4, 1.0)[:, None])
    loose = replace(setup, observations=wide)
    near = over_noise(setup, bare, ~held)
    assert over_noise(replace(loose, said=None), bare) < 0.3 * near
    part = seen.used[~held].sum() / seen.used.sum()
    expected = np.sqrt(part * near**2 + (1 - part) * over_noise(loose, bare, held) ** 2)
    assert over_noise(loose, bare) == pytest.approx(expected)
    assert over_noise(loose, bare) > 0.8 * near
    assert over_noise(loose, bare, ~held) == near


def test_a_mode_without_structure_is_looked_for_again(fitted, anew):
    """On top of the first model as it is now."""
    _, models = fitted
    now, again = anew
    assert [one.key for one in again] == [*(one.key for one in models), (UNSTRUCTURED, "")]
    assert over_seen(now, again[-1]) < over_seen(now, again[0])


@pytest.mark.parametrize(("left", "moves"), [(3.0, False), (1.9, False), (1.7, True)])
def test_only_what_comes_nearer_than_the_nearest_was_moves_anything(monkeypatch, fitted, left, moves):
    """However much another model gains by its own angles and places: here from 5 times the noise."""
    setup, (bare, right, wrong) = fitted
    gained = replace(wrong, key=wrong.key)
    sizes = {bare: 9.0, right: 2.0, wrong: 5.0, gained: left}
    monkeypatch.setattr(set_up_anew, "over_seen", lambda setup, model: sizes.get(model, 9.0))
    monkeypatch.setattr(set_up_anew, "_beside", lambda now, one: [(setup, gained)] if one is wrong else [])
    found = seen_anew(setup, [bare, right, wrong])
    assert (found is not None) is moves
    assert not moves or found[1][2] is gained


def test_a_model_sees_points_and_postures_that_are_not_its_own(fitted):
    """As if its diagnosis had begun with them; twins of the campaign's points among these."""
    setup, (_, model, _) = fitted
    one = next(nuisances_of(setup.observations))
    other = moved(setup.observations, [(one, 5 * one.deviation)])
    context = Context.of(setup.context.robot, other)
    right = predict(Hypothesis(context, setup.base, model.hypothesis.placed), model.x, other)
    found = predict(Elsewhere(model.hypothesis), model.x, other)
    np.testing.assert_allclose(found, right, rtol=1e-12)
    assert not np.allclose(right, model.predicted, rtol=1e-3)


def test_what_sits_on_a_sensor_is_no_error_of_its_place(fitted):
    """A gain of a sensor leaves every derivative of ln H as it is."""
    setup, (bare, *_) = fitted
    point = setup.context.sensors[0]
    hypothesis = bare.hypothesis.and_also(Placed(catalogue()["sensor_gain"], point))
    x = hypothesis.start(hypothesis.placed[0], {"gain": 1.5}, bare.x)
    lines = np.arange(5, len(setup.observations.axis), 20)
    every = [
        Sensitivities.of(Elsewhere(model), at, setup.observations, lines).shared
        for model, at in ((bare.hypothesis, bare.x), (hypothesis, x))
    ]
    assert predict(hypothesis, x, setup.observations) != pytest.approx(bare.predicted)
    for key in every[0]:
        np.testing.assert_allclose(every[1][key], every[0][key], atol=1e-6)


def test_one_that_leaves_mere_noise_moves_nothing_more(monkeypatch, fitted):
    setup, models = fitted
    perfect = replace(models[1], predicted=setup.observations.value)
    assert isinstance(perfect, FittedFrfs)
    monkeypatch.setattr(
        "flexmodal.diagnosis.selection.set_up_anew.set_up_beside", Mock(side_effect=AssertionError)
    )
    assert seen_anew(setup, [models[0], perfect]) is None


@pytest.mark.parametrize("where", ["set_up_beside", "predict"])
def test_where_there_is_no_model_nothing_is_moved(monkeypatch, fitted, where):
    """As beside a loop that rings up once points or angles are others."""
    setup, models = fitted
    real, rings_up = set_up_anew.predict, Mock(side_effect=SingularResponse("it rings up"))

    def predicted(hypothesis, x, observations):
        return real(hypothesis, x, observations) if observations is setup.observations else rings_up()

    monkeypatch.setattr(set_up_anew, where, predicted if where == "predict" else rings_up)
    assert seen_anew(setup, models) is None
    rings_up.assert_called()
    if where == "set_up_beside":
        assert with_everything(setup, models) == (setup, models)

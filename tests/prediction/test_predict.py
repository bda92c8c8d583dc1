"""Postures that nobody struck: nearer than what needs no model, a band that holds, an honest choice."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from flexmodal.campaign import read_campaign
from flexmodal.errors import InvalidPosture, InvalidRequest, MissingExtra
from flexmodal.identification import identify, observe
from flexmodal.identification.beside import shuffled_gap
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.gap import gap
from flexmodal.identification.poor import POOR
from flexmodal.prediction import METHODS, build_prediction, solve_by_all, solve_prediction
from flexmodal.prediction.cross_motion import with_cross_motion
from flexmodal.prediction.export import COLUMNS, as_frf, as_json, write_csv, write_uff
from flexmodal.prediction.judging import (
    PRIOR,
    SHARES,
    best,
    best_share,
    standings,
    together,
    typical,
)
from flexmodal.prediction.leave_one_out import known_by
from flexmodal.prediction.page import write_prediction_page
from flexmodal.prediction.panel import with_posture
from flexmodal.prediction.process import likeness


@pytest.fixture(scope="module")
def judged(every, problem):
    """What was measured in the postures that were never shown, and every method's predictions of it."""
    ids = [posture.id for posture in every.postures[5:]]
    seen = observe(replace(every, frfs=every.frfs.select(posture=ids)))
    made = [solve_by_all(problem, posture.q) for posture in seen.postures]
    value = {name: np.array(seen.value) for name in METHODS}
    size = {name: np.zeros(seen.value.shape) for name in METHODS}
    for row in range(len(seen)):
        for name in METHODS:
            for one in made[int(seen.posture[row])][name].frfs:
                pair = (seen.direction(seen.response[row]), seen.direction(seen.reference[row]))
                if (str(one.response), str(one.reference)) == pair:
                    value[name][row], size[name][row] = one.value, one.log_size
    return seen, value, size


@pytest.fixture(scope="module")
def found(problem, every):
    return solve_prediction(problem, every.postures[5].q)


@pytest.mark.slow
def test_it_is_nearer_than_what_needs_no_model_and_than_physics_alone(judged, problem):
    seen, value, _ = judged
    gaps = {name: gap(seen, each).value for name, each in value.items()}
    chosen = problem.left_out.chosen
    assert chosen == "hybrid"  # a sensor off by 30 % is the same in every posture
    assert all(gaps[chosen] < gaps[name] for name in ("mean", "nearest", "process", "physics"))
    assert gaps[chosen] < 0.9 * gaps["physics"]


def test_what_was_left_out_foretells_what_was_never_shown(judged, problem):
    seen, value, _ = judged
    real = gap(seen, value[problem.left_out.chosen]).value
    foretold = float(np.sqrt(np.mean(problem.left_out.chosen_anew**2)))
    assert 0.3 < foretold / real < 3


def test_the_band_holds_most_lines(judged, problem):
    seen, value, size = judged
    chosen = problem.left_out.chosen
    error = np.abs(residual(value[chosen], seen.value).real)
    inside = (error <= size[chosen])[seen.used]
    assert inside.mean() > 0.85
    assert np.median(size[chosen][seen.used]) < np.log(3)  # and says something


def test_shuffled_angles_fit_far_worse_and_it_says_where_they_do_not(problem, found):
    """The gap over all postures at once is that of the postures one by one."""
    left, evidence = problem.left_out, problem.evidence
    assert together(left.shuffled, left.weight) == pytest.approx(shuffled_gap(evidence), rel=1e-9)
    whole = evidence.gap(evidence.predicted(problem.x)).value
    assert together(left.fitted, left.weight) == pytest.approx(whole, rel=1e-9)
    assert left.tells_postures
    assert whole < 0.5 * shuffled_gap(evidence)
    assert "apart" not in found.verdict
    alike = replace(found, left_out=replace(left, shuffled=1.02 * left.fitted))
    assert "these data do not tell the postures apart" in alike.verdict


def test_the_choice_is_that_of_the_smallest_gap_left_out(problem):
    left = problem.left_out
    usual, gaps = left.typical, left.gap
    assert usual[left.chosen] <= 1.02 * min(usual.values())
    assert set(gaps) == set(usual) == set(METHODS)
    for name, each in left.gaps.items():
        assert gaps[name] == pytest.approx(gap(left.panel.observations, left.predicted[name]).value)
        assert len(each) == len(left.postures)


@pytest.mark.slow
def test_left_out_gaps_are_those_of_the_identification(problem, campaign, fanuc):
    """Physics, mean and nearest: by another room's loop over the same folds."""
    beside = identify(campaign, fanuc, source="frf", trust=POOR).baselines
    assert problem.left_out.gap["physics"] == pytest.approx(beside.model, rel=0.02)
    assert problem.left_out.gap["mean"] == pytest.approx(beside.mean, rel=0.02)
    assert problem.left_out.gap["nearest"] == pytest.approx(beside.nearest, rel=0.02)


@pytest.mark.slow
def test_a_posture_is_not_predicted_by_itself(campaign, fanuc, problem):
    """Its FRFs made ten times larger change what the others tell of it not at all."""
    frfs, own = campaign.frfs, campaign.postures[2]
    value = np.where((frfs.posture == own.id)[:, None], 10 * frfs.value, frfs.value)
    spoilt = build_prediction(replace(campaign, frfs=replace(frfs, value=value)), fanuc, trust=POOR)
    here = problem.left_out.panel.observations.posture == 2
    for name in ("mean", "nearest", "process"):
        one, other = (each.left_out.predicted[name][here] for each in (problem, spoilt))
        np.testing.assert_allclose(one, other, rtol=1e-9)
    one, other = (each.left_out.predicted["physics"][here] for each in (problem, spoilt))
    assert np.median(np.abs(np.log(np.abs(one / other)))) < 0.02  # begun elsewhere, ends alike


def test_choice_takes_the_more_trusted_of_two_alike():
    gaps = {"physics": np.array([0.099, 0.1]), "hybrid": np.array([0.1, 0.1]), "mean": np.array([0.5, 0.6])}
    alike = np.ones(2)
    assert best(gaps, alike) == "hybrid"
    assert best({**gaps, "physics": np.array([0.05, 0.05])}, alike) == "physics"
    assert best({**gaps, "mean": np.array([0.01, 0.6])}, np.array([1.0, 1e-9])) == "mean"


def test_a_difference_within_its_standard_error_is_none():
    """Three postures at 0.7, 0.7 and 1.5 of the gap: a mean of ln that is a tenth of its scatter."""
    away = np.array([0.7, 0.7, 1.5])
    gaps = {"hybrid": np.full(3, 1.0), "physics": away}
    mean = -np.log(away).mean()
    assert 0.02 < mean < np.std(np.log(away)) / np.sqrt(2)
    assert best(gaps, np.ones(3)) == "hybrid"
    many = {name: np.tile(one, 40) for name, one in gaps.items()}
    assert best(many, np.ones(120)) == "physics"  # told by 120 postures it is a difference


def test_one_posture_does_not_decide_which_method_predicts():
    """Seven postures at half the gap of the mean, and one in which the model has next to nothing."""
    usual = {name: np.full(8, 1.0) for name in METHODS}
    physics = np.full(8, 0.5)
    physics[3] = 5.0
    gaps = {**usual, "hybrid": 1.1 * physics, "physics": physics}
    assert together(physics, np.ones(8)) > together(usual["mean"], np.ones(8))
    assert best(gaps, np.ones(8)) == "physics"
    weight = np.linspace(1, 2, 8)
    assert typical(physics, weight) == pytest.approx(np.prod(physics ** (weight / weight.sum())))
    missing = np.where(np.arange(8) == 3, np.nan, physics)
    assert typical(missing, weight) == pytest.approx(0.5)


def test_a_posture_with_a_twin_counts_for_little_and_is_named(problem, every):
    """Three postures a radian apart and a twin of the last: of new postures the pair says next to nothing."""
    found = standings([{"q1": 0.0}, {"q1": 1.0}, {"q1": 2.0}, {"q1": 2.01}])
    usual = np.sqrt((1 + 1 + 2 * 0.01**2) / 4)
    np.testing.assert_allclose(found, [1, 1, 0.01 / usual, 0.01 / usual])
    near = {name: np.array([0.5, 0.5, 0.5, 0.5]) for name in METHODS}
    near["nearest"] = np.array([0.9, 0.9, 0.001, 0.001])
    assert best(near, np.ones(4)) == "nearest"
    assert best(near, found) == "hybrid"
    left = problem.left_out
    np.testing.assert_allclose(left.counts, left.weight * left.standing)
    twinned = replace(problem, left_out=replace(left, standing=np.where(np.arange(5) == 1, 0.1, 1.0)))
    told = solve_prediction(twinned, every.postures[5].q).verdict
    assert f"{left.names[1]}: so near to another posture" in told
    assert "so near to another posture" not in solve_prediction(problem, every.postures[5].q).verdict


def test_a_posture_with_a_large_gap_tells_no_more_of_the_share_than_another():
    gaps = np.sqrt([[0.01 + (0.2 - share) ** 2 for share in SHARES]] * 8)
    gaps[3] *= 30.0
    assert best_share(gaps, np.ones(8)) == pytest.approx((8 * 0.2 + PRIOR / 2) / (8 + PRIOR))


def test_a_posture_in_which_it_was_far_off_is_named(problem, every):
    left = problem.left_out
    gaps = {name: np.array(each) for name, each in left.gaps.items()}
    gaps[left.chosen][2] = 40 * left.typical[left.chosen]
    spoilt = replace(problem, left_out=replace(left, gaps=gaps))
    told = solve_prediction(spoilt, every.postures[5].q, method=left.chosen).verdict
    assert f"it was far off in {left.names[2]} (" in told
    assert "far off" not in solve_prediction(problem, every.postures[5].q).verdict


def test_a_share_is_where_the_parabola_is_least_drawn_towards_a_half():
    """Squared gaps a² + (b − s c)²: least at s = b/c."""
    for count, least in ((4, 0.9), (20, 0.9), (8, 0.2)):
        gaps = np.sqrt([[0.01 + (least - share) ** 2 for share in SHARES]] * count)
        expected = (count * least + PRIOR / 2) / (count + PRIOR)
        assert best_share(gaps, np.ones(count)) == pytest.approx(expected)
    beyond = np.array([[1.0, 0.8, 0.6, 0.4, 0.2]] * 6)
    assert best_share(beyond, np.ones(6)) == pytest.approx((6 + PRIOR / 2) / (6 + PRIOR))
    unheard = np.full((3, len(SHARES)), np.nan)
    assert best_share(unheard, np.ones(3)) == 0.5


def test_hybrid_is_made_of_its_parts(problem, every):
    """Two routes: the prediction, and physics, surface and process put together by hand."""
    q = {**every.postures[5].q, "q2": every.postures[5].q["q2"] - 0.4}  # far from all that were struck
    problem = replace(problem, left_out=replace(problem.left_out, mix=0.3))
    made, left = solve_by_all(problem, q), problem.left_out
    panel = with_posture(left.panel, "there", q)
    there = known_by(problem.evidence, panel, problem.x, left.postures, problem.sliding)
    rows, resonances = panel.of_posture(len(panel.observations.postures) - 1), there.resonances[-1]
    place = panel.place[rows]
    surface = problem.known.beside_physics.at(q, resonances)[place]
    assert 0.0 < left.share < 1.0
    moving = with_cross_motion(there.physics[rows], problem.known.mean[place], left.beside)
    for number, one in enumerate(made["hybrid"].frfs):
        base = moving[number]
        physics = base * np.exp(left.share * surface[number])
        alone = made["process"].frfs[number].value
        size = (1 - left.mix) * np.log(np.abs(physics)) + left.mix * np.log(np.abs(alone))
        turn = np.angle(physics) + left.mix * np.angle(alone / physics)
        np.testing.assert_allclose(one.value, np.exp(size + 1j * turn), rtol=1e-9)


def test_a_posture_that_was_struck_is_what_was_measured(problem, campaign):
    """Also by a model that is far off, and by the mean of postures; half a radian away they are as before."""
    observed = observe(campaign)
    for method in ("hybrid", "process"):
        made = solve_prediction(problem, campaign.postures[1].q, method=method)
        wanted = {(str(one.response), str(one.reference)): one.value for one in made.frfs}
        for row in np.flatnonzero(observed.posture == 1).tolist():
            value = wanted[
                observed.direction(observed.response[row]), observed.direction(observed.reference[row])
            ]
            used = observed.used[row]
            np.testing.assert_allclose(value[used], observed.value[row][used], rtol=0.01)
    apart = {**campaign.postures[1].q, "q1": campaign.postures[1].q["q1"] + 0.5}
    features = problem.known.beside_mean.features
    here = features.at(campaign.postures[1].q)
    assert likeness(here, here) == 1.0
    assert likeness(features.at(apart), here) < 1e-4


def test_what_moves_beside_a_model_is_the_mean_logarithm_of_both():
    """By a million draws of a motion nothing is known of; their mean logarithm scatters by 0.0006."""
    rng = np.random.default_rng(1)
    part = 0.1
    beside = part * 2.0 * (rng.normal(size=(2, 1_000_000)) / np.sqrt(2))
    usual = np.full((4, 1), 2.0 + 0j)
    model = np.array([[0.0], [0.05], [0.2], [3.0]]) * np.exp(0.4j)
    found = with_cross_motion(model, usual, part)
    for value, own in zip(found[:, 0], model[:, 0], strict=True):
        drawn = np.log(np.abs(own + beside[0] + 1j * beside[1]))
        assert np.log(np.abs(value)) == pytest.approx(drawn.mean(), abs=0.003)
    assert np.angle(found[0, 0]) == 0.0  # the mean's, where the model has none
    np.testing.assert_allclose(np.angle(found[1:]), 0.4, rtol=1e-12)
    assert found[3, 0] == pytest.approx(model[3, 0], rel=1e-6)
    np.testing.assert_array_equal(with_cross_motion(model, 0 * usual, part), model)
    little = with_cross_motion(
        1e-3 * model, usual, part
    )  # all of the arm moves little: so does what is beside
    np.testing.assert_allclose(np.abs(little[0]), 1e-3 * 3.0 * part * np.exp(-np.euler_gamma / 2), rtol=1e-9)
    apart = with_cross_motion(model, usual, part, np.array([0, 0, 0, 1]))  # the last of another posture
    np.testing.assert_allclose(np.abs(apart[0]), 0.2 * part * np.exp(-np.euler_gamma / 2), rtol=1e-9)


def test_a_point_that_stands_still_in_the_model_is_given_some_motion(problem, every):
    """Physics of exactly nothing; far from all that were struck, so that none of these says anything."""
    q = {**every.postures[5].q, "q2": every.postures[5].q["q2"] - 0.4}
    axis = problem.left_out.panel.axis
    places = np.arange(len(problem.left_out.panel.pairs))
    nothing = np.zeros((len(places), len(axis)), complex)
    found = problem.known.by_hybrid(q, nothing, places, np.zeros(0), axis, 0.0, 0.0)
    size = np.abs(found) / np.abs(problem.known.mean)
    np.testing.assert_allclose(size, problem.known.beside * np.exp(-np.euler_gamma / 2), rtol=1e-9)


def test_data_alone_is_said_where_physics_fits_nothing(problem, every):
    told = solve_prediction(problem, every.postures[5].q, method="mean")
    assert told.is_data_alone
    assert "physics has no part in this" in told.verdict
    assert "no better than the mean of the others" in told.verdict


def test_the_verdict_says_what_is_outside(problem, every):
    q = {**every.postures[5].q, "q1": 3.0}
    told = solve_prediction(problem, q)
    assert "q1" in told.beyond
    assert "outside what was measured: q1" in told.verdict
    near = solve_prediction(problem, every.postures[0].q)
    assert told.remote > near.remote == 1.0
    assert np.all(told.frfs[0].log_size >= 0)


def test_without_noise_in_the_records_a_long_record_is_predicted(problem, found):
    """The receptance itself: no window, no end of the record, real at 0 Hz's side."""
    assert found.left_out.panel.observations.lengths[0] > 0
    assert np.all(np.isfinite(found.frfs[0].value))
    assert np.all(found.frfs[0].low <= np.abs(found.frfs[0].value))
    assert np.all(np.abs(found.frfs[0].value) <= found.frfs[0].high)


def test_files_hold_what_was_predicted(found, tmp_path):
    write_csv(found, tmp_path / "p.csv")
    with (tmp_path / "p.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == len(found.frequency) * len(found.frfs)
    first = found.frfs[0]
    assert float(rows[3]["re"]) == first.value[3].real
    assert float(rows[3]["high"]) == first.high[3]
    write_uff(found, tmp_path / "p.uff")
    read = read_campaign(tmp_path / "p.uff").frfs
    np.testing.assert_allclose(np.abs(read.value[0]), np.abs(as_frf(found).value[:, 0, 0]), rtol=1e-5)
    told = as_json(found)
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert told["frfs"][0]["low"][3] == first.low[3]
    write_prediction_page(found, tmp_path / "p.html")
    page = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 2
    assert found.method in page


def test_a_matrix_with_a_hole_is_no_universal_file(found):
    with pytest.raises(InvalidRequest, match="every response for every force"):
        as_frf(
            replace(found, frfs=(*found.frfs[:1], replace(found.frfs[1], reference=found.frfs[1].response)))
        )


# what is refused


def test_two_postures_are_too_few(every, fanuc):
    two = replace(every, frfs=every.frfs.select(posture=[1, 2]))
    with pytest.raises(InvalidRequest, match="2 with FRFs"):
        build_prediction(two, fanuc)


def test_unknown_joints_limits_and_methods_are_refused(problem):
    with pytest.raises(InvalidPosture, match="shoulder"):
        solve_prediction(problem, {"shoulder": 1.0})
    with pytest.raises(InvalidPosture, match="limits"):
        solve_prediction(problem, {"q1": 99.0})
    with pytest.raises(InvalidRequest, match="hybrid"):
        solve_prediction(problem, {"q1": 1.0}, method="magic")


def test_without_scikit_learn_it_says_what_to_install(campaign, fanuc, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "sklearn", None)
    with pytest.raises(MissingExtra, match=r"flexmodal\[predict\]"):
        build_prediction(campaign, fanuc)


@pytest.mark.slow
def test_along_the_axes_of_a_link_it_predicts_and_says_so(campaign, fanuc):
    """The data of the world's axes taken for those of a link: other numbers, and the axes in the verdict."""
    points = tuple(replace(one, frame="link") for one in campaign.points[:1])
    turned = replace(campaign, points=(*points, *campaign.points[1:]))
    found = solve_prediction(build_prediction(turned, fanuc, trust=POOR), campaign.postures[0].q)
    (said,) = found.axes.items()
    assert said == (points[0].name, f"the axes of {points[0].link}")
    assert f"x, y, z at {points[0].name} are the axes of {points[0].link}" in found.verdict

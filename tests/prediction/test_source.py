"""A prediction as a source of receptances: the same as the prediction itself, in a search and in an atlas."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.atlas import (
    Grid,
    Plan,
    SourcedReceptances,
    Task,
    best,
    build_atlas,
    open_atlas,
    reach,
    workspace_map,
)
from flexmodal.errors import InvalidPoint, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model.receptance_source import MODEL, ReceptanceSource
from flexmodal.optimisation import PostureProblem, ReceptanceObjective, optimise
from flexmodal.optimisation.pictures.plot import draw_receptances
from flexmodal.prediction import METHODS, PredictedReceptances, build_prediction, solve_by_all
from flexmodal.prediction.page import method_cells

PAIR = (PointDirection("location_1", "z"), PointDirection("location_1", "z"))


@pytest.fixture(scope="module")
def source(problem):
    return PredictedReceptances(problem)


def test_both_fulfil_the_same_interface(source):
    assert isinstance(source, ReceptanceSource)
    assert isinstance(MODEL, ReceptanceSource)


@pytest.mark.parametrize("method", [name for name in METHODS if name != "mean"])
def test_it_gives_what_the_prediction_gives(problem, every, fanuc, method):
    q = every.postures[5].q
    source, whole = PredictedReceptances(problem, method), solve_by_all(problem, q)[method]
    one = whole.frfs[0]
    lines = whole.frequency[10:14]
    posed = fanuc.at(dict(q))
    found = source.receptances(posed, [(one.response, one.reference)], lines)
    np.testing.assert_allclose(found[:, 0], one.value[10:14], rtol=1e-9)
    band = source.band(posed, [(one.response, one.reference)], lines)
    np.testing.assert_allclose(band.log_size[:, 0], one.log_size[10:14], rtol=1e-9)
    assert band.remote == whole.remote
    assert band.beyond == whole.beyond


def test_signs_mirrors_and_points_of_the_robot(source, fanuc, every):
    posed = fanuc.at(dict(every.postures[5].q))
    (response, reference), turned = PAIR, PointDirection("location_1", "-z")
    pairs = [(response, reference), (turned, reference), (turned, turned)]
    found = source.receptances(posed, pairs, np.array([12.0]))[0]
    np.testing.assert_allclose(found, found[0] * np.array([1, -1, 1]))
    struck = {tuple(row) for row in source.problem.left_out.panel.pairs.tolist()}
    names = {point.id: point.name for point in every.points}
    other = next(row for row in struck if row[0] != row[2])
    there, here = (PointDirection(names[number], "z") for number in (other[0], other[2]))
    across = source.receptances(posed, [(there, here), (here, there)], np.array([12.0]))[0]
    assert across[0] == across[1]
    renamed = tuple(replace(point, name=f"p{point.id}") for point in every.points)
    campaign = replace(source.problem.campaign, points=renamed)
    placed = PredictedReceptances(replace(source.problem, campaign=campaign))
    np.testing.assert_allclose(placed.receptances(posed, pairs[:1], np.array([12.0]))[0], found[0])


@pytest.mark.slow
def test_a_search_ends_where_the_prediction_says_the_same(source, problem, fanuc):
    judge = ReceptanceObjective("location_1:+z", 12.0, source=source)
    start = dict.fromkeys(fanuc.commanded, 0.3)
    outcome = optimise(PostureProblem(fanuc, judge), start=start, starts=1)
    best_one = outcome.best
    whole = solve_by_all(problem, best_one.posture.values)[source.method]
    there = next(one for one in whole.frfs if (one.response, one.reference) == PAIR)
    value = np.interp(12.0, whole.frequency, np.abs(there.value))
    assert best_one.objective == pytest.approx(value, rel=0.02)  # between two lines
    assert best_one.objective < 0.5 * outcome.compared.objective
    drawn = draw_receptances(outcome, None)
    assert "predicted" in drawn.axes[0].get_title(loc="left")


def test_slopes_are_those_of_the_predicted_receptance(source, fanuc, every):
    judge = ReceptanceObjective("location_1:+z", [12.0, 30.0], source=source)
    q = dict(every.postures[5].q)
    slope = judge.cost_and_gradient(fanuc.at(q))[1]
    for name, joint in fanuc.commanded.items():
        step = 1e-3 if q[name] + 1e-3 < joint.upper else -1e-3
        ends = [judge.cost_and_gradient(fanuc.at({**q, name: q[name] + side * step}))[0] for side in (1, -1)]
        assert slope[list(fanuc.moving).index(name)] == pytest.approx(
            (ends[0] - ends[1]) / (2 * step), rel=1e-2, abs=1e-2
        )


def test_what_it_cannot_know_is_refused(source, problem, fanuc, every):
    posed = fanuc.at(dict(every.postures[5].q))
    with pytest.raises(InvalidRequest, match="the band that was measured"):
        source.receptances(posed, [PAIR], np.array([500.0]))
    with pytest.raises(InvalidPoint, match=r"struck and measured: .*location_1:z per location_1:z"):
        source.receptances(posed, [(PointDirection("location_1", "x"), PAIR[1])], np.array([12.0]))
    with pytest.raises(InvalidPoint, match="one of location_1"):
        source.receptances(posed, [(PointDirection("nowhere", "z"), PAIR[1])], np.array([12.0]))
    with pytest.raises(InvalidRequest, match="a method that knows postures"):
        PredictedReceptances(problem, "mean")
    with pytest.raises(InvalidRequest, match="one of hybrid"):
        PredictedReceptances(problem, "guess")


@pytest.mark.slow
def test_data_alone_is_said_where_no_physics_fits(every, fanuc, problem):
    """Angles of other postures: the model fits nothing, and what predicts knows no physics."""
    alone = PredictedReceptances(problem, "nearest")
    assert alone.is_data_alone
    assert "physics has no part in this" in alone.verdict
    turned = tuple(
        replace(one, q=other.q)
        for one, other in zip(every.postures, every.postures[3:] + every.postures[:3], strict=True)
    )
    ids = [posture.id for posture in every.postures[:5]]
    wrong = replace(every, postures=turned, frfs=every.frfs.select(posture=ids))
    spoilt = build_prediction(wrong, fanuc)
    if spoilt.left_out.chosen == "mean":
        with pytest.raises(InvalidRequest, match="tell no posture from another"):
            PredictedReceptances(spoilt)
    else:
        assert PredictedReceptances(spoilt).is_data_alone
    assert method_cells(solve_by_all(spoilt, every.postures[5].q)["mean"])


@pytest.mark.slow
def test_an_atlas_holds_what_the_prediction_gives(source, problem, fanuc, tmp_path):
    axes = {name: np.array([0.2]) for name in fanuc.commanded}
    first = next(iter(axes))
    axes[first] = np.array([0.2, 0.7, 3.0])
    quantity = SourcedReceptances.of(fanuc, ["location_1:+z"], [12.0, 13.0], source)
    build_atlas(Plan(Grid(fanuc, axes), quantity), tmp_path / "a.zarr", workers=1)
    read = open_atlas(tmp_path / "a.zarr")
    assert read.source["method"] == source.method
    task = Task((12.0, 12.0))
    spots = best(read, task, count=3)
    for spot in spots:
        posed = fanuc.at(spot.posture)
        value = source.receptances(posed, [PAIR], np.array([12.0]))[0, 0]
        band = source.band(posed, [PAIR], np.array([12.0]))
        there = reach(read, task, spot)
        assert spot.value == pytest.approx(abs(value), rel=1e-12)
        assert there.high / spot.value == pytest.approx(np.exp(band.log_size[0, 0]))
        assert there.beyond == len(band.beyond)
    assert any(reach(read, task, spot).beyond for spot in spots)  # nobody struck at 3 rad
    drawn = workspace_map(read, task)
    assert drawn.outside.any()

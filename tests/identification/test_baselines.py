"""What needs no model, beside what a model predicts: numbers by hand, words, and a control that can fail."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.identification import baselines, build_identification, identify
from flexmodal.identification.as_json import as_json
from flexmodal.identification.baselines import Baselines, log_mean, posture_distance, shuffled
from flexmodal.identification.page import BESIDE, baseline_cells
from flexmodal.identification.poor import POOR
from flexmodal.structure import robot_space


@pytest.fixture(scope="module")
def seen(campaign, fanuc):
    return build_identification(campaign, fanuc).evidence.observations


@pytest.fixture(scope="module")
def outcome(campaign, fanuc):
    return identify(campaign, fanuc)


def by_hand(seen, number, others, pick):
    """Weighted mean of squares over the records of a posture, from a dictionary of places, line by line."""
    places = {}
    for row in range(len(seen)):
        key = (*seen.response[row], *seen.reference[row], seen.level[row])
        places.setdefault(tuple(int(one) for one in key), {})[int(seen.posture[row])] = seen.value[row]
    total = weight = 0.0
    for record in range(len(seen.records)):
        row = seen.of_record[record]
        if seen.posture[row] != number:
            continue
        key = tuple(int(one) for one in (*seen.response[row], *seen.reference[row], seen.level[row]))
        guess = pick([places[key][other] for other in others if other in places[key]])
        for line in range(seen.value.shape[1]):
            away = np.log(guess[line] / seen.records.value[record, line])
            away = abs(complex(away.real, np.angle(np.exp(1j * away.imag)))) ** 2
            counts = seen.records.weight[record, line]
            total, weight = total + counts * min(away, 100.0), weight + counts
    return np.sqrt(total / weight)


@pytest.mark.slow
def test_the_mean_and_the_nearest_are_what_a_plain_loop_gives(seen):
    found = baselines(seen, np.array(seen.value))
    for number, one in enumerate(found.each):
        others = [k for k in range(3) if k != number]

        def geometric(values):
            phase = np.angle(sum(value / np.abs(value) for value in values))
            return np.prod(np.abs(values), axis=0) ** (1 / len(values)) * np.exp(1j * phase)

        assert one.mean == pytest.approx(by_hand(seen, number, others, geometric), rel=1e-9)
        near = min(others, key=lambda k: posture_distance(seen.postures[k].q, seen.postures[number].q))
        assert one.nearest == pytest.approx(by_hand(seen, number, [near], lambda values: values[0]), rel=1e-9)
        assert one.nearest_posture == seen.postures[near].name


def test_with_two_postures_mean_and_nearest_are_the_other_one(seen):
    two = seen.keeping(seen.posture < 2)
    found = baselines(two, np.array(two.value))
    for one in found.each:
        assert one.mean == pytest.approx(one.nearest, rel=1e-12)
    assert [one.nearest_posture for one in found.each] == [seen.postures[1].name, seen.postures[0].name]


def test_a_right_model_beats_them_and_is_said_to(outcome):
    found = outcome.baselines
    assert found.model == pytest.approx(outcome.gap.held_out_after)
    assert found.beats_mean
    assert found.beats_nearest
    assert found.tells_postures
    assert found.shuffled > 5 * found.fitted
    assert "it beats the mean of the others" in outcome.verdict
    assert found.missing == 0


def test_a_model_that_is_the_mean_is_said_to_predict_no_better(seen):
    value = np.array(seen.value)
    for row in range(len(seen)):
        same = np.all(seen.response == seen.response[row], axis=1) & (seen.posture != seen.posture[row])
        same &= np.all(seen.reference == seen.reference[row], axis=1) & (seen.level == seen.level[row])
        value[row] = log_mean(seen.value[same])
    found = baselines(seen, value)
    assert found.model == pytest.approx(found.mean, rel=1e-12)
    assert f"predicts no better than the mean of the others ({found.mean:.2g})" in found.verdict


def test_a_stiff_card_that_may_not_move_is_told_off(campaign, fanuc):
    """Stiffnesses are held a hundred times too high: the verdict says what the mean would do."""
    space = robot_space(fanuc, ["stiffness"])
    wrong = [replace(p, card=100 * p.card, lower=99 * p.card, upper=101 * p.card) for p in space]
    told = identify(campaign, fanuc, space=type(space)(tuple(wrong)))
    assert not told.baselines.beats_mean
    assert "predicts no better than the mean of the others" in told.verdict


def test_data_that_do_not_tell_postures_apart_are_told(campaign, fanuc):
    """Every posture bears the first one's FRFs: angles shuffled fit as well."""
    frfs = campaign.frfs
    first = frfs.value[frfs.posture == campaign.postures[0].id]
    value = frfs.value.copy()
    for posture in campaign.postures:
        value[frfs.posture == posture.id] = first
    told = identify(replace(campaign, frfs=replace(frfs, value=value)), fanuc)
    assert not told.baselines.tells_postures
    assert "with the postures' angles shuffled it fits as well" in told.verdict


def test_angles_that_belong_to_other_postures_are_told(campaign, fanuc):
    """Each posture bears the angles of the next but one but not its own: shuffled back it fits far better."""
    postures = campaign.postures
    step = max(1, len(postures) // 2)
    turned = (*postures[-step:], *postures[:-step])
    wrong = tuple(replace(one, q=other.q) for one, other in zip(postures, turned, strict=True))
    told = identify(replace(campaign, postures=wrong), fanuc)
    assert told.baselines.shuffled < 0.5 * told.baselines.fitted
    assert "angles and FRFs do not belong together as stated" in told.verdict


@pytest.mark.slow
def test_one_point_and_untrusted_masses_tell_no_scale(campaign, fanuc):
    """Records 20 % too large make every mass and stiffness 20 % smaller and leave the misfit as it is."""
    frfs = campaign.frfs.select(response=campaign.points[0].id)
    told, larger = (
        identify(replace(campaign, frfs=replace(frfs, value=scale * frfs.value)), fanuc, trust=POOR)
        for scale in (1.0, 1.2)
    )
    assert larger.over_noise == pytest.approx(told.over_noise, rel=0.02)
    for one, other in zip(told.estimates, larger.estimates, strict=True):
        if one.name.startswith(("stiffness", "mass")) and one.identified:
            assert other.value / one.value == pytest.approx(1 / 1.2, rel=0.12)
    for one in (told, larger):
        assert "a wrong scale of sensor or hammer passes for masses" in one.verdict
    assert "wrong scale" not in identify(campaign, fanuc, trust=POOR).verdict
    assert "wrong scale" not in identify(replace(campaign, frfs=frfs), fanuc).verdict


def test_what_only_one_posture_has_is_left_out_and_counted(seen):
    lone = (seen.posture != 0) | (seen.response[:, 0] != seen.campaign.points[0].id)
    part = seen.keeping(lone | (np.arange(len(seen)) == 0))
    found = baselines(part, np.array(part.value))
    gone = seen.keeping(~((seen.posture > 0) & (seen.response[:, 0] == seen.campaign.points[0].id)))
    assert found.missing == 0
    told = baselines(gone, np.array(gone.value))
    assert told.missing == int(np.sum((gone.posture == 0) & (gone.response[:, 0] == 1)))
    one = seen.keeping(seen.posture == 0)
    assert baselines(one, np.array(one.value)) is None


def test_named_postures_are_judged_by_those_that_were_fitted(campaign, fanuc, seen):
    names = [posture.name for posture in campaign.postures]
    told = identify(campaign, fanuc, hold_out=names[:2]).baselines
    assert [one.posture for one in told.each] == names[:2]
    assert {one.nearest_posture for one in told.each} == {names[2]}
    assert told.shuffled is None  # one posture was fitted: nothing to shuffle
    assert told.tells_postures


def test_modes_alone_have_no_such_baselines(campaign, fanuc):
    assert identify(campaign, fanuc, source="modes").baselines is None


def test_both_kinds_of_data_are_judged_on_their_frfs(campaign, fanuc, outcome):
    told = identify(campaign, fanuc, source="both").baselines
    assert told.mean == pytest.approx(outcome.baselines.mean, rel=1e-9)
    assert told.beats_mean


def test_shuffling_moves_every_posture(seen):
    turned = shuffled(seen)
    assert [one.name for one in turned.postures] == [one.name for one in seen.postures]
    assert all(one.q != other.q for one, other in zip(turned.postures, seen.postures, strict=True))


def test_distance_takes_a_joint_left_out_for_zero():
    assert posture_distance({"a": 3.0}, {"b": -4.0}) == pytest.approx(5.0)


def test_the_mean_of_logarithms_in_closed_form():
    value = np.array([[1.0 + 0j, 4j, 0.0], [4.0 + 0j, 1j, 0.0]])
    np.testing.assert_allclose(log_mean(value), [2.0, 2j, 0.0], atol=1e-15)


def test_table_and_json_have_the_same_numbers(outcome):
    cells = baseline_cells(outcome.baselines)
    assert all(len(row) == len(BESIDE) for row in cells)
    told = as_json(outcome)["baselines"]
    assert cells[0][1:4] == tuple(f"{told[key]:.3g}" for key in ("model", "mean", "nearest"))
    assert cells[-1][1] == f"{told['shuffled']:.3g}"
    assert told["verdict"] == outcome.baselines.verdict


def test_ties_are_no_wins():
    near = Baselines(0.5, 0.51, 0.9, 0.1, ())
    assert not near.beats_mean
    assert near.beats_nearest
    assert "no better than the mean of the others (0.51)" in near.verdict
    both = Baselines(0.5, 0.4, 0.3, 0.1, ())
    assert "nor than the nearest posture (0.3)" in both.verdict
    some = Baselines(0.5, 0.9, 0.5, 0.1, ())
    assert "beats the mean of the others (0.9) but predicts no better than the nearest" in some.verdict

"""Labelled FRFs: selecting, signs, forms, repeats and the matrix of one posture."""

import numpy as np
import pytest

from flexmodal.campaign import Campaign, FrfRecords, Trial, repeat_groups
from flexmodal.errors import FlexmodalError, InvalidCampaign, InvalidRequest


@pytest.fixture
def frfs(campaign: Campaign) -> FrfRecords:
    assert campaign.frfs is not None
    return campaign.frfs


def test_select_by_ids(frfs: FrfRecords) -> None:
    found = frfs.select(posture=2, trial=(1, 3), response=1)
    assert found.posture.tolist() == [2, 2]
    assert found.trial.tolist() == [1, 3]
    assert len(frfs.select(posture=9)) == 0


def test_a_direction_finds_either_sense_and_turns_the_sign(frfs: FrfRecords) -> None:
    as_recorded = frfs.select(response=(2, -3), reference=(2, -3))
    turned = frfs.select(response=(2, 3), reference=(2, -3))
    both = frfs.select(response=(2, 3), reference=(2, 3))
    assert turned.response[:, 1].tolist() == [3] * 8
    np.testing.assert_array_equal(turned.value, -as_recorded.value)
    np.testing.assert_array_equal(both.value, as_recorded.value)
    np.testing.assert_array_equal(frfs.select(response=2).value, as_recorded.value)


def test_positive_turns_each_negative_direction_once(frfs: FrfRecords) -> None:
    plain = frfs.positive()
    sign = np.where(frfs.response[:, 1] < 0, 1, -1)  # every reference is negative
    np.testing.assert_array_equal(plain.value, sign[:, None] * frfs.value)
    assert plain.response.min() > 0
    assert plain.reference.min() > 0


def test_the_matrix_of_a_posture(frfs: FrfRecords) -> None:
    frf = frfs.to_frf(1, 2, {1: "tip", 2: "wrist", 3: "elbow"})
    assert [str(d) for d in frf.response] == ["tip:+z", "wrist:-z", "elbow:+x"]
    assert [str(d) for d in frf.reference] == ["wrist:-z"]
    row = frfs.select(posture=1, trial=2, response=3)
    np.testing.assert_array_equal(frf.between("elbow:+x", "wrist:-z"), row.value[0])
    with pytest.raises(InvalidRequest, match="no name for point 3"):
        frfs.to_frf(1, 2, {1: "tip", 2: "wrist"})
    with pytest.raises(InvalidRequest, match="no records"):
        frfs.to_frf(1, 9, {})


def test_a_pair_that_was_not_measured_is_named(frfs: FrfRecords) -> None:
    from dataclasses import replace

    reference = frfs.reference.copy()
    reference[0] = (3, 1)
    with pytest.raises(InvalidRequest, match=r"no record of 1:\+z per 2:-z"):
        replace(frfs, reference=reference).to_frf(1, 1, {1: "a", 2: "b", 3: "c"})


def test_forms_there_and_back(frfs: FrfRecords) -> None:
    omega = 2 * np.pi * frfs.frequency[1:]
    receptance = frfs.to("receptance")
    np.testing.assert_allclose(receptance.value[:, 1:], -frfs.value[:, 1:] / omega**2, rtol=1e-12)
    np.testing.assert_allclose(receptance.to("inertance").value[:, 1:], frfs.value[:, 1:], rtol=1e-12)
    assert np.all(np.isfinite(receptance.value))  # 0 Hz is held at the first line above
    np.testing.assert_allclose(receptance.value[:, 0], -frfs.value[:, 0] / omega[0] ** 2)


def test_the_floor_holds_the_divisor_and_the_phase(frfs: FrfRecords) -> None:
    held, free = frfs.to("receptance", floor=2.0), frfs.to("receptance")
    below, above = (frfs.frequency > 0) & (frfs.frequency < 2), frfs.frequency >= 2
    np.testing.assert_array_equal(held.value[:, above], free.value[:, above])
    ratio = held.value[:, below] / free.value[:, below]
    np.testing.assert_allclose(ratio, np.tile((frfs.frequency[below] / 2.0) ** 2, (len(frfs), 1)), rtol=1e-12)
    with pytest.raises(InvalidRequest, match="floor"):
        frfs.to("receptance", floor=0.0)


def test_repeats_by_name_and_by_kind(frfs: FrfRecords) -> None:
    assert repeat_groups(frfs.trials) == ((1, 2), (3, 4))
    pairs = frfs.repeats()
    assert len(pairs) == 12  # two postures, three responses, two groups of two
    for one, other in pairs:
        assert {int(frfs.trial[one]), int(frfs.trial[other])} in ({1, 2}, {3, 4})
        assert frfs.response[one].tolist() == frfs.response[other].tolist()
        assert frfs.posture[one] == frfs.posture[other]


def test_trials_that_name_another_do_not_join_by_kind() -> None:
    trials = (Trial(1, 10.0, 1, "a"), Trial(2, 20.0, 1, "b", repeat_of=1), Trial(3, 20.0, 1, "b"))
    assert repeat_groups(trials) == ((1, 2), (3,))


def test_a_campaign_that_contradicts_itself_cannot_be_made(campaign: Campaign) -> None:
    from dataclasses import replace

    assert campaign.frfs is not None
    spoilt = replace(campaign.frfs, value=campaign.frfs.value * np.nan)
    with pytest.raises(InvalidCampaign) as caught:
        replace(campaign, frfs=spoilt, points=campaign.points[:2])
    assert len(caught.value.faults) >= 3  # the values, a point of the FRFs, and of each blow
    assert isinstance(caught.value, FlexmodalError)

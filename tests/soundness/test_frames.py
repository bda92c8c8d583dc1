"""Axes that turn with the link and are stated in the world, or the other way round."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.identification import RobotModel, observe
from flexmodal.identification.model import predict
from flexmodal.rig import simulate
from flexmodal.rig.laboratory import with_mishaps
from flexmodal.soundness import check_soundness
from flexmodal.soundness.check import beside_model
from flexmodal.soundness.hypotheses import frame_hypotheses
from flexmodal.soundness.readings import Reading, with_frames
from flexmodal.structure import robot_space

KIND = "axes in another frame"


@pytest.fixture(scope="module")
def glued(fanuc):
    """A sound campaign whose sensors and hammer follow the links, stated so."""
    made = simulate(
        fanuc, postures=["configuration_1", "configuration_3", "configuration_7"], points=2, references=2,
        trials=2, averages=2, peaks=(100.0,), band=(2.0, 120.0), record_length=1.5, seed=6, frame="link",
    )  # fmt: skip
    return made.campaign


def restated(campaign, frame, ids=None):
    """The same data, its points said to have axes of another frame."""
    points = tuple(
        replace(one, frame=frame) if ids is None or one.id in ids else one for one in campaign.points
    )
    return replace(campaign, points=points)


def told(campaign, robot):
    return [one for one in check_soundness(campaign, robot) if one.kind == KIND]


def test_of_axes_that_are_stated_rightly_nothing_is_said(glued, planar, fanuc):
    assert check_soundness(glued, fanuc) == ()
    assert check_soundness(planar, fanuc) == ()


def test_glued_sensors_stated_in_the_world_are_found(glued, fanuc):
    (found,) = check_soundness(restated(glued, "world"), fanuc)
    assert found.kind == KIND
    assert found.where == "every point: the axes are those of their links"
    assert "so read, these records come from" in found.evidence
    assert "stiffness" in found.cost
    assert 'axes = "link"' in found.remedy


def test_sensors_of_the_world_stated_in_the_links_are_found_one_by_one(planar, fanuc):
    point = planar.points[1]
    (found,) = check_soundness(restated(planar, "link", {point.id}), fanuc)
    assert (found.kind, found.where) == (KIND, f"{point.name}: the axes are those of the world")


def test_it_is_found_beside_another_error(glued, fanuc):
    spoilt, done = with_mishaps(restated(glued, "world"), ["drift"], seed=4)
    assert [one.kind for one in done] == ["drift"]
    assert {one.kind for one in check_soundness(spoilt, fanuc)} == {KIND, "drift"}


def test_so_in_a_spatial_arm(spatial, arm):
    point = next(one for one in spatial.points if one.link != "link_1")
    assert told(restated(spatial, "link", {point.id}), arm)


@pytest.mark.parametrize("what", ["sensor", "hammer"])
def test_a_sensor_alone_and_a_hammer_alone_are_told_apart(planar, fanuc, what):
    """The model's own FRFs, of a point where one of the two turned with the link."""
    seen = observe(planar)
    model = RobotModel(fanuc, robot_space(fanuc))
    point = planar.points[1]  # the other stands level in all of these postures
    made = Reading(framed=frozenset({(point.id, what)})).applied(seen)
    there = replace(seen, value=predict(model, np.zeros(len(model.space)), made))
    (found,) = beside_model(there, fanuc)
    assert found.kind == KIND
    assert found.where.startswith(f"the {what} at {point.name}")


def test_a_reading_is_the_campaign_stated_otherwise(planar, fanuc):
    """Two routes: points beside the campaign's, and the campaign with its own points changed."""
    seen = observe(planar)
    point = planar.points[0]
    both = frozenset({(point.id, "sensor"), (point.id, "hammer")})
    model = RobotModel(fanuc, robot_space(fanuc))
    x = np.zeros(len(model.space))
    changed = replace(seen, campaign=restated(planar, "link", {point.id}))
    np.testing.assert_allclose(predict(model, x, with_frames(seen, both)), predict(model, x, changed))
    assert with_frames(seen, frozenset()) is seen


def test_no_hypothesis_of_all_points_where_they_are_stated_differently(planar):
    mixed = observe(restated(planar, "link", {planar.points[0].id}))
    assert not any("every point" in one.where for one in frame_hypotheses(mixed))
    assert any("every point" in one.where for one in frame_hypotheses(observe(planar)))


def test_the_mishap_states_the_other_frame_and_touches_no_record(planar, glued):
    for campaign, other in ((planar, "link"), (glued, "world")):
        spoilt, (done,) = with_mishaps(campaign, [KIND], seed=2)
        wrong = [one for one in spoilt.points if one.frame == other]
        assert {one.name for one in wrong} == set(done.where.split(", "))
        np.testing.assert_allclose(spoilt.frfs.value, campaign.frfs.value, rtol=1e-9)

"""A campaign on its robot: things stand where they were measured and move as the shapes say."""

from dataclasses import replace

import numpy as np
import pytest
from flexmodal_viewer import campaign_scene
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.commands import payload
from flexmodal_viewer.measured_shape import joint_shape
from flexmodal_viewer.motion import SHARE
from flexmodal_viewer.palette import EXTREME, FORCE, POINT, TARGET

from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture, FrfRecords, Trial
from flexmodal.ema.shapes import FittedShapes
from flexmodal.errors import InvalidCampaign
from flexmodal.modal import mac
from flexmodal.model.placements import link_placements

AXIS = np.array([1.0, 2.0])


@pytest.fixture
def campaign(fanuc):
    """Two postures, two points; a sensor along +z and −x, a hammer along −z."""
    card = fanuc.points["location_2"]
    points = (
        CampaignPoint(1, "tip <b>", "link_3", (0.23, 0.0, 0.0)),
        CampaignPoint(2, "location_2", card.link, tuple(card.xyz)),
    )
    response, reference = np.array([[1, 3], [2, 3], [1, -1]]), np.array([[2, -3]] * 3)
    ones = np.ones(3, dtype=int)
    frfs = FrfRecords(
        AXIS, np.ones((3, 2), dtype=complex), None, ones, ones, response, reference, "inertance"
    )
    names = ("configuration_1", "configuration_4")
    postures = tuple(CampaignPosture(n, name, dict(fanuc.postures[name])) for n, name in enumerate(names, 1))
    return Campaign("test", "fanuc_s360", (1.0, 2.0), postures, points, (Trial(1, 100.0, 1, "soft"),), frfs)


SHAPES = FittedShapes(
    1, (2, -3), "reference", ((1, 3), (2, 3), (1, -1)), (7.0, 90.0),
    np.array([[1.0, 0.5j], [0.4, 1.0], [0.2, 0.0]], dtype=complex),
)  # fmt: skip


def test_points_stand_where_they_were_measured(fanuc, campaign):
    scene = campaign_scene(fanuc, campaign)
    for posture in campaign.postures:
        posed = fanuc.at(dict(posture.q))
        for number, name in ((1, "location_1"), (2, "location_2")):
            node = scene.nodes[f"posture_{posture.id}/point_{number}"]
            np.testing.assert_allclose(node[:3, 3], posed.position(name), atol=1e-12)


def test_arrows_along_the_axes_of_a_link_turn_with_it(fanuc, campaign):
    """And the table of each posture says whose axes they are; of the world's nothing is said."""
    fixed = replace(campaign.points[1], link="link_1", xyz=(0.85, 0.0, 0.0), frame="link")
    scene = campaign_scene(fanuc, replace(campaign, points=(campaign.points[0], fixed)))
    turn = link_placements(fanuc, fanuc.postures["configuration_1"])[fixed.link][:3, :3]
    assert abs(turn[2, 2]) < 0.99
    np.testing.assert_allclose(scene.nodes["posture_1/response_1"][:3, 2], turn[:, 2], atol=1e-12)
    np.testing.assert_allclose(scene.nodes["posture_1/hammer_0"][:3, 2], -turn[:, 2], atol=1e-12)
    np.testing.assert_allclose(scene.nodes["posture_1/response_0"][:3, 2], [0, 0, 1], atol=1e-12)
    rows = dict(scene.motions[0].table.rows)
    assert rows["x, y, z at location_2"] == f"the axes of {fixed.link}"
    assert not any(name.startswith("x, y, z at tip") for name in rows)


def test_arrows_say_where_sensor_and_hammer_point(fanuc, campaign):
    scene = campaign_scene(fanuc, campaign)
    posed = fanuc.at("configuration_1")
    arrows = {name: place for name, place in scene.nodes.items() if name.startswith("posture_1/")}
    sensor = arrows["posture_1/response_2"]
    np.testing.assert_allclose(sensor[:3, 2], [-1, 0, 0], atol=1e-12)  # −x
    np.testing.assert_allclose(sensor[:3, 3], posed.position("location_1"), atol=1e-12)  # begins at its point
    hammer = arrows["posture_1/hammer_0"]
    np.testing.assert_allclose(hammer[:3, 2], [0, 0, -1], atol=1e-12)
    assert hammer[2, 3] > posed.position("location_2")[2]  # comes from above, ends at its point
    assert "posture_2/response_0" not in scene.nodes  # nothing was measured there
    colours = {
        item.path.split("/")[1].split("_")[0]: item.colour for item in scene.items if "/shaft" in item.path
    }
    assert (colours["response"], colours["hammer"]) == (POINT, FORCE)


def test_trace_lines_join_the_points_where_they_stand(fanuc, campaign):
    scene = campaign_scene(fanuc, replace(campaign, trace_lines=((2, 1), (1, 2, 1))))
    for posture in campaign.postures:
        (traced,) = (one for one in scene.items if one.path == f"posture_{posture.id}/trace")
        posed = fanuc.at(dict(posture.q))
        first, last = posed.position("location_2"), posed.position("location_1")
        np.testing.assert_allclose(
            traced.shape.ends, [[first, last], [last, first], [first, last]], atol=1e-12
        )
    assert not any(one.path.endswith("trace") for one in campaign_scene(fanuc, campaign).items)


def test_each_posture_is_seen_alone(fanuc, campaign):
    scene = campaign_scene(fanuc, campaign, [SHAPES])
    assert [motion.name for motion in scene.motions] == [
        "1: configuration_1", "1: 7 Hz", "1: 90 Hz", "2: configuration_4",
    ]  # fmt: skip
    assert [motion.shows for motion in scene.motions] == [
        ("posture_1",), ("posture_1", "shape_1_0"), ("posture_1", "shape_1_1"), ("posture_2",),
    ]  # fmt: skip
    assert [bool(motion.tracks) for motion in scene.motions] == [False, True, True, False]


def test_points_move_as_the_residues_say(fanuc, campaign):
    scene = campaign_scene(fanuc, campaign, [SHAPES])
    posed = fanuc.at("configuration_1")
    first, second = scene.motions[1], scene.motions[2]
    tip = first.tracks["shape_1_0/point_1"][:, :3, 3] - posed.position("location_1")
    # +z 1.0 and −x 0.2, in phase: along (−0.2, 0, 1), farthest at the beginning and after half a cycle.
    along = np.array([-0.2, 0, 1]) / np.hypot(0.2, 1)
    np.testing.assert_allclose(tip[0], np.linalg.norm(tip[0]) * along, atol=1e-12)
    np.testing.assert_allclose(tip[16], -tip[0], atol=1e-12)
    other = first.tracks["shape_1_0/point_2"][:, :3, 3] - posed.position("location_2")
    np.testing.assert_allclose(other[0][2] / tip[0][2], 0.4, atol=1e-12)
    # A quarter of a period apart: where the one is farthest out, the other passes its rest.
    a = second.tracks["shape_1_1/point_1"][:, 2, 3] - posed.position("location_1")[2]
    b = second.tracks["shape_1_1/point_2"][:, 2, 3] - posed.position("location_2")[2]
    assert abs(a[0]) < 1e-12
    np.testing.assert_allclose(np.max(np.abs(a)) / np.max(np.abs(b)), 0.5, atol=1e-9)
    assert 0.1 * SHARE * Arm(fanuc).reach < np.max(np.abs(b)) <= (1 + 1e-9) * SHARE * Arm(fanuc).reach
    balls = [item for item in scene.items if item.path.startswith("shape_") and item.path.endswith("ball")]
    assert len(balls) == 4
    assert {item.colour for item in balls} == {EXTREME}


def test_strangers_are_refused_all_at_once(fanuc, campaign):
    point = CampaignPoint(1, "tip", "nowhere", (0.0, 0.0, 0.0))
    posture = CampaignPosture(1, "odd", {"q9": 0.0})
    odd = replace(campaign, points=(point, campaign.points[1]), postures=(posture, campaign.postures[1]))
    with pytest.raises(InvalidCampaign) as caught:
        campaign_scene(fanuc, odd)
    told = [str(fault) for fault in caught.value.faults]
    assert len(told) == 2
    assert any("q9" in line for line in told)
    assert any("nowhere" in line for line in told)


def test_the_page_is_finite_and_escaped(fanuc, campaign):
    from flexmodal_viewer.page import page_html

    scene = campaign_scene(fanuc, campaign, [SHAPES])
    assert payload(scene)["motions"][1]["animations"]
    text = page_html(scene)
    assert "tip <b>" not in text
    assert "tip &lt;b&gt;" in text or "tip \\u003cb\\u003e" in text


@pytest.fixture
def everywhere(campaign, fanuc):
    """All points of the card, measured along x and z."""
    points = tuple(
        CampaignPoint(number, name, card.link, tuple(card.xyz))
        for number, (name, card) in enumerate(fanuc.points.items(), 1)
    )
    response = np.array([[point.id, way] for point in points for way in (1, 3)])
    ones = np.ones(len(response), dtype=int)
    reference = np.array([[1, 3]] * len(response))
    value = np.ones((len(response), 2), dtype=complex)
    frfs = FrfRecords(AXIS, value, None, ones, ones, response, reference, "inertance")
    return replace(campaign, points=points, frfs=frfs)


def shape_of(fanuc, campaign, mode, extra=()):
    """What a test without noise would find of a mode of the card, and more beside it."""
    posed = fanuc.at("configuration_1")
    ways = [tuple(way) for way in campaign.frfs.response.tolist()]
    names = {point.id: point.name for point in campaign.points}
    rows = np.array([posed.jacobian(names[point])[abs(way) - 1] for point, way in ways])
    values = rows @ posed.modes().shape[:, mode]
    values = np.concatenate([values / values[np.argmax(np.abs(values))], [value for _, value in extra]])
    places = (*ways, *(way for way, _ in extra))
    return FittedShapes(1, (1, 3), "reference", places, (7.0,), values[:, None].astype(complex))


def test_a_measured_shape_moves_the_links_as_the_mode_does(fanuc, everywhere):
    posed = fanuc.at("configuration_1")
    for mode in (0, 1):
        shape = shape_of(fanuc, everywhere, mode)
        motion = campaign_scene(fanuc, everywhere, [shape]).motions[1]
        rows = dict(motion.table.rows)
        assert rows["the joints can do"] == "100 % of it"
        assert rows["most like it"] == f"the card's mode at {posed.modes().frequency[mode]:.4g} Hz, MAC 1.00"
    motion = campaign_scene(fanuc, everywhere, [shape_of(fanuc, everywhere, 0)]).motions[1]
    # where the tip is on the moving link, the ball of the tip is, but for the second order of the turn
    link = motion.tracks[Arm(fanuc).node("posture_1", "link_3")]
    ball = motion.tracks["shape_1_0/point_1"][:, :3, 3]
    tip = link[:, :3, :3] @ np.array(fanuc.points["location_1"].xyz) + link[:, :3, 3]
    assert np.max(np.linalg.norm(tip - ball, axis=1)) < 0.1 * np.max(np.linalg.norm(ball - ball[8], axis=1))


@pytest.mark.parametrize("mode", [0, 1, 2, 3])
def test_the_joints_of_a_measured_mode_are_those_of_the_mode(fanuc, everywhere, mode):
    posed, shape = fanuc.at("configuration_1"), shape_of(fanuc, everywhere, mode)
    names = {point.id: point.name for point in everywhere.points}
    rows = np.array([posed.jacobian(names[point])[way - 1] for point, way in shape.places])
    found = joint_shape(posed, rows, shape.shape[:, 0])
    assert mac(found.amplitude[:, None], posed.modes().shape[:, [mode]])[0, 0] > 0.99
    assert found.nearest == pytest.approx((posed.modes().frequency[mode], 1.0), rel=1e-9)
    assert np.max(np.abs(found.left)) < 0.1


def test_a_point_that_the_joints_cannot_follow_is_coloured(fanuc, everywhere):
    shape = shape_of(fanuc, everywhere, 0, extra=(((3, 2), 0.8),))  # across the plane of the arm
    scene = campaign_scene(fanuc, everywhere, [shape])
    balls = {
        item.path: item.colour for item in scene.items if item.path.endswith("/ball") and "shape" in item.path
    }
    assert {path for path, colour in balls.items() if colour == TARGET} == {"shape_1_0/point_3/ball"}
    assert dict(scene.motions[1].table.rows)["the joints can do"] != "100 % of it"
    assert any("cannot follow" in swatch.text for swatch in scene.motions[1].legend)


def test_a_posture_at_rest_stands_as_it_stood(fanuc, everywhere):
    scene = campaign_scene(fanuc, everywhere, [shape_of(fanuc, everywhere, 0)])
    still = scene.motions[0]
    assert not still.tracks
    for path, place in still.poses.items():
        np.testing.assert_array_equal(place, scene.nodes[path])

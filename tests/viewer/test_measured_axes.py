"""Records along axes of their own do not stand beside curves along those of the world."""

from dataclasses import replace

import numpy as np
import pytest
from flexmodal_viewer.live_measured import measured_curves

from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture, FrfRecords, Trial
from flexmodal.errors import InvalidRequest


@pytest.fixture
def campaign(fanuc):
    points = (
        CampaignPoint(1, "location_1", "link_3", (0.23, 0.0, 0.0), None, "link"),
        CampaignPoint(2, "location_6", "link_1", (0.85, 0.0, 0.0)),
    )
    response, reference = np.array([[1, 3], [2, 3]]), np.array([[2, 3], [2, 3]])
    ones = np.ones(2, dtype=int)
    axis, value = np.array([1.0, 2.0]), np.ones((2, 2), dtype=complex)
    frfs = FrfRecords(axis, value, None, ones, ones, response, reference, "receptance")
    posture = CampaignPosture(1, "p", dict(fanuc.postures["configuration_1"]))
    return Campaign("test", "fanuc_s360", (1.0, 2.0), (posture,), points, (Trial(1, 100.0, 1, "soft"),), frfs)


def test_those_along_a_link_are_left_out(fanuc, campaign):
    (curve,) = measured_curves(fanuc, campaign)
    assert (curve["response"], curve["reference"]) == ("location_6:+z", "location_6:+z")


def test_where_none_is_left_it_says_why(fanuc, campaign):
    every = tuple(replace(point, frame="link") for point in campaign.points)
    with pytest.raises(InvalidRequest, match="a record along the axes of the world"):
        measured_curves(fanuc, replace(campaign, points=every))

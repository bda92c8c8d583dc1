"""Records along axes of a link are curves of the page as those along the world's are."""

import numpy as np
import pytest
from flexmodal_viewer.live_measured import measured_curves, measured_points

from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture, FrfRecords, Trial


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


def test_those_along_a_link_are_curves_too(fanuc, campaign):
    """The page computes along the axes that the point has."""
    curves = measured_curves(fanuc, campaign)
    assert [(one["response"], one["reference"]) for one in curves] == [
        ("location_1:+z", "location_6:+z"), ("location_6:+z", "location_6:+z"),
    ]  # fmt: skip
    points = measured_points(campaign)
    assert (points["location_1"].frame, points["location_6"].frame) == ("link", "world")

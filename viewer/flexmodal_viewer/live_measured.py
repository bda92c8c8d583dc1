"""Measured FRFs as curves beside the model's, in the postures they were measured in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import Campaign, CampaignPoint, estimate_frfs, named_direction
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot

_MOST_LINES = 1000
"""Lines of a measured curve that go into a page; of finer ones every second, third, … is taken."""


def measured_curves(robot: Robot, campaign: Campaign) -> list[dict[str, Any]]:
    """Receptance of every posture, pair and trial in the campaign's band, ready for JSON.

    Args:
        robot: whose joints the postures set.
        campaign: with FRFs or blows.

    Raises:
        InvalidRequest: it has neither.
        InvalidPosture: a posture that the robot cannot take.
    """
    if campaign.frfs is None and not campaign.blows:
        source = str(campaign.path or "campaign")
        raise InvalidRequest(Fault(source, "", "no FRFs and no blows", "measured curves to compare with"))
    records = (estimate_frfs(campaign) if campaign.frfs is None else campaign.frfs).to("receptance")
    names = {point.id: point.name for point in campaign.points}
    low, high = campaign.band
    lines = records.frequency
    inside = np.flatnonzero((lines >= low) & (lines <= high) & (lines > 0))
    inside = inside[:: max(1, -(-len(inside) // _MOST_LINES))]
    several = len(set(records.trial.tolist())) > 1
    curves = []
    for row in range(len(records)):
        where = campaign.posture(int(records.posture[row]))
        places = (records.response[row].tolist(), records.reference[row].tolist())
        response, reference = (str(named_direction(place, names)) for place in places)
        curves.append(
            {
                "name": f"measured, trial {int(records.trial[row])}" if several else "measured",
                "posture": where.name,
                "q": dict(robot.posture(dict(where.q)).values),
                "response": response,
                "reference": reference,
                "frequencies": short(lines[inside], 7),
                "sizes": short(np.abs(records.value[row, inside]), 4),
            }
        )
    return curves


def measured_points(campaign: Campaign) -> Mapping[str, CampaignPoint]:
    """Each point of a campaign, by name."""
    return {point.name: point for point in campaign.points}


def short(values: Float[np.ndarray, " line"], digits: int) -> list[float]:
    """Rounded to so many digits, which a picture does not show beyond.

    Args:
        values: of a curve.
        digits: that are kept.
    """
    return [float(f"{value:.{digits}g}") for value in values]

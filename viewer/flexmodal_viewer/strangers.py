"""Whether a robot can be what a campaign tested."""

from __future__ import annotations

from flexmodal.campaign import Campaign
from flexmodal.errors import Fault, InvalidCampaign, InvalidPosture
from flexmodal.model import Robot


def refuse_strangers(robot: Robot, campaign: Campaign) -> None:
    """Complain of all postures and points that the robot cannot have.

    Args:
        robot: that is to be shown.
        campaign: that is to be shown on it.

    Raises:
        InvalidCampaign: there are some.
    """
    source = str(campaign.path or campaign.title)
    faults: list[Fault] = []
    for posture in campaign.postures:
        try:
            robot.posture(dict(posture.q), source=f"{source}: posture {posture.id}")
        except InvalidPosture as error:
            faults += error.faults
    links = [link.name for link in robot.urdf.links]
    for point in campaign.points:
        if point.link not in links:
            faults.append(
                Fault(
                    source,
                    f"point {point.id}: link",
                    repr(point.link),
                    f"a link of {robot.name}: {', '.join(links)}",
                )
            )
    if faults:
        raise InvalidCampaign(faults)

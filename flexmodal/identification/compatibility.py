"""Do a campaign and a robot belong together? Every fault at once, before anything is fitted."""

from __future__ import annotations

from dataclasses import replace

from flexmodal.campaign import Campaign
from flexmodal.errors import Fault, InvalidPosture, InvalidRequest
from flexmodal.model import Robot
from flexmodal.structure.arm import beyond
from flexmodal.text.words import listing


def check_compatible(campaign: Campaign, robot: Robot) -> None:
    """Check postures and points of a campaign against a robot.

    Args:
        campaign: what was measured.
        robot: on which it is said to be.

    Raises:
        InvalidRequest: links or joints that the robot does not have, postures outside its limits, points that
            no flexible joint moves.
    """
    source = str(campaign.path / "campaign.toml" if campaign.path else "campaign")
    faults = _posture_faults(campaign, robot, source) + _point_faults(campaign, robot, source)
    if faults:
        raise InvalidRequest(faults)


def unmentioned(campaign: Campaign, robot: Robot) -> tuple[str, ...]:
    """Joints of another robot than the one the campaign names, which none of its postures mentions.

    A joint left out of a posture stands at 0; one that the campaign does not know of is another arm's.

    Args:
        campaign: what was measured.
        robot: that it is to be compared with.
    """
    own = campaign.robot == robot.name
    if campaign.path is not None and robot.path is not None:
        own = own or (campaign.path / campaign.robot).resolve() == robot.path.resolve()
    known = {name for posture in campaign.postures for name in posture.q}
    return () if own else tuple(name for name in robot.commanded if name not in known)


def _posture_faults(campaign: Campaign, robot: Robot, source: str) -> list[Fault]:
    faults: list[Fault] = []
    strange = unmentioned(campaign, robot)
    if strange:
        allowed = f"an angle or way of each in some posture: the campaign is of {campaign.robot}"
        found = f"nothing of {listing(strange)}, which {robot.name} is posed by"
        faults.append(Fault(source, "posture", found, allowed))
    for posture in campaign.postures:
        try:
            robot.posture(dict(posture.q), source=f"{source}: posture {posture.name}")
        except InvalidPosture as error:
            faults += error.faults
        springs = [name for name, joint in robot.joints.items() if not joint.pseudo]
        for name in sorted(set(posture.locked) - set(springs)):
            allowed = f"flexible joints of {robot.name}: {listing(springs)}"
            faults.append(Fault(source, f"posture {posture.name}: locked", repr(name), allowed))
        seen = campaign.modes is not None and posture.id in campaign.modes.posture
        if seen and (posture.locked or posture.masses):
            found = "joints locked or masses bolted on beside modes.csv"
            faults.append(
                Fault(source, f"posture {posture.name}", found, "FRFs, which alone count with them")
            )
    return faults


def _point_faults(campaign: Campaign, robot: Robot, source: str) -> list[Fault]:
    moved = {
        link for name in robot.joints for link in beyond(robot.urdf, robot.urdf.joint_by_name[name].child)
    }
    faults = []
    for point in campaign.points:
        key = f"point {point.name}"
        if point.link not in robot.urdf.link_by_name:
            allowed = f"a link of {robot.name}: {listing(sorted(robot.urdf.link_by_name))}"
            faults.append(Fault(source, key, f"the unknown link {point.link!r}", allowed))
        elif point.link not in moved and _is_used(campaign, point.id):
            found = f"a point on {point.link}, which no flexible joint of {robot.name} moves"
            faults.append(Fault(source, key, found, f"a point on {listing(sorted(moved))}"))
    return faults


def _is_used(campaign: Campaign, point: int) -> bool:
    """Whether any record is of that point."""
    places: list[int] = []
    if campaign.frfs is not None:
        places += [*campaign.frfs.response[:, 0].tolist(), *campaign.frfs.reference[:, 0].tolist()]
    for blow in campaign.blows:
        places += [blow.reference[0], *(number for number, _ in blow.channels)]
    if campaign.modes is not None:
        places += [*campaign.modes.response.tolist(), *campaign.modes.reference.tolist()]
    return point in places


def placed_on(campaign: Campaign, robot: Robot) -> tuple[Campaign, tuple[str, ...]]:
    """The campaign with points on links that the robot lacks put where its card has a point of that name.

    A campaign names links of one card; a card with fewer links, the same arm without a pseudo-joint, say,
    keeps its points under the same names elsewhere.

    Args:
        campaign: what was measured.
        robot: with points of its card.

    Returns:
        The campaign, and a sentence for each point that was moved.
    """
    points, said = [], []
    for point in campaign.points:
        known = robot.points.get(point.name)
        if point.link in robot.urdf.link_by_name or known is None:
            points.append(point)
            continue
        x, y, z = (float(value) for value in known.xyz)
        points.append(replace(point, link=known.link, xyz=(x, y, z)))
        said.append(
            f"{point.name} sits on {point.link!r}, which {robot.name} does not have; "
            f"its card has a point of that name on {known.link!r}, which was taken"
            + (", with the axes of that link" if point.frame == "link" else "")
        )
    return (replace(campaign, points=tuple(points)) if said else campaign), tuple(said)

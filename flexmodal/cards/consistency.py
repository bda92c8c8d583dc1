"""Whether a card belongs to its URDF."""

from __future__ import annotations

from collections.abc import Mapping

from flexmodal.cards.card import FamilyCard, RobotCard
from flexmodal.cards.mass import massless_joints
from flexmodal.cards.urdf.urdf import Urdf
from flexmodal.errors import InvalidCard
from flexmodal.text.words import FaultList, listing, nearest

TOLERANCE = 1e-6
"""What a posture may exceed a limit by [rad, or m]: the rounding of printed angles."""


def check_consistency(card: RobotCard, urdf: Urdf) -> None:
    """Check that the names of a card exist in its URDF and its postures lie within the limits.

    Args:
        card: a card that is sound in itself.
        urdf: its URDF.

    Raises:
        InvalidCard: with every fault at once; those of masses name the URDF as their file.
    """
    faults = FaultList(card.path)
    _check_joints(card, urdf, faults)
    _check_links(card, urdf, faults)
    for name, posture in card.postures.items():
        _check_posture(f"posture.{name}", posture, card, urdf, faults)
    for name, family in card.families.items():
        _check_family(f"family.{name}", family, card, urdf, faults)
    faults.faults.extend(massless_joints(urdf, list(card.joints)))
    if faults.faults:
        raise InvalidCard(faults.faults)


def _check_joints(card: RobotCard, urdf: Urdf, faults: FaultList) -> None:
    for name, joint in card.joints.items():
        if _is_movable(name, f"joint.{name}", urdf, faults) and joint.pseudo:
            described = urdf.joint_by_name[name]
            if not described.lower <= 0 <= described.upper:
                limits = f"{described.lower:g} to {described.upper:g}"
                found = f"a pseudo-joint, which rests at 0, with limits {limits}"
                faults.add(f"joint.{name}.pseudo", found, "limits in the URDF that contain 0")


def _is_movable(name: str, key: str, urdf: Urdf, faults: FaultList) -> bool:
    """Whether the URDF has a movable joint of that name; a fault where it has not."""
    names = urdf.movable_joints
    if name in names:
        return True
    allowed = f"{nearest(name, names)}the movable joints of {urdf.path.name} are {listing(names)}"
    if name in urdf.joint_by_name:
        faults.add(key, f'"{name}", a fixed joint', allowed)
    else:
        faults.add(key, f'"{name}", a joint that the URDF does not have', allowed)
    return False


def _check_links(card: RobotCard, urdf: Urdf, faults: FaultList) -> None:
    places = {"tool": card.tool} | {f"point.{name}.link": point.link for name, point in card.points.items()}
    places |= {f"obstacle.{name}.link": one.link for name, one in card.obstacles.items() if one.link}
    for key, link in places.items():
        if link not in urdf.link_by_name:
            names = urdf.link_by_name
            allowed = f"{nearest(link, names)}the links of {urdf.path.name} are {listing(names)}"
            faults.add(key, f'"{link}", a link that the URDF does not have', allowed)
    for name, point in card.points.items():
        if name in urdf.link_by_name and (point.link != name or any(point.xyz)):
            found = "the name of a link of the URDF, for another place"
            faults.add(f"point.{name}", found, "a name that no link has: both are asked for by name")


def _is_commanded(name: str, key: str, card: RobotCard, urdf: Urdf, faults: FaultList) -> bool:
    """Whether a posture may set this joint; a fault where it may not."""
    if name in card.pseudo_joints:
        faults.add(key, "a pseudo-joint, which rests at 0", f"commanded joints: {_commanded(card, urdf)}")
        return False
    return _is_movable(name, key, urdf, faults)


def _commanded(card: RobotCard, urdf: Urdf) -> str:
    return listing(name for name in urdf.movable_joints if name not in card.pseudo_joints)


def _check_posture(
    key: str, posture: Mapping[str, float], card: RobotCard, urdf: Urdf, faults: FaultList
) -> None:
    for name, angle in posture.items():
        if _is_commanded(name, f"{key}.{name}", card, urdf, faults):
            _check_angle(angle, f"{angle:.9g}", f"{key}.{name}", name, urdf, faults)
    for name in urdf.movable_joints:
        if name not in posture and name not in card.pseudo_joints:
            _check_angle(0.0, "nothing, which means 0", f"{key}.{name}", name, urdf, faults)


def _check_angle(angle: float, found: str, key: str, joint: str, urdf: Urdf, faults: FaultList) -> None:
    lower, upper = urdf.joint_by_name[joint].lower, urdf.joint_by_name[joint].upper
    if not lower - TOLERANCE <= angle <= upper + TOLERANCE:
        faults.add(key, found, f"{lower:.9g} to {upper:.9g}, the limits of {joint} in {urdf.path.name}")


def _check_family(key: str, family: FamilyCard, card: RobotCard, urdf: Urdf, faults: FaultList) -> None:
    """The ends of the sweep are enough: every joint moves in proportion to the parameter."""
    ends = {"from": family.start, "to": family.stop}
    if _is_commanded(family.parameter, f"{key}.parameter", card, urdf, faults):
        for end, angle in ends.items():
            _check_angle(angle, f"{angle:.9g}", f"{key}.{end}", family.parameter, urdf, faults)
    for name, factor in family.follow.items():
        if not _is_commanded(name, f"{key}.follow.{name}", card, urdf, faults):
            continue
        for end, angle in ends.items():
            found = f"{factor:g}, which puts {name} at {factor * angle:.9g} at the end {end!r}"
            _check_angle(factor * angle, found, f"{key}.follow.{name}", name, urdf, faults)
    for name in urdf.movable_joints:
        if name not in {family.parameter, *family.follow, *card.pseudo_joints}:
            _check_angle(0.0, f"{name} left out, which means 0", f"{key}.follow", name, urdf, faults)

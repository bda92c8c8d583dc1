"""Whether every flexible joint carries mass."""

from __future__ import annotations

from collections.abc import Collection

from flexmodal.cards.urdf.urdf import Urdf
from flexmodal.errors import Fault, InvalidUrdf


def massless_joints(urdf: Urdf, flexible: Collection[str]) -> tuple[Fault, ...]:
    """Faults for the flexible joints that carry no mass.

    A joint carries its child link and whatever is rigidly joined to that: through fixed joints, and
    through movable joints that are not flexible, which only move with the posture. Without mass there
    the mass matrix is not that of a body, and its eigenvalues mean nothing.

    Args:
        urdf: the robot.
        flexible: names of its flexible joints; other names are left out.

    Returns:
        One fault for each such joint, naming the link whose mass is missing.
    """
    faults = []
    for name in flexible:
        joint = urdf.joint_by_name.get(name)
        if joint is None or not joint.movable:
            continue
        body = _rigid_body(urdf, joint.child, flexible)
        if sum(urdf.link_by_name[link].mass or 0.0 for link in body) > 0:
            continue
        mass = urdf.link_by_name[joint.child].mass
        found = "no <inertial>" if mass is None else f"mass {mass:g}"
        rest = f", nor has any link fixed to it ({', '.join(body[1:])})" if len(body) > 1 else ""
        faults.append(
            Fault(
                str(urdf.path),
                f"link.{joint.child}.inertial",
                f"link {joint.child} has {found}{rest}",
                f"a mass above 0, since the flexible joint {name} carries it",
            )
        )
    return tuple(faults)


def check_masses(urdf: Urdf, flexible: Collection[str]) -> None:
    """Check that every flexible joint carries mass; for a URDF without a card.

    Args:
        urdf: the robot.
        flexible: names of its flexible joints.

    Raises:
        InvalidUrdf: with the faults of `massless_joints`.
    """
    faults = massless_joints(urdf, flexible)
    if faults:
        raise InvalidUrdf(faults)


def _rigid_body(urdf: Urdf, link: str, flexible: Collection[str]) -> list[str]:
    """The link and all links that move with it when only flexible joints deflect."""
    body = [link]
    for member in body:
        for joint in urdf.joints:
            if joint.parent == member and joint.name not in flexible:
                body.append(joint.child)
    return body

"""Which link of a URDF is the end-effector, where nobody has said it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from flexmodal.cards.urdf.urdf import Urdf

_NAMES = (
    r"(.*_)?tool",
    r"(.*_)?(tcp|tool_?cent(er|re)_?point)",
    r"(.*_)?(ee|eef|ee_link|link_ee|link_eef|end_?effector(_link)?)",
    r"(.*_)?tool_?0",
    r"(.*_)?(gripper_)?(tip|frame)(_link)?",
    r"(.*_)?flange(_link)?",
)
"""What end-effectors are called, the surest first; tool0 and flange are ROS-Industrial's."""


@dataclass(frozen=True)
class FoundTool:
    """The link that is taken for the end-effector."""

    link: str
    how: str
    """Why that one, for people."""
    sure: bool
    """Whether its name says so, or no other link could be meant."""
    others: tuple[str, ...]
    """Links that carry no other, and may be meant instead."""


def find_tool(urdf: Urdf) -> FoundTool:
    """The end-effector by its name, or else the link after the longest chain of joints.

    Only links that a joint moves are looked at. Of several by one name the one farthest from the base.

    Args:
        urdf: the root is answered where no joint moves.
    """
    depth = _depths(urdf)
    if not depth:  # whoever loads it says so
        return FoundTool(urdf.root, "no joint moves", True, ())
    carriers = {joint.parent for joint in urdf.joints}
    ends = tuple(link for link in depth if link not in carriers)
    for pattern in _NAMES:
        found = [link for link in depth if re.fullmatch(pattern, link, re.IGNORECASE)]
        if found:
            link = max(found, key=depth.__getitem__)
            return FoundTool(link, "by its name", True, tuple(one for one in ends if one != link))
    link = max(ends, key=depth.__getitem__)
    others = tuple(one for one in ends if one != link)
    how = "after the longest chain of joints" if others else "the only link that carries no other"
    return FoundTool(link, how, not others, others)


def _depths(urdf: Urdf) -> dict[str, int]:
    """Joints between the base and each link that a joint moves, in the order of the file."""
    above = {joint.child: joint for joint in urdf.joints}
    found = {}
    for link in urdf.links:
        count, moves, name = 0, False, link.name
        while name in above:
            moves = moves or above[name].movable
            name, count = above[name].parent, count + 1
        if moves:
            found[link.name] = count
    return found

"""Places that give nearly alike: a foundation and the bearing of the first joint, a link and its bearings.

The function of one is free in every line and takes up most of what the other does, so that a look that has
come to the noise at one of them need not have tried the other. A law of one does not pass for the other's.
A foundation's functions do what the joints on it and the links that these carry do, as they turn with them.
And what two joints' coupling holds: its functions do all that sits in either of them, or on what they alone
move.
"""

from __future__ import annotations

from collections.abc import Sequence

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.lawfree.effects_at import PORT_OF
from flexmodal.structure.arm import beyond

_BASE = ("base", "base")


def adjacent(context: Context, port: str, where: str) -> frozenset[tuple[str, str]]:
    """Kinds and places of the elastic ports that touch another one.

    Args:
        context: of the diagnosis.
        port: kind of the other one.
        where: its place.
    """
    touching = [pair for joint in context.joints for pair in _at(context, joint)]
    here = (port, where)
    return frozenset(one for pair in touching if here in pair for one in pair if one != here)


def within(context: Context, keys: Sequence[tuple[str, str]], port: str, where: str) -> bool:
    """Whether effects sit in the joints of a coupling, or on bodies that nothing else moves.

    A torque that such a function holds does not change with the force of the blow: what rubs sticks.

    Args:
        context: of the diagnosis.
        keys: names and places of the effects.
        port: kind of a port; none but a coupling's holds others.
        where: its place.
    """
    return port == "coupling" and all(
        PORT_OF.get(name) in ("joint", "torque", "body")
        and set(_moving(context, place)) <= set(where.split("+"))
        for name, place in keys
    )


def between(context: Context, where: str) -> frozenset[tuple[str, str]]:
    """Kind and place of the port of the link that the joints of a coupling hold between them, if they do.

    Args:
        context: of the diagnosis.
        where: place of the coupling.
    """
    ends = [{key for pair in _at(context, joint) for key in pair} for joint in where.split("+")]
    return frozenset(key for key in set.intersection(*ends) if key[0] == "link")


def on_base(context: Context) -> frozenset[tuple[str, str]]:
    """Kinds and places of ports in the joints that stand on the base, and of the links that these carry.

    Args:
        context: of the diagnosis.
    """
    standing = [joint for joint in context.joints if any(_BASE in pair for pair in _at(context, joint))]
    kinds = ("bearing", "joint", "torque")
    carried = [("link", context.robot.urdf.joint_by_name[joint].child) for joint in standing]
    return frozenset([*((kind, joint) for kind in kinds for joint in standing), *carried])


def _moving(context: Context, place: str) -> list[str]:
    """A joint, or the joints that move a link."""
    urdf = context.robot.urdf
    if place in context.joints:
        return [place]
    return [joint for joint in context.joints if place in beyond(urdf, urdf.joint_by_name[joint].child)]


def _at(context: Context, joint: str) -> list[tuple[tuple[str, str], tuple[str, str]]]:
    """A joint's bearing and what it sits on, and it and what it carries."""
    urdf, bearing = context.robot.urdf, ("bearing", joint)
    described = urdf.joint_by_name[joint]
    holding = [link for link in context.links if described.parent in beyond(urdf, link)]
    below = min(holding, key=lambda link: len(beyond(urdf, link)), default=None)
    return [(bearing, _BASE if below is None else ("link", below)), (bearing, ("link", described.child))]

"""The parameters of a robot, with bounds and priors from its card."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.structure import shape
from flexmodal.structure.arm import moved_bodies
from flexmodal.structure.parameter import Parameter, ParameterSpace

KINDS = ("stiffness", "damping", "mass", "inertia")
"""What a fit changes unless told otherwise."""
TRUST = {"stiffness": 0.3, "damping": 0.5, "mass": 0.08, "inertia": 0.08}
"""Standard deviation of ln(true / card) where the card gives no `scale`: masses come from drawings."""
WIDEST = {"stiffness": 30.0, "damping": 100.0, "mass": 3.0, "inertia": 3.0}
"""Factor by which a parameter may differ from the card where that gives no bounds."""
_UNITS = {
    ("stiffness", False): "N·m/rad",
    ("stiffness", True): "N/m",
    ("damping", False): "N·m·s/rad",
    ("damping", True): "N·s/m",
}


def robot_space(
    robot: Robot, kinds: Sequence[str] = KINDS, *, trust: Mapping[str, float] | None = None
) -> ParameterSpace:
    """Stiffness and damping of each flexible joint, mass and relative inertia of each link it moves.

    Args:
        robot: from its card come the values, bounds (`lower`, `upper`) and trust (`scale`) of each joint, and
            that of masses and inertias (`tolerance`).
        kinds: some of `KINDS` and of those of shape, see `shape_parameters`. `mass.LINK` [kg] takes the
            link's inertia with it; `inertia.LINK` is the factor on the moments about the mass centre besides,
            so that any value above 0 is a body there can be.
        trust: standard deviation of ln(true / card) by kind or by name, over those of the card; of position
            and payload that of the value itself.

    Raises:
        InvalidRequest: an unknown kind or name, one that the robot has none of, a deviation that is not above
            0, a card with loss factors.
    """
    given = {**robot.tolerance, **(trust or {})}
    if robot.hysteresis is not None:
        allowed = "joints without; a fit finds hysteresis itself, as structural damping"
        raise InvalidRequest(Fault(robot.name, "joint: loss_factor", "joints with a loss factor", allowed))
    known = (*KINDS, *shape.KINDS)
    unknown = [kind for kind in kinds if kind not in known]
    if unknown or not kinds:
        found = ", ".join(map(repr, unknown)) or "nothing"
        raise InvalidRequest(Fault("call", "kinds", found, f"some of {', '.join(known)}"))
    parts = {kind: _of_kind(robot, kind) for kind in kinds}
    if none := [kind for kind in shape.KINDS if kind in parts and not parts[kind]]:
        allowed = f"kinds that {robot.name} has something of"
        raise InvalidRequest(
            [Fault("call", "kinds", f"{kind!r}, of which there is none", allowed) for kind in none]
        )
    parameters = [parameter for part in parts.values() for parameter in part]
    space = ParameterSpace(tuple(parameters))
    sorts = tuple(dict.fromkeys((*KINDS, *kinds)))
    odd = [key for key in given if key not in space.index and key not in sorts]
    if odd:
        allowed = f"a kind ({', '.join(sorts)}) or a parameter: {', '.join(space.names)}"
        raise InvalidRequest([Fault("call", "trust", repr(key), allowed) for key in odd])
    return space.trusting(given)


def _of_kind(robot: Robot, kind: str) -> list[Parameter]:
    if kind in shape.KINDS:
        return shape.shape_parameters(robot, kind)
    return _of_joints(robot, kind) if kind in ("stiffness", "damping") else _of_links(robot, kind)


def _of_joints(robot: Robot, kind: str) -> list[Parameter]:
    found = []
    for name, joint in robot.joints.items():
        card = float(getattr(joint, kind))
        if card <= 0:  # an undamped joint: no logarithm, no scale to go by; its damping stays 0
            continue
        wide = WIDEST[kind]
        found.append(
            Parameter(
                name=f"{kind}.{name}",
                unit=_UNITS[kind, robot.urdf.joint_by_name[name].is_prismatic],
                card=card,
                deviation=TRUST[kind] if joint.scale is None else joint.scale,
                lower=card * (1 / wide if joint.lower is None else max(joint.lower, 1e-6)),
                upper=card * (wide if joint.upper is None else joint.upper),
            )
        )
    return found


def _of_links(robot: Robot, kind: str) -> list[Parameter]:
    found = []
    for name in moved_bodies(robot):
        link = robot.urdf.link_by_name[name]
        if kind == "inertia" and (link.inertia is None or not np.any(link.inertia)):
            continue
        card, wide = (float(link.mass or 0.0), WIDEST[kind]) if kind == "mass" else (1.0, WIDEST[kind])
        unit = "kg" if kind == "mass" else ""
        found.append(Parameter(f"{kind}.{name}", unit, card, TRUST[kind], card / wide, card * wide))
    return found

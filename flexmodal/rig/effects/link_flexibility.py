"""A link bends: a uniform beam by finite elements, where the card has a rigid body."""

from __future__ import annotations

import numpy as np

from flexmodal.rig.believed import Body
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, each, positive, within
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import Beam, sections
from flexmodal.rig.plant.chain import reach, slender_links
from flexmodal.rig.plant.geometry import across

_FIRST = 1.875104068711961
"""First root of cos βL cosh βL = −1, for the clamped-free beam."""


def span(site_link: str, stand: Stand) -> tuple[float, np.ndarray]:
    """Length of a link [m] and the unit vector along it, in its frame.

    Args:
        site_link: which.
        stand: the true robot and its plan.
    """
    end = reach(stand.robot, site_link)
    length = float(np.linalg.norm(end))
    return length, end / length


def spread(
    body: Body, length: float, axis: np.ndarray, normal: np.ndarray | None = None
) -> tuple[float, Body]:
    """Split a link's inertia into a uniform beam and a rest, so that the rigid link keeps all of it.

    Args:
        body: mass properties of the link.
        length: of the beam [m].
        axis: unit vector along it, in the frame of the link.
        normal: of the plane that it moves in, likewise, if it moves in one; nothing turns about another axis.

    Returns:
        Mass of the beam, as much as leaves the rest with a moment of inertia a body can have, and the rest.
    """
    thin = np.eye(3) - np.outer(axis, axis)
    for share in np.linspace(1.0, 0.0, 41):
        beam = share * body.mass
        rest = body.mass - beam
        if rest < 1e-9 * body.mass:
            off = np.linalg.norm(body.com - length / 2 * axis) > 1e-6 * length
            rest, com = 0.0, length / 2 * axis
            if off:
                continue
        else:
            com = (body.mass * body.com - beam * length / 2 * axis) / rest
        total = body.inertia + body.mass * _about(body.com)
        left = total - beam * (length**2 / 12 * thin + _about(length / 2 * axis)) - rest * _about(com)
        if _is_a_body(left, normal, 1e-12 * np.trace(total)) and 0 <= com @ axis <= length:
            return float(beam), Body(float(rest), com, left)
    return 0.0, body


def plane_in(assembly: PlantAssembly, link: str) -> np.ndarray | None:
    """Normal of the plane of an arm in the frame of a link; None in space.

    Args:
        assembly: the plant in the making.
        link: whose frame.
    """
    return None if assembly.normal is None else assembly.orientation(link).T @ assembly.normal


def _is_a_body(inertia: np.ndarray, normal: np.ndarray | None, rounding: float) -> bool:
    """Whether a body can have an inertia: no second moment of its mass, along and not about, is below 0."""
    if normal is not None:
        return bool(normal @ inertia @ normal >= -rounding)
    second = np.trace(inertia) / 2 * np.eye(3) - inertia
    return bool(np.linalg.eigvalsh(second)[0] >= -rounding)


def _about(lever: np.ndarray) -> np.ndarray:
    return float(lever @ lever) * np.eye(3) - np.outer(lever, lever)


def _draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """EI/L half to one and a half times the stiffest joint between this link and the base."""
    length, _ = span(where, stand)
    stiffest = max(stand.true.stiffness[name] for name in stand.robot.joints if where in _beyond(stand, name))
    return {
        "bending_stiffness": float(random.uniform(0.5, 1.5) * stiffest * length),
        "damping_ratio": float(random.uniform(0.005, 0.02)),
    }


def _beyond(stand: Stand, joint: str) -> tuple[str, ...]:
    from flexmodal.structure.arm import beyond

    return beyond(stand.robot.urdf, stand.robot.urdf.joint_by_name[joint].child)


def _shape(assembly: PlantAssembly, site: Site) -> None:
    length, axis = span(site.where, site.stand)
    normal = plane_in(assembly, site.where)
    mass, _ = spread(site.stand.true.bodies[site.where], length, axis, normal)
    beam = Beam(length, site["bending_stiffness"], mass / length)
    weight = max(site.stand.true.bodies[site.where].mass, 1e-9) / length
    first = _FIRST**2 * np.sqrt(site["bending_stiffness"] / (weight * length**4))  # rad/s, clamped and free
    loss = 2 * site["damping_ratio"] / first
    for side in across(axis, normal):
        assembly.add_flexure(site.where, beam, axis, side, loss)


def body(assembly: PlantAssembly, site: Site) -> bool:
    """The beam's own mass and the rest's moment along its length, the rest's mass at its centre.

    Args:
        assembly: the plant in the making.
        site: the link.
    """
    length, axis = span(site.where, site.stand)
    normal = plane_in(assembly, site.where)
    mass, rest = spread(site.stand.true.bodies[site.where], length, axis, normal)
    for place, weight in zip(*sections(), strict=True):
        assembly.add_body(
            site.where, place * length * axis, float(mass * weight), rest.inertia * float(weight)
        )
    assembly.add_body(site.where, rest.com, rest.mass)
    return True


EFFECT = Effect(
    name="link_flexibility",
    says="the link bends as a uniform Euler-Bernoulli beam",
    units={"bending_stiffness": "N·m²", "damping_ratio": "of the first clamped mode"},
    places=lambda robot, points: slender_links(robot),
    place_is="a link that is long enough to bend",
    draw=_draw,
    scaled=divided("bending_stiffness"),
    check=each(positive("bending_stiffness"), within(damping_ratio=(0.0, 1.0))),
    shape=_shape,
    body=body,
)

"""What a robot itself puts into a structure: bodies, springs, dampers, rotors, couplings of its card."""

from __future__ import annotations

from collections.abc import Mapping

from flexmodal.structure.arm import Body
from flexmodal.structure.assembly import Assembly
from flexmodal.structure.fixtures import add_fixtures


def put_together(assembly: Assembly, values: Mapping[str, float], bodies: Mapping[str, Body]) -> None:
    """Every body, spring, damper, rotor and coupling of the robot, at these parameter values; fixtures too.

    Args:
        assembly: with all motions added.
        values: `stiffness.JOINT`, `damping.JOINT`, `mass.LINK`, `inertia.LINK` (moments about the mass
            centre over those the card's shape would have at that mass); what is missing is as the card says.
        bodies: as the card says; links that are left out are put in by somebody else.
    """
    for link, body in bodies.items():
        assembly.add_body(link, scaled(body, link, values), mass=f"mass.{link}", inertia=f"inertia.{link}")
    for name, joint in assembly.robot.joints.items():
        row = assembly.stretch_of(name)
        assembly.add_spring(row, values.get(f"stiffness.{name}", joint.stiffness), f"stiffness.{name}")
        assembly.add_damper(row, values.get(f"damping.{name}", joint.damping), f"damping.{name}")
        if joint.rotor_inertia:
            assembly.add_inertia(assembly.row(name), joint.rotor_inertia)
    for coupling in assembly.robot.couplings.values():
        one, other = (assembly.stretch_of(name) for name in coupling.joints)
        assembly.add_coupling(one, other, coupling.stiffness)
    add_fixtures(assembly)


def scaled(body: Body, link: str, values: Mapping[str, float]) -> Body:
    """A body at the parameters' mass and inertia.

    Args:
        body: as the card has it.
        link: name of its link.
        values: of parameters by name; the mass [kg] and the factor on the inertia stay where they are not
            named.
    """
    mass = values.get(f"mass.{link}", body.mass)
    grown = mass / body.mass * values.get(f"inertia.{link}", 1.0)
    return Body(mass, body.centre, body.inertia * grown)

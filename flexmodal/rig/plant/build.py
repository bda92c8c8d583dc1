"""From a test plan and what is hidden to the plant of one posture and its sensors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmodal.campaign import CampaignPosture
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.rig.effects import EFFECTS, Effect, Site, Stand
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.card_springs import add_card_springs
from flexmodal.rig.plant.plant import Plant
from flexmodal.rig.sensing import Sensor

LOCK = 2e3
"""Stiffness of a lock over that of the joint: a clamp gives a little."""
Hidden = tuple[Effect, Site]
"""An effect in one of its forms, and its site."""


def sensors(
    stand: Stand, hidden: Sequence[Hidden], posture: CampaignPosture | None = None
) -> dict[str, Sensor]:
    """The sensor on each point, spoilt as hidden.

    Args:
        stand: the true robot and its plan.
        hidden: effects put in.
        posture: in which they measure, of the plan; without one, before the first.
    """
    made = {point.name: Sensor() for point in stand.plan.points}
    for effect, site in hidden:
        if effect.sense is not None:
            effect.sense(made, site)
    if posture is not None:
        number = next(k for k, one in enumerate(stand.plan.postures) if one.id == posture.id)
        for sensor in made.values():
            for change in sensor.later:
                change(sensor, number)
    return made


def build(
    stand: Stand,
    posture: CampaignPosture,
    hidden: Sequence[Hidden],
    carrying: tuple[str, Sensor] | None = None,
) -> Plant:
    """The plant in one posture.

    Args:
        stand: robot, true parameters and plan.
        posture: where it stands.
        hidden: what is put in.
        carrying: name of the point with the sensor on it, and the sensor.

    Raises:
        InvalidPosture: see `Robot.at`.
        InvalidRequest: what is drawn and hidden is more than the robot's own couplings hold.
    """
    assembly = PlantAssembly(stand.robot.at(dict(posture.q)))
    ordered = sorted(hidden, key=lambda item: list(EFFECTS).index(item[0].name))
    for effect, site in ordered:
        if effect.shape is not None:
            effect.shape(assembly, site)
    done = {site.where for effect, site in ordered if effect.body and effect.body(assembly, site)}
    for link, body in stand.true.bodies.items():
        if link not in done:
            assembly.add_body(link, body.com, body.mass, body.inertia)
    for joint in stand.robot.joints:
        stretch = assembly.stretch(joint)
        assembly.add_spring(stretch, stand.true.stiffness[joint], stand.true.damping[joint])
        assembly.add_inertia(assembly.row(joint), stand.true.rotor.get(joint, 0.0))
    for effect, site in ordered:
        if effect.act is not None:
            effect.act(assembly, site)
    _add_fixtures(assembly, stand, posture)
    add_card_springs(assembly, stand.robot, stand.true, stand.plan)
    if carrying is not None:
        carrying[1].load(assembly, next(p for p in stand.plan.points if p.name == carrying[0]))
    plant = assembly.plant()
    _check_holds(plant, stand)
    return plant


def _add_fixtures(assembly: PlantAssembly, stand: Stand, posture: CampaignPosture) -> None:
    """Locks from link to link, and masses at points, as the posture was asked for."""
    for joint in posture.locked:
        assembly.add_spring(assembly.row(joint), LOCK * stand.true.stiffness[joint])
    for name, mass in posture.masses.items():
        point = next(one for one in stand.plan.points if one.name == name)
        assembly.add_body(point.link, np.array(point.xyz), mass)


def _check_holds(plant: Plant, stand: Stand) -> None:
    """With couplings, the springs must still hold together, whatever was drawn and hidden beside them."""
    if stand.robot.couplings and np.linalg.eigvalsh(plant.stiffness)[0] <= 0:
        found = "springs that with what is drawn and hidden push instead of holding"
        names = ", ".join(stand.robot.couplings)
        allowed = f"a smaller coupling of {names}, a smaller parameter_error, or nothing hidden there"
        raise InvalidRequest(Fault("call", "robot: coupling", found, allowed))

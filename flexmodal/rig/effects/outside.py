"""Effects that no catalogue names: a diagnosis has to say that it does not know them."""

from __future__ import annotations

import numpy as np

from flexmodal.model import Robot
from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, divided, multiplied, positive
from flexmodal.rig.effects.sensors import points_that_move
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import commanded_joints, reach
from flexmodal.rig.plant.plant import BACKLASH, NonlinearElement
from flexmodal.rig.sensing import Sensor
from flexmodal.structure.arm import beyond, moved_bodies


def _draw_clearance(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """Gravity presses the teeth together; a hard blow lifts them."""
    low, high = stand.deflection[where]
    return {
        "gap": float(random.uniform(0.3, 1.0) * high),
        "preload": float(random.uniform(0.2, 0.5) * np.sqrt(low * high)),
    }


def _clear(assembly: PlantAssembly, site: Site) -> None:
    k = site.stand.true.stiffness[site.where]
    law = (k, site["gap"], k * site["preload"])
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), BACKLASH, law))


CLEARANCE = Effect(
    name="clearance",
    says="play in a joint: no torque inside the gap",
    units={"gap": "rad", "preload": "rad, deflection under gravity that keeps the contact shut"},
    places=lambda robot, points: commanded_joints(robot),
    place_is="a flexible joint",
    draw=_draw_clearance,
    scaled=multiplied("gap"),
    check=positive("gap", "preload"),
    act=_clear,
    linear=False,
    catalogued=False,
)


def _hose_links(robot: Robot) -> tuple[str, ...]:
    """Links that at least two joints move."""
    counts = {
        link: sum(link in beyond(robot.urdf, robot.urdf.joint_by_name[j].child) for j in robot.joints)
        for link in moved_bodies(robot)
    }
    return tuple(link for link, count in counts.items() if count >= 2) or moved_bodies(robot)


def _draw_hose(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    length = sum(float(np.linalg.norm(reach(stand.robot, link))) for link in moved_bodies(stand.robot))
    k = max(stand.true.stiffness.values())
    slack = random.uniform(0.3, 0.7) * length
    return {
        "stiffness": float(random.uniform(0.5, 2.0) * k / length**2),
        "damping": float(random.uniform(0.0005, 0.002) * k / length**2),
        "slack": float(slack),
        "x": float(random.uniform(-0.3, 0.3) * length),
        "y": 0.0,
        "z": float(random.uniform(0.0, 0.4) * length),
    }


def _hose(assembly: PlantAssembly, site: Site) -> None:
    """From a hook in the world to the end of a link; stiffer the farther it is stretched."""
    end = reach(site.stand.robot, site.where)
    at = assembly.origin(site.where) + assembly.orientation(site.where) @ end
    line = at - site.vector("x", "y", "z")
    length = float(np.linalg.norm(line))
    stretch = max(length / site["slack"] - 0.5, 0.0) ** 2
    row = (line / max(length, 1e-9)) @ assembly.motion(site.where, end)[:3]
    assembly.add_spring(row, site["stiffness"] * stretch, site["damping"] * stretch)


HOSE = Effect(
    name="hose",
    says="a hose to a link, stiffer the farther the posture stretches it",
    units={
        "stiffness": "N/m",
        "damping": "N·s/m",
        "slack": "m",
        "x": "m",
        "y": "m",
        "z": "m, hook in the world",
    },
    places=lambda robot, points: _hose_links(robot),
    place_is="a link that moves",
    draw=_draw_hose,
    scaled=multiplied("stiffness", "damping"),
    check=positive("stiffness", "slack"),
    act=_hose,
    catalogued=False,
)


def _clip(sensors: dict[str, Sensor], site: Site) -> None:
    sensors[site.where].range = site["range"]


SATURATION = Effect(
    name="saturation",
    says="a sensor that clips what exceeds its range",
    units={"range": "m/s²"},
    places=points_that_move,
    place_is="a point with a sensor",
    draw=lambda stand, where, random: {"range": float(random.uniform(0.3, 0.7) * stand.acceleration[where])},
    scaled=divided("range"),
    check=positive("range"),
    sense=_clip,
    linear=False,
    catalogued=False,
)


def _draw_neighbour(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    mass = stand.mass
    low, high = stand.plan.band
    return {
        "floor_stiffness": float(3 * mass * (2 * np.pi * random.uniform(20, 50)) ** 2),
        "floor_mass": float(random.uniform(2, 5) * mass),
        "mass": float(random.uniform(2, 6) * mass),
        "frequency": float(np.exp(random.uniform(np.log(max(3 * low, 0.04 * high)), np.log(0.4 * high)))),
        "damping_ratio": float(random.uniform(0.01, 0.04)),
    }


def _shape_neighbour(assembly: PlantAssembly, site: Site) -> None:
    _, motion = base_directions(assembly.normal)
    upright = motion[:, [int(np.argmax(np.abs(motion[2])))]]
    assembly.add_root_motion(assembly.add_coordinates(["floor"]), upright)
    assembly.add_coordinates(["neighbour"])


def _neighbour(assembly: PlantAssembly, site: Site) -> None:
    floor, other = assembly.row("floor"), assembly.row("neighbour")
    loss, k = site["damping_ratio"], site["mass"] * (2 * np.pi * site["frequency"]) ** 2
    damper = 2 * loss * float(np.sqrt(site["floor_stiffness"] * site["floor_mass"]))
    assembly.add_inertia(floor, site["floor_mass"])
    assembly.add_spring(floor, site["floor_stiffness"], damper)
    assembly.add_inertia(other, site["mass"])
    assembly.add_spring(other - floor, k, 2 * loss * float(np.sqrt(k * site["mass"])))


def _scale_neighbour(parameters: Parameters, s: float) -> dict[str, float]:
    return divided("floor_stiffness", "floor_mass")(parameters, s)


NEIGHBOUR = Effect(
    name="neighbour",
    says="another machine, felt through the floor",
    units={
        "floor_stiffness": "N/m",
        "floor_mass": "kg",
        "mass": "kg",
        "frequency": "Hz",
        "damping_ratio": "",
    },
    places=lambda robot, points: ("base",),
    place_is="the base",
    draw=_draw_neighbour,
    scaled=_scale_neighbour,
    most=lambda parameters: 100.0,
    check=positive("floor_stiffness", "floor_mass", "mass", "frequency"),
    shape=_shape_neighbour,
    act=_neighbour,
    catalogued=False,
)

"""Other ways for the sensor that goes from point to point to weigh on what it measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodal.campaign import CampaignPoint
from flexmodal.rig.effects.effect import Effect, Site, Stand, drawing, multiplied, positive
from flexmodal.rig.effects.sensors import SENSOR_MASS as OWN
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.chain import heading
from flexmodal.rig.plant.geometry import across
from flexmodal.rig.plant.plant import Branch
from flexmodal.rig.sensing import Sensor


def everywhere(
    load: Callable[[PlantAssembly, CampaignPoint, Site], None],
) -> Callable[[dict[str, Sensor], Site], None]:
    """The same load on whatever point carries the sensor."""

    def sense(sensors: dict[str, Sensor], site: Site) -> None:
        for sensor in sensors.values():
            sensor.loads.append(lambda assembly, point: load(assembly, point, site))

    return sense


def _outward(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> np.ndarray:
    """Away from the axis of the link, in the plane of a planar chain; in the frame of the link."""
    axis = heading(site.stand.robot, point.link)
    axes = assembly.orientation(point.link)
    sides = across(axis, None if assembly.normal is None else axes.T @ assembly.normal)
    return sides[0] if sides else across(axis, None)[0]


def _block(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """A cube of that height on the surface: its centre half of it away."""
    place = np.array(point.xyz) + site["height"] / 2 * _outward(assembly, point, site)
    inertia = site["mass"] * site["height"] ** 2 / 6 * np.eye(3)
    assembly.add_body(point.link, place, site["mass"], inertia)


def _cable(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """A part of the mass is the cable's, taped to the link at its origin."""
    assembly.add_body(point.link, np.array(point.xyz), site["mass"] * (1 - site["share"]))
    assembly.add_body(point.link, np.zeros(3), site["mass"] * site["share"])


_SWINGS = ("mass", "frequency", "damping_ratio")


def _sprung(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The mass sits on its mount's springs, equal each way; what is measured moves with the surface."""
    carried = assembly.motion(point.link, np.array(point.xyz))[:3]
    names = [f"sensor {axis}" for axis in "xyz"]
    assembly.add_on_springs(names, carried, *(site[name] for name in _SWINGS))


def _bracket(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The mass is off the surface on a bracket that bends both ways; along itself the bracket is stiff."""
    out = _outward(assembly, point, site)
    axes = assembly.orientation(point.link)
    carried = assembly.motion(point.link, np.array(point.xyz) + site["height"] * out)[:3]
    assembly.add_inertia((axes @ out) @ carried, site["mass"])
    sides = np.array([(axes @ side) @ carried for side in across(out, None)])
    assembly.add_on_springs(["bracket 1", "bracket 2"], sides, *(site[name] for name in _SWINGS))


def _taped(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """On its tape's springs, a Maxwell element beside each whose loss is largest where the sensor swings."""
    carried = assembly.motion(point.link, np.array(point.xyz))[:3]
    names = [f"sensor {axis}" for axis in "xyz"]
    omega, strength = 2 * np.pi * site["frequency"], site["relaxing"]
    static = site["frequency"] / float(np.sqrt(1 + strength / 2))
    assembly.add_on_springs(names, carried, site["mass"], static, 0.0)
    spring = strength * site["mass"] * (2 * np.pi * static) ** 2
    assembly.branches += [Branch(assembly.row(name), spring, 1 / omega) for name in names]


def _draw_taped(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = drawing(OWN.draw, relaxing=(0.3, 1.5))(stand, where, random)
    return {**drawn, "frequency": float(random.uniform(1.0, 2.5) * stand.plan.band[1])}


def _draw_bracket(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    return {**_draw_sprung(stand, where, random), "height": float(random.uniform(0.03, 0.1))}


def _draw_sprung(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    drawn = drawing(OWN.draw, damping_ratio=(0.02, 0.1))(stand, where, random)
    return {**drawn, "frequency": float(random.uniform(1.5, 4.0) * stand.plan.band[1])}


def _dragging(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The cable hangs on the sensor: it weighs, holds back a little and rubs, all ways alike."""
    assembly.add_body(point.link, np.array(point.xyz), site["mass"])
    omega = 2 * np.pi * site["frequency"]
    for row in assembly.motion(point.link, np.array(point.xyz))[:3]:
        assembly.add_spring(row, site["mass"] * omega**2, 2 * site["damping_ratio"] * site["mass"] * omega)


def _along_arm(assembly: PlantAssembly, point: CampaignPoint, site: Site) -> None:
    """The sensor, and a line of mass down to the base: along each link from its frame to where it is left."""
    assembly.add_body(point.link, np.array(point.xyz), site["mass"])
    before = {joint.child: joint for joint in site.stand.robot.urdf.joints}
    link, end = point.link, np.array(point.xyz)
    while link in before:
        weight = site["line_mass"] * float(np.linalg.norm(end))
        spread = end @ end * np.eye(3) - np.outer(end, end)
        assembly.add_body(link, end / 2, weight, weight / 12 * spread)
        link, end = before[link].parent, np.array(before[link].xyz)


def _draw_along_arm(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A cable that weighs a half to one and a half times what the sensor does, were it to run all along."""
    mass = OWN.draw(stand, where, random)["mass"]
    length = sum(float(np.linalg.norm(joint.xyz)) for joint in stand.robot.urdf.joints)
    return {"mass": mass, "line_mass": float(random.uniform(0.5, 1.5) * mass / length)}


BLOCK: Effect = replace(
    OWN,
    form="block",
    says="a sensor on a block, its mass off the surface",
    source="ISO 5348, mechanical mounting of accelerometers",
    units={"mass": "kg", "height": "m"},
    draw=drawing(OWN.draw, height=(0.03, 0.12)),
    check=positive("mass", "height"),
    sense=everywhere(_block),
)
CABLE: Effect = replace(
    OWN,
    form="cable",
    says="a sensor and its cable, taped to the link",
    source="Ewins, Modal Testing, 2nd ed., section 3.5 (attachment of transducers)",
    units={"mass": "kg", "share": "of it, the cable's"},
    draw=drawing(OWN.draw, share=(0.2, 0.5)),
    check=lambda p: (
        positive("mass")(p) or (None if p["share"] < 1 else f"share = {p['share']:g}, where below 1")
    ),
    sense=everywhere(_cable),
)
SPRUNG: Effect = replace(
    OWN,
    form="sprung",
    says="a sensor on a magnet that gives",
    source="Den Hartog, Mechanical Vibrations, 4th ed., section 2.5; ISO 5348 on magnets",
    units={"mass": "kg", "frequency": "Hz, of the mass on its mount", "damping_ratio": ""},
    draw=_draw_sprung,
    check=positive("mass", "frequency"),
    sense=everywhere(_sprung),
)
DRAGGED: Effect = replace(
    OWN,
    form="dragged",
    says="a sensor whose cable hangs in the air and holds it back",
    source="McConnell and Varoto, Vibration Testing, 2nd ed., Wiley 2008, chapter 4 (cables)",
    units={"mass": "kg", "frequency": "Hz, of the mass on its cable", "damping_ratio": ""},
    draw=drawing(OWN.draw, frequency=(1.0, 4.0), damping_ratio=(0.1, 0.5)),
    scaled=multiplied("mass"),
    check=positive("mass", "frequency"),
    sense=everywhere(_dragging),
)

BRACKET: Effect = replace(
    SPRUNG,
    form="bracket",
    says="a sensor on a bracket that bends",
    source="ISO 5348, mechanical mounting of accelerometers; Den Hartog, as sprung",
    units={**SPRUNG.units, "height": "m"},
    draw=_draw_bracket,
    check=positive("mass", "frequency", "height"),
    sense=everywhere(_bracket),
)
TAPED: Effect = replace(
    SPRUNG,
    form="taped",
    says="a sensor on double-sided tape, which relaxes",
    source="ISO 5348, on adhesive tape; a Maxwell element beside the spring as Snowdon (rubber)",
    units={
        "mass": "kg",
        "frequency": "Hz, of the mass on its tape",
        "relaxing": "stiffness that does, relative",
    },
    draw=_draw_taped,
    check=positive("mass", "frequency", "relaxing"),
    sense=everywhere(_taped),
)
ALONG_ARM: Effect = replace(
    OWN,
    form="along_arm",
    says="a sensor whose cable is taped down the whole arm",
    source="McConnell and Varoto, as dragged; a thin line of mass on each link",
    units={"mass": "kg", "line_mass": "kg/m, of the cable"},
    draw=_draw_along_arm,
    scaled=multiplied("mass", "line_mass"),
    check=positive("mass", "line_mass"),
    sense=everywhere(_along_arm),
)

FORMS = (BLOCK, CABLE, SPRUNG, DRAGGED, BRACKET, TAPED, ALONG_ARM)

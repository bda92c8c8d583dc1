"""Sixth forms of what bends, carries and hangs: a tube in a socket, a floor, a jacket, a bar on a swivel."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from flexmodal.rig.effects.added_mass import EFFECT as ADDED_MASS
from flexmodal.rig.effects.base_flexibility import EFFECT as BASE
from flexmodal.rig.effects.base_flexibility import base_directions
from flexmodal.rig.effects.effect import Effect, Site, Stand, divided, drawing, each, positive, within
from flexmodal.rig.effects.link_flexibility import EFFECT as LINK
from flexmodal.rig.effects.link_flexibility import plane_in, span, spread
from flexmodal.rig.effects.local_absorber import EFFECT as ABSORBER
from flexmodal.rig.forms.local_absorber import coordinates, ways
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.beam import Beam
from flexmodal.rig.plant.chain import reach
from flexmodal.rig.plant.geometry import across
from flexmodal.structure.arm import beyond

WAVES = (1, 2, 3)
"""Half waves of a floor each way."""


@dataclass(frozen=True, eq=False)
class Socketed:
    """A beam whose root lies bedded in a socket; its coordinates are shift and slope there, then its own.

    Of a long beam on an even bed of k N/m² with β⁴ = k/(4 E I), a force P and a moment M at the mouth give a
    shift 2 P β/k + 2 M β²/k and a slope 2 P β²/k + 4 M β³/k.
    """

    beam: Beam
    """From the mouth of the socket on."""
    fade: float
    """1/β: how far into the socket a load is felt [m]."""
    mouth: float
    """How far from the link's near end the socket ends; before that all is stiff [m]."""

    @property
    def length(self) -> float:
        """Of the whole link [m]."""
        return self.mouth + self.beam.length

    @property
    def condensed_stiffness(self) -> Float[np.ndarray, "kept kept"]:
        """E I [[4 β³, −2 β²], [−2 β², 2 β]] at the mouth, the beam's own beside it."""
        own = self.beam.condensed_stiffness
        whole = np.zeros((len(own) + 2, len(own) + 2))
        root = np.array([[4 / self.fade**3, -2 / self.fade**2], [-2 / self.fade**2, 2 / self.fade]])
        whole[:2, :2] = self.beam.bending_stiffness * root
        whole[2:, 2:] = own
        return whole

    def shape(self, place: float) -> tuple[Float[np.ndarray, " kept"], Float[np.ndarray, " kept"]]:
        """Deflection and slope at a distance from the near end [m], each a row over the coordinates."""
        out = place - self.mouth
        deflection, slope = self.beam.shape(out)
        if out < 0:
            return np.zeros(len(deflection) + 2), np.zeros(len(deflection) + 2)
        return np.concatenate([[1.0, out], deflection]), np.concatenate([[0.0, 1.0], slope])


def _draw_socket(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """The socket adds a sixth to all of what the tube bends by; both together about the rig's own beam."""
    drawn = LINK.draw(stand, where, random)
    stiffer = float(random.uniform(1.0, 2.0))
    return {
        **drawn,
        "bending_stiffness": stiffer * drawn["bending_stiffness"],
        "fade": float(random.uniform(0.05, 0.25)),
        "mouth": float(random.uniform(0.1, 0.25)),
    }


def _shape_socket(assembly: PlantAssembly, site: Site) -> None:
    length, axis = span(site.where, site.stand)
    normal, body = plane_in(assembly, site.where), site.stand.true.bodies[site.where]
    mass, _ = spread(body, length, axis, normal)
    rigidity, mouth = site["bending_stiffness"], site["mouth"] * length
    beam = Beam(length - mouth, rigidity, mass / length)
    socketed = Socketed(beam, site["fade"] * length, mouth)
    slow = float(np.sqrt(max(body.mass, 1e-9) * length**3 / rigidity)) / 1.875104**2
    for side in across(axis, normal):
        assembly.add_flexure(site.where, socketed, axis, side, 2 * site["damping_ratio"] * slow)


def _draw_floor(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A floor of 8 to 25 Hz, two to six times as heavy as the robot; spans by the stretched arm."""
    joints = stand.robot.urdf.joints
    long = max(float(sum(np.linalg.norm(joint.xyz) for joint in joints)), 0.5)
    length, width = (float(random.uniform(1.5, 3.5)) * long for _ in range(2))
    mass = float(random.uniform(2.0, 6.0)) * stand.mass
    omega = 2 * np.pi * float(random.uniform(8.0, 25.0))
    return {
        "rigidity": mass / (length * width) * (omega / (np.pi / length) ** 2) ** 2
        / (1 + (length / width) ** 2) ** 2,
        "floor_mass": mass,
        "length": length,
        "width": width,
        "along": float(random.uniform(0.2, 0.8)),
        "across": float(random.uniform(0.2, 0.8)),
        "damping_ratio": float(random.uniform(0.02, 0.06)),
    }  # fmt: skip


def _half_waves(site: Site) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each mode: deflection and both slopes where the robot stands [1, 1/m], and frequency [rad/s]."""
    long, wide = (part.ravel() for part in np.meshgrid(WAVES, WAVES, indexing="ij"))
    one, other = np.pi * long / site["length"], np.pi * wide / site["width"]
    x, y = site["along"] * site["length"], site["across"] * site["width"]
    moved = np.sin(one * x) * np.sin(other * y)
    slopes = np.array(
        [one * np.cos(one * x) * np.sin(other * y), other * np.sin(one * x) * np.cos(other * y)]
    )
    line = site["floor_mass"] / (site["length"] * site["width"])
    return moved, slopes, (one**2 + other**2) * np.sqrt(site["rigidity"] / line)


def _floor_names() -> list[str]:
    return [f"floor {one}.{other}" for one in WAVES for other in WAVES]


def _shape_floor(assembly: PlantAssembly, site: Site) -> None:
    """The root rises with the floor and tilts with its slopes; a chain in a plane keeps to it."""
    _, own = base_directions(assembly.normal)
    flat = assembly.normal is not None
    level, up = own[:3, 0], own[:3, 1 if flat else 2]
    beside = np.cross(up, level)
    moved, slopes, _ = _half_waves(site)
    motion = np.zeros((6, len(moved)))
    motion[:3] = np.outer(up, moved)
    motion[3:] = -np.outer(beside, slopes[0]) + (0.0 if flat else 1.0) * np.outer(level, slopes[1])
    assembly.add_root_motion(assembly.add_coordinates(_floor_names()), motion)


def _act_floor(assembly: PlantAssembly, site: Site) -> None:
    """Each mode moves a quarter of the floor's mass."""
    part = site["floor_mass"] / 4
    for name, omega in zip(_floor_names(), _half_waves(site)[2].tolist(), strict=True):
        row = assembly.row(name)
        assembly.add_inertia(row, part)
        assembly.add_spring(row, part * omega**2, 2 * site["damping_ratio"] * part * omega)


def _draw_jacket(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    mass = ADDED_MASS.draw(stand, where, random)["mass"]
    return {"mass": float(random.uniform(1.0, 2.0)) * mass, "radius": float(random.uniform(0.05, 0.15))}


def _act_jacket(assembly: PlantAssembly, site: Site) -> None:
    """Thin tubes about this link and those beyond, as heavy as long: m r² along, m (r²/2 + l²/12) across."""
    ends = {link: reach(site.stand.robot, link) for link in beyond(assembly.robot.urdf, site.where)}
    sizes = {link: float(np.linalg.norm(end)) for link, end in ends.items()}
    whole, wide = sum(sizes.values()), site["radius"] ** 2
    if whole < 1e-6:
        assembly.add_body(site.where, np.zeros(3), site["mass"], site["mass"] * wide * np.eye(3))
        return
    for link, size in sizes.items():
        if size > 1e-6:
            mass, axis = site["mass"] * size / whole, ends[link] / size
            thin = np.eye(3) - np.outer(axis, axis)
            tube = mass * (wide * np.outer(axis, axis) + (wide / 2 + size**2 / 12) * thin)
            assembly.add_body(link, ends[link] / 2, mass, tube)


def _draw_swivel(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    """A bar about as long as its link."""
    drawn = drawing(ABSORBER.draw, long=(0.8, 1.8))(stand, where, random)
    size = max(float(np.linalg.norm(reach(stand.robot, where))), 0.2)
    return {**drawn, "mass": 1.5 * drawn["mass"], "long": drawn["long"] * size}


def _act_swivel(assembly: PlantAssembly, site: Site) -> None:
    """A thin bar along `d` that turns about its own middle: its mass goes along, its moment swings."""
    bar, second = ways(assembly, site)
    axis, mass = np.cross(bar, second), site["mass"]
    (own,) = coordinates(assembly, 1)
    motion = assembly.motion(site.where, site.vector("x", "y", "z"))
    moment, omega = mass * site["long"] ** 2 / 12, 2 * np.pi * site["frequency"]
    for row in motion[:3]:
        assembly.add_inertia(row, mass)
    assembly.add_inertia(axis @ motion[3:] + own, moment)
    assembly.add_inertia(second @ motion[3:], moment)
    assembly.add_spring(own, moment * omega**2, 2 * site["damping_ratio"] * moment * omega)


SOCKET: Effect = replace(
    LINK,
    form="socket",
    says="a tube that is glued or clamped into a socket, in which it lies on an even bed: its root "
    "shifts and tilts, both by a force and by a moment",
    source="Hetényi, Beams on Elastic Foundation, University of Michigan Press 1946, chapter II (beams of "
    "unlimited length); Géradin and Rixen, Mechanical Vibrations, 3rd ed., section 5.3",
    units={**LINK.units, "fade": "1/β of the bed, over the length", "mouth": "where the socket ends"},
    draw=_draw_socket,
    check=each(LINK.check, within(fade=(1e-3, 1.0), mouth=(0.01, 0.8))),
    shape=_shape_socket,
)
FLOOR: Effect = replace(
    BASE,
    form="floor",
    says="the robot stands somewhere on an upper floor, which swings as a plate between walls: it rises and "
    "tilts by the plate's modes",
    source="Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed., McGraw-Hill 1959, "
    "chapter 5; Leissa, Vibration of Plates, NASA SP-160, 1969, chapter 4 (simply supported)",
    units={
        "rigidity": "N·m, of the plate", "floor_mass": "kg", "length": "m", "width": "m",
        "along": "of the robot, over the length", "across": "of the robot, over the width",
        "damping_ratio": "of each mode",
    },
    draw=_draw_floor,
    scaled=divided("rigidity"),
    check=each(
        positive("rigidity", "floor_mass", "length", "width"),
        within(along=(0.05, 0.95), across=(0.05, 0.95), damping_ratio=(0.0, 1.0)),
    ),
    shape=_shape_floor,
    act=_act_floor,
)  # fmt: skip
JACKET: Effect = replace(
    ADDED_MASS,
    form="jacket",
    says="a protective jacket over a link and all beyond it, as heavy everywhere",
    source="Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 2.13; Beer and Johnston, "
    "Vector Mechanics for Engineers: Dynamics, McGraw-Hill (thin tubes)",
    units={"mass": "kg, of all of it", "radius": "m"},
    draw=_draw_jacket,
    check=positive("mass", "radius"),
    act=_act_jacket,
)
SWIVEL: Effect = replace(
    ABSORBER,
    form="swivel",
    says="a long, balanced bar on a swivel that gives, such as the spar of a gripper: it turns about its "
    "middle and feels nothing but turns of the link",
    source="Den Hartog, Mechanical Vibrations, 4th ed., chapter 3, on dampers of torsional vibration; "
    "Nestorides, A Handbook on Torsional Vibration, Cambridge 1958",
    units={**ABSORBER.units, "dx": "", "dy": "", "dz": "along the bar", "long": "m, the bar"},
    draw=_draw_swivel,
    check=each(ABSORBER.check, positive("long")),
    act=_act_swivel,
)

FORMS = (SOCKET, FLOOR, JACKET, SWIVEL)

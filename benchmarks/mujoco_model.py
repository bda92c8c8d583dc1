"""A robot in one posture as an MJCF model, with effects hidden in it by MuJoCo's own means.

The model is built in its posture, so that all its joints rest at 0: springs and dampers of the card, no
gravity, no contact. A hidden effect is a thing that MuJoCo has: another hinge in a link, a body, dry
friction of a joint, a foundation on springs, a body on a spring. Numbers are those of the rig's effect of
the same name, the physics is not the rig's: a link that bends is a chain of short stiff ones, a joint that
rubs pulls a brake by a spring (Jenkins's element; MuJoCo's friction is a constraint).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from flexmodal.campaign import CampaignPoint
from flexmodal.model import Robot
from flexmodal.rig.believed import Body, TrueRobot
from flexmodal.rig.plant.chain import children, reach
from flexmodal.rig.plant.geometry import across
from flexmodal.structure.arm import plane_normal

EFFECTS = (
    "link_flexibility", "base_flexibility", "coulomb_friction", "added_mass", "local_absorber", "sensor_mass",
)  # fmt: skip
"""Effects that can be hidden in such a model."""
HINGES = 3
"""In a link that bends, each in the middle of its share of the length."""
_POINT_GYRATION = 1e-3
"""Radius of gyration of a body that stands for a point [m]; MuJoCo wants a moment of inertia."""


@dataclass(frozen=True, eq=False)
class Spoil:
    """One effect: its name, place and parameters, as the rig has them."""

    effect: str
    where: str
    parameters: Mapping[str, float]


@dataclass(eq=False)
class _Bend:
    """A link in pieces."""

    pieces: tuple[Body, ...]
    places: tuple[np.ndarray, ...]
    """Where each piece begins in the frame of the link: its foot, then the hinges [m]."""
    axes: tuple[np.ndarray, ...]
    stiffness: float
    damping: float


class _Builder:
    """Writes the tree, body by body."""

    def __init__(
        self, robot: Robot, true: TrueRobot, pose: Mapping[str, float], spoils: Sequence[Spoil], step: float
    ) -> None:
        self.robot, self.true, self.pose, self.step = robot, true, pose, step
        self.by_name = {spoil.effect: spoil for spoil in spoils}
        self.root = ElementTree.Element("mujoco", model=robot.name)
        ElementTree.SubElement(self.root, "compiler", angle="radian", autolimits="false")
        option = ElementTree.SubElement(
            self.root, "option", gravity="0 0 0", integrator="RK4", timestep=repr(step)
        )
        ElementTree.SubElement(option, "flag", contact="disable")
        self.world = ElementTree.SubElement(self.root, "worldbody")
        self.carriers: dict[str, list[tuple[float, ElementTree.Element, Rotation, np.ndarray]]] = {}
        """The bodies of each link: how far along it each begins, element, orientation, origin in the link."""

    def build(self) -> None:
        urdf = self.robot.urdf
        holder, turned = self.world, Rotation.identity()
        if "base_flexibility" in self.by_name:
            holder = self._foundation()
        self._fill(holder, urdf.root, turned, moves=holder is not self.world)

    def _foundation(self) -> ElementTree.Element:
        """A body on springs: two directions and a tilt of a planar chain, all six of a spatial one."""
        given = self.by_name["base_flexibility"].parameters
        body = ElementTree.SubElement(self.world, "body", name="foundation")
        normal = plane_normal(self.robot)
        if normal is None:
            slides, hinges = np.eye(3), np.eye(3)
        else:
            up = np.array([0.0, 0.0, 1.0])
            level = np.cross(normal, up)
            slides, hinges = np.array([level / np.linalg.norm(level), up]), normal[None]
        mass = sum(part.mass for part in self.true.bodies.values())
        shift = given["translation_stiffness"]
        for kind, axes in (("slide", slides), ("hinge", hinges)):
            for number, axis in enumerate(axes):
                upright = abs(axis[2]) > 0.5
                if kind == "slide":
                    k = shift * (given["vertical_over_horizontal"] if upright else 1.0)
                else:
                    k = given["tilt_stiffness"] * (2.0 if normal is None and upright else 1.0)
                damper = 2 * given["damping_ratio"] * k * np.sqrt(mass / shift)
                _joint(body, f"foundation {kind} {number}", kind, axis, k, damper)
        return body

    def _fill(self, body: ElementTree.Element, link: str, turned: Rotation, *, moves: bool) -> None:
        """Put a link into a body: its mass, what hangs on it, and the links beyond."""
        bend = self._bend(link)
        own = self.true.bodies.get(link)
        carriers = [(-np.inf, body, turned, np.zeros(3))]
        if bend is not None:
            end = reach(self.robot, link)
            _inertial(body, bend.pieces[0], np.zeros(3))
            holder, foot = body, bend.places[0]
            for count, (piece, place) in enumerate(zip(bend.pieces[1:], bend.places[1:], strict=True), 1):
                holder = ElementTree.SubElement(
                    holder, "body", name=f"{link} piece {count}", pos=_text(place - foot)
                )
                for number, axis in enumerate(bend.axes):
                    name = f"{link} bend {count}.{number}"
                    _joint(holder, name, "hinge", axis, bend.stiffness, bend.damping)
                _inertial(holder, piece, place)
                carriers.append((float(place @ end / np.linalg.norm(end)), holder, turned, place))
                foot = place
        elif own is not None and moves:
            _inertial(body, own, np.zeros(3))
        self.carriers[link] = carriers
        self._attach(link)
        for joint in children(self.robot.urdf, link):
            holder, _, origin = self.carrier(link, np.asarray(joint.xyz))
            angle = float(self.pose.get(joint.name, 0.0))
            frame = Rotation.from_euler("xyz", joint.rpy)
            place = np.asarray(joint.xyz) - origin
            if joint.is_prismatic:
                place = place + frame.apply(angle * joint.axis)
            elif joint.movable:
                frame = frame * Rotation.from_rotvec(angle * joint.axis)
            child = ElementTree.SubElement(
                holder, "body", name=joint.child, pos=_text(place), quat=_text(_quaternion(frame))
            )
            flexible = joint.name in self.robot.joints
            if flexible:
                self._card_joint(child, joint.name, joint.type, joint.axis)
            self._fill(child, joint.child, turned * frame, moves=moves or flexible)

    def _card_joint(self, body: ElementTree.Element, name: str, kind: str, axis: np.ndarray) -> None:
        made = _joint(
            body, name, "slide" if kind == "prismatic" else "hinge", axis,
            self.true.stiffness[name], self.true.damping[name],
        )  # fmt: skip
        made.set("armature", repr(float(self.true.rotor.get(name, 0.0))))
        spoil = self.by_name.get("coulomb_friction")
        if spoil is not None and spoil.where == name:
            self._rub(name, made.get("type", "hinge"), spoil.parameters)

    def _rub(self, joint: str, kind: str, given: Mapping[str, float]) -> None:
        """A brake that the joint pulls by a spring: elastic until the brake slides, at its torque then."""
        bristles = float(given["presliding_stiffness"])
        body = ElementTree.SubElement(self.world, "body", name=f"{joint} brake")
        _inertial(body, Body(1e-6, np.zeros(3), 1e-6 * np.eye(3)), np.zeros(3))
        brake = _joint(body, f"{joint} brake", kind, np.array([0.0, 0.0, 1.0]), 0.0, 0.0)
        inertia = bristles * self.step**2  # as little as the step can follow
        brake.set("armature", repr(inertia))
        brake.set("frictionloss", repr(float(given["torque"])))
        brake.set("solreffriction", "0.0005 1")
        brake.set("solimpfriction", "0.9999 0.9999 0.001 0.5 2")
        tendons = ElementTree.SubElement(self.root, "tendon")
        spring = ElementTree.SubElement(
            tendons, "fixed", stiffness=repr(bristles), springlength="0",
            damping=repr(float(np.sqrt(bristles * inertia)) / 5),
        )  # fmt: skip
        for name, turn in ((joint, "1"), (f"{joint} brake", "-1")):
            ElementTree.SubElement(spring, "joint", joint=name, coef=turn)

    def _bend(self, link: str) -> _Bend | None:
        """The pieces of a link that bends; a tip force deflects its end as it does that of the rig's beam."""
        spoil = self.by_name.get("link_flexibility")
        if spoil is None or spoil.where != link:
            return None
        end = reach(self.robot, link)
        length = float(np.linalg.norm(end))
        axis, body = end / length, self.true.bodies[link]
        middles = (np.arange(HINGES) + 0.5) / HINGES
        normal = plane_normal(self.robot)
        if normal is not None:
            from flexmodal.model.placements import link_placements

            normal = link_placements(self.robot, {})[link][:3, :3].T @ normal
        sides = across(axis, normal)
        rigidity = spoil.parameters["bending_stiffness"]
        stiffness = 3 * rigidity * np.sum((1 - middles) ** 2) / length
        first = 1.875104068711961**2 * np.sqrt(rigidity / (body.mass * length**3))  # clamped and free [rad/s]
        damping = 2 * spoil.parameters["damping_ratio"] / first * stiffness
        axes = tuple(np.cross(axis, side) for side in sides)
        places = tuple(part * length * axis for part in (0.0, *middles))
        return _Bend(pieces(body, length, axis, HINGES), places, axes, stiffness, damping)

    def carrier(self, link: str, place: np.ndarray) -> tuple[ElementTree.Element, Rotation, np.ndarray]:
        """The body of a link that carries a place in its frame, its orientation in the world, its origin."""
        end = reach(self.robot, link)
        length = float(np.linalg.norm(end))
        along = float(place @ end / length) if length else 0.0
        _, body, turned, origin = max(
            (one for one in self.carriers[link] if one[0] <= along + 1e-9), key=lambda one: one[0]
        )
        return body, turned, origin

    def _attach(self, link: str) -> None:
        spoil = self.by_name.get("added_mass")
        if spoil is not None and spoil.where == link:
            given = spoil.parameters
            self.add_body(link, "payload", _vector(given, "xyz"), given["mass"], given["gyration"])
        spoil = self.by_name.get("local_absorber")
        if spoil is not None and spoil.where == link:
            given = spoil.parameters
            body = self.add_body(link, "absorber", _vector(given, "xyz"), given["mass"], _POINT_GYRATION)
            way = np.array([given["dx"], given["dy"], given["dz"]])
            k = given["mass"] * (2 * np.pi * given["frequency"]) ** 2
            damper = 2 * given["damping_ratio"] * np.sqrt(k * given["mass"])
            _joint(body, "absorber", "slide", way / np.linalg.norm(way), k, damper)

    def add_body(
        self, link: str, name: str, place: np.ndarray, mass: float, gyration: float
    ) -> ElementTree.Element:
        """A small body on a link."""
        holder, _, origin = self.carrier(link, place)
        body = ElementTree.SubElement(holder, "body", name=name, pos=_text(place - origin))
        _inertial(body, Body(mass, np.zeros(3), mass * gyration**2 * np.eye(3)), np.zeros(3))
        return body

    def add_site(self, name: str, link: str, place: np.ndarray) -> None:
        """A site on a link with the axes of the world."""
        holder, turned, origin = self.carrier(link, place)
        quaternion = _text(_quaternion(turned.inv()))
        ElementTree.SubElement(holder, "site", name=name, pos=_text(place - origin), quat=quaternion)


def pieces(body: Body, length: float, axis: np.ndarray, hinges: int) -> tuple[Body, ...]:
    """A link cut at hinges in the middle of equal shares of its length, the whole inertia kept.

    Pieces of a uniform link lie as far apart as their shares of the length; nearer to each other where the
    link has less moment of inertia than that.
    """
    cuts = np.concatenate([[0.0], (np.arange(hinges) + 0.5) / hinges, [1.0]])
    share, offset = np.diff(cuts), (cuts[1:] + cuts[:-1]) / 2 - 0.5
    thin = np.eye(3) - np.outer(axis, axis)
    for part in np.linspace(1.0, 0.0, 21):
        rest = body.inertia - body.mass * (part * length) ** 2 * np.sum(share * offset**2) * thin
        moments = np.linalg.eigvalsh(rest)
        if moments[0] > 0 and moments[0] + moments[1] >= moments[2] * (1 - 1e-9):
            break
    return tuple(
        Body(body.mass * own, body.com + part * length * far * axis, own * rest)
        for own, far in zip(share, offset, strict=True)
    )


def mjcf(
    robot: Robot,
    true: TrueRobot,
    pose: Mapping[str, float],
    points: Sequence[CampaignPoint],
    hammers: Sequence[int],
    *,
    spoils: Sequence[Spoil] = (),
    carrying: tuple[CampaignPoint, float] | None = None,
    step: float,
) -> str:
    """The model as XML.

    Args:
        robot: the believed robot, for what hangs on what.
        true: its true stiffness, damping and masses.
        pose: joint values [rad, m].
        points: each gets a site and a velocimeter, in their order.
        hammers: ids of points that are struck; each gets six actuators, forces and moments, world axes.
        spoils: effects hidden in it.
        carrying: the point that carries the sensor, and the sensor's mass [kg].
        step: of the integration [s].
    """
    builder = _Builder(robot, true, pose, spoils, step)
    builder.build()
    if carrying is not None:
        point, mass = carrying
        builder.add_body(point.link, "sensor", np.array(point.xyz), mass, _POINT_GYRATION)
    sensors = ElementTree.SubElement(builder.root, "sensor")
    actuators = ElementTree.SubElement(builder.root, "actuator")
    for point in points:
        builder.add_site(f"point {point.id}", point.link, np.array(point.xyz))
        ElementTree.SubElement(sensors, "velocimeter", site=f"point {point.id}")
    for number in hammers:
        for gear in np.eye(6):
            ElementTree.SubElement(actuators, "general", site=f"point {number}", gear=_text(gear))
    return ElementTree.tostring(builder.root, encoding="unicode")


def _joint(
    body: ElementTree.Element, name: str, kind: str, axis: np.ndarray, stiffness: float, damping: float
) -> ElementTree.Element:
    return ElementTree.SubElement(
        body, "joint", name=name, type=kind, axis=_text(axis), stiffness=repr(float(stiffness)),
        damping=repr(float(damping)),
    )  # fmt: skip


def _inertial(body: ElementTree.Element, part: Body, origin: np.ndarray) -> None:
    i = part.inertia
    full = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    ElementTree.SubElement(
        body, "inertial", pos=_text(part.com - origin), mass=repr(float(part.mass)), fullinertia=_text(full)
    )


def _quaternion(frame: Rotation) -> np.ndarray:
    return np.roll(frame.as_quat(), 1)  # w first


def _vector(given: Mapping[str, float], names: str) -> np.ndarray:
    return np.array([given[name] for name in names])


def _text(values: Sequence[float] | np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)

"""A robot's URDF and card being changed: what effects do to it so that it loads like any other.

Everything is put in at rest and in place, so that nothing moves by being added. What is attached to a link is
hung on at the end, on whichever side of a hinge it sits.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodal.cards import JointCard
from flexmodal.cards.write import UrdfDraft
from flexmodal.diagnosis.improved.inertia import nearest_inertia
from flexmodal.diagnosis.improved.joints import Vector, joint_card, new_joint
from flexmodal.diagnosis.improved.pieces import Cut, Hung
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.structure.arm import Body, beyond, bodies_of, moved_bodies
from flexmodal.structure.robot_terms import scaled

DUST = 1e-12
"""Mass of a link that only stands between two joints, over that of the arm: readers of URDFs want some."""
FOOT = 1e-8
"""Mass of a base that moves and has none in the URDF, likewise; and its inertia over that at 1 m."""


class Draft:
    """A robot in the making, from one that is loaded and new values for its parameters."""

    def __init__(self, robot: Robot, values: Mapping[str, float]) -> None:
        self.robot = robot
        self.urdf = UrdfDraft(robot.urdf)
        self.joints: dict[str, JointCard] = {n: joint_card(robot, n, values) for n in robot.joints}
        self.couplings = {name: float(one.stiffness) for name, one in robot.couplings.items()}
        self.loss_frequency = robot.loss_frequency
        self.notes: list[str] = []
        """Sentences about what the files cannot hold, or hold differently."""
        self.arm_mass = float(sum(robot.urdf.link_by_name[n].mass or 0.0 for n in moved_bodies(robot)))
        self._still = link_placements(robot, {})
        self._lowest = robot.urdf.root
        self._cuts: dict[str, list[Cut]] = {}
        self._hung: list[Hung] = []
        self._names = self.urdf.names | {*robot.points, "universe"}
        for link, body in bodies_of(robot.urdf).items():
            if {f"mass.{link}", f"inertia.{link}"} & set(values):
                self.set_body(link, scaled(body, link, values))

    # what effects call

    def fresh(self, name: str) -> str:
        """A name like this one that no link, joint or point has; taken from now on."""
        free, number = name, 2
        while free in self._names:
            free, number = f"{name}_{number}", number + 1
        self._names.add(free)
        return free

    def set_body(self, link: str, body: Body) -> None:
        """Give a link mass, mass centre and inertia.

        Args:
            link: its name.
            body: in its frame; an inertia that no body has, which a fit may end at, gives way to the nearest.
        """
        inertia, differs = nearest_inertia(body.inertia, self._normal(link))
        if differs:
            self.notes.append(f"the inertia of {link} is the nearest that a body can have")
        self.urdf.set_body(link, float(body.mass), body.centre, inertia)

    def flexible(self, joint: str, stiffness: float, damping: float, *, rotor_inertia: float = 0.0) -> None:
        """Put a spring and a damper on a new pseudo-joint; see `JointCard` for the arguments."""
        self.joints[joint] = JointCard(float(stiffness), float(damping), True, float(rotor_inertia))

    def stiffen(self, joint: str, added: float) -> None:
        """Add to the stiffness of a joint [N·m/rad].

        Args:
            joint: its name.
            added: on top of what it has.
        """
        self.joints[joint] = replace(
            self.joints[joint], stiffness=self.joints[joint].stiffness + float(added)
        )

    def damp(self, joint: str, factor: float) -> None:
        """Multiply the viscous damping of a joint.

        Args:
            joint: which.
            factor: above 0.
        """
        card = self.joints[joint]
        self.joints[joint] = replace(card, damping=card.damping * float(factor))

    def loses(self, joint: str, loss_factor: float) -> None:
        """Give the spring of a joint a loss factor; see `JointCard` for the arguments."""
        self.joints[joint] = replace(self.joints[joint], loss_factor=float(loss_factor))

    def hinge(
        self, link: str, place: Vector, way: Vector, axes: Mapping[str, Vector], slides: Collection[str] = ()
    ) -> str:
        """Cut a link and join the parts by joints, one behind the other; returns the part beyond.

        Args:
            link: which; its frame and name stay with the part nearest to the base.
            place: of the cut, in its frame [m]; beyond those made before.
            way: unit vector towards its far end.
            axes: names of new joints and their axes in the frame of the link.
            slides: those of them that slide.
        """
        outer = self.fresh(f"{link}_beyond")
        near, xyz = self.place_of(link, place)
        parent, offset = near, place - xyz
        for number, (name, axis) in enumerate(axes.items(), start=1):
            child = outer if number == len(axes) else self._dust(f"{name}_part")
            if child == outer:
                self.urdf.add_link(outer)
            moves = "prismatic" if name in slides else "revolute"
            self.urdf.add_joint(new_joint(name, moves, parent, child, axis, xyz))
            parent, xyz = child, np.zeros(3)
        self._cuts.setdefault(link, []).append(Cut(place, way, outer))
        self.urdf.shift_joints(near, -(place - offset), onto=outer, keep=frozenset(axes))
        self.urdf.split_shapes(near, outer, place - offset, way)
        return outer

    def attach(
        self,
        link: str,
        part: Body,
        *,
        name: str,
        slides: Sequence[Vector] = (),
        hinges: Sequence[Vector] = (),
    ) -> tuple[str, ...]:
        """Hang a body on a link, rigidly or free along directions or about them, one behind the other.

        Args:
            link: its name.
            part: its centre in the frame of the link [m].
            name: of the new joint; others get a number behind it.
            slides: unit vectors in that frame; rigid if there are neither these nor hinges.
            hinges: likewise, about which it turns.

        Returns:
            The names of the joints.
        """
        ways, kind = (*slides, *hinges), "prismatic" if slides else "revolute" if hinges else "fixed"
        joints = tuple(self.fresh(f"{name}_{number}" if number else name) for number in range(len(ways) or 1))
        body = Body(float(part.mass), np.zeros(3), part.inertia)
        self._hung.append(Hung(link, part.centre, body, joints, ways, kind))
        return joints

    def under_root(self, motions: Sequence[tuple[str, Vector, bool]], centre: Vector) -> str:
        """Let the root link, and what was put under it before, move by new joints.

        Args:
            motions: names, axes, and whether each turns or slides.
            centre: where their axes meet, in the frame of the root link [m].

        Returns:
            The link that these joints stand on, now the lowest; its frame is that of the root link.
        """
        root, above = self.robot.urdf.root, self._lowest
        ground = self._lowest = self.fresh(f"world_{root}")
        self.urdf.add_link(ground, first=True)
        parent, xyz = ground, centre
        for name, axis, turns in motions:
            child = self._dust(f"{name}_part")
            kind = "revolute" if turns else "prismatic"
            self.urdf.add_joint(new_joint(name, kind, parent, child, axis, xyz))
            parent, xyz = child, np.zeros(3)
        stands = self.fresh(f"{root}_on_its_foundation")
        self.urdf.add_joint(new_joint(stands, "fixed", parent, above, np.array([1.0, 0.0, 0.0]), -centre))
        fixed = _rigid(self.robot, root)
        if above == root and not any(self.robot.urdf.link_by_name[link].mass for link in fixed):
            size = FOOT * self.arm_mass
            self.urdf.set_body(root, size, np.zeros(3), size * np.eye(3))
            self.notes.append(f"the URDF gives the base no mass, though it moves: {size:.3g} kg stand for it")
        return ground

    def behind(self, joint: str, name: str) -> None:
        """Put a new joint, of the same axis and kind, between a joint and the link that carries it.

        Args:
            joint: which.
            name: of the new one.
        """
        described = self.urdf.joints[joint]
        rotor = self._dust(f"{name}_rotor")
        kind = "prismatic" if described.is_prismatic else "revolute"
        new = new_joint(name, kind, described.parent, rotor, described.axis, described.xyz)
        self.urdf.add_joint(replace(new, rpy=described.rpy), before=joint)
        self.urdf.change_joint(joint, parent=rotor, xyz=np.zeros(3), rpy=np.zeros(3))

    def under_joint(self, joint: str, motions: Sequence[tuple[str, Vector, bool]], centre: Vector) -> None:
        """Let a joint, and what it carries, move by new joints between it and the link that carries it.

        Args:
            joint: which.
            motions: names, axes in the frame of the joint, and whether each turns or slides.
            centre: where their axes meet, in that frame [m].
        """
        described = self.urdf.joints[joint]
        parent, xyz, rpy = described.parent, described.xyz, described.rpy
        first = self._dust(f"{joint}_bearing")
        fixed = new_joint(
            self.fresh(f"{joint}_mount"), "fixed", parent, first, np.array([1.0, 0.0, 0.0]), xyz
        )
        self.urdf.add_joint(replace(fixed, rpy=rpy), before=joint)
        parent, xyz = first, centre
        for name, axis, turns in motions:
            child = self._dust(f"{name}_part")
            kind = "revolute" if turns else "prismatic"
            self.urdf.add_joint(new_joint(name, kind, parent, child, axis, xyz), before=joint)
            parent, xyz = child, np.zeros(3)
        self.urdf.change_joint(joint, parent=parent, xyz=-centre, rpy=np.zeros(3))

    def couple(self, one: str, other: str, stiffness: float) -> None:
        """Add an off-diagonal stiffness between two flexible joints.

        Args:
            one: name of a joint.
            other: name of the other one.
            stiffness: of either sign, added to what is there [N·m/rad].
        """
        name = f"{other}+{one}" if f"{other}+{one}" in self.couplings else f"{one}+{other}"
        self.couplings[name] = self.couplings.get(name, 0.0) + float(stiffness)

    # the end

    def place_of(self, link: str, place: Vector) -> tuple[str, Vector]:
        """Link and place of a point of the robot as it was, once links are cut.

        Args:
            link: its name in the robot as it was.
            place: in its frame there [m].
        """
        for cut in reversed(self._cuts.get(link, [])):
            if (place - cut.place) @ cut.way > 0:
                return cut.outer, place - cut.place
        return link, place

    def finish(self) -> UrdfDraft:
        """The URDF, with everything hung where it belongs."""
        for one in self._hung:
            link, place = self.place_of(one.link, one.place)
            child = self.fresh(f"{one.joints[0]}_mass")
            self.urdf.add_link(child)
            self.urdf.set_body(child, one.body.mass, one.body.centre, one.body.inertia)
            for name, way in zip(one.joints, one.ways or (np.array([1.0, 0.0, 0.0]),), strict=True):
                carried = child if name == one.joints[-1] else self._dust(f"{name}_part")
                self.urdf.add_joint(new_joint(name, one.kind, link, carried, way, place))
                link, place = carried, np.zeros(3)
        self._hung = []
        return self.urdf

    def _normal(self, link: str) -> Vector | None:
        """Normal of a planar chain's plane in the frame of a link; frames turn about it only."""
        if not self.robot.is_planar:
            return None
        parts = {cut.outer: whole for whole, cuts in self._cuts.items() for cut in cuts}
        source = parts.get(link, link)
        return self._still[source][:3, :3].T @ self.robot.task[2, 3:]

    def _dust(self, name: str) -> str:
        """A link with next to no mass."""
        free, mass = self.fresh(name), DUST * self.arm_mass
        self.urdf.add_link(free)
        self.urdf.set_body(free, mass, np.zeros(3), 0.01 * mass * np.eye(3))
        return free


def _rigid(robot: Robot, link: str) -> list[str]:
    """The link and those that no flexible joint parts from it."""
    moved: set[str] = set()
    for name in robot.joints:
        moved.update(beyond(robot.urdf, robot.urdf.joint_by_name[name].child))
    return [one for one in beyond(robot.urdf, link) if one not in moved]

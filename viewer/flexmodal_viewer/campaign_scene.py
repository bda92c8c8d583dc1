"""A campaign on its robot: every posture with sensors and hammer, and how fitted modes move the points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture
from flexmodal.ema.shapes import FittedShapes, Way
from flexmodal.model import PosedRobot, Posture, Robot
from flexmodal.model.placements import link_placements
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.marks import Drawn
from flexmodal_viewer.measured_shape import JointShape, joint_shape, odd_points
from flexmodal_viewer.motion import FRAMES, SHARE, Deflection
from flexmodal_viewer.palette import EXTREME, FORCE, POINT, TARGET
from flexmodal_viewer.scene import Caption, Item, Label, Matrix, Motion, Scene, Swatch, Table
from flexmodal_viewer.shapes import Lines, Sphere
from flexmodal_viewer.stage import set_stage, view_of
from flexmodal_viewer.strangers import refuse_strangers
from flexmodal_viewer.units import joint_value, plain

_BALL, _RESPONSE, _HAMMER = 0.012, 0.07, 0.13
"""Sizes of points and arrows, as parts of the arm's reach."""
_NOTHING = "nothing"
"""What was done at a point where nothing was."""
_LEGEND = (
    Swatch("points, and the directions of the sensor", POINT, "arrow"),
    Swatch("where the hammer hits", FORCE, "arrow"),
)


def campaign_scene(robot: Robot, campaign: Campaign, shapes: Sequence[FittedShapes] = ()) -> Scene:
    """Draw the postures of a campaign, a button each, and under each of them its fitted shapes.

    Args:
        robot: what was tested, or what the tester believes it to be.
        campaign: postures, points, and the directions of its FRFs or blows.
        shapes: of fitted modes; of each posture those of the first fixed place that has the most points.

    Raises:
        InvalidCampaign: postures or points that the robot does not have, all of them at once.
    """
    refuse_strangers(robot, campaign)
    arm = Arm(robot)
    nodes: dict[str, Matrix] = {}
    items: list[Item] = []
    labels: list[Label] = []
    motions: list[Motion] = []
    for posture in campaign.postures:
        tested = _tested(arm, campaign, posture)
        drawn = tested.drawn()
        own = [_swing(tested, shape, mode) for shape, mode in _modes_of(posture, shapes)]
        for part in (drawn, *(part for part, _ in own)):
            nodes |= part.nodes
            items += part.items
            labels += part.labels
        motions.append(tested.still())
        motions += [motion for _, motion in own]
    caption = Caption(
        campaign.title,
        f"{robot.title or robot.name}: {_count(campaign.postures, 'posture')}, "
        f"{_count(campaign.points, 'point')}",
        _LEGEND,
        (),
        arm.looks.notes,
    )
    first = robot.at(dict(campaign.postures[0].q))
    view = view_of(robot, first.position(robot.tool))
    return set_stage(Scene(caption, view, nodes, tuple(items), tuple(labels), tuple(motions)))


@dataclass(frozen=True, eq=False)
class _Tested:
    """One posture with what was measured in it."""

    arm: Arm
    posture: CampaignPosture
    values: Posture
    positions: Mapping[int, Float[np.ndarray, "3"]]
    """Of each point [m]."""
    points: Mapping[int, CampaignPoint]
    turned: Mapping[int, Float[np.ndarray, "3 3"]]
    """Axes of the links that carry the points, column by column."""
    responses: tuple[Way, ...]
    references: tuple[Way, ...]
    trace_lines: tuple[tuple[int, ...], ...] = ()
    """Ids of points that are joined one after the other."""

    @property
    def group(self) -> str:
        """Node that carries the arm and its marks."""
        return f"posture_{self.posture.id}"

    def drawn(self) -> Drawn:
        """The arm, a ball on each point, an arrow for each direction of sensor or hammer, trace lines."""
        arm, reach = self.arm, self.arm.reach
        nodes = arm.nodes(self.group, self.values.values)
        found = Drawn(nodes, arm.items(self.group, lambda own: own), [])
        for number, position in self.positions.items():
            node = f"{self.group}/point_{number}"
            ball = Item(f"{node}/ball", Sphere(_BALL * reach), POINT, on_top=True)
            found = found.beside(
                Drawn({node: marks.at(position)}, [ball], [Label(self.points[number].name, node)])
            )
        for kind, ways in (("response", self.responses), ("hammer", self.references)):
            for place, way in enumerate(ways):
                found = found.beside(self._arrow(kind, place, way))
        ends = self._trace()
        if len(ends):
            line = Item(f"{self.group}/trace", Lines(ends), POINT, on_top=True)
            found = found.beside(Drawn({}, [line], []))
        return found

    def _trace(self) -> Float[np.ndarray, "line 2 3"]:
        """Both ends of every stretch of the trace lines."""
        pairs = [pair for line in self.trace_lines for pair in pairwise(line)]
        return np.array([[self.positions[one] for one in pair] for pair in pairs]).reshape(-1, 2, 3)

    def _arrow(self, kind: str, number: int, way: Way) -> Drawn:
        """A sensor's arrow begins at its point; the hammer's ends there."""
        size = self.arm.reach * (_RESPONSE if kind == "response" else _HAMMER)
        axis = self.along(way)
        start = self.positions[way[0]] - (0 if kind == "response" else size) * axis
        colour = POINT if kind == "response" else FORCE
        return marks.arrow(f"{self.group}/{kind}_{number}", axis, start, size, colour)

    def still(self) -> Motion:
        """The button that shows this posture at rest."""
        moving, values = self.arm.robot.moving, self.values.values.items()
        rows = [(name, joint_value(value, slides=moving[name].is_prismatic)) for name, value in values]
        rows += [(self.points[number].name, self._at_point(number)) for number in self.positions]
        rows += [
            (f"x, y, z at {one.name}", one.axes_text())
            for one in self.points.values()
            if one.own_axes and self._at_point(one.id) != _NOTHING
        ]
        table = Table(f"Posture {self.posture.id}", (), tuple(rows))
        name, rest = f"{self.posture.id}: {self.posture.name}", self.arm.nodes(self.group, self.values.values)
        return Motion(name, {}, 0.0, shows=(self.group,), poses=rest, table=table)

    def _at_point(self, number: int) -> str:
        """What was done at a point, such as "sensor +z, hammer −x"."""
        tools = (("sensor", self.responses), ("hammer", self.references))
        done = [f"{tool} {_sense(way)}" for tool, ways in tools for point, way in ways if point == number]
        return ", ".join(done) or _NOTHING

    def along(self, way: Way) -> Float[np.ndarray, "3"]:
        """Unit vector in the world of a direction at a point, by the point's own axes."""
        return self.points[way[0]].way(way[1], self.turned[way[0]])

    @cached_property
    def posed(self) -> PosedRobot:
        """The robot as it stood."""
        return self.arm.robot.at(self.values)

    def joints(self, shapes: FittedShapes, mode: int) -> JointShape:
        """What the joints do in a fitted mode.

        Args:
            shapes: of the fitted modes.
            mode: number of one of them.
        """
        rows = []
        for point, way in shapes.places:
            link = self.points[point].link
            jacobian, arm = self.posed.jacobian(link), self.positions[point] - self.posed.position(link)
            moved = jacobian[:3] + np.cross(jacobian[3:], arm, axis=0)
            rows.append(self.along((point, way)) @ moved)
        return joint_shape(self.posed, np.array(rows), shapes.shape[:, mode])

    def text(self, way: Way) -> str:
        """A point's name with a direction."""
        return f"{self.points[way[0]].name} {_sense(way[1])}"


def _tested(arm: Arm, campaign: Campaign, posture: CampaignPosture) -> _Tested:
    values = arm.robot.posture(dict(posture.q))
    placed = link_placements(arm.robot, values.values)
    positions = {
        point.id: placed[point.link][:3, :3] @ np.array(point.xyz) + placed[point.link][:3, 3]
        for point in campaign.points
    }
    responses, references = _ways(campaign, posture.id)
    points = {point.id: point for point in campaign.points}
    turned = {point.id: placed[point.link][:3, :3] for point in campaign.points}
    lines = campaign.trace_lines
    return _Tested(arm, posture, values, positions, points, turned, responses, references, lines)


def _ways(campaign: Campaign, posture: int) -> tuple[tuple[Way, ...], tuple[Way, ...]]:
    """Directions of the sensors and of the hammer in a posture, each once."""
    responses: dict[Way, None] = {}
    references: dict[Way, None] = {}
    frfs = campaign.frfs
    if frfs is not None:
        for row in np.flatnonzero(frfs.posture == posture).tolist():
            responses[int(frfs.response[row, 0]), int(frfs.response[row, 1])] = None
            references[int(frfs.reference[row, 0]), int(frfs.reference[row, 1])] = None
    for blow in campaign.blows:
        if blow.posture == posture:
            references[blow.reference] = None
            responses |= dict.fromkeys(blow.channels)
    return tuple(responses), tuple(references)


def _count(things: Sequence[object], name: str) -> str:
    return f"{len(things)} {name}{'' if len(things) == 1 else 's'}"


def _sense(way: int) -> str:
    return f"{'+' if way > 0 else '−'}{'xyz'[abs(way) - 1]}"


def _modes_of(posture: CampaignPosture, shapes: Sequence[FittedShapes]) -> list[tuple[FittedShapes, int]]:
    own = [shape for shape in shapes if shape.posture == posture.id]
    if not own:
        return []
    best = max(own, key=lambda shape: len(shape.places))
    return [(best, mode) for mode in range(len(best.frequency))]


def _swing(tested: _Tested, shapes: FittedShapes, mode: int) -> tuple[Drawn, Motion]:
    """Balls that move as the residues say, with the way of each between its extremes."""
    group = f"shape_{tested.posture.id}_{mode}"
    moved = _amplitudes(tested, shapes, mode)
    joints = tested.joints(shapes, mode)
    odd = odd_points(shapes, mode, joints)
    phases = 2 * np.pi * np.arange(FRAMES + 1) / FRAMES
    largest = max(float(np.max(np.linalg.norm(_at(moved[p], phases), axis=1))) for p in moved)
    scale = SHARE * tested.arm.reach / largest if largest > 0 else 0.0
    scale = min(scale, joints.widest(tested.posed, tested.arm.reach))
    nodes, items, tracks, ends = {}, [], {}, []
    for point, amplitude in moved.items():
        node, rest = f"{group}/point_{point}", tested.positions[point]
        path = rest + scale * _at(amplitude, phases)
        nodes[node] = marks.at(rest)
        colour = TARGET if point in odd else EXTREME
        items.append(Item(f"{node}/ball", Sphere(1.4 * _BALL * tested.arm.reach), colour, on_top=True))
        tracks[node] = np.array([marks.at(place) for place in path])
        far = int(np.argmax(np.linalg.norm(path - rest, axis=1)))
        ends.append(np.array([path[far], 2 * rest - path[far]]))
    items.append(Item(f"{group}/ways", Lines(np.array(ends)), EXTREME))
    frequency = plain(shapes.frequency[mode])
    rows = tuple(
        (tested.text(way), f"{abs(value):.2f} at {np.degrees(np.angle(value)):.0f}°".replace("-", "−"))
        for way, value in zip(shapes.places, shapes.shape[:, mode], strict=True)
    )
    tracks |= dict(Deflection(tested.posed, joints.amplitude).tracks(tested.arm, (tested.group,), scale))
    like, mac = joints.nearest
    rows += (
        ("the joints can do", f"{100 * joints.share:.0f} % of it"),
        ("most like it", f"the card's mode at {plain(like)} Hz, MAC {mac:.2f}"),
    )
    legend = [Swatch("as the fitted mode moves the points", EXTREME, "dot")]
    if odd:
        legend.append(Swatch("where the joints of the card cannot follow", TARGET, "dot"))
    fixed = "hammer" if shapes.side == "reference" else "sensor"
    motion = Motion(
        f"{tested.posture.id}: {frequency} Hz",
        tracks,
        0.0,
        shows=(tested.group, group),
        legend=tuple(legend),
        table=Table(f"Mode at {frequency} Hz, {fixed} at {tested.text(shapes.fixed)}", (), rows),
        notes=(
            "The points move as measured; the arm as its joints come nearest to that with the least elastic "
            "energy. Drawn as large as can be seen well.",
        ),
    )
    return Drawn(nodes, items, []), motion


def _amplitudes(tested: _Tested, shapes: FittedShapes, mode: int) -> dict[int, Complex[np.ndarray, "3"]]:
    """Complex displacement of each point, its directions put together."""
    moved: dict[int, Complex[np.ndarray, "3"]] = {}
    for way, value in zip(shapes.places, shapes.shape[:, mode], strict=True):
        moved[way[0]] = moved.get(way[0], np.zeros(3, dtype=complex)) + value * tested.along(way)
    return moved


def _at(amplitude: np.ndarray, phases: np.ndarray) -> Float[np.ndarray, "frame 3"]:
    moved: Float[np.ndarray, "frame 3"] = (amplitude[None, :] * np.exp(1j * phases)[:, None]).real
    return moved

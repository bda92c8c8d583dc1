"""A campaign on its robot: every posture with sensors and hammer, and how fitted modes move the points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.campaign import Campaign, CampaignPosture
from flexmodal.ema.shapes import FittedShapes, Way
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.model import Posture, Robot
from flexmodal.model.placements import link_placements
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.marks import Drawn
from flexmodal_viewer.motion import FRAMES, SHARE
from flexmodal_viewer.palette import EXTREME, FORCE, POINT
from flexmodal_viewer.scene import Caption, Item, Label, Matrix, Motion, Scene, Swatch, Table
from flexmodal_viewer.shapes import Lines, Sphere
from flexmodal_viewer.stage import set_stage, view_of
from flexmodal_viewer.units import joint_value, plain

_BALL, _RESPONSE, _HAMMER = 0.012, 0.07, 0.13
"""Sizes of points and arrows, as parts of the arm's reach."""


def campaign_scene(robot: Robot, campaign: Campaign, shapes: Sequence[FittedShapes] = ()) -> Scene:
    """Draw the postures of a campaign, a button each, and under each of them its fitted shapes.

    Args:
        robot: what was tested, or what the tester believes it to be.
        campaign: postures, points, and the directions of its FRFs or blows.
        shapes: of fitted modes; of each posture those of the first fixed place that has the most points.

    Raises:
        InvalidCampaign: postures or points that the robot does not have, all of them at once.
    """
    _refuse_strangers(robot, campaign)
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
        f"{robot.title or robot.name}: {len(campaign.postures)} postures, {len(campaign.points)} points",
        _legend(bool(shapes)),
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
    names: Mapping[int, str]
    responses: tuple[Way, ...]
    references: tuple[Way, ...]

    @property
    def group(self) -> str:
        """Node that carries the arm and its marks."""
        return f"posture_{self.posture.id}"

    def drawn(self) -> Drawn:
        """The arm, a ball on each point, an arrow for each direction of a sensor or the hammer."""
        arm, reach = self.arm, self.arm.reach
        nodes = arm.nodes(self.group, self.values.values)
        found = Drawn(nodes, arm.items(self.group, lambda own: own), [])
        for number, position in self.positions.items():
            node = f"{self.group}/point_{number}"
            ball = Item(f"{node}/ball", Sphere(_BALL * reach), POINT, on_top=True)
            found = found.beside(Drawn({node: marks.at(position)}, [ball], [Label(self.names[number], node)]))
        for kind, ways in (("response", self.responses), ("hammer", self.references)):
            for place, way in enumerate(ways):
                found = found.beside(self._arrow(kind, place, way))
        return found

    def _arrow(self, kind: str, number: int, way: Way) -> Drawn:
        """A sensor's arrow begins at its point; the hammer's ends there."""
        size = self.arm.reach * (_RESPONSE if kind == "response" else _HAMMER)
        axis = direction(way)
        start = self.positions[way[0]] - (0 if kind == "response" else size) * axis
        colour = POINT if kind == "response" else FORCE
        return marks.arrow(f"{self.group}/{kind}_{number}", axis, start, size, colour)

    def still(self) -> Motion:
        """The button that shows this posture at rest."""
        robot = self.arm.robot
        rows = [
            (name, joint_value(value, robot.moving[name].type)) for name, value in self.values.values.items()
        ]
        measured = (
            ("sensor", ", ".join(self._text(way) for way in self.responses) or "nowhere"),
            ("hammer", ", ".join(self._text(way) for way in self.references) or "nowhere"),
        )
        table = Table(f"Posture {self.posture.id}", (), (*rows, *measured))
        return Motion(f"{self.posture.id}: {self.posture.name}", {}, 0.0, shows=(self.group,), table=table)

    def _text(self, way: Way) -> str:
        point, sense = way
        return f"{self.names[point]} {'+' if sense > 0 else '−'}{'xyz'[abs(sense) - 1]}"


def _tested(arm: Arm, campaign: Campaign, posture: CampaignPosture) -> _Tested:
    values = arm.robot.posture(dict(posture.q))
    placed = link_placements(arm.robot, values.values)
    positions = {
        point.id: placed[point.link][:3, :3] @ np.array(point.xyz) + placed[point.link][:3, 3]
        for point in campaign.points
    }
    responses, references = _ways(campaign, posture.id)
    names = {point.id: point.name for point in campaign.points}
    return _Tested(arm, posture, values, positions, names, responses, references)


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


def direction(way: Way) -> Float[np.ndarray, "3"]:
    """±1, ±2, ±3 as a unit vector along ±x, ±y, ±z of the world."""
    axis: Float[np.ndarray, "3"] = np.eye(3)[abs(way[1]) - 1] * np.sign(way[1])
    return axis


def _modes_of(posture: CampaignPosture, shapes: Sequence[FittedShapes]) -> list[tuple[FittedShapes, int]]:
    own = [shape for shape in shapes if shape.posture == posture.id]
    if not own:
        return []
    best = max(own, key=lambda shape: len(shape.places))
    return [(best, mode) for mode in range(len(best.frequency))]


def _swing(tested: _Tested, shapes: FittedShapes, mode: int) -> tuple[Drawn, Motion]:
    """Balls that move as the residues say, with the way of each between its extremes."""
    group = f"shape_{tested.posture.id}_{mode}"
    moved = _amplitudes(shapes, mode)
    phases = 2 * np.pi * np.arange(FRAMES + 1) / FRAMES
    largest = max(float(np.max(np.linalg.norm(_at(moved[p], phases), axis=1))) for p in moved)
    scale = SHARE * tested.arm.reach / largest if largest > 0 else 0.0
    nodes, items, tracks, ends = {}, [], {}, []
    for point, amplitude in moved.items():
        node, rest = f"{group}/point_{point}", tested.positions[point]
        path = rest + scale * _at(amplitude, phases)
        nodes[node] = marks.at(rest)
        items.append(Item(f"{node}/ball", Sphere(1.4 * _BALL * tested.arm.reach), EXTREME, on_top=True))
        tracks[node] = np.array([marks.at(place) for place in path])
        far = int(np.argmax(np.linalg.norm(path - rest, axis=1)))
        ends.append(np.array([path[far], 2 * rest - path[far]]))
    items.append(Item(f"{group}/ways", Lines(np.array(ends)), EXTREME))
    frequency = plain(shapes.frequency[mode])
    rows = tuple(
        (tested._text(way), f"{abs(value):.2f} at {np.degrees(np.angle(value)):.0f}°".replace("-", "−"))
        for way, value in zip(shapes.places, shapes.shape[:, mode], strict=True)
    )
    fixed = "hammer" if shapes.side == "reference" else "sensor"
    motion = Motion(
        f"{tested.posture.id}: {frequency} Hz",
        tracks,
        0.0,
        shows=(tested.group, group),
        legend=(Swatch("as the fitted mode moves the points", EXTREME, "dot"),),
        table=Table(f"Mode at {frequency} Hz, {fixed} at {tested._text(shapes.fixed)}", (), rows),
        notes=("Only what was measured moves; drawn as large as can be seen well.",),
    )
    return Drawn(nodes, items, []), motion


def _amplitudes(shapes: FittedShapes, mode: int) -> dict[int, Complex[np.ndarray, "3"]]:
    """Complex displacement of each point, its directions put together."""
    moved: dict[int, Complex[np.ndarray, "3"]] = {}
    for way, value in zip(shapes.places, shapes.shape[:, mode], strict=True):
        moved[way[0]] = moved.get(way[0], np.zeros(3, dtype=complex)) + value * direction(way)
    return moved


def _at(amplitude: np.ndarray, phases: np.ndarray) -> Float[np.ndarray, "frame 3"]:
    moved: Float[np.ndarray, "frame 3"] = (amplitude[None, :] * np.exp(1j * phases)[:, None]).real
    return moved


def _legend(fitted: bool) -> tuple[Swatch, ...]:
    found = [
        Swatch("points, and the directions of the sensor", POINT, "arrow"),
        Swatch("where the hammer hits", FORCE, "arrow"),
    ]
    return tuple([*found, Swatch("points in a fitted mode", EXTREME, "dot")] if fitted else found)


def _refuse_strangers(robot: Robot, campaign: Campaign) -> None:
    """Complain of all postures and points that the robot cannot have."""
    from flexmodal.errors import InvalidPosture

    source = str(campaign.path or campaign.title)
    faults: list[Fault] = []
    for posture in campaign.postures:
        try:
            robot.posture(dict(posture.q), source=f"{source}: posture {posture.id}")
        except InvalidPosture as error:
            faults += error.faults
    links = [link.name for link in robot.urdf.links]
    for point in campaign.points:
        if point.link not in links:
            faults.append(
                Fault(
                    source,
                    f"point {point.id}: link",
                    repr(point.link),
                    f"a link of {robot.name}: {', '.join(links)}",
                )
            )
    if faults:
        raise InvalidCampaign(faults)

"""What is drawn beside the arm: target, force, points, grid and axes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.frf import PointDirection
from flexmodal_viewer.arm import Arm, along
from flexmodal_viewer.palette import AXIS, FORCE, GRID, POINT, TARGET, Colour
from flexmodal_viewer.scene import Item, Label, Matrix
from flexmodal_viewer.shapes import Box, Cylinder, Lines, Ring, Sphere


@dataclass(frozen=True)
class Drawn:
    """Nodes, items and labels to be put into a scene."""

    nodes: dict[str, Matrix]
    items: list[Item]
    labels: list[Label]

    def beside(self, other: Drawn) -> Drawn:
        """Both together."""
        return Drawn(self.nodes | other.nodes, self.items + other.items, self.labels + other.labels)


def at(position: Float[np.ndarray, "3"]) -> Matrix:
    """A placement at a position, not turned."""
    place = np.eye(4)
    place[:3, 3] = position
    return place


def target(position: Float[np.ndarray, "3"], size: float) -> Drawn:
    """A cross in space where a point is held [m].

    Args:
        position: of the centre [m].
        size: length of the bars [m].
    """
    bar = size / 9
    items = [
        Item(f"target/bar_{axis}", Box(tuple(np.where(np.arange(3) == axis, size, bar))), TARGET, on_top=True)
        for axis in range(3)
    ]
    items.append(Item("target/ball", Sphere(size / 5), TARGET, on_top=True))
    return Drawn({"target": at(position)}, items, [Label("target", "target", "mark")])


def force(direction: PointDirection, position: Float[np.ndarray, "3"], size: float, number: int = 0) -> Drawn:
    """An arrow from a point along a force, or a bent one about the axis of a moment.

    Args:
        direction: and point of the force.
        position: of the point [m].
        size: length of the arrow [m].
        number: of the force, where there are several.
    """
    group = f"force_{number}"
    axis = direction.selector[3:] if direction.is_rotation else direction.selector[:3]
    node = along(axis)
    node[:3, 3] = position
    build = _moment if direction.is_rotation else _arrow
    sense = f"{'+' if direction.sign > 0 else '−'}{direction.axis.removeprefix('r')}"
    text = f"moment about {sense}" if direction.is_rotation else f"force {sense}"
    tip = node @ at(np.array([0.0, 0.0, 1.12 * size]))
    nodes = {group: node, f"force_{number}_tip": at(tip[:3, 3])}
    return Drawn(nodes, build(group, size), [Label(text, f"force_{number}_tip", "mark")])


def arrow(
    group: str, axis: Float[np.ndarray, "3"], start: Float[np.ndarray, "3"], size: float, colour: Colour
) -> Drawn:
    """An arrow of some length [m] along a unit vector, without a name.

    Args:
        group: path of the arrow.
        axis: unit vector along it.
        start: where it begins [m].
        size: its length [m].
        colour: of it.
    """
    node = along(axis)
    node[:3, 3] = start
    return Drawn({group: node}, _arrow(group, size, colour), [])


def _arrow(group: str, size: float, colour: Colour = FORCE) -> list[Item]:
    radius, head = size / 28, size / 3
    shaft = Cylinder(radius, size - head)
    return [
        Item(f"{group}/shaft", shaft, colour, at(np.array([0, 0, (size - head) / 2])), on_top=True),
        Item(
            f"{group}/head",
            Cylinder(head / 3, head, top=0.0),
            colour,
            at(np.array([0, 0, size - head / 2])),
            on_top=True,
        ),
    ]


def _moment(group: str, size: float) -> list[Item]:
    radius, arc = size * 0.6, 1.5 * math.pi
    head = Cylinder(size / 7, size / 3, top=0.0)
    tangent = np.array([-math.sin(arc), math.cos(arc), 0.0])
    end = along(tangent)
    end[:3, 3] = radius * np.array([math.cos(arc), math.sin(arc), 0.0])
    return [
        Item(f"{group}/ring", Ring(radius, size / 28, arc), FORCE, on_top=True),
        Item(f"{group}/head", head, FORCE, end, on_top=True),
    ]


def points(arm: Arm, group: str, size: float) -> Drawn:
    """A ball and a name at each measurement point of the card, moving with its link.

    Args:
        arm: with the card.
        group: the drawn posture.
        size: of a ball [m].
    """
    drawn = Drawn({}, [], [])
    for number, name in enumerate(arm.robot.points):
        link, place = arm.carrier(name)
        path = f"{arm.node(group, link)}/point_{number}"
        drawn.items.append(Item(path, Sphere(size), POINT, place, on_top=True))
        drawn.labels.append(Label(name, f"{path}/<object>"))
    return drawn


def nice_step(length: float, most: int) -> float:
    """The smallest of 1, 2, 5 times a power of ten that divides a length into `most` parts or fewer.

    Args:
        length: above 0.
        most: parts.
    """
    rough = length / most
    power = 10.0 ** math.floor(math.log10(rough))
    return next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough * (1 - 1e-9))


def grid(
    low: Float[np.ndarray, "3"], high: Float[np.ndarray, "3"], across: int, behind: float | None, floor: float
) -> tuple[Drawn, float]:
    """A grid over the extent of the arm, and its step [m].

    Args:
        low: least coordinates of the arm.
        high: largest ones.
        across: the axis that the grid lies across.
        behind: coordinate along that axis of a grid that stands behind a planar arm; None for a floor.
        floor: coordinate of the floor, the level of a grid that lies under the arm.
    """
    first, second = (axis for axis in range(3) if axis != across)
    if behind is None:
        low, high = np.minimum(low, 0), np.maximum(high, 0)
    step = nice_step(
        float(max(high[first] - low[first], high[second] - low[second])), 12 if behind is not None else 8
    )
    edges = {
        axis: (math.floor(low[axis] / step + 1e-6), math.ceil(high[axis] / step - 1e-6))
        for axis in (first, second)
    }
    level = floor if behind is None else behind
    drawn = Drawn({}, [], [])
    ends: list[np.ndarray] = []
    for axis, other in ((first, second), (second, first)):
        for count in range(edges[axis][0], edges[axis][1] + 1):
            line = np.full((2, 3), level)
            line[:, axis] = count * step
            line[:, other] = np.array(edges[other]) * step
            ends.append(line)
            if behind is None:
                continue  # numbers along a floor would stand in the way of the arm
            path = f"grid/tick_{axis}_{count}"
            drawn.nodes[path] = at(line[0])
            text = f"{count * step:.6g}".replace("-", "−")
            if count == edges[axis][1]:
                text = f"{'xyz'[axis]} {text} m"
            drawn.labels.append(Label(text, path, "tick beside" if axis == second else "tick below"))
    drawn.items.append(Item("grid/lines", Lines(np.array(ends)), GRID, framed=behind is not None))
    return drawn, step


def axes(position: Float[np.ndarray, "3"], size: float) -> Drawn:
    """Arrows along the axes of the world.

    Args:
        position: of the origin [m].
        size: length of the arrows [m].
    """
    drawn = Drawn({"axes": at(position)}, [], [])
    for axis in range(3):
        end = np.eye(3)[axis]
        turn = along(end)
        shaft, tip = turn.copy(), turn.copy()
        shaft[:3, 3], tip[:3, 3] = end * size * 0.4, end * size * 0.9
        drawn.items.append(
            Item(f"axes/shaft_{axis}", Cylinder(size / 40, size * 0.8), AXIS, shaft, on_top=True)
        )
        drawn.items.append(
            Item(f"axes/tip_{axis}", Cylinder(size / 12, size * 0.2, top=0.0), AXIS, tip, on_top=True)
        )
        drawn.nodes[f"axes/name_{axis}"] = at(end * size * 1.15)
        drawn.labels.append(Label("xyz"[axis], f"axes/name_{axis}", "axis"))
    return drawn

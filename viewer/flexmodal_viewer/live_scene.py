"""A robot whose joints can be moved on the page, its receptance and modes following."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexmodal.campaign import Campaign, CampaignPoint
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot, Posture, Robot
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm, along
from flexmodal_viewer.live_measured import measured_curves, measured_points
from flexmodal_viewer.live_numbers import live_numbers
from flexmodal_viewer.obstacles import LEGEND as OBSTACLES
from flexmodal_viewer.obstacles import obstacles
from flexmodal_viewer.palette import FORCE, JOINT, OPTIMISED, PLAIN, POINT, START, TARGET, shade
from flexmodal_viewer.scene import Caption, Item, Scene, Swatch
from flexmodal_viewer.shapes import Ring, Sphere
from flexmodal_viewer.stage import set_stage, view_of

_GHOST, _CLOUD = 0.3, 0.4
"""Opacity of the posture at rest, and of the ellipsoid."""
_BEYOND = 1.25
"""The axis of frequencies ends so far beyond the highest mode that it shows."""
_WIDEST = 30.0
"""Modes higher than so many times the first are left off the axis at first."""


def live_scene(
    robot: Robot,
    posture: Posture,
    *,
    response: str | PointDirection | None = None,
    frequency: float | None = None,
    band: tuple[float, float] | None = None,
    swing: str = "",
    others: Mapping[str, Robot] | None = None,
    measured: Campaign | None = None,
    workspace: bool = False,
    points: Sequence[str] = (),
) -> Scene:
    """Draw a robot that can be put in postures by hand.

    Args:
        robot: what to draw; each of its joints turns about an axis or slides along one.
        posture: how it stands when the page opens.
        response: point and direction of force and motion; the tool along z if none.
        frequency: chosen at first [Hz]; that of the first mode if none.
        band: first and last frequency of the axis [Hz]; from 0 beyond the modes if none.
        swing: "force" or "mode" if it swings when the page opens.
        others: models to compare with on the same axes, by what they are called.
        measured: a campaign whose FRFs stand on the same axes while the arm is in one of its postures.
        workspace: with the map of the workspace laid when the page opens.
        points: that can be pushed at besides those of the card and the one of `response`.

    Raises:
        InvalidPoint, InvalidFrequencies, InvalidPosture: bad arguments.
        SingularResponse: an undamped mode is driven at its natural frequency.
        InvalidRequest: joints of another kind, here or among the others, a campaign without FRFs, or a band
            that is none.
    """
    posed = robot.at(posture)
    if isinstance(response, list | tuple):
        raise InvalidRequest(Fault("call", "response", "several", "one point and direction"))
    (direction,) = posed.directions(response)
    if frequency is not None:
        posed.frf([frequency], response=direction)  # refuses what is no frequency, and an infinite response
    arm = Arm(robot)
    tested = {} if measured is None else measured_points(measured)
    lowest = float(posed.modes().frequency[0])
    beside = others or {}
    live = {
        "robot": _numbers(robot, [direction.point, *points], tested),
        "posture": dict(posture.values),
        "response": str(direction),
        "hertz": lowest if frequency is None else frequency,
        "band": _band(posed, band),
        "swing": swing,
        "map": workspace,
        "reach": arm.reach,
        "others": [{"name": name, "robot": _numbers(one, (), tested)} for name, one in beside.items()],
        "measured": [] if measured is None else measured_curves(robot, measured),
    }
    return _staged(arm, posed, direction, live)


def _staged(arm: Arm, posed: PosedRobot, direction: PointDirection, live: Mapping[str, Any]) -> Scene:
    """The arm with its marks and its words, on a stage."""
    robot, posture = arm.robot, posed.posture
    drawn = _drawn(arm, posed, direction)
    around, hidden = obstacles(arm, "arm")
    drawn = drawn.beside(around)
    where = f"{robot.name}, posture {posture.name}" if posture.name else robot.name
    legend = (*_legend(robot), *([OBSTACLES] if around.items else []))
    caption = Caption(robot.title or robot.name, where, legend, (), (*arm.looks.notes, *hidden))
    view = view_of(robot, posed.position(robot.tool))
    return set_stage(Scene(caption, view, drawn.nodes, tuple(drawn.items), tuple(drawn.labels), live=live))


def _numbers(robot: Robot, points: Sequence[str], measured: Mapping[str, CampaignPoint]) -> dict[str, Any]:
    numbers = live_numbers(robot, points, measured)
    if numbers is None:
        raise InvalidRequest(
            Fault(robot.name, "joints", "joints of another kind", "joints that turn or slide, on a live page")
        )
    return numbers


def _band(posed: PosedRobot, given: tuple[float, float] | None) -> list[float]:
    """As it was given; or from 0 to beyond the modes, those much higher than the first left out."""
    if given is not None:
        first, last = given
        if not 0 <= first < last < np.inf:
            found = f"{first:g} to {last:g} Hz"
            raise InvalidRequest(Fault("call", "band", found, "two ascending frequencies"))
        return [float(first), float(last)]
    modes = posed.modes().frequency
    modes = modes[modes <= _WIDEST * max(float(modes[0]), 1e-3)] if modes[0] > 0 else modes
    rough = _BEYOND * float(modes[-1]) or 1.0
    step = marks.nice_step(rough, 40)
    return [0.0, float(np.ceil(rough / step) * step)]


def _legend(robot: Robot) -> tuple[Swatch, ...]:
    found = [
        Swatch("arm", PLAIN, "own"),
        Swatch("the same at rest, while it swings", START, "clear"),
        Swatch("joints: the larger and the more orange, the more of the energy", JOINT, "dot"),
        Swatch("tool; drag it", TARGET, "dot"),
        Swatch("force", FORCE, "arrow"),
        Swatch("receptance ellipsoid: how far unit forces move the tool", OPTIMISED, "clear"),
    ]
    if robot.points:
        found.append(Swatch("measurement points", POINT, "dot"))
    return tuple(found)


def _drawn(arm: Arm, posed: PosedRobot, direction: PointDirection) -> marks.Drawn:
    robot, values, reach = arm.robot, posed.posture.values, arm.reach
    still = arm.still_links()
    drawn = marks.Drawn(arm.nodes("arm", values), arm.items("arm", lambda own: own), [])
    ghost = arm.items("rest", lambda own: shade(START, own), opacity=_GHOST, skip=still)
    drawn = drawn.beside(marks.Drawn(arm.nodes("rest", values), ghost, []))
    others = [
        Item(f"ring_{number}/ring", Ring(0.035 * reach, 0.007 * reach), JOINT, on_top=True, framed=False)
        for number in range(len(robot.joints))
    ]
    others.append(Item("handle/ball", Sphere(0.016 * reach), TARGET, on_top=True))
    others.append(Item("ellipsoid/ball", Sphere(1.0), OPTIMISED, opacity=_CLOUD, framed=False))
    drawn = drawn.beside(marks.Drawn({"handle": marks.at(posed.position(robot.tool))}, others, []))
    # A straight arrow and a bent one, of which the page shows the one that is meant.
    for number, kind in enumerate(("+z", "+rz")):
        arrow = marks.force(PointDirection.parse(f"tool:{kind}"), np.zeros(3), 0.16 * reach, number)
        drawn = drawn.beside(marks.Drawn(arrow.nodes, arrow.items, []))
    if robot.points:
        drawn = drawn.beside(marks.points(arm, "arm", 0.012 * reach))
    place = along(direction.selector[:3] + direction.selector[3:])
    place[:3, 3] = posed.position(direction.point)
    drawn.nodes["force_0"] = drawn.nodes["force_1"] = place
    return drawn

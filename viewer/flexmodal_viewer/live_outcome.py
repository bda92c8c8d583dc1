"""A posture search as a film: from the start down to the optimum, the other optima as ghosts, all live."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.errors import FlexmodalError
from flexmodal.frf import PointDirection
from flexmodal.model import Posture, Robot
from flexmodal.model.placements import link_placements
from flexmodal.optimisation import (
    MobilityObjective,
    Objective,
    Outcome,
    PostureProblem,
    ReceptanceObjective,
    SeparationObjective,
    StiffnessObjective,
    TunedObjective,
)
from flexmodal.optimisation.pictures.traces import Trace, follow
from flexmodal.optimisation.search import random_starts
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.live_scene import live_scene
from flexmodal_viewer.outcome_scene import directions_of, heading_of, judge_of, target_of, worst_line
from flexmodal_viewer.palette import START, TARGET, shade
from flexmodal_viewer.scene import Label, Scene, Swatch
from flexmodal_viewer.units import quantity

_MOST_OPTIMA = 8
"""In the list."""
_MOST_GHOSTS = 3
"""Optima besides the best that stand in the picture."""
_MOST_DESCENTS = 12
"""Followed step by step; a search makes more."""
_SAME = 1e-5
"""Relative difference of two values that are one optimum's, where a search compiled and one in Python end."""
_CLEAR, _CLEARER = 0.42, 0.16
"""Opacity of the start, and of the other optima."""


def live_outcome_scene(outcome: Outcome, *, start: Posture | None) -> Scene:
    """Draw what a search found, ready to be gone through and to be changed by hand.

    Args:
        outcome: of a robot that a live page can move.
        start: posture to compare with, and where the film begins, if any.

    Raises:
        InvalidRequest: joints that the page cannot move.
    """
    robot, best = outcome.problem.robot, outcome.problem.robot.at(outcome.best.posture)
    judge = judge_of(outcome)
    asked: dict[str, Any] = {}
    ways = directions_of(outcome)
    if ways:
        asked["response"] = ways[0]
        asked["points"] = [one.point for one in ways]
    if isinstance(judge, TunedObjective):
        asked["frequency"] = judge.frequency_at(best)
    elif isinstance(judge, ReceptanceObjective):
        asked["frequency"] = worst_line(judge, best if start is None else robot.at(start))
    scene = live_scene(robot, outcome.best.posture, **asked)
    drawn, legend = _ghosts(outcome, start)
    caption = replace(
        scene.caption,
        subtitle=heading_of(outcome),
        legend=(*scene.caption.legend, *legend),
        notes=(f"Search: {outcome.verdict}.", *scene.caption.notes),
    )
    return replace(
        scene,
        caption=caption,
        nodes={**scene.nodes, **drawn.nodes},
        items=(*scene.items, *drawn.items),
        labels=(*scene.labels, *drawn.labels),
        live={**(scene.live or {}), "search": _search(outcome, start)},
    )


def _search(outcome: Outcome, start: Posture | None) -> dict[str, Any]:
    """Optima, start and the ways down, with their values."""
    found, problem = outcome.optima[:_MOST_OPTIMA], outcome.problem
    judge, hold = problem.objective, problem.hold
    held = ""
    if hold is not None:
        held = "place" if hold.orientation is None or hold.orientation.components == 2 else "turn"
    return {
        "heading": heading_of(outcome),
        "unit": judge.unit,
        "large": judge.larger_is_better,
        "held": held if hold is not None and hold.point == problem.robot.tool else "",
        "objective": judged(judge, problem.robot),
        "optima": [
            {"q": dict(one.posture.values), "value": _finite(one.objective), "hits": one.hits}
            for one in found
        ],
        "start": None if start is None else dict(start.values),
        "descents": _descents(outcome, start),
    }


def judged(judge: Objective, robot: Robot) -> dict[str, Any] | None:
    """An objective in numbers, for the page to compute; None for one that it cannot.

    Args:
        judge: of the search.
        robot: whose postures are judged.
    """
    if isinstance(judge, ReceptanceObjective):
        return {
            "kind": "receptance",
            "directions": [str(one) for one in judge.directions],
            "frequencies": np.asarray(judge.frequency).tolist(),
            "combine": judge.combine,
            "weights": list(judge.weights),
            "toward": list(judge.toward),
            "over": judge.over,
            "shares": list(judge.line_weights),
        }
    if isinstance(judge, StiffnessObjective):
        rows = robot.task if judge.task == "full" else robot.task[: 2 if robot.is_planar else 3]
        way = PointDirection.parse(judge.direction)
        along = (rows @ way.selector).tolist()
        return {"kind": "stiffness", "point": way.point, "rows": rows.tolist(), "along": along}
    if isinstance(judge, MobilityObjective):
        return {"kind": "mobility", "direction": str(judge.direction)}
    if isinstance(judge, SeparationObjective):
        return {"kind": "separation", "frequency": judge.frequency}
    return None


def _descents(outcome: Outcome, start: Posture | None) -> list[dict[str, Any]]:
    """Descents of the search followed again, step by step: from the start, and from the first random ones."""
    problem, found = outcome.problem, []
    if start is not None:
        found.append(("from the start", start))
    if outcome.seed is not None and problem.clearance is None:  # which is kept by other steps than these
        count = min(_MOST_DESCENTS, outcome.tried) - len(found)
        vectors = random_starts(problem, max(count, 0), np.random.default_rng(outcome.seed))
        found += [(f"from random start {n}", problem.posture(v)) for n, v in enumerate(vectors, start=1)]
    told = [(name, _trace(problem, posture)) for name, posture in found]
    return [_descent(outcome, name, trace) for name, trace in told if trace is not None]


def _trace(problem: PostureProblem, start: Posture) -> Trace | None:
    """None of a start that comes to nothing, as some of any search do."""
    try:
        return follow(problem, start)
    except FlexmodalError:
        return None


def _descent(outcome: Outcome, name: str, trace: Trace) -> dict[str, Any]:
    names = list(outcome.problem.robot.commanded)
    steps = [
        {"q": dict(zip(names, values.tolist(), strict=True)), "value": _finite(float(value))}
        for values, value in zip(trace.values, trace.objective, strict=True)
    ]
    last = float(outcome.problem.objective.value(outcome.problem.posed(trace.values[-1])))
    return {"name": name, "end": _end(outcome, last), "steps": steps}


def _end(outcome: Outcome, value: float) -> int | None:
    """Which of the optima listed has this value; the search takes postures of equal value for one."""
    for number, one in enumerate(outcome.optima[:_MOST_OPTIMA]):
        if abs(value - one.objective) <= _SAME * abs(one.objective):
            return number
    return None


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _ghosts(outcome: Outcome, start: Posture | None) -> tuple[marks.Drawn, list[Swatch]]:
    robot, unit = outcome.problem.robot, outcome.problem.objective.unit
    arm, drawn, legend = Arm(robot), marks.Drawn({}, [], []), []
    still = arm.still_links()

    def ghost(group: str, posture: Posture, opacity: float, text: str) -> marks.Drawn:
        items = arm.items(group, lambda own: shade(START, own), opacity=opacity, skip=still)
        nodes = arm.nodes(group, posture.values)
        nodes[f"{group}/value"] = marks.at(_elbow(robot, posture))
        return marks.Drawn(nodes, items, [Label(text, f"{group}/value", "mark")])

    if start is not None:
        first = outcome.start
        text = "start" if first is None else f"start: {quantity(first, unit) if np.isfinite(first) else '∞'}"
        drawn = drawn.beside(ghost("start", start, _CLEAR, text))
        legend.append(Swatch("start posture; its curve is dashed", START, "clear"))
    others = outcome.optima[1 : 1 + _MOST_GHOSTS]
    for number, one in enumerate(others, start=2):
        text = f"optimum {number}: {quantity(one.objective, unit)}"
        drawn = drawn.beside(ghost(f"optimum_{number}", one.posture, _CLEARER, text))
    if others:
        legend.append(Swatch("other optima, fainter", START, "clear"))
    held = target_of(outcome, robot.at(outcome.best.posture))
    if held is not None:
        drawn = drawn.beside(marks.target(held, 0.07 * arm.reach))
        legend.append(Swatch("target", TARGET, "cross"))
    return drawn, legend


def _elbow(robot: Robot, posture: Posture) -> Float[np.ndarray, "3"]:
    """The joint farthest from the straight line between the first joint and the tool [m]."""
    placed = link_placements(robot, posture.values)
    spots = np.array([placed[joint.child][:3, 3] for joint in robot.moving.values()])
    way = robot.at(posture).position(robot.tool) - spots[0]
    size = float(np.linalg.norm(way))
    along = way / size if size > 0 else np.zeros(3)
    apart = np.linalg.norm(np.cross(spots - spots[0], along), axis=1) if size > 0 else np.zeros(len(spots))
    spot: Float[np.ndarray, "3"] = spots[int(np.argmax(apart))]
    return spot

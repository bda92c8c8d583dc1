"""A posture search as a film: from the start down to the optimum, the other optima as ghosts, all live."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from flexmodal.errors import FlexmodalError
from flexmodal.model import Posture
from flexmodal.optimisation import Outcome, ReceptanceObjective, TunedObjective
from flexmodal.optimisation.pictures.traces import follow
from flexmodal_viewer import marks
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.live_scene import live_scene
from flexmodal_viewer.outcome_scene import directions_of, heading_of, judge_of, target_of, worst_line
from flexmodal_viewer.palette import START, TARGET, shade
from flexmodal_viewer.scene import Scene, Swatch

_MOST_OPTIMA = 8
"""In the list."""
_MOST_GHOSTS = 3
"""Optima besides the best that stand in the picture."""
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
    """Optima, start and the way between them, with their values."""
    found = outcome.optima[:_MOST_OPTIMA]
    return {
        "heading": heading_of(outcome),
        "unit": outcome.problem.objective.unit,
        "optima": [
            {"q": dict(one.posture.values), "value": _finite(one.objective), "hits": one.hits}
            for one in found
        ],
        "start": None if start is None else dict(start.values),
        "descent": _descent(outcome, start),
    }


def _descent(outcome: Outcome, start: Posture | None) -> list[dict[str, Any]]:
    """Every step from the start down; only the start and the best where it cannot be followed."""
    if start is None:
        return []
    problem = outcome.problem
    names = list(problem.robot.commanded)
    try:
        trace = follow(problem, start)
    except FlexmodalError:
        return []
    return [
        {"q": dict(zip(names, values.tolist(), strict=True)), "value": _finite(float(value))}
        for values, value in zip(trace.values, trace.objective, strict=True)
    ]


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _ghosts(outcome: Outcome, start: Posture | None) -> tuple[marks.Drawn, list[Swatch]]:
    robot = outcome.problem.robot
    arm, drawn, legend = Arm(robot), marks.Drawn({}, [], []), []
    still = arm.still_links()

    def ghost(group: str, posture: Posture, opacity: float) -> marks.Drawn:
        items = arm.items(group, lambda own: shade(START, own), opacity=opacity, skip=still)
        return marks.Drawn(arm.nodes(group, posture.values), items, [])

    if start is not None:
        drawn = drawn.beside(ghost("start", start, _CLEAR))
        legend.append(Swatch("start posture; its curve is dashed", START, "clear"))
    others = outcome.optima[1 : 1 + _MOST_GHOSTS]
    for number, one in enumerate(others):
        drawn = drawn.beside(ghost(f"optimum_{number}", one.posture, _CLEARER))
    if others:
        legend.append(Swatch("other optima, fainter", START, "clear"))
    held = target_of(outcome, robot.at(outcome.best.posture))
    if held is not None:
        drawn = drawn.beside(marks.target(held, 0.07 * arm.reach))
        legend.append(Swatch("target", TARGET, "cross"))
    return drawn, legend

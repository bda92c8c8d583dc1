"""Sequences of postures drawn over time: vibration, and each joint with its speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmodal.optimisation.path.plan import PathOutcome
from flexmodal.report.figure import WIDE, drawing, look, new_figure


@drawing
def draw_path(found: Mapping[str, PathOutcome]) -> Any:
    """Draw the values of some sequences over time, and the joints of the first.

    Args:
        found: sequences on one toolpath, by the name for the legend.

    Returns:
        A matplotlib figure.
    """
    figure = new_figure(WIDE, 6.4)
    upper, lower = figure.subplots(2, 1, sharex=True)
    first = next(iter(found.values()))
    time = np.array([point.time for point in first.problem.points])
    for place, (name, outcome) in enumerate(found.items()):
        upper.plot(time, outcome.values, label=name, **look(place, marker="os^d"[place % 4]))
    upper.set_yscale("log")
    upper.set_ylabel(f"‖αf‖ [{first.problem.points[0].objective.unit}]")
    upper.legend()
    for place, joint in enumerate(first.problem.robot.commanded):
        values = first.postures[:, place]
        turning = not first.problem.robot.commanded[joint].is_prismatic
        name = joint if turning else f"{joint} [m]"
        lower.plot(time, np.degrees(values) if turning else values, label=name, **look(place))
    lower.set_ylabel("Joint angles [°]")
    lower.set_xlabel("Time [s]")
    lower.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    robot = first.problem.robot
    upper.set_title(f"{robot.title or robot.name}: vibration along the path")
    lower.set_title(f"Postures, {next(iter(found))}")
    return figure

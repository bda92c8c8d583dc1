"""Sequences of postures drawn over time: vibration, and each joint with its speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmodal.frf.plot import PALETTE
from flexmodal.optimisation.path.plan import PathOutcome

_STYLES = ("-", "--", "-.", ":")


def draw_path(found: Mapping[str, PathOutcome]) -> Any:
    """Draw the values of some sequences over time, and the joints of the first.

    Args:
        found: sequences on one toolpath, by the name for the legend.

    Returns:
        A matplotlib figure.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 6.4), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    first = next(iter(found.values()))
    time = np.array([point.time for point in first.problem.points])
    for place, (name, outcome) in enumerate(found.items()):
        style = {"color": PALETTE[place], "linestyle": _STYLES[place % 4], "marker": "os^d"[place % 4]}
        upper.plot(time, outcome.values, label=name, markersize=4, **style)
    upper.set_yscale("log")
    upper.set_ylabel(f"‖αf‖ [{first.problem.points[0].objective.unit}]")
    upper.legend(fontsize=9)
    upper.grid(True, which="minor", axis="y", color="0.92", linewidth=0.4)
    for place, joint in enumerate(first.problem.robot.commanded):
        values = first.postures[:, place]
        turning = not first.problem.robot.commanded[joint].is_prismatic
        style = {"color": PALETTE[place % len(PALETTE)], "linestyle": _STYLES[place % 4]}
        name = joint if turning else f"{joint} [m]"
        lower.plot(time, np.degrees(values) if turning else values, label=name, **style)
    lower.set_ylabel("Joint angles [°]")
    lower.set_xlabel("Time [s]")
    lower.legend(fontsize=9, loc="center left", bbox_to_anchor=(1.0, 0.5))
    for axes in (upper, lower):
        axes.grid(True, which="major", color="0.85", linewidth=0.6)
    robot = first.problem.robot
    upper.set_title(f"{robot.title or robot.name}: vibration along the path", loc="left", fontsize=11)
    lower.set_title(f"Postures, {next(iter(found))}", loc="left", fontsize=11)
    return figure

"""Pictures of a posture search: the arm, the objective over its self-motion and the workspace, descents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.errors import FlexmodalError
from flexmodal.frf.plot import PALETTE, draw_frf
from flexmodal.model import PosedRobot, Posture, Robot
from flexmodal.optimisation.hold import Hold
from flexmodal.optimisation.objective import ReceptanceObjective
from flexmodal.optimisation.optimise import optimise
from flexmodal.optimisation.outcome import Outcome
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.quadratic import null_space

_STYLES = ("-", "--", "-.", ":")

_TRIES = 8
"""Random postures that are brought to a place before it counts as out of reach."""


@dataclass(frozen=True, eq=False)
class Trace:
    """A descent, step by step."""

    values: Float[np.ndarray, "step commanded"]
    objective: Float[np.ndarray, " step"]


def draw_receptances(outcome: Outcome, start: Posture, frequencies: Float[np.ndarray, " line"]) -> Any:
    """|receptance| and phase over frequency at the start and at the best posture.

    Args:
        outcome: of a search judged by receptance.
        start: posture to compare with.
        frequencies: ascending [Hz].
    """
    robot, judge = outcome.problem.robot, outcome.problem.objective
    along = judge.directions[0] if isinstance(judge, ReceptanceObjective) else None
    lines = judge.frequency if isinstance(judge, ReceptanceObjective) else np.zeros(2)
    curves = {
        name: robot.frf(posture, frequencies, response=along)
        for name, posture in (("before", start), ("after", outcome.best.posture))
    }
    mark = float(lines[0]) if len(lines) == 1 else None
    return draw_frf(curves, title=f"{robot.title or robot.name}, before and after", mark=mark)


def draw_postures(robot: Robot, postures: Mapping[str, Posture], *, target: Hold | None = None) -> Any:
    """Arms as lines through their joints: from the side if planar, else from the side and from above.

    Args:
        robot: the robot.
        postures: by the name for the legend.
        target: what is held, marked by a cross.
    """
    from matplotlib.figure import Figure

    views = [robot.task[:2, :3]] if robot.is_planar else [np.eye(3)[[0, 2]], np.eye(3)[[0, 1]]]
    figure = Figure(figsize=(6.2 * len(views), 5.4), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(views)))
    for axes, view in zip(panels, views, strict=True):
        for place, (name, posture) in enumerate(postures.items()):
            points = _skeleton(robot.at(posture)) @ view.T
            style: dict[str, Any] = {"color": PALETTE[place], "linestyle": _STYLES[place % 4]}
            axes.plot(*points.T, label=name, linewidth=2.4, marker="o", markersize=5, **style)
        if target is not None:
            held = view @ target.rows.T @ target.target
            axes.plot(*held, "x", color="black", markersize=11, markeredgewidth=2, label="target")
        names = ["xyz"[int(np.argmax(np.abs(row)))] for row in view]
        axes.set_xlabel(f"{names[0]} [m]")
        axes.set_ylabel(f"{names[1]} [m]")
        axes.set_aspect("equal", adjustable="datalim")
        axes.grid(True, color="0.9", linewidth=0.6)
    panels[0].legend(fontsize=9)
    panels[0].set_title(robot.title or robot.name, loc="left", fontsize=11)
    return figure


def draw_self_motion(problem: PostureProblem, centre: Posture, *, reach: float = 1.5, count: int = 61) -> Any:
    """The objective over the self-motion about a posture, the hold kept: a curve, or a map of two axes.

    The axes are directions in what the hold leaves free; where it leaves more than two, those along which the
    objective changes most over the range.

    Args:
        problem: objective and hold.
        centre: a posture on the hold, such as an optimum.
        reach: how far to go each way [rad].
        count: postures along each axis.
    """
    from matplotlib.figure import Figure

    vector = problem.vector(centre)
    free = _telling(problem, vector, null_space(problem.held(vector)[1]), reach)
    steps = np.linspace(-reach, reach, count)
    figure = Figure(figsize=(6.8, 5.2), layout="constrained")
    axes = figure.subplots()
    label = f"Objective [{problem.objective.unit}]"
    if free.shape[1] == 1:
        axes.plot(steps, [_value(problem, vector + a * free[:, 0]) for a in steps], color=PALETTE[0])
        axes.set_yscale("log")
        axes.set_ylabel(label)
        axes.axvline(0.0, color="0.3", linestyle=":")
    else:
        grid = np.array([[_value(problem, vector + free @ [a, b]) for a in steps] for b in steps])
        low, high = np.nanmin(grid), np.nanmax(grid)
        from matplotlib.colors import LogNorm

        shown = axes.pcolormesh(steps, steps, grid, norm=LogNorm(low, high), cmap="viridis", shading="auto")
        axes.contour(steps, steps, np.log(grid), levels=14, colors="white", linewidths=0.5)
        figure.colorbar(shown, label=label)
        axes.plot(0, 0, "x", color="white", markersize=11, markeredgewidth=2)
        axes.set_ylabel(f"Second axis of the self-motion [rad]: {_words(problem, free[:, 1])}")
    axes.set_xlabel(f"First axis of the self-motion [rad]: {_words(problem, free[:, 0])}")
    axes.set_title("Objective over the self-motion, tool held", loc="left", fontsize=11)
    return figure


def workspace_map(
    problem: PostureProblem, first: Float[np.ndarray, " column"], second: Float[np.ndarray, " row"],
    *, starts: int = 64, others: Sequence[float] = (),
) -> Float[np.ndarray, "row column"]:  # fmt: skip
    """The best objective at each place of a grid of targets; NaN where nothing reaches.

    Args:
        problem: robot and objective; its hold is replaced.
        first: coordinates along the first axis of the plane, or x [m].
        second: along the second, or y [m].
        starts: of the search at each place.
        others: z of a spatial chain [m].
    """
    grid, generator = np.full((len(second), len(first)), np.nan), np.random.default_rng(0)
    for row, b in enumerate(second):
        for column, a in enumerate(first):
            hold = Hold.at(problem.robot, (float(a), float(b), *others))
            at = replace(problem, hold=hold)
            if any(at.retract(at.random_vector(generator)) is not None for _ in range(_TRIES)):
                grid[row, column] = optimise(at, starts=starts).best.objective
    return grid


def draw_workspace(
    problem: PostureProblem,
    first: Float[np.ndarray, " column"],
    second: Float[np.ndarray, " row"],
    grid: Float[np.ndarray, "row column"],
) -> Any:
    """Draw what `workspace_map` found."""
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.8, 5.4), layout="constrained")
    axes = figure.subplots()
    norm = LogNorm(float(np.nanmin(grid)), float(np.nanmax(grid)))
    shown = axes.pcolormesh(first, second, grid, norm=norm, cmap="viridis", shading="nearest")
    figure.colorbar(shown, label=f"Best objective [{problem.objective.unit}]")
    names = [
        "xyz"[int(np.argmax(np.abs(row)))]
        for row in problem.robot.task[: 2 if problem.robot.is_planar else 3, :3]
    ]
    axes.set_xlabel(f"{names[0]} [m]")
    axes.set_ylabel(f"{names[1]} [m]")
    axes.set_aspect("equal")
    title = problem.robot.title or problem.robot.name
    axes.set_title(f"{title}: best posture at each place", loc="left", fontsize=11)
    return figure


def draw_traces(problem: PostureProblem, traces: Mapping[str, Trace]) -> Any:
    """Objective and joints over the steps of some descents, each in a column."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2 * len(traces), 6.4), layout="constrained")
    panels = figure.subplots(2, len(traces), sharex="col", sharey="row", squeeze=False)
    for column, (name, trace) in enumerate(traces.items()):
        upper, lower = panels[:, column]
        upper.plot(trace.objective, color=PALETTE[0])
        upper.set_yscale("log")
        upper.set_title(name, loc="left", fontsize=11)
        for place, joint in enumerate(problem.names):
            turning = problem.robot.commanded[joint].type != "prismatic"
            values = np.degrees(trace.values[:, place]) if turning else trace.values[:, place]
            style: dict[str, Any] = {"color": PALETTE[place % 7], "linestyle": _STYLES[place % 4]}
            lower.plot(values, label=joint if turning else f"{joint} [m]", **style)
        lower.set_xlabel("Step")
        for axes in (upper, lower):
            axes.grid(True, color="0.88", linewidth=0.6)
    panels[0, 0].set_ylabel(f"Objective [{problem.objective.unit}]")
    panels[1, 0].set_ylabel("Joints [°]")
    panels[1, 0].legend(fontsize=8, ncols=2)
    return figure


def _skeleton(posed: PosedRobot) -> Float[np.ndarray, "point 3"]:
    """Base, the joints that move, and the tool."""
    robot = posed.robot
    links = [robot.urdf.links[0].name, *(joint.child for joint in robot.moving.values()), robot.tool]
    return np.array([posed.position(link) for link in links])


def _value(problem: PostureProblem, values: np.ndarray) -> float:
    """Objective at a vector brought onto the hold; NaN where that cannot be."""
    found = problem.retract(values)
    if found is None:
        return float("nan")
    try:
        return problem.objective.value(problem.posed(found))
    except FlexmodalError:
        return float("nan")


def _telling(problem: PostureProblem, vector: np.ndarray, free: np.ndarray, reach: float) -> np.ndarray:
    """At most two free directions, those along which the logarithm of the objective varies most."""
    if free.shape[1] <= 2:
        return free
    swing = []
    for column in free.T:
        walked = [_value(problem, vector + step * column) for step in np.linspace(-reach, reach, 9)]
        swing.append(np.nanstd(np.log(np.maximum(walked, 1e-30))))
    return free[:, np.argsort(swing)[::-1][:2]]


def _words(problem: PostureProblem, direction: np.ndarray) -> str:
    """A direction in joint space by its largest parts."""
    order = np.argsort(-np.abs(direction))[:3]
    return ", ".join(f"{direction[place]:+.2f} {problem.names[place]}" for place in order)

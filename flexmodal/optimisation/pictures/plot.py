"""Pictures of a posture search: the receptance, the arm, and the objective over its self-motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, FlexmodalError, InvalidRequest
from flexmodal.frf import PointDirection
from flexmodal.frf.plot import draw_frf
from flexmodal.model import PosedRobot, Posture, Robot
from flexmodal.optimisation.descent import RANK
from flexmodal.optimisation.hold import Hold
from flexmodal.optimisation.objectives import (
    CombinedObjective,
    Objective,
    ReceptanceObjective,
    RobustObjective,
    TunedObjective,
)
from flexmodal.optimisation.outcome import Outcome
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.report.figure import (
    DASHED,
    MARK,
    NOISE,
    PALETTE,
    WIDE,
    drawing,
    frequency_axis,
    look,
    new_figure,
)

_SIZES = {"weighted": "|tᵀαw|", "force": "‖αw‖", "worst": "Largest singular value"}
_LABEL = 40
"""Characters of a label beside the axis of a picture; longer ones are broken."""


def draw_outcome(outcome: Outcome, *, frequencies: Float[np.ndarray, " line"] | None = None) -> Any:
    """Draw the receptance at the start, brought onto the hold, and at the best; see `draw_receptances`.

    Args:
        outcome: of a search.
        frequencies: of the lines; chosen if none [Hz].
    """
    start = None if outcome.compared is None else outcome.compared.held
    return draw_receptances(outcome, start, frequencies)


@drawing
def draw_receptances(
    outcome: Outcome,
    start: Posture | None,
    frequencies: Float[np.ndarray, " line"] | None = None,
) -> Any:
    """|receptance| and phase over frequency at the start and at the best posture.

    Where several directions are judged together, their receptance as judged, which has no phase. Objectives
    without a frequency are shown by the receptance along their direction.

    Args:
        outcome: of a search.
        start: posture to compare with, if there is one.
        frequencies: ascending [Hz]; if none, from well below the first mode to well above the last.
    """
    robot, judge = outcome.problem.robot, _judged(outcome.problem.objective)
    postures = {"before": start} if start is not None else {}
    postures["after"] = outcome.best.posture
    measured = judge.source.lines if isinstance(judge, ReceptanceObjective) else None
    if frequencies is None:
        own = measured is None
        frequencies = _telling_axis(robot, list(postures.values()), judge) if own else np.asarray(measured)
    title = f"{robot.title or robot.name}, before and after"
    lines = judge.frequency if isinstance(judge, ReceptanceObjective) else np.zeros(0)
    mark = float(lines[0]) if len(lines) == 1 and lines[0] > 0 else None
    if isinstance(judge, ReceptanceObjective) and (len(judge.directions) > 1 or measured is not None):
        return _draw_sizes(robot, judge, postures, frequencies, title, mark)
    along = judge.directions[0] if isinstance(judge, ReceptanceObjective) else _direction(judge)
    curves = {name: robot.frf(posture, frequencies, response=along) for name, posture in postures.items()}
    return draw_frf(curves, title=title, mark=mark)


def _draw_sizes(
    robot: Robot,
    judge: ReceptanceObjective,
    postures: Mapping[str, Posture],
    frequencies: np.ndarray,
    title: str,
    mark: float | None,
) -> Any:
    figure = new_figure(WIDE, 4.4)
    axes = figure.subplots()
    for place, (name, posture) in enumerate(postures.items()):
        sizes = judge.sizes(robot.at(posture), frequencies)
        axes.plot(frequencies, sizes, label=name, **look(place))
    frequency_axis(axes, frequencies)
    axes.set_yscale("log")
    axes.set_ylabel(f"{_SIZES[judge.combine]} [{judge.unit}]")
    for line in [] if mark is not None else judge.frequency:
        axes.axvline(float(line), color=NOISE, linewidth=0.6, zorder=0)
    if mark is not None:
        axes.axvline(mark, color=MARK, linewidth=1, linestyle=DASHED)
    axes.legend()
    names = ", ".join(map(str, judge.directions))
    axes.set_title(f"{title}: {names}{'' if judge.source.lines is None else ', predicted'}")
    return figure


def _judged(objective: Objective) -> Objective:
    """What a sample or a single part is judged by; of several parts the first with a receptance."""
    if isinstance(objective, RobustObjective):
        return _judged(objective.objective)
    if isinstance(objective, CombinedObjective):
        parts = [_judged(part) for part in objective.parts]
        return next((part for part in parts if isinstance(part, ReceptanceObjective)), parts[0])
    return objective


def _direction(objective: Objective) -> PointDirection | None:
    """The one direction of an objective that is no receptance; none of the distance between poles."""
    found = getattr(objective, "direction", None)
    return found if isinstance(found, PointDirection) else None


def _telling_axis(robot: Robot, postures: Sequence[Posture], judge: Objective) -> np.ndarray:
    """Frequencies with all modes well inside, and those that are judged."""
    told = [robot.modes(posture).frequency for posture in postures]
    if isinstance(judge, ReceptanceObjective):
        told.append(judge.frequency)
    if isinstance(judge, TunedObjective):
        told.append(np.array(judge.band))
    values = np.concatenate(told)
    values = values[np.isfinite(values) & (values > 0)]
    return np.geomspace(values.min() / 4, values.max() * 3, 800)


def draw_posed(posed: PosedRobot) -> Any:
    """Draw an arm in its posture; see `draw_postures`."""
    robot = posed.robot
    if not isinstance(robot, Robot):
        raise TypeError(f"a {type(robot).__name__} is not drawn")
    return draw_postures(robot, {str(posed.posture): posed.posture})


@drawing
def draw_postures(robot: Robot, postures: Mapping[str, Posture], *, target: Hold | None = None) -> Any:
    """Arms as lines through their joints: from the side if planar, else from the side and from above.

    Args:
        robot: the robot.
        postures: by the name for the legend.
        target: what is held, marked by a cross.
    """
    views = [robot.task[:2, :3]] if robot.is_planar else [np.eye(3)[[0, 2]], np.eye(3)[[0, 1]]]
    figure = new_figure(6.2 * len(views), 5.4)
    panels = np.atleast_1d(figure.subplots(1, len(views)))
    for axes, view in zip(panels, views, strict=True):
        for place, (name, posture) in enumerate(postures.items()):
            points = _skeleton(robot.at(posture)) @ view.T
            axes.plot(*points.T, label=name, **look(place, linewidth=2.4, marker="o"))
        if target is not None:
            held = view @ target.rows.T @ target.target
            axes.plot(*held, "x", color=PALETTE[6], markersize=11, markeredgewidth=2, label="target")
        names = ["xyz"[int(np.argmax(np.abs(row)))] for row in view]
        axes.set_xlabel(f"{names[0]} [m]")
        axes.set_ylabel(f"{names[1]} [m]")
        axes.set_aspect("equal", adjustable="datalim")
    panels[0].legend()
    panels[0].set_title(robot.title or robot.name)
    return figure


@drawing
def draw_self_motion(problem: PostureProblem, centre: Posture, *, reach: float = 1.5, count: int = 61) -> Any:
    """The objective over the self-motion about a posture, the hold kept: a curve, or a map of two axes.

    The axes are directions in what the hold leaves free; where it leaves more than two, those along which the
    objective changes most over the range.

    Args:
        problem: objective and hold.
        centre: a posture on the hold, such as an optimum.
        reach: how far to go each way [rad].
        count: postures along each axis.

    Raises:
        InvalidRequest: the hold leaves nothing free.
    """
    vector = problem.vector(centre)
    free = _free(problem, vector)
    if free.shape[1] == 0:
        found, allowed = "a hold that leaves nothing free", "one that leaves a joint free"
        raise InvalidRequest(Fault("call", "problem", found, allowed))
    free = _telling(problem, vector, free, reach)
    steps = np.linspace(-reach, reach, count)
    figure = new_figure(6.8, 5.2)
    axes = figure.subplots()
    label = f"Objective [{problem.objective.unit}]"
    if free.shape[1] == 1:
        axes.plot(steps, [_value(problem, vector + a * free[:, 0]) for a in steps], color=PALETTE[0])
        axes.set_yscale("log")
        axes.set_ylabel(label)
        axes.axvline(0.0, color=MARK, linestyle=":")
    else:
        grid = np.array([[_value(problem, vector + free @ [a, b]) for a in steps] for b in steps])
        low, high = np.nanmin(grid), np.nanmax(grid)
        from matplotlib.colors import LogNorm

        shown = axes.pcolormesh(steps, steps, grid, norm=LogNorm(low, high), cmap="viridis", shading="auto")
        lines = {"levels": 14, "colors": "white", "linewidths": 0.5, "linestyles": "solid"}
        axes.contour(steps, steps, np.log(grid), **lines)
        figure.colorbar(shown, label=label)
        axes.plot(0, 0, "x", color="white", markersize=11, markeredgewidth=2)
        axes.set_ylabel(f"Second axis of the self-motion [rad]:\n{_words(problem, free[:, 1])}")
    axes.set_xlabel(f"First axis of the self-motion [rad]:\n{_words(problem, free[:, 0])}")
    title = f"{problem.robot.title or problem.robot.name}: objective over the self-motion"
    axes.set_title(title)
    return figure


def _skeleton(posed: PosedRobot) -> Float[np.ndarray, "point 3"]:
    """Base, the joints that move, and the tool."""
    robot = posed.robot
    links = [robot.urdf.links[0].name, *(joint.child for joint in robot.moving.values()), robot.tool]
    return np.array([posed.position(link) for link in links])


def _value(problem: PostureProblem, values: np.ndarray) -> float:
    """Objective at a vector brought onto the hold; NaN where that cannot be, or comes too near something."""
    found = problem.retract(values)
    if found is None or not problem.is_clear(found):
        return float("nan")
    try:
        return problem.objective.value(problem.posed(found))
    except FlexmodalError:
        return float("nan")


def _free(problem: PostureProblem, vector: np.ndarray) -> np.ndarray:
    """Orthonormal directions that the hold leaves free, column by column."""
    from scipy.linalg import null_space

    constraint = problem.held(vector)[1]
    return np.asarray(null_space(constraint, rcond=RANK)) if len(constraint) else np.eye(len(vector))


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
    """A direction in joint space by its largest parts, no longer than the picture is high."""
    order = np.argsort(-np.abs(direction))[:3]
    parts = [f"{direction[place]:+.2f} {problem.names[place]}" for place in order]
    text = ", ".join(parts)
    return text if len(text) <= _LABEL else ",\n".join(parts)

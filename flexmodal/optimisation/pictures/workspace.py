"""The best objective over the workspace, computed and drawn."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InCollision, InvalidRequest
from flexmodal.optimisation.hold import Hold
from flexmodal.optimisation.optimise import optimise
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.report import drawing, new_figure

_TRIES = 8
"""Random postures that are brought to a place before it counts as out of reach."""

_SAMPLE = 400
"""Random postures from which the extent of the workspace is taken."""

_ZERO = 1e-4
"""Share of the median below which a value counts as a zero, which would swamp the colours of the others; of a
value to be large, that many times the median counts as without bound."""

_RED = "#D55E00"


def extent(problem: PostureProblem) -> Float[np.ndarray, "axis 2"]:
    """Least and greatest coordinate of the held point over random postures, along each held axis [m].

    Raises:
        InvalidRequest: a search without a held position.
    """
    hold, generator = _held(problem), np.random.default_rng(0)
    postures = [problem.posed(problem.random_vector(generator)) for _ in range(_SAMPLE)]
    places = np.array([hold.rows @ posed.position(hold.point) for posed in postures])
    return np.stack([places.min(axis=0), places.max(axis=0)], axis=1)


def workspace_map(
    problem: PostureProblem,
    first: Float[np.ndarray, " column"],
    second: Float[np.ndarray, " row"],
    *,
    starts: int = 64,
    advance: Callable[[], None] = lambda: None,
) -> Float[np.ndarray, "row column"]:
    """The best objective at each place of a grid of targets; NaN where nothing reaches.

    Args:
        problem: robot, objective and hold, whose first two coordinates are replaced; a third, and the
            orientation if it is held, stay.
        first: coordinates along the first axis of the plane, or x [m].
        second: along the second, or y [m].
        starts: of the search at each place.
        advance: called once a place, for a progress bar.

    Raises:
        InvalidRequest: nothing is held.
    """
    hold = _held(problem)
    grid, generator = np.full((len(second), len(first)), np.nan), np.random.default_rng(0)
    for row, b in enumerate(second):
        for column, a in enumerate(first):
            there = replace(problem, hold=replace(hold, target=np.array([a, b, *hold.target[2:]])))
            if any(there.retract(there.random_vector(generator)) is not None for _ in range(_TRIES)):
                with suppress(InCollision):
                    grid[row, column] = optimise(there, starts=starts).best.objective
            advance()
    return grid


@drawing
def draw_workspace(
    problem: PostureProblem,
    first: Float[np.ndarray, " column"],
    second: Float[np.ndarray, " row"],
    grid: Float[np.ndarray, "row column"],
) -> Any:
    """Draw what `workspace_map` found; zeros in a colour of their own.

    Args:
        problem: as for `workspace_map`.
        first: coordinates along the first axis [m].
        second: along the second [m].
        grid: best objective at each place.

    Raises:
        InvalidRequest: nothing is held, or no place is within reach.
    """
    import matplotlib as mpl
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Patch

    hold = _held(problem)
    found = grid[np.isfinite(grid)]
    if len(found) == 0:
        raise InvalidRequest(Fault("call", "grid", "no place within reach", "some place within reach"))
    middle = float(np.median(found))
    large = problem.objective.larger_is_better
    seen = found[found < middle / _ZERO] if large else found[found > middle * _ZERO]
    figure = new_figure(6.8, 5.6)
    axes = figure.subplots()
    axes.grid(False)
    colours = mpl.colormaps["viridis"].with_extremes(under=_RED, over=_RED)
    norm = LogNorm(float(seen.min()), float(max(seen.max(), 1.001 * seen.min())))
    shown = axes.pcolormesh(first, second, grid, norm=norm, cmap=colours, shading="nearest")
    left_out = len(seen) < len(found)
    label = f"Best objective [{problem.objective.unit}]"
    figure.colorbar(shown, label=label, extend=("max" if large else "min") if left_out else "neither")
    axes.plot(*hold.target[:2], "x", color="white", markersize=10, markeredgewidth=2)
    names = ["xyz"[int(np.argmax(np.abs(row)))] for row in hold.rows]
    axes.set_xlabel(f"{names[0]} [m]")
    axes.set_ylabel(f"{names[1]} [m]")
    axes.set_aspect("equal")
    where = "" if len(names) < 3 else f", {names[2]} = {hold.target[2]:g} m"
    title = problem.robot.title or problem.robot.name
    axes.set_title(f"{title}: best at each place{where}")
    if left_out:
        patch = Patch(color=_RED, label="without bound" if large else "zero but for rounding")
        figure.legend(handles=[patch], loc="outside lower center")
    return figure


def _held(problem: PostureProblem) -> Hold:
    if problem.hold is None:
        raise InvalidRequest(Fault("call", "problem", "nothing held", "a hold: the map is of its targets"))
    return problem.hold

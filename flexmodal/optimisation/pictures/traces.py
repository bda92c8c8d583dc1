"""Descents step by step, followed and drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from flexmodal.model import Posture
from flexmodal.optimisation.problem import PostureProblem
from flexmodal.optimisation.search import beside, descend, null_space_descent, unreachable
from flexmodal.report.figure import drawing, look, new_figure

_NAMES = {"newton": "Quasi-Newton on the hold", "null-space": "Gradient in the null space [3.14]"}


@dataclass(frozen=True, eq=False)
class Trace:
    """A descent, step by step."""

    values: Float[np.ndarray, "step commanded"]
    """Of the commanded joints [rad, m]."""
    objective: Float[np.ndarray, " step"]
    """Where the search takes a smooth maximum, that."""
    deviation: Float[np.ndarray, " step"]
    """How far the held point is from its target [m]; 0 without a hold."""


def follow(problem: PostureProblem, start: Posture, method: str = "newton", *, iterations: int = 0) -> Trace:
    """Descend from a start and note every step.

    Args:
        problem: what to minimise and what to hold.
        start: where to start; the quasi-Newton method brings it onto the hold first.
        method: "newton" or "null-space", as for `flexmodal.optimise`.
        iterations: give up after this many; as many as the method allows if 0.

    Raises:
        Unreachable: the quasi-Newton method cannot bring the start onto the hold.
    """
    steps: list[tuple[np.ndarray, float]] = []
    vector, most = problem.vector(start), {"iterations": iterations} if iterations else {}

    def watch(values: np.ndarray, cost: float) -> None:
        steps.append((values.copy(), cost))

    if method == "null-space":
        null_space_descent(problem, vector, watch=watch, **most)
    elif descend(problem, beside(problem, vector), watch=watch, **most) is None:
        raise unreachable(problem, 1)
    values = np.array([vector for vector, _ in steps])
    costs = np.array([cost for _, cost in steps])
    held = 0 if problem.hold is None else len(problem.hold.target)
    deviation = [float(np.linalg.norm(problem.held(vector)[0][:held])) for vector in values]
    return Trace(values, np.exp(-costs if problem.objective.larger_is_better else costs), np.array(deviation))


@drawing
def draw_traces(problem: PostureProblem, traces: Mapping[str, Trace]) -> Any:
    """Objective, joints and distance from the target over the steps of some descents, each in a column.

    Args:
        problem: whose descents.
        traces: by their method, or any other name.
    """
    figure = new_figure(max(5.2 * len(traces), 6.5), 8.0)
    panels = figure.subplots(
        3, len(traces), sharex="col", sharey="row", squeeze=False, height_ratios=(3, 3, 1.6)
    )
    for column, (name, trace) in enumerate(traces.items()):
        upper, middle, lower = panels[:, column]
        upper.plot(trace.objective, **look(0))
        upper.set_yscale("log")
        upper.set_title(_NAMES.get(name, name))
        for place, joint in enumerate(problem.names):
            turning = not problem.robot.commanded[joint].is_prismatic
            values = np.degrees(trace.values[:, place]) if turning else trace.values[:, place]
            middle.plot(values, label=joint if turning else f"{joint} [m]", **look(place))
        lower.plot(np.maximum(trace.deviation, 1e-16), **look(0))
        lower.set_yscale("log")
        lower.set_xlabel("Step")
    panels[0, 0].set_ylabel(f"Objective [{problem.objective.unit}]")
    panels[1, 0].set_ylabel("Joints [°]")
    panels[2, 0].set_ylabel("From target [m]")
    handles, labels = panels[1, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=7)
    return figure

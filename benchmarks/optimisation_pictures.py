"""Pictures of docs/optimisation.md: receptances, arms, self-motion, workspace, descents, a path."""

from __future__ import annotations

import numpy as np
from tables import ROOT

import flexmodal
from flexmodal import Hold, PointDirection, PostureProblem, ReceptanceObjective
from flexmodal.optimisation.path import PathProblem, greedy_path, line, plan_path
from flexmodal.optimisation.path.plot import draw_path
from flexmodal.optimisation.pictures.plot import draw_postures, draw_receptances, draw_self_motion
from flexmodal.optimisation.pictures.traces import draw_traces, follow
from flexmodal.optimisation.pictures.workspace import draw_workspace, workspace_map
from flexmodal.report import write_figure

PICTURES = ROOT / "docs" / "pictures"


def main() -> None:
    arm = flexmodal.load("six_link")
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([5.0]))
    hold = Hold.at(arm, (-2.0, 2.0))
    problem = PostureProblem(arm, judge, hold)
    start = arm.posture("start_2")
    found = flexmodal.optimise(problem, start=start)
    save(draw_receptances(found, start, np.geomspace(0.2, 60, 600)), "optimisation_receptance")
    postures = {
        "start (Table 3.9)": start,
        "printed final (Table 3.9)": arm.posture("table_3_9_final"),
        "best found": found.best.posture,
    }
    save(draw_postures(arm, postures, target=hold), "optimisation_postures")
    save(draw_self_motion(problem, found.best.posture, count=81), "optimisation_self_motion")
    first, second = np.linspace(-6, 6, 31), np.linspace(-6, 6, 31)
    grid = workspace_map(problem, first, second, starts=32)
    save(draw_workspace(problem, first, second, grid), "optimisation_workspace")
    traces = {method: follow(problem, start, method) for method in ("newton", "null-space")}
    save(draw_traces(problem, traces), "optimisation_traces")
    toolpath = line((-4.0, 0.5), (-1.0, 2.5), 16, 0.05)
    path = PathProblem.along(arm, toolpath, 5.0, stride=0.12)
    static = PathProblem.along(arm, toolpath, 0.0, stride=0.12)
    save(
        draw_path(
            {
                "least vibration": plan_path(path, nodes=20, iterations=30),
                "greedy": greedy_path(path),
                "static stiffness": plan_path(static, nodes=20, iterations=30).judged_by(path),
            }
        ),
        "optimisation_path",
    )


def save(figure: object, name: str) -> None:
    write_figure(figure, PICTURES / f"{name}.png", overwrite=True)
    print(f"wrote {name}.png", flush=True)


if __name__ == "__main__":
    main()

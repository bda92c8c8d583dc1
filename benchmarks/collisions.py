"""A hundred random tasks beside a table and a fixture: does any optimum come within the clearance?

And what does keeping it cost? A UR5 with guessed stiffness on a table, a box of random size and place in
front of it, a random target that it reaches. The same starts are searched with and without the clearance,
one after the other in one process; the time is that of the processor. Every optimum is looked at again with
a scene of its own, and the best posture without a clearance too: how many of those would be in the table.

    python benchmarks/collisions.py [--tasks N] [--starts N] [--out FILE.json]
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import flexmodal
from flexmodal.cards import ObstacleCard
from flexmodal.errors import InCollision, Unreachable
from flexmodal.model.collision import scene_of
from flexmodal.model.guess import guess_card

DISTANCE = 0.01


def task(robot: flexmodal.Robot, generator: np.random.Generator) -> flexmodal.PostureProblem:
    """A robot with a table and a fixture, and something to hold above the table."""
    angle, away = generator.uniform(-1.2, 1.2), generator.uniform(0.35, 0.65)
    size = generator.uniform((0.08, 0.08, 0.1), (0.25, 0.25, 0.35))
    place = (away * np.cos(angle), away * np.sin(angle), size[2] / 2)
    obstacles = {
        "table": ObstacleCard(box=(1.6, 1.6, 0.05), xyz=(0.0, 0.0, -0.03)),
        "fixture": ObstacleCard(box=tuple(map(float, size)), xyz=tuple(map(float, place))),
    }
    beside = angle + generator.choice([-1, 1]) * generator.uniform(0.1, 0.8)
    radius, height = generator.uniform(0.35, 0.65), generator.uniform(0.06, 0.45)
    target = tuple(float(x) for x in (radius * np.cos(beside), radius * np.sin(beside), height))
    around = replace(robot, obstacles=obstacles)
    direction = "tool:+" + str(generator.choice(list("xyz")))
    judge = flexmodal.ReceptanceObjective(direction, float(generator.uniform(5.0, 60.0)))
    hold = flexmodal.Hold.at(around, target)
    clearance = flexmodal.Clearance.of(around, DISTANCE)
    return flexmodal.PostureProblem(around, judge, hold, clearance=clearance)


def search(
    problem: flexmodal.PostureProblem, starts: int, seed: int
) -> tuple[flexmodal.Outcome | None, float]:
    """The outcome, if there is one, and the processor's seconds."""
    before = time.process_time()
    try:
        found = flexmodal.optimise(problem, starts=starts, seed=seed, way="plain")
    except (InCollision, Unreachable):
        found = None
    return found, time.process_time() - before


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--tasks", type=int, default=100)
    parser.add_argument("--starts", type=int, default=8)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        robot = flexmodal.load(guess_card("ur5", Path(folder)).write())
    rows = []
    for number in range(given.tasks):
        problem = task(robot, np.random.default_rng(number))
        free = replace(problem, clearance=None)
        kept, long = search(problem, given.starts, number)
        loose, short = search(free, given.starts, number)
        scene = scene_of(problem.robot)
        assert scene is not None

        def least(found: flexmodal.Outcome | None, scene=scene, problem=problem) -> float | None:
            """Over all optima, and their equals."""
            if found is None:
                return None
            postures = [one for o in found.optima for one in (o.posture, *o.equals)]
            return min(scene.nearest(problem.robot.at(posture))[0] for posture in postures)

        best = None if loose is None else scene.nearest(problem.robot.at(loose.best.posture))[0]
        rows.append(
            {
                "task": number,
                "least": least(kept),
                "optima": 0 if kept is None else len(kept.optima),
                "best_without": best,
                "value": None if kept is None else kept.best.objective,
                "value_without": None if loose is None else loose.best.objective,
                "ratio": long / short,
            }
        )
        print(rows[-1], flush=True)
    found = [row for row in rows if row["least"] is not None]
    summary = {
        "tasks": len(rows),
        "with_an_answer": len(found),
        "optima": sum(row["optima"] for row in found),
        "within_the_clearance": sum(row["least"] < DISTANCE for row in found),
        "least_distance_mm": 1e3 * min(row["least"] for row in found),
        "best_without_that_collide": sum((row["best_without"] or 1.0) < 0 for row in rows),
        "best_without_within_the_clearance": sum((row["best_without"] or 1.0) < DISTANCE for row in rows),
        "time_ratio_median": float(np.median([row["ratio"] for row in rows])),
        "time_ratio_quartiles": np.quantile([row["ratio"] for row in rows], [0.25, 0.75]).tolist(),
    }
    print(json.dumps(summary, indent=1))
    if given.out is not None:
        given.out.write_text(
            json.dumps({"summary": summary, "tasks": rows}, indent=1) + "\n", encoding="utf-8"
        )


if __name__ == "__main__":
    main()

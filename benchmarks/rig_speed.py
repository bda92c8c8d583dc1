"""What a campaign of the rig costs, step by step: simulating, the search for a height, writing.

Processor seconds of one core, the median of three runs, after one run to compile. A campaign as an exam takes
it on three robots, with FRFs alone; and a full one with its time records, written as the rig writes it and by
pyuff from end to end.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import numpy as np
from tables import write

import flexmodal
from flexmodal.campaign.uff import frame as uff_frame
from flexmodal.rig import Hide, RigResult, simulate
from flexmodal.rig.hidden import placement as placing

EXAM = {"postures": 5, "points": 5, "time": False}
RUNS = 3
ROBOTS = ("fanuc_s360", "six_link", "six_axis")
HIDDEN = ("link_flexibility", "structural_damping", "coulomb_friction", "clearance")


def seconds(run: Callable[[int], object], runs: int = RUNS) -> float:
    """Median processor time [s]."""
    spent = []
    for seed in range(runs):
        start = time.process_time()
        run(seed)
        spent.append(time.process_time() - start)
    return float(np.median(spent))


def searching() -> tuple[list[float], object]:
    """A list that gathers the processor time of each search for a severity, and the patch that fills it."""
    spent: list[float] = []
    real = placing.severity_for

    def timed(*given: object) -> object:
        start = time.process_time()
        found = real(*given)  # type: ignore[arg-type]
        spent.append(time.process_time() - start)
        return found

    return spent, patch.object(placing, "severity_for", timed)


def exam_rows() -> list[list[str]]:
    rows = []
    for name in ROBOTS:
        robot = flexmodal.load(name)
        bare = seconds(lambda seed, robot=robot: written(simulate(robot, **EXAM, seed=seed)))
        rows.append([name, "nothing", f"{bare:.2f}", "–"])
        for effect in HIDDEN:
            spent, watch = searching()
            hide = [Hide(effect, height=(3.0, 30.0))]
            with watch:  # type: ignore[attr-defined]
                run = seconds(lambda seed, r=robot, h=hide: written(simulate(r, **EXAM, hide=h, seed=seed)))
            rows.append([name, effect, f"{run:.2f}", f"{np.sum(spent) / RUNS:.2f}"])
    return rows


def written(result: RigResult) -> None:
    with tempfile.TemporaryDirectory() as folder:
        result.write(Path(folder) / "campaign")


def full_rows() -> list[list[str]]:
    rows = []
    for name in ("fanuc_s360", "six_axis"):
        robot = flexmodal.load(name)
        result = simulate(robot)
        simulated = seconds(lambda seed, robot=robot: simulate(robot, seed=seed))
        framed = seconds(lambda seed, result=result: written(result))
        with patch.object(uff_frame, "splice", lambda *given: None):
            alone = seconds(lambda seed, result=result: written(result), 1)
        records = len(result.campaign.blows) * (1 + len(result.plan.axes))
        rows.append([name, str(records), f"{simulated:.2f}", f"{framed:.2f}", f"{alone:.2f}"])
    return rows


def main() -> None:
    for effect in HIDDEN:  # compile
        simulate(flexmodal.load("fanuc_s360"), postures=1, points=2, trials=1, hide=[effect])
    write(
        "rig_speed",
        "What a campaign of the rig costs",
        "5 postures × 5 points × 2 hammer positions × 2 levels × 2 repeats of 3 blows, FRFs alone, written; "
        "the effect searched for at 3 to 30 times the noise floor. Processor seconds of one core, "
        "`python benchmarks/rig_speed.py`.",
        ["robot", "hidden", "whole campaign [s]", "of it the search [s]"],
        exam_rows(),
    )
    write(
        "rig_writing",
        "What writing a campaign costs",
        "7 postures × 6 points × 2 hammer positions × 4 trials of 3 blows with their time records, dataset "
        "58b. Processor seconds of one core, `python benchmarks/rig_speed.py`.",
        ["robot", "time records", "simulated [s]", "written [s]", "written by pyuff alone [s]"],
        full_rows(),
    )


if __name__ == "__main__":
    main()

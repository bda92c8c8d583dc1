"""Random campaigns as an exam would draw them: does every one come about, and how high do the effects stand?

    python benchmarks/rig_heights.py

Thirty scenarios drawn from seeds of their own: nothing hidden once, each of the seventeen effects, then
pairs; the three robots in turn. Nothing here is tuned to: an exam takes other seeds.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Iterator

import numpy as np
from tables import write

import flexmodal
from flexmodal.rig import EFFECTS, draw_scenario, simulate
from flexmodal.rig.hidden.scenario import HEIGHTS

CAMPAIGNS = 30
ROBOTS = ("fanuc_s360", "six_link", "six_axis")
POINTS = 5
FIRST_SEED = 7_000


def asked() -> Iterator[tuple[int, list[str] | None]]:
    """How many effects to hide, and of which; None for any of the catalogue."""
    yield 0, None
    for name in EFFECTS:
        yield 1, [name]
    for _ in range(CAMPAIGNS - 1 - len(EFFECTS)):
        yield 2, None


def main() -> None:
    robots = [flexmodal.load(name) for name in ROBOTS]
    rows, heights, spent = [], [], []
    for number, (count, effects) in enumerate(asked()):
        robot, seed = robots[number % len(robots)], FIRST_SEED + number
        scenario = draw_scenario(robot, seed, count=count, effects=effects, points=POINTS)
        start = time.process_time()
        result = simulate(
            robot, postures=5, points=POINTS, hide=scenario.hide, parameter_error=scenario.parameter_error,
            seed=seed, time=False,
        )  # fmt: skip
        spent.append(time.process_time() - start)
        frfs = result.campaign.frfs
        assert frfs is not None
        assert np.all(np.isfinite(frfs.value))
        found = [(effect.effect, effect.where, effect.height or 0.0) for effect in result.truth.effects]
        heights += [height for *_, height in found]
        hidden = " and ".join(f"{name}@{where}" for name, where, _ in found) or "nothing"
        stood = " and ".join(f"{height:.1f}" for *_, height in found) or "–"
        rows.append([str(seed), robot.name, hidden, stood, f"{100 * scenario.parameter_error:.1f}"])
    low, high = HEIGHTS
    inside = sum(low <= height <= high for height in heights)
    end = f"{inside} of {len(heights)} heights lie between {low:g} and {high:g}; "
    write(
        "rig_heights",
        "Random campaigns of the rig",
        "5 postures, 5 points, 2 hammer positions, 2 levels and their repeats; effects, places, heights and "
        "parameter errors drawn from the seed. `python benchmarks/rig_heights.py`.",
        ["seed", "robot", "hidden", "times the noise floor", "parameter error [%]"],
        rows,
        end + f"the lowest {min(heights):.2f}, the highest {max(heights):.2f}.",
    )
    print(f"median {np.median(spent):.1f} s a campaign, longest {max(spent):.1f} s of one core")


if __name__ == "__main__":
    main()

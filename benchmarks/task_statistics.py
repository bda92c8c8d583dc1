"""How much the frequency matters: random tasks, each posture optimised by receptance and by stiffness.

For each task a target, a direction and a frequency are drawn, and a random posture on the target is the
start. The receptance at that frequency is compared: at the start, after optimising it, after optimising the
static receptance, and after optimising the stiffness measure. Rows are added to
docs/tables/task_statistics.csv as they are computed, so that an interrupted run goes on where it stopped;
`--tasks N` asks for N tasks an arm, `--scheduler ADDRESS` has them computed on a Dask cluster.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from spreading import add_options, pieces
from tables import ROOT, TABLES

import flexmodal
from flexmodal import Hold, PostureProblem, ReceptanceObjective, StiffnessObjective
from flexmodal.errors import FlexmodalError
from flexmodal.files import whole_file
from flexmodal.frf import PointDirection
from flexmodal.model import Robot
from flexmodal.report import PALETTE, write_figure

FILE = TABLES / "task_statistics.csv"
COLUMNS = ("arm", "task", "frequency", "first_mode", "start", "receptance", "static", "stiffness", "singular")
WAYS = {
    "receptance": "receptance at the frequency",
    "static": "static receptance",
    "stiffness": "stiffness measure ξ_K",
}
STARTS = 64
BLOCK = 10
"""Tasks of a piece of work."""


@dataclass(frozen=True)
class Arm:
    """An arm and what its tasks are like."""

    title: str
    load: Callable[[], Robot]
    band: tuple[float, float]
    """Frequencies of the tasks [Hz], log-uniform."""
    axis: bool
    """Whether the tool's axis is held along the one of the random posture, free to turn."""


ARMS = {
    "six_link": Arm(
        "six-link planar arm, position held", lambda: flexmodal.load("six_link"), (0.5, 30.0), False
    ),
    "panda": Arm(
        "Panda, seven axes, position and tool axis held",
        lambda: flexmodal.load("panda", stiffness=1.4e4, damping=20.0, tool="panda_hand"),
        (2.0, 100.0),
        True,
    ),
    "ur10": Arm(
        "UR10, six axes, position and tool axis held",
        lambda: flexmodal.load("ur10", stiffness=2e4, damping=20.0, tool="tool0"),
        (2.0, 100.0),
        True,
    ),
}


def draw(robot: Robot, arm: Arm, generator: np.random.Generator):
    """A start posture, what it holds, a direction and a frequency."""
    free = PostureProblem(robot, ReceptanceObjective((PointDirection(robot.tool, "z"),), np.array([1.0])))
    start = free.posture(free.random_vector(generator))
    posed = robot.at(start)
    place = posed.position(robot.tool)
    axis = posed.rotation(robot.tool)[:, 2]
    target = tuple((robot.task[:2, :3] @ place if robot.is_planar else place).tolist())
    hold = Hold.at(robot, target, axis=tuple(axis.tolist()) if arm.axis else None)
    names = [name for name, row in zip("xyz", np.eye(3), strict=True) if not robot.is_planar or name != "y"]
    along = PointDirection(robot.tool, str(generator.choice(names)))
    return start, hold, along, float(np.exp(generator.uniform(*np.log(arm.band))))


def run(name: str, task: int, robot: Robot) -> dict[str, object]:
    arm = ARMS[name]
    start, hold, along, frequency = draw(robot, arm, np.random.default_rng([task, *name.encode()]))
    judge = ReceptanceObjective((along,), np.array([frequency]))
    objectives = {
        "receptance": judge,
        "static": ReceptanceObjective((along,), np.array([0.0])),
        "stiffness": StiffnessObjective(along),
    }
    row: dict[str, object] = {
        "arm": name,
        "task": task,
        "frequency": frequency,
        "first_mode": float(robot.modes(start).frequency.min()),
        "start": judge.value(robot.at(start)),
    }
    for key, objective in objectives.items():
        found = flexmodal.optimise(PostureProblem(robot, objective, hold), start=start, starts=STARTS)
        row[key] = judge.value(robot.at(found.best.posture))
        if key == "stiffness":
            row["singular"] = int(found.unbounded == found.starts)
    return row


def rows_there() -> list[dict[str, str]]:
    if not FILE.exists():
        return []
    with FILE.open(newline="") as file:
        return list(csv.DictReader(file))


def one(piece: str) -> None:
    """Print the rows of some tasks, `ARM:FIRST:COUNT`; a task without an answer is a complaint."""
    name, first, count = piece.split(":")
    robot, writer = ARMS[name].load(), csv.writer(sys.stdout)
    for task in range(int(first), int(first) + int(count)):
        try:
            row = run(name, task, robot)
        except FlexmodalError as error:
            print(f"{name} {task}: {error}", file=sys.stderr)
            continue
        writer.writerow(f"{row[key]:.6g}" if isinstance(row[key], float) else row[key] for key in COLUMNS)


def compute(tasks: int, scheduler: str | None, workers: int | None) -> None:
    """Add the rows that are missing, in whatever order they come."""
    done = {(row["arm"], int(row["task"])) for row in rows_there()}
    if not FILE.exists():
        FILE.write_text(",".join(COLUMNS) + "\n")
    missing = [
        f"{name}:{first}:{min(BLOCK, tasks - first)}"
        for name in ARMS
        for first in range(0, tasks, BLOCK)
        if any((name, task) not in done for task in range(first, min(first + BLOCK, tasks)))
    ]
    for piece, told in pieces("task_statistics.py", missing, [], scheduler=scheduler, workers=workers):
        rows = csv.reader((told or "").splitlines())
        new = [row for row in rows if (row[0], int(row[1])) not in done]
        with FILE.open("a", newline="") as file:
            csv.writer(file).writerows(new)
        print(piece, flush=True)


def ratios(rows: list[dict[str, str]], key: str) -> np.ndarray:
    return np.array([float(row[key]) / float(row["start"]) for row in rows])


def summarise(everything: list[dict[str, str]]) -> str:
    lines = [
        "# How much the frequency matters",
        "",
        f"Made by `python benchmarks/task_statistics.py` from {len(everything)} random tasks: "
        + ", ".join(f"{sum(row['arm'] == name for row in everything)} of {name}" for name in ARMS)
        + ". Each draws a posture, whose tool position (and, of the arms in space, tool axis) is held, a "
        "world axis for the force, and a frequency (log-uniform, 0.5 to 30 Hz for the six-link arm, 2 to 100 "
        f"Hz for the others). {STARTS} starts, the drawn posture among them. Panda and UR10 are URDFs "
        "without stiffness: 14 and 20 kN·m/rad and 20 N·m·s/rad are taken for every joint, so only ratios "
        "mean something. A ratio is |receptance| at the operating frequency over that of the drawn posture; "
        "below 1 is better. The last two columns part the tasks by the first natural frequency at the start.",
        "",
        "| arm | optimised by | median ratio | 10 % to 90 % | worse than the start | median, below the "
        "first mode | median, above it |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for name, arm in ARMS.items():
        rows = [row for row in everything if row["arm"] == name]
        if not rows:
            continue
        below = np.array([float(row["frequency"]) < float(row["first_mode"]) for row in rows])
        for key, title in WAYS.items():
            ratio = ratios(rows, key)
            low, middle, high = np.quantile(ratio, [0.1, 0.5, 0.9])
            parts = [f"{np.median(ratio[part]):.3g} ({part.sum()})" for part in (below, ~below) if part.any()]
            parts += ["–"] * (2 - len(parts))
            lines.append(
                f"| {arm.title} | {title} | {middle:.3g} | {low:.3g} to {high:.3g} | "
                f"{100 * np.mean(ratio > 1 + 1e-9):.0f} % | {parts[0]} | {parts[1]} |"
            )
    lines += ["", *conclusions(everything), "", "![distribution](../pictures/task_statistics.png)", ""]
    return "\n".join(lines)


def conclusions(everything: list[dict[str, str]]) -> list[str]:
    """Sentences with their numbers."""
    found = []
    for name, arm in ARMS.items():
        rows = [row for row in everything if row["arm"] == name]
        if not rows:
            continue
        gain = np.array([float(row["stiffness"]) / float(row["receptance"]) for row in rows])
        static = np.array([float(row["static"]) / float(row["receptance"]) for row in rows])
        singular = sum(int(row["singular"]) for row in rows)
        found.append(
            f"- {arm.title}: after optimising the receptance it is {np.median(gain):.3g} times lower "
            f"(median) than after optimising ξ_K, {np.median(static):.3g} times lower than after the static "
            f"receptance. In {singular} of {len(rows)} tasks every start by ξ_K ran into a singular posture, "
            "which then counts."
        )
    return found


def picture(everything: list[dict[str, str]]):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.5), layout="constrained")
    panels = figure.subplots(1, len(ARMS), sharey=True)
    styles = ("-", "--", ":")
    for axes, (name, arm) in zip(panels, ARMS.items(), strict=True):
        rows = [row for row in everything if row["arm"] == name]
        for place, (key, title) in enumerate(WAYS.items()):
            ratio = np.sort(np.maximum(ratios(rows, key), 1e-6))
            share = np.arange(1, len(ratio) + 1) / len(ratio)
            axes.plot(
                ratio, 100 * share, color=PALETTE[place], linestyle=styles[place], linewidth=2, label=title
            )
        axes.axvline(1.0, color="0.4", linewidth=1)
        axes.set_xscale("log")
        axes.set_xlim(1e-3, 20)
        axes.grid(True, color="0.88", linewidth=0.6)
        axes.set_title(f"{arm.title.replace(', ', chr(10), 1)}\n{len(rows)} tasks", fontsize=10, loc="left")
        axes.set_xlabel("|receptance| over that of the start [–]")
    panels[0].set_ylabel("Tasks at or below [%]")
    handles, titles = panels[0].get_legend_handles_labels()
    figure.legend(
        handles,
        [f"optimised by {title}" for title in titles],
        fontsize=9,
        loc="outside lower center",
        ncols=3,
    )
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", type=int, default=200, help="tasks an arm")
    add_options(parser)
    options = parser.parse_args()
    if options.one:
        one(options.one)
        return
    compute(options.tasks, options.scheduler, options.workers)
    everything = rows_there()
    with whole_file(TABLES / "task_statistics.md", overwrite=True) as scratch:
        scratch.write_text(summarise(everything), encoding="utf-8")
    write_figure(picture(everything), ROOT / "docs" / "pictures" / "task_statistics.png", overwrite=True)
    print(summarise(everything))


if __name__ == "__main__":
    main()

"""Does the identification find the truth, and are its intervals honest? 100 campaigns on each of three arms.

The true robot differs from the card by a standard deviation between 2 and 10 %, drawn for each campaign, in
every stiffness, damping, mass and inertia. What is counted is how often the 95 % interval of a parameter
that the data tell holds the truth. Results are kept as JSON lines in build/, so that a run that was stopped
goes on where it was; `--scheduler ADDRESS` has them made on a Dask cluster. Times are of one core.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from spreading import add_options, pieces
from tables import ROOT, write

import flexmodal
from flexmodal.identification import build_identification
from flexmodal.rig import simulate

ROBOTS = ("fanuc_s360", "six_link", "six_axis")
CACHE = ROOT / "build" / "identification_recovery.jsonl"
SMALLEST, LARGEST = 0.02, 0.10
KINDS = ("stiffness", "damping", "mass", "inertia")


def one(name: str, seed: int) -> dict[str, Any]:
    """Simulate a campaign and identify it from its FRFs alone."""
    robot = flexmodal.load(name)
    size = float(np.random.default_rng([seed, 77]).uniform(SMALLEST, LARGEST))
    made = simulate(robot, postures=4, points=4, references=2, trials=4, parameter_error=size, seed=seed)
    start = time.perf_counter()
    problem = build_identification(replace(made.campaign, blows=()), robot)
    before = problem.identifiability
    fitted = problem.evidence.fit()
    sure = problem.evidence.uncertainty(fitted)
    taken = time.perf_counter() - start
    low, high = sure.interval(fitted.x)
    truth = [float(np.log(made.truth.factors[parameter])) for parameter in problem.space.names]
    return {
        "robot": name,
        "seed": seed,
        "off": size,
        "time": taken,
        "steps": fitted.steps,
        "over_noise": problem.evidence.over_noise(problem.evidence.predicted(fitted.x)),
        "names": problem.space.names,
        "truth": truth,
        "found": fitted.x.tolist(),
        "low": low.tolist(),
        "high": high.tolist(),
        "identified": [parameter in sure.identified for parameter in problem.space.names],
        "foreseen": [parameter in before.identifiable for parameter in problem.space.names],
    }


def run(count: int, cache: Path, scheduler: str | None, workers: int | None) -> list[dict[str, Any]]:
    """Every campaign once; those of the cache are not run again."""
    cache.parent.mkdir(exist_ok=True)
    done = [json.loads(line) for line in cache.read_text().splitlines()] if cache.exists() else []
    known = {(entry["robot"], entry["seed"]) for entry in done}
    missing = (f"{name}:{seed}" for name in ROBOTS for seed in range(count) if (name, seed) not in known)
    given = {"scheduler": scheduler, "workers": workers}
    with cache.open("a") as file:
        for name, told in pieces("identification_recovery.py", missing, [], **given):
            if told is not None:
                done.append(json.loads(told))
                file.write(told.strip() + "\n")
                file.flush()
                print(f"{name}: {done[-1]['time']:.1f} s", flush=True)
    done.sort(key=lambda entry: (ROBOTS.index(entry["robot"]), entry["seed"]))
    return [entry for entry in done if entry["seed"] < count]


def rows_of(name: str, entries: list[dict[str, Any]]) -> list[list[str]]:
    """A row for each kind of parameter, and one for all."""
    names = entries[0]["names"]
    truth, found, low, high = (
        np.array([e[key] for e in entries]) for key in ("truth", "found", "low", "high")
    )
    known = np.array([entry["identified"] for entry in entries])
    foreseen = np.array([entry["foreseen"] for entry in entries])
    hit = (low <= truth) & (truth <= high)
    error, width = np.abs(np.expm1(found - truth)), (high - low) / 2
    rows = []
    for kind in (*KINDS, ""):
        columns = np.array([parameter.startswith(kind) for parameter in names])
        some = known & columns
        if not some.any():
            continue
        each = [
            hit[known[:, k], k].mean()
            for k in np.flatnonzero(columns)
            if known[:, k].sum() >= len(entries) / 2
        ]
        never = [n for k, n in enumerate(names) if columns[k] and known[:, k].mean() < 0.5]
        took = np.median([entry["time"] for entry in entries])
        rows.append([
            f"{name}: {kind or 'all'}",
            f"{some.sum()} of {columns.sum() * len(entries)}",
            f"{100 * hit[some].mean():.1f}",
            f"{100 * min(each):.0f} to {100 * max(each):.0f}",
            f"{100 * np.median(error[some]):.3f}",
            f"{100 * np.median(width[some]):.3f}",
            ", ".join(never) or "–",
            f"{100 * (known == foreseen)[:, columns].mean():.1f}",
            f"{took:.1f}" if not kind else "",
        ])  # fmt: skip
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100, help="campaigns on each robot")
    parser.add_argument("--cache", type=Path, default=CACHE)
    add_options(parser)
    options = parser.parse_args()
    if options.one:
        name, seed = options.one.split(":")
        print(json.dumps(one(name, int(seed))))
        return
    entries = run(options.count, options.cache, options.scheduler, options.workers)
    rows = []
    for name in ROBOTS:
        rows += rows_of(name, [entry for entry in entries if entry["robot"] == name])
    write(
        "identification_recovery",
        "Identification of simulated campaigns: is the truth found?",
        f"Made by `make recovery`: {options.count} campaigns on each robot, 4 postures × 4 points × 2 "
        f"hammer positions × "
        "4 trials, FRFs alone, every parameter of the true robot off the card by a standard deviation "
        "between 2 and "
        "10 %. A parameter is identified if less than half of its prior's standard deviation is left.",
        ["robot: parameters", "identified", "inside 95 % interval [%]", "single parameters [%]",
         "median error [%]", "median half interval [%]", "not identified", "foreseen before the fit [%]",
         "time [s]"],
        rows,
        "Inside: how often the interval of an identified parameter held the truth; single parameters: the "
        "lowest and the highest such share of one of them; of 100 campaigns a share of 95 % scatters by 2 % "
        "(one standard deviation), and parameters of one campaign are hit or missed together. Foreseen: how "
        "often what the Fisher information at the card said about identified or not was so after the fit. "
        "Time: median for reading, fit and intervals on one core of a shared machine, without the "
        "simulation.",
    )  # fmt: skip


if __name__ == "__main__":
    main()

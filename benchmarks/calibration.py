"""Are confidences calibrated? Of the effects named with 90 %, nine in ten should be there.

    python benchmarks/calibration.py [FOLDER…] [--campaigns N] [--first SEED]

Reads the answers of any number of runs of the exam (`exam.py --folder`: FOLDER holds `answers` and
`truth`), and poses small campaigns of its own besides, of one to three postures, points and hammer
positions, in which a diagnosis has little to go by and is wrong more often. Each effect that is named is
one statement: it is right if it is hidden, and hidden there. Rows are kept in build/, so that a run goes
on.
"""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from exam_question import NAMED
from scipy.stats import beta
from tables import TABLES, answered, write

import flexmodal
from flexmodal.diagnosis import diagnose
from flexmodal.errors import InvalidRequest
from flexmodal.files import whole_file
from flexmodal.rig import Hide, simulate

FIRST = 72_000
"""Of the seeds: none from here on was looked at while the weights were tuned; `--first` looks at others."""
ROBOT, HEIGHTS = "fanuc_s360", (3.0, 25.0)
EDGES = (0.0, 0.5, 0.75, 0.9, 0.97, 1.0 + 1e-9)
"""Of the bins of stated confidence."""
SMALL = {
    "trials": 2, "averages": 2, "record_length": 2.0, "band": (2.0, 120.0), "peaks": [120.0],
    "parameter_error": 0.05, "time": False,
}  # fmt: skip
LINEAR = tuple(name for name in NAMED if name not in ("coulomb_friction", "nonlinear_stiffness"))
"""Effects that one level of force can show."""

Statement = tuple[float, bool]
"""What was stated, and whether it was right."""


def statements(steps: Sequence[dict[str, Any]], truth: Sequence[Sequence[str]]) -> list[Statement]:
    """Of one answer.

    Args:
        steps: effects that are named, with `effect`, `where` and `confidence`.
        truth: pairs of effect and place that are hidden.
    """
    hidden = {tuple(one) for one in truth}
    return [(float(one["confidence"]), (one["effect"], one["where"]) in hidden) for one in steps]


def of_exam(folder: Path) -> Iterator[Statement]:
    """Of every answer of an exam, or of exams in one folder.

    Args:
        folder: that holds `answers` and `truth`, or folders that do.
    """
    for file in sorted(folder.rglob("answers/*.json")):
        told = json.loads(file.read_text(encoding="utf-8"))
        truth = tomllib.loads((file.parents[1] / "truth" / f"{file.stem}.toml").read_text(encoding="utf-8"))
        if "steps" in told:  # answers of before have no places beside their confidences
            yield from statements(told["steps"], [(one["effect"], one["where"]) for one in truth["effect"]])


def one(seed: int) -> dict[str, Any]:
    """A small campaign from its seed, diagnosed."""
    random = np.random.default_rng([seed, 3])
    postures, points, struck = (int(random.integers(1, most)) for most in (4, 4, 3))
    effect = LINEAR[seed % len(LINEAR)]
    try:
        made = simulate(
            flexmodal.load(ROBOT), postures=postures, points=points, references=struck if points > 1 else 1,
            hide=[Hide(effect, height=HEIGHTS)], seed=seed, **SMALL,  # type: ignore[arg-type]
        )  # fmt: skip
    except InvalidRequest:  # no place has it as high as that
        return {"seed": seed, "truth": [], "steps": []}
    found = diagnose(made.campaign, made.robot)
    return {
        "seed": seed,
        "truth": [(one.effect, one.where) for one in made.truth.effects],
        "steps": [
            {"effect": step.effect, "where": step.where, "confidence": step.confidence}
            for step in found.steps
        ],
    }


def interval(right: int, count: int) -> tuple[float, float]:
    """Clopper and Pearson's 90 % interval of a share."""
    low = float(beta.ppf(0.05, right, count - right + 1)) if right else 0.0
    high = float(beta.ppf(0.95, right + 1, count - right)) if right < count else 1.0
    return low, high


def curve(stated: Sequence[Statement]) -> list[tuple[float, float, float, float, int, int]]:
    """Of each bin that is not empty: its edges, mean stated, share right, how many right, how many."""
    rows = []
    for low, high in pairwise(EDGES):
        some = [(sure, right) for sure, right in stated if low <= sure < high]
        if some:
            right = sum(ok for _, ok in some)
            rows.append(
                (
                    low,
                    min(high, 1.0),
                    float(np.mean([s for s, _ in some])),
                    right / len(some),
                    right,
                    len(some),
                )
            )
    return rows


def loss(stated: Sequence[Statement]) -> float:
    """Mean −ln of the probability that was given to what turned out [nat]."""
    given = [sure if right else 1 - sure for sure, right in stated]
    return float(np.mean(-np.log(np.clip(given, 1e-4, 1.0))))


def draw(rows: Sequence[tuple[float, float, float, float, int, int]], path: Path) -> None:
    """The curve with its intervals and counts."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5.2, 5), layout="constrained")
    axes.plot([0, 1], [0, 1], color="0.6", linestyle="--", label="calibrated")
    for _, _, stated, share, right, count in rows:
        low, high = interval(right, count)
        axes.errorbar(stated, share, [[share - low], [high - share]], fmt="o", color="#0072b2", capsize=3)
        offset = (-8, -16 if share > 0.1 else 8)
        axes.annotate(
            f"{right} of {count}", (stated, share), textcoords="offset points", xytext=offset, ha="right"
        )
    axes.set(xlabel="stated confidence", ylabel="part that was right", xlim=(0, 1.02), ylim=(0, 1.04))
    axes.legend(loc="upper left")
    with whole_file(path, overwrite=True) as scratch:
        figure.savefig(scratch, dpi=130)
    plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path, help="of exams")
    parser.add_argument("--campaigns", type=int, default=60, help="small ones")
    parser.add_argument("--first", type=int, default=FIRST, help="of the seeds")
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.campaigns)
    rows = answered(f"calibration-{given.first}", seeds, one)
    small = [each for row in rows for each in statements(row["steps"], row["truth"])]
    exams = [each for folder in given.folders for each in of_exam(folder)]
    report(small, exams, given.first == FIRST)


def report(small: Sequence[Statement], exams: Sequence[Statement], published: bool) -> None:
    """Print the table; for the seeds that nobody looked at write it, with its picture.

    Args:
        small: statements of small campaigns.
        exams: of exams.
        published: whether these seeds judge.
    """
    both = [*small, *exams]
    if not both:
        print("nothing was named yet")
        return
    rows = curve(both)
    table = []
    for low, high, stated, share, right, count in rows:
        least, most = interval(right, count)
        table.append([
            f"{100 * low:.0f} to {100 * high:.0f} %", f"{100 * stated:.0f} %", f"{right} of {count}",
            f"{100 * share:.0f} %", f"{100 * least:.0f} to {100 * most:.0f} %",
        ])  # fmt: skip
    lead = (
        f"Made by `python benchmarks/calibration.py`: {len(small)} effects named in small campaigns of one "
        f"to three postures, points and hammer positions on {ROBOT}, {len(exams)} in answers of the exam, "
        "on seeds that nobody had looked at. Right is an effect that is hidden, and hidden there."
    )
    right, mean = sum(ok for _, ok in both), 100 * np.mean([sure for sure, _ in both])
    certain = loss([(1.0, ok) for _, ok in both])
    end = (
        f"Of all, {right} of {len(both)} are right; the mean stated is {mean:.0f} %. Mean logarithmic loss "
        f"{loss(both):.2f} nats; of the same answers each stated at 100 % it would be {certain:.2f} (a "
        "certainty that is wrong counted as one in 10 000).\n\n![Reliability](calibration.png)"
    )
    header = ["stated", "mean", "right", "share", "90 % interval"]
    if published:
        draw(rows, TABLES / "calibration.png")
        write("calibration", "Are confidences calibrated?", lead, header, table, end)
    else:
        print(lead, *("  ".join(line) for line in table), end, sep="\n")


if __name__ == "__main__":
    main()

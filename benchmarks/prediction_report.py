"""Tables and the learning curve of `prediction.py`, from the rows that it keeps."""

from __future__ import annotations

from typing import Any

import numpy as np
from tables import ROOT

from flexmodal.prediction import METHODS
from flexmodal.report.figure import FITTED, MEASURED, PALETTE, SOFT, THIRD, drawing, log_axis, new_figure

ROBOTS = ("fanuc_s360", "six_link")
COUNTS = (3, 5, 8, 12, 20)
OURS = "chosen"
CURVES = {
    OURS: (FITTED, "o", "-", "predict: the method chosen"),
    "physics": (MEASURED, "s", "--", "physics alone"),
    "process": (THIRD, "^", "-.", "process without physics"),
    "mean": (SOFT, "x", ":", "mean of the others"),
    "nearest": (PALETTE[3], "+", ":", "nearest posture"),
}
PICTURE = ROOT / "docs" / "pictures" / "prediction_learning.png"
SPREAD = 0.03
"""Curves stand beside each other by this part, so that their bars do not cover each other."""


def report(rows: list[dict[str, Any]], lead: str, first: int) -> str:
    """The tables.

    Args:
        rows: one of each campaign and count.
        lead: what was done.
        first: seed of the first campaign.
    """
    lines = ["# Prediction of postures that nobody struck", "", lead, ""]
    counts = [
        f"{len({row['seed'] for row in rows if row['robot'] == name})} of {name}"
        for name in ROBOTS
        if any(row["robot"] == name for row in rows)
    ]
    lines += [f"Campaigns: {', '.join(counts)}, seeds from {first} on.", ""]
    return "\n".join(
        [*lines, *_wins(rows), "", *_curve(rows), "", "Made by `python benchmarks/prediction.py`.", ""]
    )


def _wins(rows: list[dict[str, Any]]) -> list[str]:
    lines = [
        "## How often it is nearer",
        "",
        "Than what stands in the column; *alike*: at most 1.02 times.",
        "",
    ]
    heads = ("postures shown", "campaigns", "mean", "nearest", "process without physics", "physics alone",
             "physics alone, or alike", "lines in the 95 % band")  # fmt: skip
    lines += ["| " + " | ".join(heads) + " |", "|" + "---:|" * len(heads)]
    for count in COUNTS:
        here = [row for row in rows if row["count"] == count]
        if here:
            wins = [_share(here, name) for name in ("mean", "nearest", "process", "physics")]
            alike = np.mean([row["gaps"][OURS] <= 1.02 * row["gaps"]["physics"] for row in here])
            parts = [*wins, alike, np.mean([row["covered"] for row in here])]
            cells = " | ".join(f"{100 * part:.0f} %" for part in parts)
            lines.append(f"| {count} | {len(here)} | {cells} |")
    return lines


def whole(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of campaigns with every count, so that a curve is of the same ones all along; all if none has.

    Args:
        rows: one of each campaign and count.
    """
    counts: dict[tuple[str, int], set[int]] = {}
    for row in rows:
        counts.setdefault((row["robot"], row["seed"]), set()).add(row["count"])
    found = [row for row in rows if counts[row["robot"], row["seed"]] >= set(COUNTS)]
    return found or rows


def _curve(rows: list[dict[str, Any]]) -> list[str]:
    rows = whole(rows)
    lines = ["## Learning curve", ""]
    lines += [
        "Campaigns with every number of postures. Gap on the four postures that were never shown: median "
        "over the campaigns, in brackets the quartiles. *foreseen*: the gap on postures left out, the method "
        "chosen anew without each, as "
        "`flexmodal predict` says it.",
        "",
    ]
    lines += [f"![Learning curve](../pictures/{PICTURE.name})", ""]
    names = (*METHODS, OURS)
    lines += ["| robot | postures shown | campaigns | " + " | ".join(names) + " | foreseen | noise floor |"]
    lines += ["|---|---:|---:|" + "---:|" * (len(names) + 2)]
    for name in ROBOTS:
        for count in COUNTS:
            here = [row for row in rows if (row["robot"], row["count"]) == (name, count)]
            if here:
                told = [[row["gaps"][method] for row in here] for method in names]
                told.append([row["expected"] for row in here])
                cells = " | ".join("{1:.2f} ({0:.2f}–{2:.2f})".format(*quartiles(one)) for one in told)
                floor = float(np.median([row["floor"] for row in here]))
                lines.append(f"| {name} | {count} | {len(here)} | {cells} | {floor:.3f} |")
    return lines


@drawing
def draw_learning(rows: list[dict[str, Any]]) -> Any:
    """Median gap with its quartiles by postures shown, one pane a robot.

    Args:
        rows: one of each campaign and count.
    """
    rows = whole(rows)
    robots = [name for name in ROBOTS if any(row["robot"] == name for row in rows)]
    figure = new_figure(4.6 * len(robots), 4.2)
    panes = np.atleast_1d(figure.subplots(1, len(robots), sharey=True))
    for pane, name in zip(panes, robots, strict=True):
        for place, (method, (colour, marker, style, label)) in enumerate(CURVES.items()):
            at, told = [], []
            for count in COUNTS:
                here = [row["gaps"][method] for row in rows if (row["robot"], row["count"]) == (name, count)]
                if here:
                    at.append(count * (1 + SPREAD) ** (place - 2))
                    told.append(quartiles(here))
            low, middle, high = np.array(told).T
            bars = np.array([middle - low, high - middle])
            pane.errorbar(
                at, middle, bars, color=colour, marker=marker, linestyle=style, label=label, capsize=2,
                linewidth=1.4,
            )  # fmt: skip
        floor = float(np.median([row["floor"] for row in rows if row["robot"] == name]))
        pane.axhline(floor, color=SOFT, linewidth=1.0, linestyle=(0, (1, 2)), label="noise floor")
        pane.set_xscale("log")
        pane.set_xticks(COUNTS, [str(count) for count in COUNTS])
        pane.minorticks_off()
        pane.set_xlabel("Postures struck")
        campaigns = len({row["seed"] for row in rows if row["robot"] == name})
        pane.set_title(f"{name}, {campaigns} campaigns", fontsize=10)
        log_axis(pane.yaxis)
    panes[0].set_ylabel("Gap on postures never struck [–]")
    figure.legend(*panes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def quartiles(values: list[float]) -> tuple[float, float, float]:
    """Lower quartile, median, upper quartile."""
    low, middle, high = np.percentile(values, [25, 50, 75])
    return float(low), float(middle), float(high)


def _share(rows: list[dict[str, Any]], other: str) -> float:
    """How often ours is nearer than another."""
    return float(np.mean([row["gaps"][OURS] < row["gaps"][other] for row in rows]))

"""What goes wrong in a laboratory: how often it is found and named, and how often something is made up.

Campaigns of three arms, the true robot 5 % off the card, 1 % noise. Each is looked at clean, with one mishap
(all kinds in turn) and with three at once. Found is a mishap of which a finding is of its kind. Results are
kept as JSON lines in build/, so that a run that was stopped goes on where it was.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

from tables import ROOT, TABLES

import flexmodal
from flexmodal.campaign import Campaign
from flexmodal.files import whole_file
from flexmodal.model import Robot
from flexmodal.rig import simulate
from flexmodal.rig.laboratory import MISHAPS, draw_mishaps, with_mishaps
from flexmodal.soundness import check_soundness

CACHE = ROOT / "build" / "soundness.jsonl"
FIRST = 80_000
"""Of the seeds: none below was looked at while the checks were made, and none from here on."""
ARMS: dict[str, dict[str, Any]] = {
    "fanuc_s360": {"postures": 4, "points": 3, "record_length": 3.0},
    "six_link": {"postures": 4, "points": 3, "record_length": 3.0},
    "six_axis": {"postures": 3, "points": 2, "record_length": 2.0},
}
SAME = {"sensitivity": "scale", "AC coupled force": "AC coupling"}
"""Kinds of findings where they are called otherwise than the mishap."""


def one(number: int) -> dict[str, Any]:
    """One campaign: clean, with one mishap, with three."""
    name = list(ARMS)[number % len(ARMS)]
    robot = flexmodal.load(name)
    made = simulate(robot, references=2, trials=2, averages=3, seed=FIRST + number, **ARMS[name])
    single = list(MISHAPS)[number // len(ARMS) % len(MISHAPS)]
    return {
        "number": number,
        "robot": name,
        "clean": [str(finding) for finding in check_soundness(made.campaign, robot)],
        "single": looked_at(made.campaign, robot, (single,), number),
        "three": looked_at(made.campaign, robot, draw_mishaps(3, FIRST + number), number),
    }


def looked_at(
    campaign: Campaign, robot: Robot, kinds: tuple[str, ...], number: int
) -> list[tuple[str, bool]]:
    """Each mishap, and whether it is among the findings."""
    spoilt, done = with_mishaps(campaign, kinds, FIRST + number)
    found = {finding.kind for finding in check_soundness(spoilt, robot)}
    return [(mishap.kind, SAME.get(mishap.kind, mishap.kind) in found) for mishap in done]


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--campaigns", type=int, default=200)
    given = asked.parse_args()
    CACHE.parent.mkdir(exist_ok=True)
    rows = [json.loads(line) for line in CACHE.read_text().splitlines()] if CACHE.exists() else []
    done = {row["number"] for row in rows}
    for number in range(given.campaigns):
        if number in done:
            continue
        row = one(number)
        with CACHE.open("a") as file:
            file.write(json.dumps(row) + "\n")
        rows.append(row)
        print(number, row["robot"], len(row["clean"]), row["single"], row["three"], flush=True)
    text = report(rows)
    print(text)
    with whole_file(TABLES / "soundness.md", overwrite=True) as scratch:
        scratch.write_text(text, encoding="utf-8")


def report(rows: list[dict[str, Any]]) -> str:
    """The table."""
    lead = (__doc__ or "").split("\n\n")
    alarms = sum(bool(row["clean"]) for row in rows)
    lines = [f"# {lead[0]}".rstrip("."), "", lead[1].replace("\n", " ").strip(), ""]
    lines += [f"Clean campaigns: {len(rows)}, with a finding on {alarms}.", ""]
    lines += ["| mishap | alone | found | among three | found |", "|---|---:|---:|---:|---:|"]
    for kind in (*MISHAPS, "all"):
        cells = []
        for how in ("single", "three"):
            told = [hit for row in rows for name, hit in row[how] if kind in (name, "all")]
            share = f"{100 * sum(told) / len(told):.0f} %" if told else "–"
            cells += [str(len(told)), share]
        lines.append(f"| {kind} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, "", "Made by `python benchmarks/soundness.py`.", ""])


if __name__ == "__main__":
    main()

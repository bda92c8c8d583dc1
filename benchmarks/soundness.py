"""What goes wrong in a laboratory: how often it is found and named, and how often something is made up.

Campaigns of three arms, the true robot 5 % off the card, 1 % noise, sensor and hammer along the world's axes
in one half, along those of their links in the other. Each is looked at clean, with one mishap
(all kinds in turn) and with three at once. Found is a mishap of which a finding is of its kind. What is done
to a channel along which nothing moves changes no record with a signal in it: it does no harm, cannot be seen,
and is counted apart. Results are kept as JSON lines in build/, so that a run that was stopped goes on from
there.
"""

from __future__ import annotations

import argparse
import json
from itertools import pairwise
from typing import Any

import numpy as np
from tables import TABLES, kept

import flexmodal
from flexmodal.campaign import Campaign
from flexmodal.files import whole_file
from flexmodal.identification.signal import with_signal
from flexmodal.model import Robot
from flexmodal.model.placements import link_placements
from flexmodal.rig import simulate
from flexmodal.rig.laboratory import MISHAPS, draw_mishaps, with_mishaps
from flexmodal.rig.laboratory.mishaps import LAST
from flexmodal.soundness import check_soundness

FIRST = 7_400_000
"""Of the seeds: none from here on was looked at while the checks were made; `--first` looks at others. Those
from 7 300 000 on were judged, 200 of them, before axes in another frame were looked for."""
ARMS: dict[str, dict[str, Any]] = {
    "fanuc_s360": {"postures": 4, "points": 3, "record_length": 3.0},
    "six_link": {"postures": 4, "points": 3, "record_length": 3.0},
    "six_axis": {"postures": 3, "points": 2, "record_length": 2.0},
}
SAME = {"sensitivity": "scale", "AC coupled force": "AC coupling"}
"""Kinds of findings where they are called otherwise than the mishap."""


def one(number: int, first: int) -> dict[str, Any]:
    """One campaign: clean, with one mishap, with three."""
    name, seed = list(ARMS)[number % len(ARMS)], first + number
    robot = flexmodal.load(name)
    frame = ("world", "link")[number // len(ARMS) % 2]
    made = simulate(robot, references=2, trials=2, averages=3, seed=seed, frame=frame, **ARMS[name])
    single = list(MISHAPS)[number // len(ARMS) % len(MISHAPS)]
    return {
        "number": number,
        "robot": name,
        "clean": [str(finding) for finding in check_soundness(made.campaign, robot)],
        "single": looked_at(made.campaign, robot, (single,), seed),
        "three": looked_at(made.campaign, robot, draw_mishaps(3, seed), seed),
    }


def looked_at(
    campaign: Campaign, robot: Robot, kinds: tuple[str, ...], seed: int
) -> list[tuple[str, bool, bool]]:
    """Each mishap, whether it is among the findings, and whether it changes any record with a signal."""
    spoilt, done = with_mishaps(campaign, kinds, seed)
    found = {finding.kind for finding in check_soundness(spoilt, robot)}
    order = sorted(kinds, key=lambda kind: kind == LAST)
    steps = [with_mishaps(campaign, order[:count], seed)[0] for count in range(len(order) + 1)]
    does = {kind: matters(*pair, robot) for kind, pair in zip(order, pairwise(steps), strict=True)}
    return [(one.kind, SAME.get(one.kind, one.kind) in found, does[one.kind]) for one in done]


def matters(before: Campaign, after: Campaign, robot: Robot) -> bool:
    """Whether angles, directions, or a record with a signal in it, are others."""
    if before.points != after.points and turned(before, after, robot):
        return True
    if [dict(one.q) for one in before.postures] != [dict(one.q) for one in after.postures]:
        return True
    return told(before) != told(after)


def turned(before: Campaign, after: Campaign, robot: Robot) -> bool:
    """Whether a direction of a record with a signal is another one by a tenth or more in a posture."""
    assert after.frfs is not None
    records, _ = with_signal(after.frfs, after)
    for posture in after.postures:
        placed = link_placements(robot, dict(posture.q))
        for row in np.flatnonzero(records.posture == posture.id):
            for number, way in (records.response[row], records.reference[row]):
                own, other = (one.point(int(number)) for one in (before, after))
                axes = placed[own.link][:3, :3]
                if np.linalg.norm(own.way(int(way), axes) - other.way(int(way), axes)) > 0.1:
                    return True
    return False


def told(campaign: Campaign) -> dict[tuple[int, ...], bytes]:
    """Labels and values of the records with a signal in them."""
    assert campaign.frfs is not None
    records, _ = with_signal(campaign.frfs, campaign)
    return {
        (
            int(records.posture[row]), int(records.trial[row]), *records.response[row].tolist(),
            *records.reference[row].tolist(),
        ): records.value[row].tobytes()
        for row in range(len(records))
    }  # fmt: skip


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--campaigns", type=int, default=200)
    asked.add_argument("--first", type=int, default=FIRST, help="seed; the table is written for the default")
    given = asked.parse_args()
    cache, rows = kept(f"soundness_{given.first}")
    done = {row["number"] for row in rows}
    for number in range(given.campaigns):
        if number in done:
            continue
        row = one(number, given.first)
        with cache.open("a") as file:
            file.write(json.dumps(row) + "\n")
        rows.append(row)
        print(number, row["robot"], len(row["clean"]), row["single"], row["three"], flush=True)
    text = report(rows)
    print(text)
    if given.first != FIRST:
        return
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
            hits = [hit for row in rows for name, hit, does in row[how] if does and kind in (name, "all")]
            share = f"{100 * sum(hits) / len(hits):.0f} %" if hits else "–"
            cells += [str(len(hits)), share]
        lines.append(f"| {kind} | " + " | ".join(cells) + " |")
    idle = [not does for row in rows for how in ("single", "three") for _, _, does in row[how]]
    lines += ["", f"Without effect, and not counted: {sum(idle)} of {len(idle)}."]
    return "\n".join([*lines, "", "Made by `python benchmarks/soundness.py`.", ""])


if __name__ == "__main__":
    main()

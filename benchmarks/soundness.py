"""What goes wrong in a laboratory: how often it is found and named, and how often something is made up.

Campaigns of three arms, the true robot 5 % off the card, 1 % noise, sensor and hammer along the world's axes
in one half, along those of their links in the other. Each is looked at clean, with one mishap
(all kinds in turn) and with three at once. Found is a mishap of which a finding is of its kind. What is done
to a channel along which nothing moves changes no record with a signal in it; and angles or axes that are
stated wrongly may leave the card's FRFs of these records as they are, as the base joint of a flat arm does
where all axes turn with their links. Such a mishap does no harm, cannot be seen, and is counted apart. Named
beside: a kind of finding that nobody caused, other than the symptoms of what was done (drive point,
reciprocity). Results are kept as JSON lines in build/, so that a run that was stopped goes on from there.
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
from flexmodal.identification import RobotModel, observe
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.model import predict
from flexmodal.identification.signal import with_signal
from flexmodal.model import Robot
from flexmodal.rig import simulate
from flexmodal.rig.laboratory import MISHAPS, draw_mishaps, with_mishaps
from flexmodal.rig.laboratory.mishaps import LAST
from flexmodal.soundness import check_soundness
from flexmodal.soundness.suspicion import CUT
from flexmodal.structure import robot_space

FIRST = 7_600_000
"""Of the seeds: none from here on was looked at while the checks were made; `--first` looks at others."""
ARMS: dict[str, dict[str, Any]] = {
    "fanuc_s360": {"postures": 4, "points": 3, "record_length": 3.0},
    "six_link": {"postures": 4, "points": 3, "record_length": 3.0},
    "six_axis": {"postures": 3, "points": 2, "record_length": 2.0},
}
SEEN = 0.05
"""Root mean square of |ln| by which the card's FRF of a record has to change for a statement to matter."""
SYMPTOMS = {"drive point", "reciprocity"}
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
        **looked_at(made.campaign, robot, (single,), seed, "single"),
        **looked_at(made.campaign, robot, draw_mishaps(3, seed), seed, "three"),
    }


def looked_at(
    campaign: Campaign, robot: Robot, kinds: tuple[str, ...], seed: int, how: str
) -> dict[str, list[Any]]:
    """Each mishap, whether it is among the findings, and whether it matters; and what is named beside."""
    spoilt, done = with_mishaps(campaign, kinds, seed)
    found = {str(finding.kind) for finding in check_soundness(spoilt, robot)}
    order = sorted(kinds, key=lambda kind: kind == LAST)
    steps = [with_mishaps(campaign, order[:count], seed)[0] for count in range(len(order) + 1)]
    does = {kind: matters(*pair, robot) for kind, pair in zip(order, pairwise(steps), strict=True)}
    caused = {SAME.get(one.kind, one.kind) for one in done}
    return {
        how: [(one.kind, SAME.get(one.kind, one.kind) in found, does[one.kind]) for one in done],
        f"beside {how}": sorted(found - caused - SYMPTOMS),
    }


def matters(before: Campaign, after: Campaign, robot: Robot) -> bool:
    """Whether what is stated of a record with a signal in it, or the record, is another."""
    if before.points == after.points and before.postures == after.postures:
        return told(before) != told(after)
    model = RobotModel(robot, robot_space(robot))
    seen = [observe(campaign) for campaign in (before, after)]
    one, other = (predict(model, np.zeros(len(model.space)), each) for each in seen)
    square = np.minimum(np.abs(residual(other, one)), CUT) ** 2
    used = seen[0].used
    each = np.where(used, square, 0).sum(axis=1) / np.maximum(used.sum(axis=1), 1)
    return bool(np.sqrt(each.max()) > SEEN)


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
    text = report(rows, given.first)
    print(text)
    if given.first != FIRST:
        return
    with whole_file(TABLES / "soundness.md", overwrite=True) as scratch:
        scratch.write_text(text, encoding="utf-8")


def report(rows: list[dict[str, Any]], first: int) -> str:
    """The table."""
    lead = (__doc__ or "").split("\n\n")
    alarms = sum(bool(row["clean"]) for row in rows)
    lines = [f"# {lead[0]}".rstrip("."), "", lead[1].replace("\n", " ").strip(), ""]
    beside = {how: sum(bool(row[f"beside {how}"]) for row in rows) for how in ("single", "three")}
    lines += [
        f"Clean campaigns: {len(rows)}, with a finding on {alarms}. With one mishap {beside['single']} of "
        f"{len(rows)} have something named beside, with three {beside['three']}. Seeds from {first} on.",
        "",
    ]
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

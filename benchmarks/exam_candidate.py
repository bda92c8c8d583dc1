"""The candidate: sees a campaign's folder and nothing else, and says what is hidden in it.

python benchmarks/exam_candidate.py CAMPAIGN ANSWER.json [SECONDS]
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.diagnosis import diagnose
from flexmodal.diagnosis.as_json import as_json
from flexmodal.files import whole_file
from flexmodal.identification.gap import over_noise


def processor_seconds() -> float:
    """Of this process and of those that have helped it."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def main() -> None:
    folder, answer = Path(sys.argv[1]), Path(sys.argv[2])
    wall, cpu = time.perf_counter(), processor_seconds()
    within = float(sys.argv[3]) if len(sys.argv) > 3 else None
    robot = flexmodal.load(str(folder / "robot" / "robot.toml"))
    found = diagnose(read_campaign(folder), robot, within=within)
    gaps, told = found.gaps, as_json(found)
    table = {
        "effects": found.verdict.effects,
        "explained": found.verdict.explained,
        "says": found.verdict.says,
        "confidence": [step.confidence for step in found.steps],
        "steps": told["steps"],
        "over_noise": over_noise(found.observations, found.predicted["after"]),
        "places": None if found.look is None else told["law_free"]["places"],
        "ties": [step.ties for step in found.steps],
        "parameters": [dict(step.parameters) for step in found.steps],
        "gap": {
            "believed": gaps.believed, "before": gaps.before, "after": gaps.after,
            "held_out_before": gaps.held_out_before, "held_out_after": gaps.held_out_after,
            "noise_floor": gaps.noise_floor,
        },
        "baselines": None if found.baselines is None else {
            "model": found.baselines.model, "mean": found.baselines.mean, "nearest": found.baselines.nearest,
        },
        "look": None if found.look is None else [
            {
                "port": one.port, "where": one.where, "alike": one.alike,
                "classes": [each.name for each in one.classes], "curve": one.curve is not None,
            }
            for one in found.look.found
        ],
        "cut_off": found.verdict.cut_off,
        "seconds": time.perf_counter() - wall,
        "processor_seconds": processor_seconds() - cpu,
    }  # fmt: skip
    with whole_file(answer, overwrite=True) as scratch:
        scratch.write_text(json.dumps(table, indent=1), encoding="utf-8")


main()

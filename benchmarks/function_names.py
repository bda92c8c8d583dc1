"""What free functions alone say is missing: right, wrong or nothing, before any law is tried.

    python benchmarks/function_names.py [FORMS:SEED[:MOST] …] [--workers N]

Poses the exam's campaigns with one effect, with one outside the catalogue and with nothing, takes the
law-free look for one place at each, and asks what the function of the only place that explains everything
tells. No law of the catalogue has a part in that, so that it does not matter which of them were met before.
Rows are kept in build/, so that a run goes on.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import tomllib
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from exam_plan import plan
from exam_question import NAMED, pose
from spreading import add_options, pieces
from tables import kept, write

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.diagnosis.lawfree.tells import told_by
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.setup import prepare

PUBLISHED = ("blind:20270404", "third:20270602:34")
"""Forms and seeds of the table, and how many of the campaigns if not all; the rules were found on others."""
KINDS = ("single", "outside", "nothing")


def told(forms: str, seed: int, name: str) -> dict[str, Any]:
    """A row: what is hidden in a campaign, where the look points to, and what the function there tells."""
    question = next(one for one in plan(seed, "rig", forms) if one.name == name)
    with tempfile.TemporaryDirectory() as scratch:
        campaign, truth = Path(scratch) / "campaign", Path(scratch) / "truth.toml"
        pose(question, campaign, truth)
        hidden = tomllib.loads(truth.read_text(encoding="utf-8")).get("effect", [])
        robot = flexmodal.load(str(campaign / "robot" / "robot.toml"))
        setup = prepare(read_campaign(campaign), robot, None, None, None, 0, lambda doing, part: None)
        lone = FrfData(setup).look.lone
    return {
        "piece": f"{forms}:{seed}:{name}",
        "kind": question.kind,
        "hidden": [[one["effect"], one["where"]] for one in hidden],
        "lone": None if lone is None else [lone.port, lone.where],
        "tells": None if lone is None else told_by(lone),
    }


def verdict_of(row: dict[str, Any]) -> str:
    """Right, wrong, or nothing."""
    if row["tells"] is None:
        return "nothing"
    return "right" if [row["tells"], row["lone"][1]] in row["hidden"] else "wrong"


def report(rows: Sequence[dict[str, Any]], seeds: Sequence[str]) -> None:
    """The table."""
    groups: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        groups[row["hidden"][0][0] if row["kind"] == "single" else row["kind"]].append(row)
    order = [*NAMED, "outside", "nothing"]
    table = []
    for name, some in [*((name, groups[name]) for name in order if groups[name]), ("all", list(rows))]:
        found = [verdict_of(row) for row in some]
        lone = sum(row["lone"] is not None for row in some)
        table.append(
            [name, str(len(some)), str(lone), *(str(found.count(one)) for one in ("right", "wrong"))]
        )
    lead = (
        f"Made by `python benchmarks/function_names.py`, forms and seeds {', '.join(seeds)}: campaigns with "
        "one effect, with one outside the catalogue, with nothing. *Lone* counts those in which one place "
        "explains everything without a law and all others can be told from it; *right* and *wrong* those in "
        "which its function tells an effect that is there, or is not. In all others it tells nothing. No law "
        "of the catalogue has a part in this."
    )
    header = ("hidden", "campaigns", "lone", "right", "wrong")
    write("function_names", "What free functions alone tell", lead, header, table)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seeds", nargs="*", default=PUBLISHED, metavar="FORMS:SEED[:MOST]")
    add_options(parser)
    given = parser.parse_args()
    if given.one:
        forms, seed, name = given.one.split(":")
        print(json.dumps(told(forms, int(seed), name)))
        return
    names = []
    for each in given.seeds:
        forms, seed, *most = each.split(":")
        every = [one.name for one in plan(int(seed), "rig", forms) if one.kind in KINDS]
        names += [f"{forms}:{seed}:{name}" for name in every[: int(most[0]) if most else None]]
    cache, rows = kept("function_names")
    done = {row["piece"]: row for row in rows}
    asked = [name for name in names if name not in done]
    for piece, printed in pieces(
        "function_names.py", asked, [], scheduler=given.scheduler, workers=given.workers
    ):
        if printed is not None:
            done[piece] = json.loads(printed.splitlines()[-1])
            with cache.open("a", encoding="utf-8") as file:
                file.write(json.dumps(done[piece]) + "\n")
            print(done[piece], verdict_of(done[piece]), flush=True)
    report([done[name] for name in names if name in done], list(given.seeds))


if __name__ == "__main__":
    main()

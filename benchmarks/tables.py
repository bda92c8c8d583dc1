"""Markdown tables that the docs carry, each headed by the command that makes it."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from flexmodal.files import whole_file

ROOT = Path(__file__).parents[1]
THESIS = ROOT / "tests" / "data" / "thesis"
TABLES = ROOT / "docs" / "tables"


def kept(name: str) -> tuple[Path, list[dict[str, Any]]]:
    """A file of JSON lines in build/, with the rows that a run before this one left there.

    Args:
        name: of the file, without its ending.
    """
    cache = ROOT / "build" / f"{name}.jsonl"
    cache.parent.mkdir(exist_ok=True)
    lines = cache.read_text(encoding="utf-8").splitlines() if cache.exists() else []
    return cache, [json.loads(line) for line in lines]


def answered(name: str, seeds: Iterable[int], one: Callable[[int], dict[str, Any]]) -> list[dict[str, Any]]:
    """What was made of every seed, each kept as soon as it is there; a run that was stopped goes on.

    Args:
        name: of the file that keeps them, see `kept`.
        seeds: that are asked; what was kept of others counts too.
        one: makes a row, which has the seed, of one.
    """
    cache, rows = kept(name)
    done = {row["seed"]: row for row in rows}
    for seed in seeds:
        if seed not in done:
            done[seed] = one(seed)
            with cache.open("a", encoding="utf-8") as file:
                file.write(json.dumps(done[seed]) + "\n")
            print(done[seed], flush=True)
    return [done[seed] for seed in sorted(done)]


def thesis(name: str) -> list[dict[str, str]]:
    """Rows of one of the thesis's tables."""
    with (THESIS / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def write(
    name: str, title: str, lead: str, header: Sequence[str], rows: Sequence[Sequence[str]], end: str = ""
) -> None:
    """Write docs/tables/<name>.md and print it; with `--check`, compare instead and exit 1 if it differs."""
    lines = [f"# {title}", "", lead, "", "| " + " | ".join(header) + " |"]
    lines.append("|" + "|".join(["---"] + ["---:"] * (len(header) - 1)) + "|")
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    if end:
        lines += ["", end]
    text = "\n".join(lines) + "\n"
    file = TABLES / f"{name}.md"
    print(text)
    if "--check" in sys.argv:
        sys.exit(file.read_text(encoding="utf-8") != text)
    with whole_file(file, overwrite=True) as scratch:
        scratch.write_text(text, encoding="utf-8")

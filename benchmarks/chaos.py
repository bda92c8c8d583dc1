"""Every command that writes, killed at each of its file events, on a full disk, and several at once.

Figures go to docs/tables/chaos.md, unless only some are asked for: `python benchmarks/chaos.py [CASE …]`.
After a kill the next reader has to find the old or the new, whole, and the next writer may not be barred; of
an atlas, which goes on where it was killed, every chunk that is there has to be whole and the next call has
to end with what an undisturbed one makes. Events, kills and files that may not grow are those of `killing`;
the commands are those of `chaos_cases`, places that cannot be written those of `chaos_places`. What each case
came to is kept in build/chaos.jsonl: a run that was stopped goes on where it was, `--fresh` begins again.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from chaos_cases import Case, call, cases, make_inputs, run, together_cases
from chaos_places import unwritable
from killing import digest, killed_everywhere
from tables import ROOT, write

LIMITS = (0, 2_000, 20_000)
"""Sizes of a file at which the disk is full [bytes]."""
ROUNDS = 12
NOWHERE = Path("/sys/kernel")
"""A file system in which nobody may make a file."""
KEPT = ROOT / "build" / "chaos.jsonl"


def killed(case: Case, home: Path) -> tuple[list[str], int]:
    """The row of a case, and how much is broken."""
    folder = home / case.name.replace(" ", "_").replace(",", "")
    folder.mkdir()
    target = folder / case.out.rpartition("=")[2]
    if case.before and run((*case.before, case.option, str(target)))[0] > 1:
        raise RuntimeError(f"{case.name}: nothing to replace")
    every = [
        killed_everywhere(
            lambda: run(call(case, folder)),
            folder,
            target,
            writers=case.writers,
            limits=LIMITS if by == signal.SIGKILL else (),
            by=by,
            step=case.step,
        )
        for by in case.signals
    ]
    found = every[0]
    if found.new == found.old:
        raise RuntimeError(f"{case.name}: nothing was written")
    broken = [
        f"{by.name}, {one}" for by, some in zip(case.signals, every, strict=True) for one in some.broken()
    ]
    for one in broken:
        print(f"{case.name}: {one}", file=sys.stderr)
    halves = sum(one not in (some.old, some.new) for some in every for one in some.seen)
    kept = sum(one == found.old for one in found.full)
    status, told = run(call(case, NOWHERE))
    refused = status == 2 and str(NOWHERE) in told and "Traceback" not in told
    lost = [place for place, sound in unwritable(case, folder, found.old) if not sound]
    for place in lost:
        print(f"{case.name}: {place}", file=sys.stderr)
    shutil.rmtree(folder)
    told_to = sum(len(some.events) for some in every[1:])
    row = [
        str(len(found.events)),
        str(told_to),
        str(len(broken)),
        str(halves),
        f"{kept} of {len(LIMITS)}",
    ]
    return [*row, "yes" if refused and not lost else "NO"], len(broken) + (not refused) + len(lost)


def atlas_killed(home: Path) -> tuple[list[str], int]:
    """An atlas, killed at each event: every chunk that is there is whole, and the next call ends as ever."""
    folder = home / "atlas"
    folder.mkdir()
    words = (
        "atlas",
        "fanuc_s360",
        "--grid",
        "q1=0.5:1:3,q2=-1:0:200,q3=0",
        "--frequencies",
        "1:100:0.05",
        "--quiet",
    )
    target = folder / "arm.zarr"
    again = ("--workers", "1", "--out", str(target))
    run((*words, *again))
    truth = {path.relative_to(folder): path.read_bytes() for path in target.rglob("*") if path.is_file()}
    shutil.rmtree(target)

    def call_anew() -> None:
        (folder / "called").touch()  # forks begin here, before the command looks at what stands there
        run((*words, *again))

    found = killed_everywhere(call_anew, folder, target)
    halves = [event for event, one in zip(found.events, found.written, strict=True) if one != found.new]
    for event in halves:
        print(f"atlas: {event}: the next call does not end as an undisturbed one", file=sys.stderr)
    whole = {name for name in truth if name.suffix != ".partial"}
    if len(whole) < 5 or found.new == found.old:
        raise RuntimeError("atlas: nothing was written")
    between = sum(one not in (found.old, found.new) for one in found.seen)
    status, told = run((*words, "--out", str(NOWHERE / "arm.zarr")))
    refused = status == 2 and str(NOWHERE) in told and "Traceback" not in told
    shutil.rmtree(folder)
    row = [str(len(found.events)), "0", str(len(halves)), f"{between}, by intent", "–"]
    return [*row, "yes" if refused else "NO"], len(halves) + (not refused)


def at_once(
    words: Callable[[int], tuple[str, ...]], folder: Path, writers: int, *, one: bool
) -> tuple[int, int]:
    """Rounds in which what stands there is no single writer's, and writers that were told to wait or go.

    Args:
        words: the command of each writer, which differs from the others' in what it writes.
        folder: where all of them write.
        writers: how many.
        one: whether only one of them may write, the others not being told to replace.
    """
    alone = {}
    for number in range(writers):
        run(words(number))
        alone[digest(folder)] = number
        _empty(folder)
    if len(alone) < writers:
        raise RuntimeError("two writers that write the same")
    mixed = told = 0
    for _ in range(ROUNDS):
        hold, start = os.pipe()
        children = []
        for number in range(writers):
            child = os.fork()
            if child == 0:
                os.close(start)
                _wait_at_first_event(folder, hold)
                os._exit(run(words(number))[0])
            children.append(child)
        os.close(hold)
        os.close(start)
        ended = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
        wrote = [number for number, status in enumerate(ended) if status in (0, 1)]
        told += writers - len(wrote)
        mixed += alone.get(digest(folder)) not in wrote or (one and len(wrote) != 1)
        _empty(folder)
    return mixed, told


def _wait_at_first_event(folder: Path, hold: int) -> None:
    waited = False

    def hook(name: str, given: tuple[object, ...]) -> None:
        nonlocal waited
        if not waited and name == "os.mkdir" and str(given[0]).startswith(str(folder)):
            waited = True
            os.read(hold, 1)  # until all of them are let go

    sys.addaudithook(hook)


def _empty(folder: Path) -> None:
    for entry in folder.iterdir():
        shutil.rmtree(entry) if entry.is_dir() else entry.unlink()


def main() -> None:
    """Run what is asked for; exit 1 if anything was lost, mixed or barred."""
    fresh, only = "--fresh" in sys.argv, [word for word in sys.argv[1:] if word != "--fresh"]
    KEPT.parent.mkdir(exist_ok=True)
    if fresh:
        KEPT.unlink(missing_ok=True)
    kept = {}
    for line in KEPT.read_text(encoding="utf-8").splitlines() if KEPT.is_file() and not only else ():
        one = json.loads(line)
        if not one["bad"]:
            kept[one["name"]] = one
    with tempfile.TemporaryDirectory(prefix="chaos-") as name:
        home = Path(name).resolve()
        for what, work in works(home).items():
            if what in kept or (only and what not in only):
                continue
            row, bad = work()
            print(what, *row, sep=" | ", flush=True)
            kept[what] = {"name": what, "row": row, "bad": bad}
            with KEPT.open("a", encoding="utf-8") as out:
                out.write(json.dumps(kept[what]) + "\n")
    if not only:
        table(list(kept.values()))
    sys.exit(int(any(one["bad"] for one in kept.values())))


def works(home: Path) -> dict[str, Callable[[], tuple[list[str], int]]]:
    """Every case by name, and what runs it; what several need is made once."""
    inputs = make_inputs(home)
    found: dict[str, Callable[[], tuple[list[str], int]]] = {
        case.name: partial(killed, case, home) for case in cases(inputs)
    }
    found["atlas"] = partial(atlas_killed, home)
    together = home / "together"
    together.mkdir()
    for name, words in together_cases(inputs, together).items():
        for writers in (2, 4):
            one = not name.endswith("--force")
            what = f"{name}, {writers} writers"
            found[what] = partial(_several, words, together, writers, one)
    return found


def _several(
    words: Callable[[int], tuple[str, ...]], folder: Path, writers: int, one: bool
) -> tuple[list[str], int]:
    mixed, told = at_once(words, folder, writers, one=one)
    return [str(ROUNDS), str(mixed), f"{told} of {ROUNDS * writers}"], mixed


def table(kept: list[dict[str, Any]]) -> None:
    """Write docs/tables/chaos.md."""
    alone = [[one["name"], *one["row"]] for one in kept if len(one["row"]) > 3]
    several = [[one["name"], *one["row"]] for one in kept if len(one["row"]) == 3]
    events, asked = (sum(int(row[place]) for row in alone) for place in (1, 2))
    lead = (
        f"`make chaos`. {events} kills by SIGKILL, {asked} ends by SIGTERM and SIGINT, each before another "
        "file event of the command. Lost: kills after which the next reader found neither the old nor "
        "the new, or the next writer was barred. In between: kills after which `ls` shows a part of several "
        "names until the next command. `demo`, which works long in between, was killed at each tenth. "
        "Full disk: files that may not grow past 0, 2,000 or 20,000 bytes; "
        "those that do not keep the old are small enough to be written whole. Nowhere to write: a place "
        "where nobody may make a file, a read-only folder, and file systems of 16 and 256 kB, which "
        "fill up, are named in a sentence; what stood there stands, or the new, whole."
    )
    header = [
        "command", "kill −9", "told to end", "lost", "in between", "full disk: old kept",
        "nowhere to write: said",
    ]  # fmt: skip
    lines = [
        "| several writers of one name at once | rounds | mixed or lost | told that another writes or wrote |"
    ]
    lines += ["|---|---:|---:|---:|", *("| " + " | ".join(row) + " |" for row in several)]
    write("chaos", "Writers killed", lead, header, alone, end="\n".join(lines))


if __name__ == "__main__":
    main()

"""Every command that writes, killed at each of its file events, on a full disk, and several at once.

Figures go to docs/tables/chaos.md, unless only some are asked for: `python benchmarks/chaos.py [CASE …]`.
After a kill the next reader has to find the old or the new, whole, and
the next writer may not be barred; of an atlas, which goes on where it was killed, every chunk that is there
has to be whole and the next call has to end with what an undisturbed one makes.
Events, kills and full disks are those of `killing`.
"""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from killing import digest, killed_everywhere
from tables import write

from flexmodal.cli.main import main as flexmodal

LIMITS = (0, 2_000, 20_000)
"""Sizes of a file at which the disk is full [bytes]."""
ROUNDS, WRITERS = 25, 4
CUT = str(Path(__file__).parents[1] / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml")
NOWHERE = Path("/sys/kernel")
"""A file system in which nobody may make a file."""
SMALL = ("--postures", "2", "--points", "2", "--trials", "1", "--averages", "2", "--record-length", "1")
RIG = ("rig", "fanuc_s360", *SMALL, "--references", "1", "--quiet")
AXIS = ("--posture", "configuration_1", "--frequencies", "1:60:1")


@dataclass(frozen=True)
class Case:
    """A command, how it is called, and what it replaces."""

    name: str
    words: tuple[str, ...]
    out: str
    """Name of what it writes."""
    option: str = "--out"
    before: tuple[str, ...] = ()
    """The command that made what stands there; none where there is nothing to replace."""
    writers: int = 1
    """After each of so many kills the next writer is tried."""
    signals: tuple[signal.Signals, ...] = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)


def cases(campaign: str, single: str) -> tuple[Case, ...]:
    """All of them, on one small campaign and on one of a single FRF."""
    frf, fit = ("frf", "fanuc_s360", *AXIS), ("fit", campaign, "--no-vary", "--per", "posture")
    identify, diagnose = ("identify", campaign, "--quiet"), ("diagnose", campaign, "--quiet")
    lean = (*diagnose, "--effects", "added_mass")
    path = ("optimise", "fanuc_s360", "--family", "second_link_horizontal", "--frequency", "8", "--quiet")
    kill = (signal.SIGKILL,)
    toolpath = (
        "path",
        "fanuc_s360",
        "--line",
        "0.9,0.6:0.9,0.8",
        "--points",
        "3",
        "--feed",
        "0.1",
        "--frequency",
        "5",
    )
    lobes = ("lobes", "fanuc_s360", "--cut", CUT, "--posture", "configuration_1", "--speeds", "5")
    return (
        Case("frf", frf, "frf.csv"),
        Case("frf --force", frf, "frf.uff", before=(*frf, "--form", "mobility")),
        Case("frf --force, a page", frf, "frf.html", before=(*frf, "--form", "mobility"), writers=5),
        Case("optimise, a picture", path, "receptance=best.png", "--plot"),
        Case("show", ("show", "fanuc_s360"), "page.html"),
        Case("path", (*toolpath, "--quiet"), "path.csv"),
        Case("lobes --force", lobes, "lobes.json", before=(*lobes, "--method", "multi-frequency"), writers=5),
        Case("fit --force", fit, "modes.csv", before=("fit", campaign, "--no-vary", "--band", "5:100")),
        Case(
            "fit, pictures", ("fit", single, "--no-vary"), "pictures", "--pictures", writers=10, signals=kill
        ),
        Case("rig", (*RIG, "--seed", "2", "--hide", "added_mass"), "test", signals=kill),
        Case("identify", identify, "found", writers=10, signals=kill),
        Case(
            "identify --force",
            identify,
            "found",
            before=(*identify, "--kinds", "stiffness"),
            writers=10,
            signals=kill,
        ),
        Case("diagnose", lean, "found", writers=20, signals=kill),
        Case("diagnose --force", lean, "found", before=(*lean, "--seed", "1"), writers=20, signals=kill),
    )


def run(words: tuple[str, ...]) -> tuple[int, str]:
    """A command in this process: its status and what it complained of."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as told:
        try:
            flexmodal([str(word) for word in words])
        except SystemExit as left:
            return int(left.code or 0), told.getvalue()
    return 0, told.getvalue()


def call(case: Case, folder: Path) -> tuple[str, ...]:
    """The command with its output in a folder."""
    kind, equals, name = case.out.rpartition("=")
    force = ("--force",) if case.before else ()
    return (*case.words, case.option, f"{kind}{equals}{folder / name}", *force)


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
    shutil.rmtree(folder)
    told_to = sum(len(some.events) for some in every[1:])
    row = [
        case.name,
        str(len(found.events)),
        str(told_to),
        str(len(broken)),
        str(halves),
        f"{kept} of {len(LIMITS)}",
    ]
    return [*row, "yes" if refused else "NO"], len(broken) + (not refused)


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
    found = killed_everywhere(lambda: run((*words, *again)), folder, target, limits=LIMITS)
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
    row = ["atlas", str(len(found.events)), "0", str(len(halves)), f"{between}, by intent", "–"]
    return [*row, "yes" if refused else "NO"], len(halves) + (not refused)


def at_once(words: Callable[[int], tuple[str, ...]], folder: Path, *, replacing: bool) -> tuple[int, int]:
    """Rounds in which what stands there is no single writer's, and writers that were told to wait or go.

    Args:
        words: the command of each writer, which differs from the others' in what it writes.
        folder: where all of them write.
        replacing: whether each may replace what another wrote.
    """
    alone = {}
    for number in range(WRITERS):
        run(words(number))
        alone[digest(folder)] = number
        _empty(folder)
    mixed = told = 0
    for _ in range(ROUNDS):
        hold, start = os.pipe()
        children = []
        for number in range(WRITERS):
            child = os.fork()
            if child == 0:
                os.close(start)
                _wait_at_first_event(folder, hold)
                os._exit(run(words(number))[0])
            children.append(child)
        os.close(hold)
        os.close(start)
        ended = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
        wrote = [number for number, status in enumerate(ended) if status == 0]
        told += WRITERS - len(wrote)
        mixed += alone.get(digest(folder)) not in wrote or (not replacing and len(wrote) != 1)
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
    """Run all of it; exit 1 if anything was lost, mixed or barred."""
    with tempfile.TemporaryDirectory(prefix="chaos-") as name:
        home = Path(name).resolve()
        campaign, single, together = home / "campaign", home / "single", home / "together"
        run((*RIG, "--out", str(campaign)))
        run((*RIG, "--postures", "1", "--points", "1", "--out", str(single)))
        together.mkdir()
        rows, bad = [], 0
        only = sys.argv[1:]
        for case in cases(str(campaign), str(single)):
            if only and case.name not in only:
                continue
            row, broken = killed(case, home)
            print(*row, sep=" | ", flush=True)
            rows.append(row)
            bad += broken
        row, broken = atlas_killed(home)
        print(*row, sep=" | ", flush=True)
        rows.append(row)
        bad += broken
        if only:
            sys.exit(int(bad > 0))
        frf = ("frf", "fanuc_s360", *AXIS, "--out", str(together / "frf.csv"), "--force", "--form")
        forms = ("receptance", "mobility", "inertance", "receptance")
        pairs = {
            "rig": at_once(
                lambda n: (*RIG, "--seed", str(n), "--out", str(together / "t")), together, replacing=False
            ),
            "frf --force": at_once(lambda n: (*frf, forms[n]), together, replacing=True),
        }
    bad += sum(mixed for mixed, _ in pairs.values())
    ends = [
        f"`{name}`: {WRITERS} writers at once, {ROUNDS} times: {mixed} mixed or lost, "
        f"{told} of {ROUNDS * WRITERS} told that another process writes there or has written."
        for name, (mixed, told) in pairs.items()
    ]
    events, asked = (sum(int(row[place]) for row in rows) for place in (1, 2))
    lead = (
        f"`make chaos`. {events} kills by SIGKILL, {asked} ends by SIGTERM and SIGINT. "
        f"Lost: kills after which the next reader found neither the old nor "
        "the new, or the next writer was barred. In between: kills after which `ls` shows a part of several "
        "names until the next command."
    )
    header = [
        "command",
        "kill −9",
        "told to end",
        "lost",
        "in between",
        "full disk: old kept",
        "nowhere to write: said",
    ]
    write("chaos", "Writers killed", lead, header, rows, end="\n".join(ends))
    sys.exit(int(bad > 0))


if __name__ == "__main__":
    main()

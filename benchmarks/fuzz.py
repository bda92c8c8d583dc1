"""What a user hands in, spoilt: read or refused with sentences; a second reader judges what was accepted.

    python benchmarks/fuzz.py [TARGET …] [--count N] [--first N] [--processes N] [--fresh]
    python benchmarks/fuzz.py TARGET --guided SECONDS

`make fuzz`. Each input follows from its number, so that a finding repeats. Inputs are asked in
chunks, each in a process of its own under limits of time and memory; what came of it is kept in
build/fuzz.jsonl: a run that was stopped goes on where it was, and chunks in which something failed are
asked again. The table docs/tables/fuzz.md says what all of them came to. What is judged is in `fuzz_targets`
and `fuzz_judges`; `--guided` lets atheris look for inputs by the code they reach, where it is installed.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fuzz_targets import ENDS, TARGETS, one, warm
from tables import ROOT, write

SEED = 20_262
SECONDS = 20
"""Of processor time for one input; ten times as long by the clock."""
MEMORY = 600e6
"""What an input may take beyond what the process has at the start [bytes]."""
CHUNK = 500
SHARES = {
    "urdf": 0.16, "card": 0.16, "cut": 0.16, "toolpath": 0.14, "posture": 0.16, "arguments": 0.06,
    "campaign": 0.16,
}  # fmt: skip
"""Of each target: calls of whole commands take ten times as long as a reader."""
KEPT = ROOT / "build" / "fuzz.jsonl"
_limited = [False]
"""Whether the input that is asked has a limit of time."""


def ask(target: str, first: int, count: int, answer: Path) -> None:
    """Ask some inputs in this process under its guards, and keep what came of them; never returns."""
    status = 1
    try:
        limit = int(_virtual_memory() + 4 * MEMORY)  # address space, of which a library reserves much
        resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))
        for one_signal in (signal.SIGALRM, signal.SIGPROF):
            signal.signal(one_signal, _out_of_time)
        warnings.simplefilter("error")  # what a user would be shown
        found = _asked(target, first, count, Path(tempfile.mkdtemp(prefix="fuzz-", dir=answer.parent)))
        answer.write_text(json.dumps(found), encoding="utf-8")
        status = 0
    finally:
        os._exit(status)


def _asked(target: str, first: int, count: int, home: Path) -> dict[str, Any]:
    counts, failures = Counter[str](), []
    before, started, at_first = _resident(), time.process_time(), time.monotonic()
    slowest = 0.0
    for number in range(first, first + count):
        (home.parent / "now").write_text(str(number))
        folder = home / "case"
        folder.mkdir(exist_ok=True)
        begun = time.process_time()
        try:
            _limit(SECONDS)
            counts[one(target, SEED, number, folder)] += 1
        except BaseException:
            failures.append(f"{target} {number}:\n{traceback.format_exc(limit=-6)[-4000:]}")
        finally:
            _limit(0)
        slowest = max(slowest, time.process_time() - begun)
        if target in ("campaign", "arguments"):
            shutil.rmtree(folder, ignore_errors=True)
    return {
        "target": target, "first": first, "count": count, "ends": counts, "failures": failures,
        "processor": time.process_time() - started, "clock": time.monotonic() - at_first,
        "slowest": slowest, "grown": max(0, _resident() - before),
    }  # fmt: skip


def chunks(
    targets: list[str], total: int, first: int, kept: list[dict[str, Any]]
) -> Iterator[tuple[str, int, int]]:
    """What is still to be asked, the targets in turn."""
    done = {(one["seed"], one["target"], one["first"], one["count"]) for one in kept if not one["failures"]}
    whole = sum(SHARES[target] for target in targets)
    ends = {target: first + round(total * SHARES[target] / whole) for target in targets}
    for start in range(first, max(ends.values()), CHUNK):
        for target, end in ends.items():
            asked = (target, start, min(CHUNK, end - start))
            if start < end and (SEED, *asked) not in done:
                yield asked


def carry_out(todo: Iterator[tuple[str, int, int]], processes: int) -> Iterator[dict[str, Any]]:
    """Each chunk in a fork of this process; one that dies or hangs is a failure like any other."""
    going: dict[int, tuple[tuple[str, int, int], Path, float]] = {}
    memory = Path("/dev/shm")  # four small files an input would keep a disk busy
    home = Path(tempfile.mkdtemp(prefix="fuzz-", dir=memory if os.access(memory, os.W_OK) else None))
    try:
        while True:
            while len(going) < processes and (asked := next(todo, None)):
                place = Path(tempfile.mkdtemp(dir=home))
                child = os.fork()
                if child == 0:
                    ask(*asked, place / "answer.json")
                going[child] = (asked, place, time.monotonic())
            if not going:
                return
            child, status = os.waitpid(-1, os.WNOHANG)
            if child == 0:
                time.sleep(0.05)
                for late, (_, place, _) in going.items():
                    if _still(place) > 20 * SECONDS:
                        os.kill(late, signal.SIGKILL)
                continue
            (target, first, count), place, _ = going.pop(child)
            if (place / "answer.json").is_file():
                yield {"seed": SEED, **json.loads((place / "answer.json").read_text(encoding="utf-8"))}
            else:
                number = (place / "now").read_text() if (place / "now").is_file() else str(first)
                fault = f"{target} {number}: the process ended with {os.waitstatus_to_exitcode(status)}"
                yield {
                    "seed": SEED, "target": target, "first": first, "count": count, "ends": {},
                    "failures": [fault], "processor": 0.0, "clock": 0.0, "slowest": 0.0, "grown": 0,
                }  # fmt: skip
            shutil.rmtree(place, ignore_errors=True)
    finally:
        for child in going:
            os.kill(child, signal.SIGKILL)
        shutil.rmtree(home, ignore_errors=True)


def _still(place: Path) -> float:
    """For how long a process has been at the same input [s]."""
    now = place / "now"
    return time.time() - (now if now.is_file() else place).stat().st_mtime


def _virtual_memory() -> int:
    """What this process has mapped [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def _resident() -> int:
    """The most this process has held [bytes]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024
    return 0


def _limit(seconds: float) -> None:
    """So much processor time from now, or ten times as long by the clock; 0 for as long as it takes."""
    _limited[0] = seconds > 0
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.setitimer(signal.ITIMER_REAL, 10 * seconds)


def _out_of_time(*_: object) -> None:
    """Once: where there is little processor time to be had both limits are met together."""
    if not _limited[0]:
        return
    _limit(0)
    raise TimeoutError(f"still at it after {SECONDS} s of processor time, or ten times as long by the clock")


def table(kept: list[dict[str, Any]]) -> None:
    """Write docs/tables/fuzz.md: the last answer of every chunk."""
    last = {(one["target"], one["first"]): one for one in kept if one["seed"] == SEED}
    rows = []
    for target in [*TARGETS, "all"]:
        some = [one for (name, _), one in sorted(last.items()) if target in (name, "all")]
        if not some:
            continue
        ends = Counter[str]()
        for one_chunk in some:
            ends.update(one_chunk["ends"])
        failures = sum(len(one_chunk["failures"]) for one_chunk in some)
        processor = sum(one_chunk["processor"] for one_chunk in some)
        asked = ends.total() + failures
        rows.append([
            target, f"{asked:,}", *(f"{ends[end]:,}" for end in ENDS), str(failures),
            f"{60 * asked / max(processor, 1e-9):,.0f}",
            f"{max(one_chunk['slowest'] for one_chunk in some):.1f}",
            f"{max(one_chunk['grown'] for one_chunk in some) / 1e6:.0f}",
        ])  # fmt: skip
    lead = (
        f"`make fuzz`, seed {SEED}. Spoilt inputs and what came of them. A failure is a crash, a traceback, "
        f"a warning, more than {SECONDS} s of processor time, {4 * MEMORY / 1e9:.1f} GB more address space, "
        "a sentence of more than 2,000 characters or that steers a terminal, a refusal without the file's "
        "name, or something accepted that a second reader refuses or reads as other numbers."
    )
    header = [
        "input", "asked", *ENDS, "failures", "a minute of one processor", "slowest [s]",
        "memory grown by [MB]",
    ]  # fmt: skip
    write("fuzz", "Spoilt inputs", lead, header, rows)


def kept_answers() -> list[dict[str, Any]]:
    """What was kept of former runs."""
    if not KEPT.is_file():
        return []
    return [json.loads(line) for line in KEPT.read_text(encoding="utf-8").splitlines() if line.endswith("}")]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("targets", nargs="*", help=f"of {', '.join(TARGETS)}; all if none")
    parser.add_argument("--count", type=int, default=1_000_000, help="inputs of all targets together")
    parser.add_argument("--first", type=int, default=0, help="number of the first of each target")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--fresh", action="store_true", help="forget former runs")
    parser.add_argument("--guided", type=int, metavar="SECONDS", help="by atheris, one target")
    options = parser.parse_args()
    chosen = options.targets or list(TARGETS)
    if unknown := set(chosen) - set(TARGETS):
        parser.error(f"no such target: {', '.join(sorted(unknown))}")
    if options.guided:
        script = str(Path(__file__).with_name("fuzz_guided.py"))
        os.execv(sys.executable, [sys.executable, script, chosen[0], str(options.guided)])
    KEPT.parent.mkdir(exist_ok=True)
    if options.fresh:
        KEPT.unlink(missing_ok=True)
    kept, failed, total, shown = kept_answers(), 0, 0, time.monotonic()
    warm()
    with KEPT.open("a", encoding="utf-8") as out:
        for found in carry_out(chunks(chosen, options.count, options.first, kept), options.processes):
            kept.append(found)
            out.write(json.dumps(found) + "\n")
            out.flush()
            failed, total = failed + len(found["failures"]), total + found["count"]
            print("\n".join(found["failures"]), end="\n" if found["failures"] else "", flush=True)
            if time.monotonic() - shown > 60:
                shown = time.monotonic()
                print(f"{total:,} inputs, {failed} failures", flush=True)
    print(f"{total:,} inputs asked, {failed} failures")
    if options.first == 0 and kept:
        table(kept)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())

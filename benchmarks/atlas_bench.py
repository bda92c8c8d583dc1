"""An atlas of the six-link arm: points a second against the kernel alone, memory, workers, a billion.

Writes docs/tables/atlas.md. `python benchmarks/atlas_bench.py [POSTURES [FOLDER]]`: as many postures as are
given and as the disk has room for, 400 lines each. All rates are of this machine in this hour; what counts
is their ratios, each of runs that took turns: by the clock, which hangs on what else the machine does, and by
processor time, which hangs less on it. The kernel alone is `receptance_batch` on chunks of the same size,
thrown away, on as many threads; the bare disk is the same bytes written to files by as many threads.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tables import write

import flexmodal
from flexmodal.atlas import Plan, Receptances, Sample, build_atlas, open_atlas, whole_range
from flexmodal.frf.kernels.route import available_cores
from flexmodal.model.batch import receptance_batch

LINES = 400
SMALL = 60_000
"""Postures of the comparisons; the run of all of them is made once."""
CORES = available_cores()
ROUNDS = 3


def plan_of(postures: int, *, single: bool = False) -> Plan:
    """Random postures of the six-link arm, one direction."""
    arm = flexmodal.load("six_link")
    quantity = Receptances.of(arm, ["tool:+z"], np.linspace(0.1, 40, LINES), single=single)
    return Plan(Sample(arm, postures, whole_range(arm)), quantity)


@dataclass(frozen=True)
class Taken:
    """What a run took."""

    clock: float
    """[s]."""
    processor: float
    """Of this process; of a cluster's, nothing is known [s]."""
    points: int

    def rate(self) -> float:
        """Points a second by the clock."""
        return self.points / self.clock


def taken(points: int, work: Callable[[], object]) -> Taken:
    """Run something, and say what it took."""
    clock, processor = time.perf_counter(), time.process_time()
    work()
    return Taken(time.perf_counter() - clock, time.process_time() - processor, points)


def kernel_alone(plan: Plan, chunks: int, threads: int) -> Taken:
    """The batch engine on the plan's chunks, its results thrown away."""
    layout, quantity = plan.layout, plan.quantity
    values = [plan.points.values(layout.region(number)[1]) for number in range(chunks)]

    def solve(some: np.ndarray) -> None:
        receptance_batch(plan.robot, some, quantity.pairs, quantity.frequency, threads=1, way=quantity.way)

    def solve_all() -> None:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(solve, values))

    solve(values[0])
    return taken(sum(map(len, values)) * LINES, solve_all)


def bare_disk(plan: Plan, chunks: int, threads: int, folder: Path) -> Taken:
    """The same bytes, written as plain files."""
    content = np.random.default_rng(0).random(plan.layout.files(folder, 0)[-1][1] // 8).tobytes()
    place = Path(tempfile.mkdtemp(dir=folder))

    def write_all() -> None:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda number: (place / str(number)).write_bytes(content), range(chunks)))

    found = taken(chunks * plan.layout.chunk[0] * LINES, write_all)
    shutil.rmtree(place)
    return found


def built(plan: Plan, path: Path, **given: object) -> Taken:
    """A whole atlas."""
    found = taken(plan.points.count * LINES, lambda: build_atlas(plan, path, **given))  # type: ignore[arg-type]
    assert open_atlas(path).is_complete
    return found


def on_dask(plan: Plan, folder: Path, count: int) -> Taken:
    """An atlas made on a cluster of so many processes on loopback, one thread each."""
    folder = Path(tempfile.mkdtemp(dir=folder))
    told = folder / "scheduler.json"
    program = str(Path(sys.executable).with_name("dask"))
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    ends = ["--no-dashboard", "--scheduler-file", str(told)]
    started = [subprocess.Popen([program, "scheduler", "--host", "127.0.0.1", "--port", "0", *ends], **quiet)]  # type: ignore[call-overload]
    while not told.is_file() or not told.stat().st_size:
        time.sleep(0.1)
    for _ in range(count):
        started.append(
            subprocess.Popen([program, "worker", "--nthreads", "1", *ends, "--local-directory", "."], **quiet)
        )  # type: ignore[call-overload]
    try:
        import json

        from distributed import Client

        address = json.loads(told.read_text())["address"]
        with Client(address) as client:
            client.wait_for_workers(count)
        built(plan_of(plan.layout.chunk[0] * count), folder / "warm.zarr", scheduler=address)
        return built(plan, folder / "dask.zarr", scheduler=address)
    finally:
        for process in reversed(started):
            process.kill()
            process.wait()
        shutil.rmtree(folder, ignore_errors=True)


class Memory:
    """The largest resident memory of this process while it works."""

    def __enter__(self) -> Memory:
        self.before = self._now()
        self.most = self.before
        self.done = threading.Event()
        self.watch = threading.Thread(target=self._look, daemon=True)
        self.watch.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.done.set()
        self.watch.join()

    def _look(self) -> None:
        while not self.done.wait(0.02):
            self.most = max(self.most, self._now())

    def _now(self) -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def main() -> None:
    postures = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    home = Path(tempfile.mkdtemp(prefix="atlas-", dir=sys.argv[2] if len(sys.argv) > 2 else None))
    try:
        rows, end = measured(postures, home)
    finally:
        shutil.rmtree(home, ignore_errors=True)
    lead = (
        f"`make atlas-bench`, on a machine of {CORES} cores whose load was {os.getloadavg()[0]:.1f} at the "
        f"end: the six-link arm, {LINES} lines, one direction, random postures. Medians of {ROUNDS} runs of "
        f"{SMALL:,} postures that took turns; the whole atlas was made once. Ratios are those of "
        "the same turn; by processor time they hang less on what else the machine did."
    )
    write(
        "atlas",
        "An atlas and the kernel alone",
        lead,
        [
            "what",
            "10⁶ points/s",
            "processor [ns a point]",
            "by the clock",
            "by processor time",
            "against",
            "goal",
        ],
        rows,
        end=end,
    )


def measured(postures: int, home: Path) -> tuple[list[list[str]], str]:
    """Rows of the table, and what follows from them."""
    build_atlas(plan_of(5000), home / "warm.zarr")
    turns = {
        name: [] for name in ("kernel", "atlas", "single", "disk", "kernel 1", "atlas 1", "dask 1", "dask 2")
    }
    small, half = plan_of(SMALL), plan_of(SMALL, single=True)

    def fresh(plan: Plan, workers: int) -> Taken:
        try:
            return built(plan, home / "small.zarr", workers=workers)
        finally:
            shutil.rmtree(home / "small.zarr", ignore_errors=True)

    for _ in range(ROUNDS):
        turns["kernel"].append(kernel_alone(small, small.chunks, CORES))
        turns["atlas"].append(fresh(small, CORES))
        turns["kernel 1"].append(kernel_alone(small, small.chunks, 1))
        turns["atlas 1"].append(fresh(small, 1))
        turns["single"].append(fresh(half, CORES))
        turns["disk"].append(bare_disk(small, small.chunks, CORES, home))
        for count in (1, 2):
            turns[f"dask {count}"].append(on_dask(small, home, count))
    with Memory() as memory:
        whole = taken(postures * LINES, lambda: build_atlas(plan_of(postures), home / "whole.zarr"))
    again = taken(0, lambda: build_atlas(plan_of(postures), home / "whole.zarr"))
    turns["whole"], turns["kernel then"] = [whole], [kernel_alone(small, small.chunks, CORES)]
    rows = table_rows(turns, postures)
    return rows, outcome(whole, again, turns["dask 2"], memory.most - memory.before, postures)


def table_rows(turns: dict[str, list[Taken]], postures: int) -> list[list[str]]:
    """Medians, and ratios turn by turn."""

    def row(what: str, name: str, against: str = "", of: str = "", goal: str = "") -> list[str]:
        some = turns[name]
        cells = [f"{np.median([one.rate() for one in some]) / 1e6:.1f}", _processor(name, some)]
        if not against:
            return [what, *cells, "", "", "", goal]
        pairs = list(zip(some, turns[against], strict=True))
        clock = np.median([one.rate() / other.rate() for one, other in pairs])
        own = np.median([other.processor / other.points * one.points / one.processor for one, other in pairs])
        known = "dask" not in name and "workers against" not in what
        return [what, *cells, f"{clock:.2f}", f"{own:.2f}" if known else "", of, goal]

    return [
        row(f"the kernel alone, {CORES} threads", "kernel"),
        row(f"atlas, {CORES} workers", "atlas", "kernel", "the kernel", "≥ 0.7"),
        row(f"atlas in single precision, {CORES} workers", "single", "kernel", "the kernel"),
        row(f"plain files of the same bytes, {CORES} threads", "disk", "kernel", "the kernel"),
        row("the kernel alone, 1 thread", "kernel 1"),
        row("atlas, 1 worker", "atlas 1", "kernel 1", "the kernel", "≥ 0.7"),
        row(f"atlas, {CORES} workers against 1", "atlas", "atlas 1", "one worker"),
        row("Dask, 1 process", "dask 1", "kernel 1", "the kernel"),
        row("Dask, 2 processes", "dask 2", "dask 1", "one process"),
        row(f"atlas of {postures:,} postures", "whole", "kernel then", "the kernel", "≥ 0.7"),
    ]


def _processor(name: str, some: list[Taken]) -> str:
    if "dask" in name:
        return ""
    return f"{np.median([one.processor / one.points for one in some]) * 1e9:.1f}"


def outcome(whole: Taken, again: Taken, dask: list[Taken], grown: int, postures: int) -> str:
    """The whole atlas in words, and a billion postures on paper."""
    plan = plan_of(postures)
    bytes_each = plan.layout.size / postures
    rate, two = whole.rate(), float(np.median([one.rate() for one in dask]))
    own = whole.processor / whole.points
    billion = 1e9 * LINES
    size, tasks = plan.layout.size, 1e9 / plan_of(10**9).layout.chunk[0]
    return (
        f"The whole atlas took {whole.clock:.0f} s for {size / 1e9:.2f} GB in {plan.chunks} chunks, "
        f"{whole.processor:.0f} s of processor time; the process grew by {grown / 1e6:.0f} MB at most. "
        f"Called again, it looked at every checksum in {again.clock:.1f} s and computed nothing.\n\n"
        f"On paper, 10⁹ postures × {LINES} lines: {billion * own / 3600:.1f} hours of processor time, so "
        f"{billion * own / 3600 / CORES:.1f} hours on {CORES} cores that have nothing else to do; "
        f"{billion / rate / 3600:.1f} hours at the rate of the whole atlas as this machine was, "
        f"{billion / two / 3600:.1f} at that of two Dask processes. On 20 cores, if disk and scheduler keep "
        f"up, {billion * own / 3600 / 20:.1f} hours: {tasks:,.0f} tasks, {1e9 * bytes_each / 1e12:.1f} TB "
        f"({1e9 * bytes_each / 2e12:.1f} TB in single precision), {20 * 16 / own / 1e9:.1f} GB/s."
    )


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    main()

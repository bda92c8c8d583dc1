"""An atlas of the six-link arm: points a second against the kernel alone, memory, workers, a billion.

Writes docs/tables/atlas.md. `python benchmarks/atlas_bench.py [POSTURES [FOLDER]]`: as many postures as are
given and as the disk has room for, 400 lines each. All rates are of this machine in this hour; what counts
is their ratios. The kernel alone is `receptance_batch` on chunks of the same size, thrown away, on as many
threads; the bare disk is the same bytes written to files by the same number of threads.
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
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from tables import write

import flexmodal
from flexmodal.atlas import Plan, Receptances, Sample, build_atlas, open_atlas, whole_range
from flexmodal.frf.kernels.route import available_cores
from flexmodal.model.batch import receptance_batch

LINES = 400
SMALL = 100_000
"""Postures of the comparisons; the run of all of them is made once."""
CORES = available_cores()
ROUNDS = 3


def plan_of(postures: int, *, single: bool = False) -> Plan:
    """Random postures of the six-link arm, one direction."""
    arm = flexmodal.load("six_link")
    quantity = Receptances.of(arm, ["tool:+z"], np.linspace(0.1, 40, LINES), single=single)
    return Plan(Sample(arm, postures, whole_range(arm)), quantity)


def kernel_alone(plan: Plan, chunks: int, threads: int) -> float:
    """Points a second of the batch engine on the plan's chunks, its results thrown away."""
    layout, quantity = plan.layout, plan.quantity
    values = [plan.points.values(layout.region(number)[1]) for number in range(chunks)]

    def solve(some: np.ndarray) -> None:
        receptance_batch(plan.robot, some, quantity.pairs, quantity.frequency, threads=1, way=quantity.way)

    solve(values[0])
    started = time.perf_counter()
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(solve, values))
    return sum(map(len, values)) * LINES / (time.perf_counter() - started)


def bare_disk(plan: Plan, chunks: int, threads: int, folder: Path) -> float:
    """Points a second that the file system takes, written as plain files."""
    content = np.random.default_rng(0).random(plan.layout.files(folder, 0)[-1][1] // 8).tobytes()
    place = Path(tempfile.mkdtemp(dir=folder))
    started = time.perf_counter()
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda number: (place / str(number)).write_bytes(content), range(chunks)))
    seconds = time.perf_counter() - started
    shutil.rmtree(place)
    return chunks * plan.layout.chunk[0] * LINES / seconds


def built(plan: Plan, path: Path, **given: object) -> float:
    """Points a second of a whole atlas."""
    found = build_atlas(plan, path, **given)  # type: ignore[arg-type]
    assert open_atlas(path).is_complete
    return plan.points.count * LINES / found.seconds


def on_dask(plan: Plan, folder: Path, count: int) -> float:
    """Points a second on a cluster of so many processes on loopback, one thread each."""
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


def median(measure: object, *given: object, **more: object) -> float:
    return float(np.median([measure(*given, **more) for _ in range(ROUNDS)]))  # type: ignore[operator]


def main() -> None:
    postures = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    home = Path(tempfile.mkdtemp(prefix="atlas-", dir=sys.argv[2] if len(sys.argv) > 2 else None))
    try:
        rows, end = measured(postures, home)
    finally:
        shutil.rmtree(home, ignore_errors=True)
    lead = (
        f"`make atlas-bench`, on a machine of {CORES} cores: the six-link arm, {LINES} "
        f"lines, one direction, random "
        f"postures. Medians of {ROUNDS} runs of {SMALL:,} postures, but for the whole atlas."
    )
    write(
        "atlas",
        "An atlas and the kernel alone",
        lead,
        ["what", "10⁶ points/s", "ratio", "goal"],
        rows,
        end=end,
    )


def measured(postures: int, home: Path) -> tuple[list[list[str]], str]:
    """Rows of the table, and what follows from them."""
    small = plan_of(SMALL)
    chunks = small.chunks
    kernel, one, many, halves, disk = [], [], [], [], []
    build_atlas(plan_of(5000), home / "warm.zarr")

    def fresh(plan: Plan, workers: int) -> float:
        path = home / "small.zarr"
        try:
            return built(plan, path, workers=workers)
        finally:
            shutil.rmtree(path, ignore_errors=True)

    for _ in range(ROUNDS):  # interleaved, as the machine's speed drifts
        kernel.append(kernel_alone(small, chunks, CORES))
        many.append(fresh(small, CORES))
        halves.append(fresh(plan_of(SMALL, single=True), CORES))
        one.append(fresh(small, 1))
        disk.append(bare_disk(small, chunks, CORES, home))
    kernel_one = median(kernel_alone, small, chunks, 1)
    clusters = [median(on_dask, small, home, count) for count in (1, 2)]
    with Memory() as memory:
        found = build_atlas(plan_of(postures), home / "whole.zarr")
    whole = postures * LINES / found.seconds
    started = time.perf_counter()
    build_atlas(plan_of(postures), home / "whole.zarr")
    again = time.perf_counter() - started
    k, o, m, h, d = (float(np.median(one)) for one in (kernel, one, many, halves, disk))

    def row(what: str, rate: float, ratio: float | None, against: str = "", goal: str = "") -> list[str]:
        return [what, f"{rate / 1e6:.1f}", "" if ratio is None else f"{ratio:.2f} {against}", goal]

    rows = [
        row(f"the kernel alone, {CORES} threads", k, None),
        row(f"atlas, {CORES} workers", m, m / k, "of the kernel", "≥ 0.7"),
        row(f"atlas in single precision, {CORES} workers", h, h / k, "of the kernel"),
        row(f"plain files of the same bytes, {CORES} threads", d, d / k, "of the kernel"),
        row("the kernel alone, 1 thread", kernel_one, None),
        row("atlas, 1 worker", o, o / kernel_one, "of the kernel", "≥ 0.7"),
        row(f"atlas, {CORES} workers against 1", m, m / o, "times"),
        row("Dask, 1 process", clusters[0], clusters[0] / kernel_one, "of the kernel"),
        row("Dask, 2 processes", clusters[1], clusters[1] / clusters[0], "times 1 process"),
        row(f"atlas of {postures:,} postures", whole, whole / k, "of the kernel", "≥ 0.7"),
    ]
    size = plan_of(postures).layout.size
    billion = 1e9 * LINES
    bytes_each = size / postures
    end = (
        f"The whole atlas took {found.seconds:.0f} s for {size / 1e9:.2f} GB in "
        f"{found.chunks} chunks; the process "
        f"grew by {(memory.most - memory.before) / 1e6:.0f} MB at most. Called again, it "
        f"looked at every checksum "
        f"in {again:.1f} s and computed nothing.\n\n"
        f"On paper, 10⁹ postures × {LINES} lines: {billion / whole / 3600:.1f} hours at the "
        f"rate of the whole atlas on "
        f"this machine, {billion / clusters[1] / 3600:.1f} at that of two Dask processes, so some "
        f"{billion / (clusters[1] / 2) / 3600 / 10:.1f} on ten times two if disk and scheduler keep up: "
        f"{1e9 / plan_of(10**9).layout.chunk[0]:,.0f} tasks, {1e9 * bytes_each / 1e12:.1f} TB "
        f"({1e9 * bytes_each / 2e12:.1f} TB in single precision)."
    )
    return rows, end


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    main()

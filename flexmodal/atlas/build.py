"""Computing an atlas: what does not stand yet, chunk by chunk, on whatever there is to compute on."""

from __future__ import annotations

import os
import pickle
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from flexmodal.atlas.plan import Plan, differing, path_of, versions
from flexmodal.atlas.spread import MOST_WORKERS, PATIENCE, check_workers, spread
from flexmodal.atlas.store import create, facts_of, is_sound, make_chunk, put_chunk, sweep_out
from flexmodal.errors import Fault, FlexmodalError, OutputExists
from flexmodal.files import claimed, complete
from flexmodal.frf.kernels.route import available_cores

WRITERS = 2
"""Threads for each core, of which one may wait for the disk while another computes."""


@dataclass(frozen=True)
class Built:
    """What was done."""

    path: Path
    chunks: int
    """Of the whole atlas."""
    standing: int
    """That stood there already."""
    spoilt: int
    """That stood there with a wrong checksum, and were computed again."""
    seconds: float
    others: tuple[str, ...]
    """Libraries whose version differs from when the atlas was begun; its last digits may differ then."""


@dataclass(frozen=True)
class Worker:
    """One chunk computed and written, wherever it is called."""

    job: bytes
    path: str
    versions: tuple[tuple[str, str], ...] = ()
    """Of the libraries, where they have to be the same as here."""
    slots: AbstractContextManager[Any] | None = None
    """Held while computing, not while writing; none where each call has a core to itself."""

    def __call__(self, number: int) -> None:
        """Write one chunk.

        Raises:
            FlexmodalError: the libraries are others here, or the store cannot be seen or written.
        """
        here = versions() if self.versions else {}
        for name, wanted in self.versions:
            if here.get(name) != wanted:
                raise FlexmodalError(f"a worker has {name} {here.get(name)}, not {wanted}")
        path = Path(self.path)
        with self.slots or nullcontext():
            made = make_chunk(_plan(self.job), path, number)
        put_chunk(made, path)


@lru_cache(maxsize=4)
def _plan(job: bytes) -> Plan:
    plan: Plan = pickle.loads(job)
    return plan


def build_atlas(
    plan: Plan,
    path: str | os.PathLike[str],
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    verify: bool = True,
    patience: float = PATIENCE,
    begin: Callable[[int, int], None] = lambda chunks, standing: None,
    advance: Callable[[], None] = lambda: None,
) -> Built:
    """Compute an atlas, or what is missing of one that was begun.

    Whenever it is killed, the chunks that stand are whole, and the next call computes the others; the store
    is then the same, bit by bit, as one computed in one go with the same libraries.

    Args:
        plan: what it is to hold.
        path: of the store, new or begun with the same plan.
        scheduler: address of a Dask scheduler whose workers see the same folder; this machine if none.
        workers: processes or threads on this machine; as many as cores if none.
        verify: look at the checksums of what stands already.
        patience: how long a cluster may be without any worker [s].
        begin: told how many chunks there are and how many stand.
        advance: called after each chunk.

    Raises:
        OutputExists: something else stands there, or another process is writing it.
        InvalidRequest: there is no room on the disk, no scheduler, a number of workers out of range.
        MissingExtra: zarr, or for a scheduler Dask, is not installed.
        FlexmodalError: a posture has no such quantity, or workers died.
    """
    target, started = path_of(path), time.perf_counter()
    complete(target)
    begun = facts_of(target)
    if begun is None:
        if not target.parent.is_dir():
            raise OutputExists(Fault(str(target), "", "no such folder", "a store in an existing folder"))
        plan.check_room(target)
        create(plan, target)
        begun = facts_of(target) or {}
    others = _compare(plan, target, begun)
    with claimed(target):
        sweep_out(target)
        standing = [number for number in range(plan.chunks) if plan.layout.stands(target, number)]
        spoilt = _spoilt(plan, target, standing, workers) if verify else set()
        kept = set(standing) - spoilt
        plan.check_room(target, len(kept))
        begin(plan.chunks, len(kept))
        missing = (number for number in range(plan.chunks) if number not in kept)
        for _ in _spread(plan, target, missing, scheduler, workers, patience):
            advance()
    return Built(target, plan.chunks, len(kept), len(spoilt), time.perf_counter() - started, others)


def _spread(
    plan: Plan,
    target: Path,
    missing: Iterator[int],
    scheduler: str | None,
    workers: int | None,
    patience: float,
) -> Iterator[Any]:
    """Chunks computed on as many cores as there are workers; threads that wait for the disk leave theirs."""
    job, where = plan.job, str(target)
    if scheduler is not None:
        there = Worker(job, where, tuple(versions().items()))
        return spread(there, missing, scheduler=scheduler, patience=patience)
    if not plan.quantity.releases:
        return spread(Worker(job, where), missing, workers=workers)
    check_workers(workers)
    cores = workers or available_cores()
    shared = Worker(job, where, slots=threading.BoundedSemaphore(cores))
    return spread(shared, missing, workers=min(WRITERS * cores, MOST_WORKERS), threads=True)


def _compare(plan: Plan, target: Path, begun: dict[str, Any]) -> tuple[str, ...]:
    own = {key: value for key, value in begun.items() if key != "versions"}
    other = differing(own, plan.facts)
    if other:
        found = f"an atlas of something else: {', '.join(other[:5])} differ"
        raise OutputExists(Fault(str(target), "", found, "a new name, or the same request as before"))
    before, now = begun.get("versions", {}), versions()
    return tuple(
        f"{name} {before.get(name)}, now {now[name]}" for name in now if before.get(name) != now[name]
    )


def _spoilt(plan: Plan, target: Path, standing: list[int], workers: int | None) -> set[int]:
    """Chunks of the right size with a wrong checksum; their files are removed."""

    def look(number: int) -> bool:
        return is_sound(plan.layout, target, number)

    found = {number for number, sound in spread(look, standing, workers=workers, threads=True) if not sound}
    for number in found:
        for file, _ in plan.layout.files(target, number):
            file.unlink(missing_ok=True)
    return found

"""Work in many pieces, on this machine's cores or on a Dask cluster; the one door to Dask.

Pieces are handed out a few at a time, so that a thousand or a billion take the same memory. What a piece
makes is the caller's affair: for an atlas it is a file, so that a piece lost with its worker is done again
and nothing else is.
"""

from __future__ import annotations

import multiprocessing
import os
import re
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from logging.handlers import QueueHandler
from typing import Any, TypeVar

from flexmodal.errors import Fault, FlexmodalError, InvalidRequest, MissingExtra
from flexmodal.frf.kernels.announced import COMPILER
from flexmodal.frf.kernels.route import available_cores

Item = TypeVar("Item")
Result = TypeVar("Result")

AHEAD = 3
"""Pieces handed out for each worker: one it works at, and some that wait."""
MOST_WORKERS = 1024
PATIENCE = 60.0
"""How long a cluster may be without any worker [s]."""
_ADDRESS = re.compile(r"(tcp|tls|ws|wss)://(\[[0-9a-fA-F:]+\]|[\w.-]+):\d{1,5}")
_CONNECT = 15.0
"""How long a scheduler may take to answer [s]."""
_LOOK = 1.0
"""How often it is looked whether there are workers still, and the longest wait for the last they say [s]."""


def spread(
    call: Callable[[Item], Result],
    items: Iterable[Item],
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    threads: bool = False,
    patience: float = PATIENCE,
) -> Iterator[tuple[Item, Result]]:
    """Call a function with each item, in any order, and give what it returns as it comes.

    Args:
        call: can be pickled, unless `threads`; calling it twice does no harm.
        items: as many as there may be; they are asked for as they are needed.
        scheduler: address of a Dask scheduler; this machine if none.
        workers: processes or threads here; as many as cores if none.
        threads: threads instead of processes, for what releases the interpreter's lock.
        patience: how long a cluster may be without any worker [s].

    Raises:
        InvalidRequest: a number of workers out of range, an address where no scheduler answers.
        MissingExtra: a scheduler was named and Dask is not installed.
        FlexmodalError: a worker was killed and nobody took its place, or the cluster went away; and whatever
            `call` raises.
    """
    check_workers(workers)
    if scheduler is not None:
        yield from _on_cluster(call, iter(items), scheduler, patience)
        return
    count = workers or available_cores()
    with ThreadPoolExecutor(count) if threads else _processes(count) as pool:
        yield from _locally(pool, call, iter(items), count)


def check_workers(workers: int | None) -> None:
    """Refuse a number of workers that is none.

    Raises:
        InvalidRequest: below 1, or more than `MOST_WORKERS`.
    """
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise InvalidRequest(Fault("call", "workers", str(workers), f"1 to {MOST_WORKERS}"))


@contextmanager
def _processes(count: int) -> Iterator[Executor]:
    """A pool of processes; what they compile is said here."""
    context = multiprocessing.get_context("spawn")
    records = context.Queue()
    records.cancel_join_thread()  # a process that is killed may have left it locked
    relay = threading.Thread(target=_relay, args=(records,), daemon=True)
    relay.start()
    try:
        begin = (records, COMPILER.getEffectiveLevel())
        with ProcessPoolExecutor(count, context, initializer=_follow_parent, initargs=begin) as pool:
            yield pool
    finally:
        records.put(None)
        relay.join(_LOOK)


def _relay(records: Any) -> None:
    """Log what other processes logged, until there is nothing."""
    for record in iter(records.get, None):
        COMPILER.handle(record)


def _follow_parent(records: Any, level: int) -> None:
    """End with the process that started this one, however that ends, and tell it what is compiled here."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    records.cancel_join_thread()  # nobody may be there any more to read them
    COMPILER.addHandler(QueueHandler(records))
    COMPILER.setLevel(level)
    parent = multiprocessing.parent_process()
    if parent is not None:

        def watch() -> None:
            parent.join()
            os._exit(1)

        threading.Thread(target=watch, daemon=True).start()


def _locally(
    pool: Executor, call: Callable[[Item], Result], items: Iterator[Item], count: int
) -> Iterator[tuple[Item, Result]]:
    going: dict[Future[Result], Item] = {}
    try:
        while True:
            going |= {pool.submit(call, item): item for item in islice(items, AHEAD * count - len(going))}
            if not going:
                return
            done, _ = wait(going, return_when=FIRST_COMPLETED)
            for future in done:
                yield going.pop(future), future.result()
    except BrokenProcessPool:
        raise FlexmodalError("a worker process was killed, perhaps for want of memory") from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _on_cluster(
    call: Callable[[Item], Result], items: Iterator[Item], address: str, patience: float
) -> Iterator[tuple[Item, Result]]:
    client = _client(address)
    import distributed

    going: dict[Any, Item] = {}
    alone_since: float | None = None
    try:
        while True:
            slots = sum(client.nthreads().values())
            now = time.monotonic()
            alone_since = None if slots else (alone_since or now)
            if alone_since is not None and now - alone_since > patience:
                raise FlexmodalError(f"no worker at the scheduler {address} for {patience:g} s")
            room = max(0, AHEAD * slots - len(going))
            going |= {client.submit(call, item, pure=False): item for item in islice(items, room)}
            if not going and slots:
                return
            for future in _finished(client, going):
                yield going.pop(future), _result(future, distributed)
    except OSError as error:
        raise FlexmodalError(f"the scheduler {address} does not answer any more") from error
    finally:
        client.close(timeout=5)


def _client(address: str) -> Any:
    try:
        import distributed
    except ImportError:
        raise MissingExtra("--scheduler needs Dask: pip install flexmodal[atlas]") from None
    allowed = "the address of a Dask scheduler, such as tcp://HOST:8786"
    if not _ADDRESS.fullmatch(address):
        raise InvalidRequest(Fault("call", "scheduler", repr(address[:60]), allowed))
    try:
        return distributed.Client(address, timeout=_CONNECT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        found = f"{address!r}: {str(error).splitlines()[0] if str(error) else type(error).__name__}"
        raise InvalidRequest(Fault("call", "scheduler", found[:200], allowed)) from None


def _finished(client: Any, going: dict[Any, Any]) -> list[Any]:
    """Futures that have an end, after a while at most."""
    from distributed import wait as wait_for

    if client.status not in ("running", "connecting"):
        raise OSError("closed")
    if not going:
        time.sleep(_LOOK)
        return []
    try:
        with client.as_current():
            done, _ = wait_for(list(going), timeout=_LOOK, return_when="FIRST_COMPLETED")
    except TimeoutError:
        return []
    return list(done)


def _result(future: Any, distributed: Any) -> Any:
    if future.cancelled():
        raise OSError("lost")
    error = future.exception()
    if isinstance(error, distributed.KilledWorker):
        raise FlexmodalError(f"{error.allowed_failures + 1} workers died at the same piece of work")
    if isinstance(error, OSError):  # not one of the line to the scheduler
        raise FlexmodalError(f"on a worker: {error}")
    return future.result()

"""How many processes work side by side, and whether this one helps another."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.frf.kernels.route import available_cores

VARIABLE = "FLEXMODAL_WORKERS"
"""Environment variable: how many processes there are where nobody says."""
ENOUGH, MOST = 8, 256
"""Processes where nobody says, however many cores there are, and the most that may be asked for."""
HELPER = 0
"""Instead of a number, in a process that helps another one."""

_workers: ContextVar[int] = ContextVar("workers", default=1)
_check: ContextVar[Callable[[], None]] = ContextVar("check", default=lambda: None)


@contextmanager
def working_on(workers: int | None, check: Callable[[], None] = lambda: None) -> Iterator[None]:
    """What is done here side by side is done by so many processes.

    Args:
        workers: processes, this one among them; None for `FLEXMODAL_WORKERS`, or else as many as cores, at
            most `ENOUGH`.
        check: called now and then while results of helpers are awaited; what it raises ends that.

    Raises:
        InvalidRequest: no such number.
    """
    tokens = _workers.set(_number(workers)), _check.set(check)
    try:
        yield
    finally:
        _workers.reset(tokens[0])
        _check.reset(tokens[1])


def _number(workers: int | None) -> int:
    allowed, where, found = f"1 to {MOST}", ("call", "workers"), str(workers)
    if workers is None:
        text = os.environ.get(VARIABLE, "").strip()
        if not text:
            return min(available_cores(), ENOUGH)
        where, found = ("environment", VARIABLE), repr(text)
        workers = int(text) if text.isdecimal() else 0
    if not 1 <= workers <= MOST:
        raise InvalidRequest(Fault(*where, found, allowed))
    return workers


def number_of_workers() -> int:
    """Processes for what is done side by side here; `HELPER` in one that helps."""
    return _workers.get()


def is_helper() -> bool:
    """Whether this process is a copy that helps another one."""
    return _workers.get() == HELPER


def free_cores() -> int:
    """Threads that may share work which releases the interpreter's lock: one where processes share it."""
    return max(1, _workers.get())


def become_helper() -> None:
    """This process helps another one from now on, and has no helpers."""
    _workers.set(HELPER)


@contextmanager
def one_of_several() -> Iterator[None]:
    """What is done here is one of several things that are done side by side, and is done by this process."""
    token = None if is_helper() else _workers.set(1)
    try:
        yield
    finally:
        if token is not None:
            _workers.reset(token)


def check() -> None:
    """Ask whether to wait any longer, see `working_on`."""
    _check.get()()

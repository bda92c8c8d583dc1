"""What a terminal shows while a command works: bars, and where there is none, the time that passes.

Only on a terminal: elsewhere nothing is shown, and standard error holds sentences alone.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

PATIENCE = 2.0
"""After so long without anything shown, a command says that it works [s]."""

_LINE = "{desc} {elapsed}"


class _Screen:
    """The lines below what was printed, of which at most one is the sign that a command works."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._bars = 0
        self._sign: Any = None
        self._silent = False

    @contextmanager
    def bar(self, **options: Any) -> Iterator[Any]:
        """A bar of tqdm; the sign of life makes room for it."""
        from tqdm import tqdm

        with self._lock:
            self._bars += 1
            self._clear()
            bar = tqdm(file=sys.stderr, leave=False, **options)
        try:
            with bar:
                yield bar
        finally:
            with self._lock:
                self._bars -= 1

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Bars are out of the way while something is printed."""
        with self._lock:
            self._clear()
            if not self._bars:
                yield
                return
            from tqdm import tqdm

            with tqdm.external_write_mode(file=sys.stderr):
                yield

    def hush(self) -> None:
        """No sign of life any more: the command waits for somebody, not somebody for it."""
        with self._lock:
            self._silent = True
            self._clear()

    @contextmanager
    def watched(self) -> Iterator[None]:
        """A sign of life after some seconds without a bar, as long as this lasts."""
        self._silent = False
        over = threading.Event()
        watcher = threading.Thread(target=self._watch, args=(over,), daemon=True)
        watcher.start()
        try:
            yield
        finally:
            over.set()
            watcher.join()
            with self._lock:
                self._clear()

    def _watch(self, over: threading.Event) -> None:
        if over.wait(PATIENCE):
            return
        while True:
            with self._lock:
                if not over.is_set() and not self._bars and not self._silent:
                    self._show()
            if over.wait(1.0):
                return

    def _show(self) -> None:
        from tqdm import tqdm

        if self._sign is None:
            self._sign = tqdm(desc="working", file=sys.stderr, leave=False, bar_format=_LINE)
        self._sign.refresh()

    def _clear(self) -> None:
        if self._sign is not None:
            self._sign.close()
            self._sign = None


_SCREEN = _Screen()


@contextmanager
def shown_bar(*, quiet: bool, **options: Any) -> Iterator[Any]:
    """A bar of tqdm whose clock goes on through steps that take long; a dead one off a terminal.

    Args:
        quiet: whether to show none.
        options: of `tqdm.tqdm`.
    """
    from tqdm import tqdm

    if quiet or not sys.stderr.isatty():
        with tqdm(disable=True, **options) as bar:
            yield bar
        return
    with _SCREEN.bar(**options) as bar:
        over = threading.Event()
        ticker = threading.Thread(target=_tick, args=(bar, over), daemon=True)
        ticker.start()
        try:
            yield bar
        finally:
            over.set()
            ticker.join()


def _tick(bar: Any, over: threading.Event) -> None:
    while not over.wait(1.0):
        bar.refresh()


@contextmanager
def signs_of_life() -> Iterator[None]:
    """On a terminal, say after two seconds that a command works wherever it shows no bar of its own."""
    if not sys.stderr.isatty():
        yield
        return
    with _SCREEN.watched():
        yield


def aside() -> Any:
    """A context in which text can be printed: bars and signs of life are out of its way."""
    return _SCREEN.aside()


def hush() -> None:
    """No sign of life from here on: the command waits for its user."""
    _SCREEN.hush()

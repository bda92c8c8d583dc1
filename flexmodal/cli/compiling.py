"""A line on standard error for whatever is compiled while a command works."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from flexmodal.cli.printing import say

COMPILER = logging.getLogger("flexmodal.engine.compiler")
"""That of `flexmodal.frf.kernels.announced`, by its name: numpy is not loaded for it."""


class _Sayer(logging.Handler):
    """Says each sentence once: several functions may be compiled for one purpose."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self._said: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        sentence = record.getMessage()
        if sentence not in self._said:
            self._said.add(sentence)
            with suppress(OSError):  # nobody reads it
                say(f"flexmodal: {sentence}", err=True)


@contextmanager
def compilations_said() -> Iterator[None]:
    """Whatever numba compiles meanwhile is said on standard error; what it finds on disk is not."""
    sayer, before = _Sayer(), COMPILER.level
    COMPILER.addHandler(sayer)
    COMPILER.setLevel(logging.INFO)
    try:
        yield
    finally:
        COMPILER.removeHandler(sayer)
        COMPILER.setLevel(before)

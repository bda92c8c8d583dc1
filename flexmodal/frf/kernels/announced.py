"""Whatever numba compiles is said as it begins, and nothing where the code comes from disk.

Said in the log, at level INFO of "flexmodal.engine.compiler"; the command line shows that on standard error.
Told by numba itself (its event API), so that it is said whoever asked for the function and however it was
chosen.
"""

from __future__ import annotations

import logging
from functools import cache
from typing import Any

COMPILER = logging.getLogger("flexmodal.engine.compiler")

_sentences: dict[str, str] = {}
"""By the name of a function to be called from Python; what is compiled into it has none."""


def announce(name: str, purpose: str, seconds: float, *, kept: bool) -> None:
    """Have it said when a function is compiled.

    Args:
        name: of the function, unlike any other's.
        purpose: what it works out, in words.
        seconds: that compiling it takes, 0 where nobody measured [s].
        kept: whether it stays on disk; it is compiled in each process otherwise.
    """
    often = "once on this machine" if kept else "in each run, as no folder can be written (NUMBA_CACHE_DIR)"
    _sentences[name] = f"compiling {purpose}, {often}" + (f": some {seconds:.0f} s" if seconds else "")
    _listen()


@cache
def _listen() -> None:
    from numba.core import event

    class Listener(event.Listener):
        def on_start(self, event: Any) -> None:
            sentence = _sentences.get(event.data["dispatcher"].py_func.__name__)
            if sentence is not None:
                COMPILER.info(sentence)

        def on_end(self, event: Any) -> None:
            pass

    event.register("numba:compile", Listener())  # type: ignore[no-untyped-call]

"""Commands spread over this machine's cores or a Dask cluster by `flexmodal.atlas.spread`.

Each is a process of its own, so that a worker needs nothing but this folder under the same path and the same
Python, and one that is killed is asked again elsewhere.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from flexmodal.atlas import spread

HERE = Path(__file__).resolve().parent


def add_options(parser: argparse.ArgumentParser) -> None:
    """`--scheduler`, `--workers` and `--one`."""
    parser.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, tcp://HOST:PORT")
    parser.add_argument("--workers", type=int, default=None, help="on this machine; its cores if none")
    parser.add_argument("--one", metavar="NAME", help="only this piece, its result printed; for a worker")


def pieces(
    script: str, names: Iterable[str], options: Sequence[str], *, scheduler: str | None, workers: int | None
) -> Iterator[tuple[str, str | None]]:
    """Run `script … --one NAME` for each name, and give what it printed as it comes, none where it failed.

    Args:
        script: in this folder.
        names: of the pieces.
        options: the others of the script.
        scheduler: address of a Dask scheduler; this machine if none.
        workers: processes on this machine; as many as cores if none.
    """
    start = ("env", "OPENBLAS_NUM_THREADS=1", sys.executable, str(HERE / script), *options, "--one")
    call = partial(subprocess.run, capture_output=True, text=True, check=False)
    commands = ((*start, name) for name in names)
    for words, done in spread(call, commands, scheduler=scheduler, workers=workers, threads=True):
        if done.returncode:
            print(f"{words[-1]} failed: {done.stderr[-2000:]}", file=sys.stderr, flush=True)
        yield words[-1], None if done.returncode else done.stdout

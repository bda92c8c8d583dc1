"""Bytes of a regular file of reasonable size, and nothing else."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from flexmodal.errors import Fault


def read_regular(path: Path, *, limit: int, kind: str) -> bytes | Fault:
    """Read a whole file without ever waiting for one that is no file.

    Args:
        path: the file.
        limit: the most it may hold [bytes].
        kind: what the file should be, for the sentence ("a robot card").

    Returns:
        Its bytes, or the fault that kept them from being read.
    """
    try:
        # O_NONBLOCK: opening a pipe that nobody writes to would wait for ever.
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        return Fault(str(path), "", "no such file", f"{kind} that exists")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        return Fault(str(path), "", f"a file that cannot be opened ({reason})", f"{kind} that can be read")
    mode = os.fstat(handle).st_mode
    if not stat.S_ISREG(mode):
        os.close(handle)
        found = "a folder" if stat.S_ISDIR(mode) else "a pipe or device"
        return Fault(str(path), "", found, f"{kind}, a regular file")
    with os.fdopen(handle, "rb") as file:
        content = file.read(limit + 1)
    if len(content) > limit:
        return Fault(str(path), "", f"more than {limit / 1e6:g} MB", f"{kind} of at most {limit / 1e6:g} MB")
    return content

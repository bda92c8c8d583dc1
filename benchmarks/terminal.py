"""A command in a pseudo-terminal of 80 columns, and what it prints there."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import termios
import time
from pathlib import Path

COLUMNS, ROWS = 80, 24
CUT = re.compile(r"[\d.]…|\w\.…")
"""A number, or a dotted name such as stiffness.q2, of which an ellipsis left the beginning."""
ESCAPES = re.compile(r"\x1b\[[0-9;?]*[ -/]*[@-~]|\x1b[()][A-Z0-9]|\x1b[=>]")


def in_terminal(
    words: list[str], where: Path, environment: dict[str, str], *, give_up: float
) -> tuple[int, str, float]:
    """Run a command in a pseudo-terminal.

    Args:
        words: the command.
        where: its folder.
        environment: its environment.
        give_up: after so long [s] it is stopped.

    Returns:
        Exit status, what it printed without escapes, and the longest time [s] in which it printed nothing.
    """
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
    process = subprocess.Popen(
        words,
        cwd=where,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=theirs,
        stderr=theirs,
        close_fds=True,
    )
    os.close(theirs)
    parts, silence, start = [], 0.0, time.monotonic()
    last = start
    while True:
        ready, _, _ = select.select([ours], [], [], 0.2)
        silence = max(silence, time.monotonic() - last)
        if ready:
            try:
                part = os.read(ours, 65536)
            except OSError:  # Linux says so when the other side is closed
                break
            if not part:
                break
            parts.append(part)
            last = time.monotonic()
        elif process.poll() is not None:
            break
        if time.monotonic() - start > give_up:
            process.kill()
            break
    os.close(ours)
    text = b"".join(parts).decode("utf-8", "replace")
    return process.wait(), ESCAPES.sub("", text).replace("\r\n", "\n").replace("\r", "\n"), silence

"""Large files written past the page cache, where the system lets us.

What nobody is going to read again soon would push everything else out of the memory, and on a virtual machine
whose memory grows page by page the cache costs as much processor time as the kernel. Linux asks for whole
blocks out of aligned memory then (open(2), O_DIRECT); the rest of a file, and files where that is refused,
goes the ordinary way.
"""

from __future__ import annotations

import errno
import fcntl
import io
import mmap
import os
import threading
from pathlib import Path

_FLAG = getattr(os, "O_DIRECT", 0)
BLOCK = 4096
"""What lengths and addresses are multiples of; disks ask for 512 or 4096 [bytes]."""
LARGE = 1 << 20
"""Files below are written the ordinary way [bytes]."""
_OWN = threading.local()


def memory_for(size: int, place: int) -> memoryview:
    """Memory to write a file from; of a large one aligned, and this thread's until it asks for it again.

    Args:
        size: of the file [bytes].
        place: tells what is held at the same time apart.
    """
    if size < LARGE:
        return memoryview(bytearray(size))
    kept: dict[int, memoryview] = _OWN.__dict__.setdefault("kept", {})
    if place not in kept or len(kept[place]) < size:
        kept[place] = memoryview(mmap.mmap(-1, size))
    return kept[place][:size]


def write_file(path: Path, content: memoryview) -> None:
    """Write a new file, past the page cache if it is large and lies in `memory_for` it.

    Args:
        path: of the file.
        content: its bytes.

    Raises:
        OSError: it cannot be written.
    """
    direct = _FLAG if len(content) >= LARGE else 0
    with _opened(path, direct) as out:
        done = _write_blocks(out, content) if direct else 0
        while done < len(content):  # a write may take less than it is given
            done += out.write(content[done:])


def _opened(path: Path, direct: int) -> io.FileIO:
    try:
        return open(path, "wb", buffering=0, opener=lambda name, flags: os.open(name, flags | direct, 0o666))
    except OSError as error:
        if error.errno != errno.EINVAL or not direct:
            raise
        return path.open("wb", buffering=0)  # a file system without it


def _write_blocks(out: io.FileIO, content: memoryview) -> int:
    """Whole blocks; how many bytes were taken. What follows goes the ordinary way."""
    whole, done = len(content) // BLOCK * BLOCK, 0
    try:
        while done < whole and done % BLOCK == 0:  # a disk that is nearly full may take a part of one
            done += out.write(content[done:whole])
    except OSError as error:
        if error.errno != errno.EINVAL:
            raise
    finally:
        flags = fcntl.fcntl(out.fileno(), fcntl.F_GETFL)
        fcntl.fcntl(out.fileno(), fcntl.F_SETFL, flags & ~_FLAG)
    return done

"""Renames that one system call does: into a name that is free, or two names exchanged."""

from __future__ import annotations

import ctypes
import errno
import os
from functools import cache
from pathlib import Path
from typing import Any

_HERE = -100
"""AT_FDCWD: a relative path is one from the working directory."""
_FREE, _EXCHANGE = 1, 2
"""RENAME_NOREPLACE and RENAME_EXCHANGE of Linux."""
_UNKNOWN = frozenset({errno.ENOSYS, errno.EINVAL, errno.EOPNOTSUPP})
"""How a kernel or a file system says that it cannot do this."""


def rename_to_free(old: Path, new: Path) -> None:
    """Rename a file or folder to a name that nothing has.

    Args:
        old: what to rename.
        new: its new name, on the same file system.

    Raises:
        FileExistsError: something has that name.
    """
    if not _rename(old, new, _FREE):
        if os.path.lexists(new):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(new))
        old.rename(new)


def exchange(one: Path, other: Path) -> bool:
    """Let two files or folders change names in one step.

    Args:
        one: a file or folder.
        other: another, on the same file system.

    Returns:
        Whether they did; False where the system cannot do that.
    """
    return _rename(one, other, _EXCHANGE)


def _rename(one: Path, other: Path, flag: int) -> bool:
    call = _renameat2()
    if call is None:
        return False
    if call(_HERE, os.fsencode(one), _HERE, os.fsencode(other), flag) == 0:
        return True
    number = ctypes.get_errno()
    if number in _UNKNOWN:
        return False
    raise OSError(number, os.strerror(number), str(one), None, str(other))


@cache
def _renameat2() -> Any:
    """The system's own function; None where there is none, as outside Linux."""
    call = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if call is not None:
        call.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_uint]
    return call

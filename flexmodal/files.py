"""Writing files: whole or not at all, and never over somebody's work unasked."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from flexmodal.errors import Fault, OutputExists


@contextmanager
def whole_file(path: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Give a scratch path beside `path`; rename it into place when the block ends without an error.

    Args:
        path: where the finished file is to stand.
        overwrite: replace a file that stands there already.

    Yields:
        A path in the same folder with the same suffix; what is written to it becomes `path`.

    Raises:
        OutputExists: `path` exists and `overwrite` is false, or its folder does not exist.
    """
    target = Path(path)
    if target.exists() and not overwrite:
        raise OutputExists(Fault(str(target), "", "an existing file", "a new name, or --force"))
    if not target.parent.is_dir():
        raise OutputExists(Fault(str(target), "", "no such folder", "a file in an existing folder"))
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.stem}.", suffix=target.suffix)
    os.close(handle)
    scratch = Path(name)
    try:
        yield scratch
        umask = os.umask(0)
        os.umask(umask)
        scratch.chmod(0o666 & ~umask)
        scratch.replace(target)
    finally:
        scratch.unlink(missing_ok=True)

"""Writing files: whole or not at all, and never over somebody's work unasked."""

from __future__ import annotations

import os
import shutil
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


@contextmanager
def whole_folder(path: str | Path, *, known: str = "", overwrite: bool = False) -> Iterator[Path]:
    """Give a scratch folder beside `path`; rename it into place when the block ends without an error.

    Args:
        path: where the finished folder is to stand.
        known: name of a file by which a folder of this kind is known; only such a folder, or an empty one,
            is ever replaced.
        overwrite: replace a folder of this kind that stands there already.

    Yields:
        A folder beside `path`; what is written into it becomes `path`.

    Raises:
        OutputExists: see `refuse_folder`.
    """
    target = Path(path)
    refuse_folder(target, known=known, overwrite=overwrite)
    scratch = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}."))
    try:
        inside = scratch / target.name
        inside.mkdir()
        yield inside
        _swap(inside, target, scratch / "old")
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def refuse_folder(path: str | Path, *, known: str = "", overwrite: bool = False) -> None:
    """Complain, before the work, about a folder that output cannot become.

    Raises:
        OutputExists: something stands there and `overwrite` is false, or it is not a folder of this kind, or
            the folder it belongs in does not exist.
    """
    target = Path(path)
    if target.is_symlink() or target.exists():
        if not overwrite:
            raise OutputExists(Fault(str(target), "", "something that exists", "a new name, or --force"))
        own = target.is_dir() and not target.is_symlink()
        if not own or (any(target.iterdir()) and not (known and (target / known).is_file())):
            allowed = f"a new name, or a folder with {known or 'nothing in it'}: only that is replaced"
            raise OutputExists(Fault(str(target), "", "a file, or a folder of something else", allowed))
    if not target.parent.is_dir():
        raise OutputExists(Fault(str(target.parent), "", "no such folder", "an existing folder to put it in"))


def _swap(new: Path, target: Path, aside: Path) -> None:
    """Rename a folder into place; what stood there comes back if that fails."""
    if not target.exists():
        new.rename(target)
        return
    target.rename(aside)
    try:
        new.rename(target)
    except OSError:
        aside.rename(target)
        raise

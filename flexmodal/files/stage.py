"""The stage: a hidden folder beside what is to be written, in which it is made whole before it appears.

`.NAME.flexmodal/` holds `lock`, which its writer has locked as long as it lives; `new/`, what is being made;
and where names cannot be put in place by one system call, `commit`, which promises that they all will be,
with `old/`, what they replace. A writer killed before it promised leaves what stood there as it was; after
that, the next who reads or writes under that name completes the work.
"""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from flexmodal.errors import Fault, OutputExists
from flexmodal.files.exchange import exchange, rename_to_free

LOCK, NEW, OLD, COMMIT = "lock", "new", "old", "commit"
_ENDING = ".flexmodal"
_LONGEST = 200
"""Bytes of a name that go into the name of its stage; file systems take 255."""
_LEVELS = 3
"""Folders above a file that may be what was written: a campaign or diagnosis, its `robot/`, and the file."""


def stage_of(path: Path) -> Path:
    """The stage of a file or folder, beside it."""
    name = os.fsencode(path.name)
    short = path.name if len(name) <= _LONGEST else hashlib.sha256(name).hexdigest()
    return path.parent / f".{short}{_ENDING}"


def in_stage(path: Path) -> bool:
    """Whether a file or folder stands in a stage, which takes its place as a whole."""
    return any(name.startswith(".") and name.endswith(_ENDING) for name in path.parent.parts)


@contextmanager
def claimed(target: Path) -> Iterator[Path]:
    """The stage of `target`, empty and locked, removed in the end unless it holds a promise.

    What a killed writer promised is completed first, and what it did not promise is thrown away.

    Args:
        target: what is to be written; the first, of several.

    Raises:
        OutputExists: another process is writing it.
    """
    stage = stage_of(target)
    try:
        handle = _lock(stage)
    except BaseException:  # told to end on the way; the lock is free again
        if (handle := _lock(stage)) is not None:
            _leave(stage, handle)
        raise
    if handle is None:
        allowed = "a new name, or waiting until that process is done"
        raise OutputExists(Fault(str(target), "", "something that another process is writing", allowed))
    try:
        _settle(stage, target.parent)
        _clear(stage)
        (stage / NEW).mkdir()
        yield stage
    finally:
        _leave(stage, handle)


def complete(path: str | os.PathLike[str]) -> None:
    """Complete what a killed writer had promised under this name, or above it; nothing else happens.

    Args:
        path: a file or folder that is about to be read.

    Raises:
        OutputExists: it cannot be, as something else has taken a name meanwhile.
    """
    target = Path(os.path.abspath(path))
    for one in (target, *target.parents[:_LEVELS]):
        stage = stage_of(one)
        if not (one.name and os.path.isfile(stage / COMMIT)):
            continue
        handle = _lock(stage)
        if handle is not None:  # else its writer is alive and at it
            try:
                _settle(stage, one.parent)
            finally:
                _leave(stage, handle)


def put(stage: Path, place: Path, names: Sequence[str], *, overwrite: bool) -> None:
    """Put what is in `new/` into its place, all of it or nothing.

    Args:
        stage: claimed, with everything written.
        place: the folder that the names belong in.
        names: what stands in `new/`.
        overwrite: whether what has such a name is replaced.

    Raises:
        OutputExists: a name is taken and `overwrite` is false.
    """
    _sync_tree(stage / NEW)
    taken = [name for name in names if os.path.lexists(place / name) and not _is_empty(place / name)]
    if taken and not overwrite:
        raise _exists([place / name for name in taken])
    if len(names) > 1 or not _at_once(stage / NEW / names[0], place / names[0]):
        promise = stage / f"{COMMIT}.part"
        promise.write_text(json.dumps({"names": list(names), "overwrite": overwrite}), encoding="utf-8")
        _sync(promise)
        promise.rename(stage / COMMIT)
        _sync(stage)
        _settle(stage, place)
    _sync(place)


def _at_once(new: Path, target: Path) -> bool:
    """Put one file or folder into its place by one system call; False where none does that."""
    if not os.path.lexists(target):
        try:
            rename_to_free(new, target)
        except FileExistsError:
            raise _exists([target]) from None
    elif new.is_dir() and not _is_empty(target):
        return exchange(new, target)
    else:
        new.replace(target)
    return True


def _is_empty(folder: Path) -> bool:
    """Whether it is a folder with nothing in it, which a folder may replace."""
    return folder.is_dir() and not folder.is_symlink() and not any(folder.iterdir())


def _settle(stage: Path, place: Path) -> None:
    """Keep the promise in a stage, if there is one; what was done of it already is not done again."""
    commit = stage / COMMIT
    if not commit.is_file():
        return
    promised = json.loads(commit.read_text(encoding="utf-8"))
    (stage / OLD).mkdir(exist_ok=True)
    for name in promised["names"]:
        new, target, old = stage / NEW / name, place / name, stage / OLD / name
        if not os.path.lexists(new):
            continue
        if promised["overwrite"] and os.path.lexists(target) and not os.path.lexists(old):
            target.rename(old)
        try:
            rename_to_free(new, target)
        except FileExistsError:
            allowed = f"its own name again: what belongs here waits in {stage}"
            raise OutputExists(
                Fault(str(target), "", "something that took this name meanwhile", allowed)
            ) from None
    _sync(place)
    commit.unlink()


def _exists(paths: Sequence[Path]) -> OutputExists:
    allowed = "a new name, or --force"
    return OutputExists([Fault(str(path), "", "something that exists", allowed) for path in paths])


def _lock(stage: Path) -> int | None:
    """Make the stage and lock it, or take over one that a killed process left; None where it is in use."""
    while True:
        with suppress(FileExistsError):  # perhaps gone again by now, which opening the lock in it tells
            os.mkdir(stage)
        try:
            handle = os.open(stage / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
        except FileNotFoundError:  # its owner has just removed it
            continue
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(handle), os.stat(stage / LOCK)):
                return handle
        except BlockingIOError:
            os.close(handle)
            return None
        except FileNotFoundError:
            pass
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)


def _leave(stage: Path, handle: int) -> None:
    """Remove the stage, lock last; with a promise in it, it stays for whoever comes next."""
    try:
        if not (stage / COMMIT).is_file():
            _clear(stage)
            (stage / LOCK).unlink(missing_ok=True)
            stage.rmdir()
    except OSError:  # rubbish that stays is the next writer's to remove
        pass
    finally:
        os.close(handle)


def _clear(stage: Path) -> None:
    """Remove what an unfinished writer made; anything else in the stage is nobody's of this program."""
    names = {entry.name for entry in stage.iterdir()} - {LOCK}
    if others := names - {NEW, OLD, f"{COMMIT}.part"}:
        raise OutputExists(Fault(str(stage), "", f"a folder with {min(others)} in it", "a new name"))
    for name in (NEW, OLD):
        if (stage / name).is_dir():
            shutil.rmtree(stage / name)
    (stage / f"{COMMIT}.part").unlink(missing_ok=True)


def _sync_tree(folder: Path) -> None:
    for where, _, names in os.walk(folder):
        for name in names:
            _sync(Path(where, name))
        _sync(Path(where))


def _sync(path: Path) -> None:
    """Have the disk hold what is in a file or folder."""
    handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno != errno.EINVAL:  # a file system that has no such thing for folders
            raise
    finally:
        os.close(handle)

"""Files and folders written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from flexmodal.errors import Fault, NotWritten
from flexmodal.files.refusal import refuse_file, refuse_folder
from flexmodal.files.stage import NEW, claimed, in_stage, put, stage_of


@contextmanager
def whole_file(path: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Give a scratch path; what was written to it takes its place when the block ends without an error.

    Args:
        path: where the finished file is to stand.
        overwrite: replace a file that stands there already.

    Yields:
        A path of the same name in a hidden folder beside `path`.

    Raises:
        OutputExists: see `refuse_file`, or another process is writing it.
        NotWritten: the disk is full, or the folder may not be written.
    """
    target = Path(path)
    with _whole([target], lambda: refuse_file(target, overwrite=overwrite), overwrite) as scratch:
        yield scratch / target.name


@contextmanager
def whole_folder(path: str | Path, *, own: Sequence[str] = (), overwrite: bool = False) -> Iterator[Path]:
    """Give a scratch folder; it takes its place when the block ends without an error.

    Args:
        path: where the finished folder is to stand.
        own: what a folder of this kind may hold, see `refuse_folder`: one that holds anything else is never
            replaced.
        overwrite: replace a folder of this kind that stands there already.

    Yields:
        A folder of the same name; what is written into it becomes `path`.

    Raises:
        OutputExists: see `refuse_folder`, or another process is writing it.
        NotWritten: the disk is full, or the folder may not be written.
    """
    target = Path(os.path.abspath(path))
    with _whole([target], lambda: refuse_folder(target, own=own, overwrite=overwrite), overwrite) as scratch:
        (scratch / target.name).mkdir()
        yield scratch / target.name


@contextmanager
def whole_set(paths: Sequence[Path], *, overwrite: bool = False) -> Iterator[Path]:
    """Give a scratch folder for several files or folders of one place; they take their places together.

    Args:
        paths: where they are to stand, all in one folder.
        overwrite: replace files that stand there already; a folder is not replaced.

    Yields:
        A folder in which all of them are to be made, under their names.

    Raises:
        OutputExists: one of them cannot take its place, or another process is writing them.
        NotWritten: the disk is full, or the folder may not be written.
    """

    def refuse() -> None:
        for path in paths:
            refuse_file(path, overwrite=overwrite)

    with _whole(paths, refuse, overwrite) as scratch:
        yield scratch


@contextmanager
def _whole(paths: Sequence[Path], refuse: Callable[[], None], overwrite: bool) -> Iterator[Path]:
    target = Path(os.path.abspath(paths[0]))
    refuse()
    if in_stage(target):
        yield target.parent
        return
    try:
        with claimed(target) as stage:
            yield stage / NEW
            refuse()
            put(stage, target.parent, [path.name for path in paths], overwrite=overwrite)
    except OSError as error:
        inside = error.filename is None or Path(str(error.filename)).is_relative_to(stage_of(target))
        if isinstance(error, BrokenPipeError) or not inside:
            raise
        allowed = "a place that may be written, with room; what stood there stands as it was"
        raise NotWritten(Fault(str(paths[0]), "", error.strerror or str(error), allowed)) from error

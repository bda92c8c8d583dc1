"""What output may not replace, said before the work and again before it takes its place."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from flexmodal.errors import Fault, OutputExists

_NAMED = 5
"""Foreign files that are named."""


def refuse_file(path: str | Path, *, overwrite: bool = False) -> None:
    """Complain about a file that output cannot become.

    Args:
        path: of the output.
        overwrite: whether a file that stands there may be replaced.

    Raises:
        OutputExists: something stands there and `overwrite` is false, or it is no file, or the folder it
            belongs in does not exist.
    """
    target = Path(path)
    if target.is_dir():
        raise OutputExists(Fault(str(target), "", "a folder", "the name of a file"))
    if os.path.lexists(target):
        if not overwrite:
            raise OutputExists(Fault(str(target), "", "an existing file", "a new name, or --force"))
        if target.exists() and not target.is_file():
            raise OutputExists(Fault(str(target), "", "a pipe or device", "the name of a file"))
    if not target.parent.is_dir():
        raise OutputExists(Fault(str(target), "", "no such folder", "a file in an existing folder"))


def refuse_folder(path: str | Path, *, own: Sequence[str] = (), overwrite: bool = False) -> None:
    """Complain about a folder that output cannot become.

    Args:
        path: where it is to stand.
        own: what a folder of this kind may hold, as patterns of paths in it such as `robot/*.urdf`; one that
            holds anything else is never replaced.
        overwrite: whether a folder of this kind is replaced; an empty one is without.

    Raises:
        OutputExists: something stands there that is not replaced, or the folder it belongs in does not exist.
    """
    target = Path(path)
    if os.path.lexists(target):
        _refuse_standing(target, own, overwrite)
    if not target.parent.is_dir():
        raise OutputExists(Fault(str(target.parent), "", "no such folder", "an existing folder to put it in"))


def _refuse_standing(target: Path, own: Sequence[str], overwrite: bool) -> None:
    if not target.is_dir() or target.is_symlink():
        raise OutputExists(Fault(str(target), "", "a file or a link, not a folder", "a new name"))
    held = sorted(_held(target))
    others = [name for name in held if not any(_matches(name, one) for one in own)]
    if others:
        allowed = f"a new name, or a folder with nothing in it{' but ' * bool(own)}{', '.join(own)}"
        raise OutputExists(Fault(str(target), "", f"a folder that also holds {_first(others)}", allowed))
    if held and not overwrite:
        found = f"an existing folder with {_first(held)}"
        raise OutputExists(Fault(str(target), "", found, "a new name, or --force"))


def _first(names: Sequence[str]) -> str:
    return ", ".join(names[:_NAMED]) + ", …" * (len(names) > _NAMED)


def _matches(name: str, pattern: str) -> bool:
    return name.count("/") == pattern.count("/") and fnmatchcase(name, pattern)


def _held(folder: Path) -> Iterator[str]:
    """Paths of what a folder holds, without the folders in it that hold something themselves."""
    for where, folders, names in os.walk(folder):
        links = [name for name in folders if Path(where, name).is_symlink()]
        empty = [] if folders or names or Path(where) == folder else [""]
        for name in [*names, *links, *empty]:
            yield os.path.relpath(Path(where, name), folder)

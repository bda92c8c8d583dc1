"""Places that cannot be written: folders that may only be read, and file systems that fill up."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from chaos_cases import Case, call, run
from killing import digest

SIZES = ("16k", "256k")
"""Of file systems that fill up."""
NOBODY = 65_534


def unwritable(case: Case, folder: Path, old: str) -> Iterator[tuple[str, bool]]:
    """Places, and whether the command said so and left what stood there.

    Args:
        case: the command.
        folder: with what it replaces in it.
        old: digest of that.
    """
    yield "a folder that may only be read", _in_child(lambda: _read_only(case, folder, old))
    for size in SIZES:
        yield f"a file system of {size}", _in_child(lambda size=size: _filled(case, folder, size))


def _in_child(look: Callable[[], bool]) -> bool:
    child = os.fork()
    if child == 0:
        status = 1
        try:
            status = int(not look())
        finally:
            os._exit(status)
    return os.waitpid(child, 0)[1] == 0


def _read_only(case: Case, folder: Path, old: str) -> bool:
    """As anybody but root, who may write everywhere."""
    with tempfile.TemporaryDirectory() as scratch:
        if run(call(case, Path(scratch)))[0] > 1 and not case.before:  # everything is imported after that
            return False
    for place in (folder.parent, folder):
        place.chmod(0o555)
    try:
        if os.geteuid() == 0:
            os.seteuid(NOBODY)
        status, told = run(call(case, folder))
    finally:
        os.seteuid(os.getuid())
        for place in (folder.parent, folder):
            place.chmod(0o755)
    return status == 2 and str(folder) in told and "Traceback" not in told and digest(folder) == old


def _filled(case: Case, folder: Path, size: str) -> bool:
    """On a file system of its own, where one may be mounted; written whole, or the old with a sentence."""
    place = Path(tempfile.mkdtemp())
    mounted = ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(place)]
    if subprocess.run(mounted, capture_output=True, check=False).returncode:
        place.rmdir()
        return True  # no right to mount: files that may not grow have to do
    try:
        try:
            shutil.copytree(folder, place, dirs_exist_ok=True)
        except (OSError, shutil.Error):  # no room for what stands there already
            return True
        before = digest(place)
        status, told = run(call(case, place))
        after = digest(place)
    finally:
        subprocess.run(["umount", str(place)], check=True)
        place.rmdir()
    if status == 2:
        return str(place) in told and "Traceback" not in told and after == before
    return status in (0, 1) and after != before

"""A process killed at every file event of what it writes, each time from the same state of the folder.

The work runs in a child up to its first file event. From there it is forked once for each event to come:
every fork goes on until that event and dies of SIGKILL before it, and what is left is looked at. Events
are what audit hooks tell (open to write, mkdir, rename, remove, rmdir, chmod), each half of each write, each
fsync (told, not done: a kill loses nothing that the system holds) and each renameat2.
"""

from __future__ import annotations

import builtins
import hashlib
import io
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flexmodal.files import complete, exchange

EVENTS = frozenset({"os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.link", "os.chmod", "os.truncate"})
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


@dataclass
class Found:
    """What was left after each kill, as digests of the folder."""

    old: str
    new: str = ""
    events: list[str] = field(default_factory=list)
    seen: list[str] = field(default_factory=list)
    """As the next one finds it who looks without this program."""
    read: list[str] = field(default_factory=list)
    """As the next reader finds it."""
    written: list[str] = field(default_factory=list)
    """After the next writer; of an event whose next writer was not tried, what the reader found."""
    full: list[str] = field(default_factory=list)
    """On a disk that takes no more than so many bytes of a file."""

    def broken(self) -> list[str]:
        """Kills after which the next reader finds neither the old nor the new, or the next writer fails."""
        sound, found = {self.old, self.new}, []
        for number, event in enumerate(self.events):
            if self.read[number] not in sound:
                found.append(f"{event}: neither the old nor the new")
            if self.written[number] not in (self.new, self.read[number]):
                found.append(f"{event}: the next writer was barred")
        return found + ["full disk"] * sum(one not in sound for one in self.full)


def digest(folder: Path) -> str:
    """Of all names and contents under a folder but stages, which are nobody's to read."""
    total = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        if not any(part.endswith(".flexmodal") for part in parts):
            total.update(repr(parts).encode())
            total.update(path.read_bytes() if path.is_file() else b"/")
    return total.hexdigest()


def killed_everywhere(
    work: Callable[[], Any],
    folder: Path,
    target: Path,
    *,
    writers: int = 1,
    limits: Sequence[int] = (),
    by: signal.Signals = signal.SIGKILL,
    step: int = 1,
) -> Found:
    """Kill `work` at each of its file events under `folder`, and look at the folder after each.

    Args:
        work: writes under `folder`; may raise when there is nothing to be done any more.
        folder: what is looked at; it is put back after each kill, and in the end.
        target: what is written, for the next reader.
        writers: after each of so many kills the next writer is tried.
        limits: sizes of a file at which the disk is full [bytes].
        by: the signal; one that asks to end is heeded as by the program.
        step: only the first of each so many events.
    """
    with tempfile.TemporaryDirectory() as home:
        kept, answer = Path(home, "kept"), Path(home, "answer.json")
        shutil.copytree(folder, kept, symlinks=True)
        child = os.fork()
        if child == 0:
            _Killer(folder, target, kept, answer, writers, limits, by, step).run(work)
        _, status = os.waitpid(child, 0)
        if status or not answer.is_file():
            raise RuntimeError(f"the process that kills ended with {status}")
        return Found(**json.loads(answer.read_text(encoding="utf-8")))


class _Killer:
    def __init__(
        self,
        folder: Path,
        target: Path,
        kept: Path,
        answer: Path,
        writers: int,
        limits: Sequence[int],
        by: signal.Signals,
        step: int,
    ) -> None:
        self.writers, self.limits, self.signal, self.step = writers, limits, by, step
        self.folder, self.target, self.kept, self.answer = folder.resolve(), target, kept, answer
        self.found = Found(digest(folder))
        self.count, self.at, self.active, self.first = 0, 0, True, True
        self.last = ""

    def run(self, work: Callable[[], Any]) -> None:
        """Never returns."""
        status = 1
        try:
            if self.signal == signal.SIGTERM:
                signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
            self._listen()
            work()
            status = 0
        except BaseException as error:  # a fork ends here, whatever the work made of it
            if not isinstance(error, SystemExit | ValueError):
                sys.stderr.write(f"{type(error).__name__}: {error}\n")
            status = 3
        finally:
            os._exit(status)

    def event(self, name: str, path: object) -> None:
        """One file event to come; the first one starts all the killing."""
        if not self.active or not self._is_inside(path):
            return
        self.last = f"{name} {os.path.relpath(os.path.abspath(str(path)), self.folder)}"
        if self.first:
            self.first = False
            self._conduct()  # returns in the forks alone
            return
        self.count += 1
        if self.count == self.at:
            os.write(self.pipe, self.last.encode()[:500])
            os.kill(os.getpid(), self.signal)

    def _conduct(self) -> None:
        at = 1
        while True:
            told = self._fork(at)
            if told is None:
                return
            if not told:
                break
            self.found.events.append(told)
            self.found.seen.append(digest(self.folder))
            left = self.kept.with_name("left")
            shutil.copytree(self.folder, left, symlinks=True)
            complete(self.target)
            self.found.read.append(digest(self.folder))
            if len(self.found.events) % self.writers == 0:
                self._put_back(left)
                if self._fork(0) is None:
                    return
            self.found.written.append(digest(self.folder))
            shutil.rmtree(left)
            self._put_back(self.kept)
            at += self.step
        self.found.new = digest(self.folder)
        self._put_back(self.kept)
        for limit in self.limits:
            if self._fork(0) is None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
                return
            self.found.full.append(digest(self.folder))
            self._put_back(self.kept)
        self.active = False
        self.answer.write_text(json.dumps(vars(self.found)), encoding="utf-8")
        os._exit(0)

    def _fork(self, at: int) -> str | None:
        """Fork to die at an event; None in the fork, and before it what it died of, nothing if it lived."""
        self.active = False
        here, self.pipe = os.pipe()
        child = os.fork()
        if child == 0:
            self.at, self.count, self.active = at, 0, True
            if at == 1:  # the event that is just to come
                os.write(self.pipe, self.last.encode()[:500])
                os.kill(os.getpid(), self.signal)
            self.count = 1
            return None
        os.close(self.pipe)
        os.waitpid(child, 0)
        told = os.read(here, 1000).decode()
        os.close(here)
        return told

    def _put_back(self, kept: Path) -> None:
        for entry in self.folder.iterdir():
            shutil.rmtree(entry) if entry.is_dir() and not entry.is_symlink() else entry.unlink()
        shutil.copytree(kept, self.folder, symlinks=True, dirs_exist_ok=True)

    def _is_inside(self, path: object) -> bool:
        if isinstance(path, int):
            path = os.readlink(f"/proc/self/fd/{path}")
        if isinstance(path, bytes):
            path = os.fsdecode(path)
        if not isinstance(path, str | os.PathLike):
            return False
        place = os.path.abspath(path)
        return place.startswith(f"{self.folder}{os.sep}")

    def _listen(self) -> None:
        """Hear of every event from here on, in this process alone, which never returns to what it was."""
        killer = self

        def hook(name: str, given: tuple[Any, ...]) -> None:
            if name in EVENTS or (name == "open" and isinstance(given[2], int) and given[2] & _WRITING):
                killer.event(name, given[0])

        class Torn(io.FileIO):
            def write(self, content: Any) -> int:
                whole = memoryview(content).cast("B")
                killer.event("write", self.name)
                done = super().write(whole[: len(whole) // 2])
                killer.event("write", self.name)
                return done + super().write(whole[done:])

        plain, swap = io.open, exchange._rename

        def torn_open(file: Any, mode: str = "r", buffering: int = -1, *rest: Any, **options: Any) -> Any:
            if not set(mode) & set("wxa+") or isinstance(file, int) or not killer._is_inside(file):
                return plain(file, mode, buffering, *rest, **options)
            raw = Torn(file, mode.replace("b", "").replace("t", ""))
            buffered = (io.BufferedRandom if "+" in mode else io.BufferedWriter)(raw)
            return buffered if "b" in mode else io.TextIOWrapper(buffered, *rest, **options)

        def told_sync(handle: int) -> None:
            killer.event("fsync", handle)

        def told_swap(one: Path, other: Path, flag: int) -> bool:
            killer.event("renameat2", other)
            return swap(one, other, flag)

        io.open = builtins.open = torn_open  # type: ignore[assignment]
        os.fsync, exchange._rename = told_sync, told_swap  # type: ignore[assignment]
        sys.addaudithook(hook)

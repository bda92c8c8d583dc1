"""Act the newcomer: an empty environment, the README to the letter, the tutorials, on 80 columns.

    python benchmarks/tour.py [--python NAME] [--patience S] [PAGE …]

A copy of the checkout is made, as a clone would be, and flexmodal is installed from it as the README says.
Each command of the pages runs in a pseudo-terminal. The tour fails on any exit status other than 0, any
traceback, any number that is cut off by an ellipsis, any output of a page that does not come, and any command
that says nothing for some seconds: 5 unless told, and more on a machine that others load, by as much as it is
slower, which is measured before each page and printed. Blocks of Python are calls of a library, which prints
only what it is told to; their silence is not judged. Two commands are not run: `make test`, the tests, and
what only repeats the installation. Run by `make tour`.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from stumbles import STUMBLES, prepare
from terminal import CUT, in_terminal
from tour_pages import Step, steps

ROOT = Path(__file__).resolve().parents[1]
PAGES = (
    "README.md",
    "docs/tutorials/posture.md",
    "docs/tutorials/hammer.md",
    "docs/tutorials/own_robot.md",
    "docs/tutorials/own_data.md",
    "docs/tutorials/cut.md",
)
SKIPPED = re.compile(r"make test\b|python3\S* -m venv |\. \S*/activate$")


@dataclass
class Tour:
    """What has been seen so far."""

    place: Path
    python: str
    patience: float
    faults: list[str] = field(default_factory=list)
    longest: tuple[float, str] = (0.0, "")
    """The longest silence [s], and of which command."""
    done: int = 0
    slower: float = 1.0
    """How many times slower the machine is than it would be alone."""

    def environment(self) -> dict[str, str]:
        """As a newcomer's shell has it, the environment of the README's first lines active."""
        kept = {
            name: value
            for name, value in os.environ.items()
            if name.startswith(("PIP_", "LANG", "LC_", "SSL"))
        }
        venv = self.place / "flexmodal" / ".venv"
        path = f"{venv / 'bin'}{os.pathsep}{os.environ['PATH']}"
        own = {"PATH": path, "VIRTUAL_ENV": str(venv), "HOME": str(self.place), "TERM": "xterm-256color"}
        return {
            **kept,
            **own,
            "OPENBLAS_NUM_THREADS": "1",
            "PYENV_VERSION": os.environ.get("PYENV_VERSION", ""),
        }

    def run(
        self, words: list[str], where: Path, label: str, *, patient: bool = False, status: int = 0
    ) -> str:
        """Run one command in a terminal of 80 columns; what it printed, escapes taken out.

        Args:
            words: the command.
            where: its folder.
            label: what it is called where something is wrong.
            patient: whether its silence does not count.
            status: its exit status, as it should be.
        """
        left, printed, silence = in_terminal(words, where, self.environment(), give_up=600.0)
        self.done += 1
        if not patient and silence > self.longest[0]:
            self.longest = (silence, label)
        if left != status:
            self.faults.append(f"{label}: exit status {left}\n{printed[-1500:]}")
        if "Traceback (most recent call last)" in printed:
            self.faults.append(f"{label}: a traceback\n{printed[-1500:]}")
        for line in printed.splitlines():
            if CUT.search(line):
                self.faults.append(f"{label}: cut off: {line.strip()}")
        if silence > self.slower * self.patience and not patient:
            self.faults.append(f"{label}: {silence:.1f} s without a sign of life")
        return printed

    def page(self, page: str) -> None:
        """Do what a page says; the README in the clone, the others in an empty folder each."""
        self.slower = slower()
        print(f"{page}, patience {self.patience:g} s × {self.slower:.2f}", flush=True)
        clone = self.place / "flexmodal"
        where = clone if page == "README.md" else self.place / Path(page).stem
        where.mkdir(exist_ok=True)
        python = ""
        for number, step in enumerate(steps(ROOT / page), start=1):
            if step.writes:
                step.write(where)
                continue
            before = len(self.faults)
            if step.kind == "python":
                printed, python = self.python_step(step, python, where, f"{page}, step {number}")
            else:
                printed = "".join(self.command(line, where, page) for line in step.commands)
            missing = step.missing(printed)
            if missing and len(self.faults) == before:
                self.faults.append(
                    f"{page}, step {number}: shown, not printed: {' '.join(missing)}\n{printed}"
                )

    def stumbles(self) -> None:
        """The stumbles of a first afternoon, tried again."""
        where = self.place / "stumbles"
        where.mkdir()
        prepare(where)
        self.slower = slower()
        print(f"stumbles, patience {self.patience:g} s × {self.slower:.2f}", flush=True)
        for one in STUMBLES:
            print(f"  $ {one.command}", flush=True)
            words = ["bash", "-c", one.command]
            printed = self.run(words, where, f"stumbles: {one.name}", status=one.status)
            self.faults += one.faults(one.status, printed)

    def command(self, line: str, where: Path, page: str) -> str:
        """Run a command line of a page, unless it is one of those that are not."""
        bare = line.split("#", maxsplit=1)[0].strip()
        if SKIPPED.match(bare):
            return ""
        print(f"  $ {bare}", flush=True)
        installs = bare.startswith(("pip ", "make "))  # they are silent while they download
        return self.run(["bash", "-c", bare], where, f"{page}: {bare}", patient=installs)

    def python_step(self, step: Step, before: str, where: Path, label: str) -> tuple[str, str]:
        """Run a block after those before it, whose output is left out; what it printed, and all so far."""
        print(f"  Python, {label}", flush=True)
        quiet = (
            f"import contextlib, io\nwith contextlib.redirect_stdout(io.StringIO()):\n    exec({before!r})\n"
        )
        (where / "block.py").write_text(quiet + step.text, encoding="utf-8")
        return self.run(["python", "block.py"], where, label, patient=True), before + "\n" + step.text


def slower() -> float:
    """Time on the clock over time of the processor of a process that only computes, 1 or more.

    On a machine to itself it is 1; where others compute beside it, a command waits for them as long.
    """
    before = os.times()
    start = time.monotonic()
    subprocess.run([sys.executable, "-c", "sum(range(10**8))"], check=True)
    clock = time.monotonic() - start
    after = os.times()
    used = (after.children_user - before.children_user) + (after.children_system - before.children_system)
    return max(1.0, clock / used)


def clone(place: Path) -> None:
    """The files of the checkout that git knows, as they are now, in `place`/flexmodal."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True).stdout.split(b"\0")
    (place / "flexmodal").mkdir()
    existing = b"\0".join(name for name in names if name and (ROOT / os.fsdecode(name)).exists())
    packed = subprocess.run(
        ["tar", "--create", "--null", "--files-from=-"],
        cwd=ROOT,
        input=existing,
        check=True,
        capture_output=True,
    )
    subprocess.run(["tar", "--extract"], cwd=place / "flexmodal", input=packed.stdout, check=True)


def main() -> int:
    """Make the clone and the environment, go through the pages, say what was met."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--python", default="python3.11")
    asked.add_argument("--patience", type=float, default=5.0, help="longest silence of a command [s]")
    asked.add_argument("pages", nargs="*", default=list(PAGES))
    given = asked.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        tour = Tour(Path(folder), given.python, given.patience)
        clone(tour.place)
        subprocess.run([given.python, "-m", "venv", tour.place / "flexmodal" / ".venv"], check=True)
        if "README.md" not in given.pages:
            tour.run(
                ["pip", "install", "-q", "-e", ".[arms]"], tour.place / "flexmodal", "install", patient=True
            )
        for page in given.pages:
            tour.page(page)
        if given.pages == list(PAGES):
            tour.stumbles()
    print(f"{tour.done} commands; longest silence {tour.longest[0]:.1f} s, of {tour.longest[1]}")
    for fault in tour.faults:
        print(f"FAULT {fault}")
    print(f"{len(tour.faults)} faults" if tour.faults else "no fault met")
    return int(bool(tour.faults))


if __name__ == "__main__":
    sys.exit(main())

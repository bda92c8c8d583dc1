"""What the pages of the documentation show, done as a reader does it."""

import contextlib
import io
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from tour_pages import steps, words

ROOT = Path(__file__).resolve().parents[1]

PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
APART = ("tutorials", "howto")
"""Folders of the documentation whose pages are followed in modules of their own, side by side."""
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
LONG = {
    "hammer.md", "identification.md", "optimisation.md", "atlas.md", "machining.md", "prediction.md",
    "real_test.md", "rig.md", "viewer.md", "posture.md", "own_data.md", "robust.md", "ema.md",
    "cut.md", "path_and_speed.md", "live.md", "engine.md",
}  # fmt: skip
"""Pages that take five seconds and more; `make slow` follows them."""
LEFT_ALONE = {"git", "cd", "pip", "cat", ".", "python", "python3.11", "ls"}
"""Commands that need a network or a clone; `make tour` runs them."""
ELSEWHERE = {"demo": ROOT / "tests" / "cli" / "test_demo.py"}
"""Commands of flexmodal that take long, and the tests that run them."""


def acting(folder=None):
    """Pages that do something: those of the tutorials or how-tos, or all others."""
    chosen = [page for page in PAGES if (page.parent.name if page.parent.name in APART else None) == folder]
    return named(page for page in chosen if any(not step.writes for step in steps(page)))


def named(pages):
    return [
        pytest.param(
            page,
            id=str(page.relative_to(ROOT)),
            marks=[pytest.mark.slow] if page.name in LONG else [],
        )
        for page in pages
    ]


def run(command, page, place):
    """Run one command line; what it prints."""
    program, *rest = words(command)
    if program == "make":
        assert set(rest) <= TARGETS, f"{page.name}: {command}"
    elif program == "flexmodal" and rest[0] in ELSEWHERE:
        assert f'shell("{rest[0]}"' in ELSEWHERE[rest[0]].read_text(encoding="utf-8")
    elif program == "flexmodal":
        done = subprocess.run(
            [Path(sys.executable).with_name("flexmodal"), *rest],
            cwd=place, capture_output=True, text=True, timeout=300, check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{page.name}: {shlex.join(words(command))}\n{done.stderr}"
        return done.stdout + done.stderr
    else:
        assert program in LEFT_ALONE, f"{page.name}: {command} is not a command these tests know"
    return ""


def follow(page, place):
    """Do what a page says, in a folder that is the working directory; what it shows has to come out."""
    names = {"__name__": "__main__"}
    for number, step in enumerate(steps(page), start=1):
        if step.writes:
            step.write(place)
            continue
        if step.kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as caught:
                exec(compile(step.text, f"{page.name}, step {number}", "exec"), names)
            printed = caught.getvalue()
        else:
            printed = "".join(run(command, page, place) for command in step.commands)
        assert not step.missing(printed), f"{page.name}, step {number}: shown, not printed\n{printed}"

"""What the documentation shows, runs: commands as written, Python page by page.

Fenced blocks of three kinds are run; all others (`toml`, `text`, …) are left alone.

- `console` and `sh`: each line that begins with `$ ` (in `sh`, each line) is a command. `flexmodal …` is run
  in a folder of its own for the page and has to end with status 0, but for those that other tests run; of
  `make …` the target has to exist.
- `python`: run in order, the blocks of a page sharing their names.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```\s*$", re.MULTILINE | re.DOTALL)
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
LEFT_ALONE = {"git", "cd", "pip", "cat"}
"""Commands that need a network or a clone."""
ELSEWHERE = {"demo": ROOT / "tests" / "cli" / "test_demo.py"}
"""Commands of flexmodal that take long, and the tests that run them."""


def blocks(page, *kinds):
    return [text for kind, text in FENCE.findall(page.read_text(encoding="utf-8")) if kind in kinds]


def commands(page):
    """The command lines of a page, those that a backslash breaks put together again."""
    found = []
    for kind, block in FENCE.findall(page.read_text(encoding="utf-8")):
        text = block.replace("\\\n", " ")
        if kind == "console":
            found += [line[2:] for line in text.splitlines() if line.startswith("$ ")]
        elif kind == "sh":
            found += [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [shlex.split(line, comments=True) for line in found]


def named(pages):
    return [pytest.param(page, id=str(page.relative_to(ROOT))) for page in pages]


@pytest.fixture
def place(tmp_path):
    """A folder of its own that looks like the checkout where the pages read from it."""
    for name in ("robots", "tests"):
        (tmp_path / name).symlink_to(ROOT / name, target_is_directory=True)
    return tmp_path


@pytest.mark.parametrize("page", named(page for page in PAGES if commands(page)))
def test_commands(page, place):
    for words in commands(page):
        program, *rest = words
        if program == "make":
            assert set(rest) <= TARGETS, f"{page.name}: make {' '.join(rest)}"
        elif program == "flexmodal" and rest[0] in ELSEWHERE:
            assert f'shell("{rest[0]}"' in ELSEWHERE[rest[0]].read_text(encoding="utf-8")
        elif program == "flexmodal":
            done = subprocess.run(
                [Path(sys.executable).with_name("flexmodal"), *rest],
                cwd=place, capture_output=True, text=True, timeout=300, check=False,
            )  # fmt: skip
            assert done.returncode == 0, f"{page.name}: {shlex.join(words)}\n{done.stderr}"
        else:
            assert program in LEFT_ALONE, (
                f"{page.name}: {shlex.join(words)} is not a command these tests know"
            )


@pytest.mark.parametrize("page", named(page for page in PAGES if blocks(page, "python")))
def test_python(page, place, monkeypatch):
    monkeypatch.chdir(place)
    names = {"__name__": "__main__"}
    for number, block in enumerate(blocks(page, "python"), start=1):
        exec(compile(block, f"{page.name}, Python block {number}", "exec"), names)


def test_there_is_something_to_run():
    assert any(commands(page) for page in PAGES)
    assert any(blocks(page, "python") for page in PAGES)


@pytest.mark.parametrize("page", named(PAGES))
def test_links_within_the_repository_lead_somewhere(page):
    for address in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", address):
            assert os.path.exists(page.parent / address), f"{page.name}: {address}"


@pytest.mark.parametrize("page", named(PAGES))
def test_fences_are_closed(page):
    assert len(re.findall(r"^```", page.read_text(encoding="utf-8"), re.MULTILINE)) % 2 == 0

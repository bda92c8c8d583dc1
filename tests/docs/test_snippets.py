"""What the documentation shows, runs: commands as written, Python page by page, files as they are shown.

`benchmarks/tour_pages.py` says what is a step of a page; blocks of other kinds (`toml` without a title,
`text`, …) are left alone. `flexmodal …` is run in a folder of its own for the page and has to end with status
0, but for those that other tests run; of `make …` the target has to exist. What a page shows as output has to
come out.
"""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))

from tour_pages import steps, words  # noqa: E402

PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
LEFT_ALONE = {"git", "cd", "pip", "cat", ".", "python", "python3.11", "ls"}
"""Commands that need a network or a clone; `make tour` runs them."""
ELSEWHERE = {"demo": ROOT / "tests" / "cli" / "test_demo.py"}
"""Commands of flexmodal that take long, and the tests that run them."""


def acts(page):
    return [step for step in steps(page) if step.kind != "file"]


def named(pages):
    return [pytest.param(page, id=str(page.relative_to(ROOT))) for page in pages]


@pytest.fixture
def place(tmp_path):
    """A folder of its own that looks like the checkout where the pages read from it."""
    for name in ("robots", "tests"):
        (tmp_path / name).symlink_to(ROOT / name, target_is_directory=True)
    return tmp_path


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


@pytest.mark.parametrize("page", named(page for page in PAGES if acts(page)))
def test_the_page_does_what_it_says(page, place, monkeypatch):
    monkeypatch.chdir(place)
    names = {"__name__": "__main__"}
    for number, step in enumerate(steps(page), start=1):
        if step.kind == "file":
            target = place / step.title
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(step.text, encoding="utf-8")
            continue
        if step.kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as caught:
                exec(compile(step.text, f"{page.name}, step {number}", "exec"), names)
            printed = caught.getvalue()
        else:
            printed = "".join(run(command, page, place) for command in step.commands)
        assert not step.missing(printed), f"{page.name}, step {number}: shown, not printed\n{printed}"


def test_there_is_something_to_run():
    kinds = {step.kind for page in PAGES for step in steps(page)}
    assert kinds == {"commands", "python", "file"}
    assert any(step.expected for page in PAGES for step in steps(page))


def test_what_is_shown_and_not_printed_is_noticed(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("```console\n$ flexmodal robots\n```\n\n```output\nsix_link 7.25\n```\n")
    (step,) = steps(page)
    assert step.missing("│ six_link │") == ["7.25"]
    assert step.missing("six_link 7.25 and more") == []


@pytest.mark.parametrize("page", named(PAGES))
def test_links_within_the_repository_lead_somewhere(page):
    for address in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", address):
            assert os.path.exists(page.parent / address), f"{page.name}: {address}"


@pytest.mark.parametrize("page", named(PAGES))
def test_fences_are_closed(page):
    assert len(re.findall(r"^```", page.read_text(encoding="utf-8"), re.MULTILINE)) % 2 == 0

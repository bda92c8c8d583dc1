"""What the documentation shows, runs: commands as written, Python page by page, files as they are shown.

`benchmarks/tour_pages.py` says what is a step of a page; blocks of other kinds (`toml` without a title,
`text`, …) are left alone. `flexmodal …` is run in a folder of its own for the page and has to end with status
0, but for those that other tests run; of `make …` the target has to exist. What a page shows as output has to
come out. Tutorials and how-tos have modules of their own, so that they run side by side.
"""

import os
import re
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

from tour_followed import PAGES, acting
from tour_pages import steps

SLOW = {"collisions.md"}
"""Pages that take twenty seconds, for `make slow`; clearances: tests/optimisation, tests/cli."""


def followed_here():
    """Pages beside the folders, those that wait for the compiled descents last."""
    found = []
    for given in sorted(acting(), key=lambda one: searches(one.values[0])):
        marks = [pytest.mark.slow] if given.values[0].name in SLOW else given.marks
        found.append(pytest.param(*given.values, id=given.id, marks=marks))
    return found


def searches(page):
    """Whether a page searches for postures, which wants the compiled descents."""
    text = "".join(step.text for step in steps(page) if not step.writes)
    return re.search(r"\b(optimise|path|studies|collision)", text) is not None


@pytest.mark.parametrize("page", followed_here())
def test_the_page_does_what_it_says(page, followed, request):
    """Those that search for postures come last, when another process has compiled what they need."""
    if searches(page):
        request.getfixturevalue("descents_on_disk")
    followed(page)


def test_there_is_something_to_run():
    kinds = {step.kind for page in PAGES for step in steps(page)}
    assert kinds == {"commands", "python", "file", "addition"}
    assert any(step.expected for page in PAGES for step in steps(page))


def test_what_is_shown_and_not_printed_is_noticed(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("```console\n$ flexmodal robots\n```\n\n```output\nsix_link 7.25\n```\n")
    (step,) = steps(page)
    assert step.missing("│ six_link │") == ["7.25"]
    assert step.missing("six_link 7.25 and more") == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_within_the_repository_lead_somewhere(page):
    for address in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", address):
            assert os.path.exists(page.parent / address), f"{page.name}: {address}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_fences_are_closed(page):
    assert len(re.findall(r"^```", page.read_text(encoding="utf-8"), re.MULTILINE)) % 2 == 0

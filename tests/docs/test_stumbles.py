"""docs/tables/stumbles.md: each of its commands, run in a terminal of 80 columns."""

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

from stumbles import OUT, STUMBLES, prepare
from terminal import in_terminal


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("afternoon")
    prepare(made)
    return made


def tried(stumble, folder):
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    words = ["bash", "-c", stumble.command]
    status, printed, _ = in_terminal(words, folder, {**os.environ, "PATH": path}, give_up=120.0)
    return stumble.faults(status, printed)


REFUSED = [one for one in STUMBLES if one.status == 2]


@pytest.mark.parametrize("stumble", REFUSED[:2], ids=lambda one: one.name)
def test_what_is_refused_says_what_to_do(stumble, folder):
    assert tried(stumble, folder) == []


@pytest.mark.slow
@pytest.mark.parametrize("stumble", STUMBLES, ids=lambda one: one.name)
def test_it_is_mended(stumble, folder):
    assert tried(stumble, folder) == []


def test_the_page_has_them_all():
    text = OUT.read_text(encoding="utf-8")
    for number, stumble in enumerate(STUMBLES, start=1):
        assert f"## {number}. {stumble.name}\n" in text
        assert f"$ {stumble.command}\n" in text


def test_an_outcome_that_is_not_as_it_should_be_is_told():
    one = next(one for one in STUMBLES if one.hides)
    assert one.faults(0, " ".join(one.shows)) == []
    assert len(one.faults(1, f"1.539… {one.hides}")) == len(one.shows) + 3

"""Tutorials do what they say, step by step."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

from tour_followed import acting


@pytest.mark.parametrize("page", acting("tutorials"))
def test_the_page_does_what_it_says(page, followed):
    followed(page)

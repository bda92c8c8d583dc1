"""A place in which the pages of the documentation are followed."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from . import in_process

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder of its own that looks like the checkout where the pages read from it; one works in it."""
    for name in ("robots", "tests"):
        (tmp_path / name).symlink_to(ROOT / name, target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def followed(place, monkeypatch):
    """A function: follow a page there, the commands of a short one in this process.

    Each of many commands would spend its time on imports; programs are started in tests/cli.
    """
    import tour_followed

    def follow(page):
        if page.name not in tour_followed.LONG:
            monkeypatch.setattr(tour_followed, "subprocess", SimpleNamespace(run=in_process.run))
        tour_followed.follow(page, place)

    return follow

"""docs/architecture.md names files, classes and rooms that exist, and every room."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "flexmodal"
MAP = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
QUOTED = re.findall(r"`([^`]+)`", re.sub(r"```.*?```", "", MAP, flags=re.DOTALL))
PATHS = sorted({one for one in QUOTED if "/" in one or one.endswith(".py")})
NAMES = sorted({one for one in QUOTED if re.fullmatch(r"[A-Z][a-z]+[A-Za-z]*", one)})


@pytest.mark.parametrize("path", PATHS)
def test_a_file_that_is_named_exists(path: str) -> None:
    places = (PACKAGE, ROOT, ROOT / "viewer" / "flexmodal_viewer")
    known = path.rstrip("/")
    pattern = known if "/" in known else f"**/{known}"
    assert any(any(place.glob(pattern)) for place in places)


@pytest.mark.parametrize("name", NAMES)
def test_a_class_that_is_named_exists(name: str) -> None:
    assert any(
        re.search(rf"^(class )?{name}\b", path.read_text(), re.MULTILINE) for path in PACKAGE.rglob("*.py")
    )


def test_every_room_has_its_row() -> None:
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    table = MAP.split("## Rooms")[1].split("\n\n")[1]
    rows = {one for line in table.splitlines() for one in re.findall(r"`([^`]+)`", line.split("|")[1])}
    assert rooms <= rows
    assert len(PATHS) > 40
    assert len(NAMES) > 4

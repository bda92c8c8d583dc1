"""Benchmarks run seldom: what they import has to be there all the same."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
OURS = ("flexmodal", "flexmodal_viewer")


def taken(path: Path) -> Iterator[tuple[str, str]]:
    """Module and name of everything that a script takes from the packages."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names if alias.name.split(".")[0] in OURS)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in OURS:
            yield from ((str(node.module), alias.name) for alias in node.names)


def lacking(module: str, name: str) -> bool:
    """Whether there is no such module, or nothing of that name in it."""
    try:
        found = importlib.import_module(module)
        if name and not hasattr(found, name):
            importlib.import_module(f"{module}.{name}")
    except ModuleNotFoundError as error:
        return str(error.name).split(".")[0] in OURS
    return False


@pytest.mark.parametrize("path", sorted(BENCHMARKS.glob("*.py")), ids=lambda path: path.stem)
def test_what_a_benchmark_imports_is_there(path: Path) -> None:
    gone = [f"{module}: {name}" for module, name in taken(path) if lacking(module, name)]
    assert gone == []


def test_names_that_are_gone_are_noticed() -> None:
    assert lacking("flexmodal.diagnosis", "no_such_name")
    assert lacking("flexmodal.no_such_room", "")
    assert not lacking("flexmodal.diagnosis", "diagnose")
    assert not lacking("flexmodal", "diagnosis")

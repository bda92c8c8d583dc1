"""A public function of two parameters and more says what each of them is."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "flexmodal"
ROOMS = ("campaign", "cards", "ema", "frf", "machining", "modal", "model", "rig", "text")
PICTURES = ("plot", "page", "pictures", "canvas", "table", "report", "kernels", "batch", "kernel")
"""Modules and rooms of pictures, pages and compiled loops, which are not held to it."""


def public(node: ast.Module | ast.ClassDef) -> Iterator[ast.FunctionDef]:
    """Functions of a module and methods of its classes, none that stand inside another function."""
    for one in node.body:
        if isinstance(one, ast.ClassDef):
            yield from public(one)
        elif isinstance(one, ast.FunctionDef) and not one.name.startswith("_"):
            yield one


def unsaid(path: Path) -> Iterator[str]:
    """Parameters that the docstring of their function does not name."""
    for function in public(ast.parse(path.read_text())):
        given = function.args
        names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
        names = [name for name in names if name not in ("self", "cls")]
        text = ast.get_docstring(function) or ""
        if len(names) > 1 and "for the arguments" not in text:
            for name in names:
                if "Args:" not in text or f"\n    {name}: " not in text:
                    yield f"{path.relative_to(PACKAGE)}: {function.name}({name})"


@pytest.mark.parametrize("room", ROOMS)
def test_parameters_are_described(room: str) -> None:
    paths = [
        path
        for path in (PACKAGE / room).rglob("*.py")
        if not path.stem.startswith(PICTURES) and not set(path.relative_to(PACKAGE).parts) & set(PICTURES)
    ]
    assert paths
    assert [line for path in sorted(paths) for line in unsaid(path)] == []

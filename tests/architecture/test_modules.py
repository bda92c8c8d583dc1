"""How the modules of both packages hang together: no circles, no borrowed private names, no overlong file.

Read from the text of the modules, so that imports under `if TYPE_CHECKING` and inside functions count too.
What stands in the lists of exceptions is known and to go; one that is no longer needed fails the test.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = (ROOT / "flexmodal", ROOT / "viewer" / "flexmodal_viewer")
LONGEST_MODULE = 300
LONGEST_FUNCTION = 60

KNOWN_CIRCLES: frozenset[tuple[str, ...]] = frozenset()
KNOWN_LONG_MODULES: frozenset[str] = frozenset()
KNOWN_LONG_FUNCTIONS: frozenset[str] = frozenset()
KNOWN_PRIVATE_IMPORTS: frozenset[str] = frozenset()

KERNELS = ("flexmodal.frf.kernels", "flexmodal.model.batch")
"""Rooms of loops written out for the compiler, in which a function may be longer."""


def modules() -> dict[str, Path]:
    """Every module of both packages by its dotted name."""
    found = {}
    for package in PACKAGES:
        for path in sorted(package.rglob("*.py")):
            parts = path.relative_to(package.parent).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def tree_of(path: Path) -> ast.Module:
    """A module as the parser reads it; read once."""
    return ast.parse(path.read_text())


@cache
def imports_of(path: Path, name: str) -> tuple[tuple[str, str], ...]:
    """What a module imports, see `imported`; walked once."""
    return tuple(imported(tree_of(path), name, path))


def imported(tree: ast.AST, name: str, path: Path) -> Iterator[tuple[str, str]]:
    """What a module imports: pairs of a module and a name taken from it, the name empty for `import x`."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            source = ".".join([*base, *([node.module] if node.module else [])])
            yield from ((source, alias.name) for alias in node.names)


def graph(paths: Mapping[str, Path]) -> dict[str, set[str]]:
    """The modules of these packages that each module imports."""
    edges: dict[str, set[str]] = {}
    for name, path in paths.items():
        pairs = imports_of(path, name)
        wanted = {f"{source}.{taken}" if f"{source}.{taken}" in paths else source for source, taken in pairs}
        edges[name] = {other for other in wanted if other in paths and other != name}
    return edges


def circles(edges: Mapping[str, set[str]]) -> set[frozenset[str]]:
    """Groups of modules that reach one another: strongly connected components of two and more."""

    def reach(start: str) -> set[str]:
        seen: set[str] = set()
        left = list(edges[start])
        while left:
            one = left.pop()
            if one not in seen:
                seen.add(one)
                left += edges[one]
        return seen

    reached = {name: reach(name) for name in edges}
    return {
        frozenset(other for other in reached[name] if name in reached[other])
        for name in edges
        if name in reached[name]
    }


def test_no_two_modules_import_each_other() -> None:
    found = circles(graph(modules()))
    assert {tuple(sorted(circle)) for circle in found} == KNOWN_CIRCLES


def test_no_module_is_overlong() -> None:
    long = {name for name, path in modules().items() if len(path.read_text().splitlines()) > LONGEST_MODULE}
    assert long == KNOWN_LONG_MODULES


def test_no_function_is_overlong() -> None:
    found = {
        f"{name}.{node.name}"
        for name, path in modules().items()
        if not name.startswith(KERNELS)
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.FunctionDef)
        and (node.end_lineno or node.lineno) - node.lineno + 1 > LONGEST_FUNCTION
    }
    assert found == KNOWN_LONG_FUNCTIONS


def test_no_module_takes_a_private_name_of_another() -> None:
    paths = modules()
    found = {
        f"{name} takes {source}.{taken}"
        for name, path in paths.items()
        for source, taken in imports_of(path, name)
        if taken.startswith("_") and not taken.startswith("__")
        if source.split(".")[0] in ("flexmodal", "flexmodal_viewer")
    }
    assert found == KNOWN_PRIVATE_IMPORTS


@pytest.mark.parametrize(
    ("edges", "expected"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, set()),
        ({"a": {"b"}, "b": {"c"}, "c": {"b"}}, {frozenset({"b", "c"})}),
        ({"a": {"b"}, "b": {"a", "c"}, "c": {"d"}, "d": {"c"}}, {frozenset("ab"), frozenset("cd")}),
    ],
)
def test_circles_are_found(edges: dict[str, set[str]], expected: set[frozenset[str]]) -> None:
    assert circles(edges) == expected


def test_imports_for_typing_and_inside_functions_count() -> None:
    text = "from x import a\nif TYPE_CHECKING:\n    from .y import b\ndef f():\n    import z\n"
    found = set(imported(ast.parse(text), "flexmodal.room.module", Path("module.py")))
    assert found == {("x", "a"), ("flexmodal.room.y", "b"), ("z", "")}


@pytest.mark.parametrize(
    ("library", "room"),
    [("pinocchio", "flexmodal.model"), ("pyuff", "flexmodal.campaign.uff")],
)
def test_a_library_has_one_door(library: str, room: str) -> None:
    paths = modules()
    found = {
        name
        for name, path in paths.items()
        for source, _ in imports_of(path, name)
        if source.split(".")[0] == library
    }
    assert found
    assert {name for name in found if not name.startswith(room)} == set()

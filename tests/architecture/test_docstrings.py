"""A public function of two parameters and more says what each of them is, and any function what it raises."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "flexmodal"
ROOMS = (
    "atlas", "campaign", "cards", "cli", "diagnosis", "ema", "files", "frf", "identification", "machining",
    "modal", "model", "optimisation", "prediction", "report", "rig", "soundness", "structure", "text",
    "../viewer/flexmodal_viewer",
)  # fmt: skip
PICTURES = ("plot", "page", "pictures", "canvas", "table", "report")
LOOPS = ("kernels", "batch", "kernel", "compiled", "descent", "frf_fit")
"""Modules and rooms of pictures, pages and compiled loops, which are not held to it."""
KNOWN_UNNAMED = ["identification/frf_fit.py: fit: InvalidRequest"]


def public(node: ast.Module | ast.ClassDef) -> Iterator[ast.FunctionDef]:
    """Functions of a module and methods of its classes, none that stand inside another function."""
    for one in node.body:
        if isinstance(one, ast.ClassDef) and not one.name.startswith("_"):
            yield from public(one)
        elif isinstance(one, ast.FunctionDef) and not one.name.startswith("_"):
            yield one


def is_command(function: ast.FunctionDef) -> bool:
    """Whether it is a command: its docstring is its --help, which says of each option what it is."""
    called = [one.func for one in function.decorator_list if isinstance(one, ast.Call)]
    return any(isinstance(one, ast.Attribute) and one.attr in ("command", "group") for one in called)


def unsaid(path: Path) -> Iterator[str]:
    """Parameters that the docstring of their function does not name."""
    for function in public(ast.parse(path.read_text())):
        if is_command(function):
            continue
        given = function.args
        names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
        names = [name for name in names if name not in ("self", "cls")]
        text = ast.get_docstring(function) or ""
        if len(names) > 1 and "for the arguments" not in text:
            for name in names:
                if "Args:" not in text or f"\n    {name}: " not in text:
                    yield f"{path.name}: {function.name}({name})"


def described(path: Path) -> Iterator[str]:
    """Methods whose parameters an interface describes, once for all that have it."""
    for one in ast.parse(path.read_text()).body:
        if isinstance(one, ast.ClassDef) and {ast.unparse(base) for base in one.bases} & {"Protocol", "ABC"}:
            yield from (node.name for node in public(one) if "Args:" in (ast.get_docstring(node) or ""))


@pytest.mark.parametrize("room", ROOMS)
def test_parameters_are_described(room: str) -> None:
    paths = [
        path
        for path in (PACKAGE / room).rglob("*.py")
        if not path.stem.startswith((*PICTURES, *LOOPS))
        if not set(path.relative_to(PACKAGE / room).parts) & {*PICTURES, *LOOPS}
    ]
    assert paths
    said = {name for path in paths for name in described(path)}
    found = [line for path in sorted(paths) for line in unsaid(path)]
    left = [line for line in found if line.split(": ")[1].partition("(")[0] not in said]
    assert left == []


def functions(tree: ast.Module) -> dict[str, ast.FunctionDef]:
    """Functions and methods of a module by name, those of a class as Class.name."""
    found = {}
    for one in tree.body:
        for node in one.body if isinstance(one, ast.ClassDef) else [one]:
            if isinstance(node, ast.FunctionDef):
                found[node.name if node is one else f"{one.name}.{node.name}"] = node
    return found


def raised(name: str, there: Mapping[str, ast.FunctionDef], before: frozenset[str] = frozenset()) -> set[str]:
    """Errors of the package that a function raises, or that those do that it calls in its own module."""
    found: set[str] = set()
    caught: set[str] = set()
    for node in ast.walk(there[name]):
        if isinstance(node, ast.Raise) and node.exc is not None:
            error = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
            found |= {error.id} & set(BASES) if isinstance(error, ast.Name) else set()
        elif isinstance(node, ast.ExceptHandler) and node.type is not None:
            caught |= {one.id for one in ast.walk(node.type) if isinstance(one, ast.Name)}
        elif isinstance(node, ast.Call):
            called = ast.unparse(node.func).replace("self.", f"{name.partition('.')[0]}.")
            if called in there and called not in before | {name}:
                found |= raised(called, there, before | {name})
    return {error for error in found if not lineage(error) & caught}


def lineage(error: str) -> set[str]:
    """An error and those that it is one of."""
    return {error}.union(*(lineage(base) for base in BASES.get(error, ())))


ERRORS = (one for one in ast.parse((PACKAGE / "errors.py").read_text()).body if isinstance(one, ast.ClassDef))
BASES = {one.name: [base.id for base in one.bases if isinstance(base, ast.Name)] for one in ERRORS}


def unnamed(text: str) -> Iterator[str]:
    """Errors that a public function of a module raises and its docstring does not name."""
    there = functions(ast.parse(text))
    for name, node in there.items():
        if not name.rpartition(".")[2].startswith("_"):
            words = set(re.findall(r"\w+", ast.get_docstring(node) or ""))
            yield from (f"{name}: {error}" for error in raised(name, there) if not lineage(error) & words)


def test_errors_are_named() -> None:
    """Those of commands are not: they end in sentences for whoever called them."""
    paths = [path for path in sorted(PACKAGE.rglob("*.py")) if path.relative_to(PACKAGE).parts[0] != "cli"]
    found = [f"{path.relative_to(PACKAGE)}: {one}" for path in paths for one in unnamed(path.read_text())]
    assert found == KNOWN_UNNAMED


def test_an_error_that_is_not_named_is_found() -> None:
    text = "def f():\n    '''One.{}'''\n    _g()\ndef _g():\n    raise InvalidCard(1)\n"
    assert list(unnamed(text.format(""))) == ["f: InvalidCard"]
    assert list(unnamed(text.format("\n\n    Raises:\n        InvalidCard: never.\n    "))) == []
    assert list(unnamed(text.format("\n\n    Raises:\n        InvalidInput: it is one.\n    "))) == []
    kept = "def f():\n    try:\n        raise InvalidCard(1)\n    except InvalidInput:\n        pass\n"
    assert list(unnamed(kept)) == []


def test_commands_say_it_in_their_help(tmp_path: Path) -> None:
    text = "{}def f(a, b):\n    '''One.'''\n"
    for decorator, expected in (
        ("", 2),
        ("@cache\n", 2),
        ("@click.command()\n", 0),
        ("@a.command('b')\n", 0),
    ):
        (tmp_path / "one.py").write_text(text.format(decorator))
        assert len(list(unsaid(tmp_path / "one.py"))) == expected

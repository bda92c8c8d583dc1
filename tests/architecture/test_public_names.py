"""What a command does, Python does under a public name: the same function, nothing computed beside it."""

from __future__ import annotations

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import click
import pytest

import flexmodal
from flexmodal.cli.main import group

CLI = Path(__file__).parents[2] / "flexmodal" / "cli"

FUNCTIONS = {
    "robots": "robots",
    "check": "check",
    "optimise": "optimise",
    "lobes": "lobes",
    "tune": "tune",
    "path": "plan_path",
    "studies": "run_study",
    "fit": "fit",
    "identify": "identify",
    "predict": "predict_posture",
    "diagnose": "diagnose",
    "rig": "simulate",
}
METHODS = {"frf": "frf", "modes": "modes", "measures": "measures"}
"""Of `Robot`."""
NONE = {"atlas", "lookup", "show", "demo", "card", "campaign", "import", "export"}
"""Pictures in the browser, a tour of the other commands, and files for a person or another program."""


def taken(command: str) -> list[object]:
    """Everything of the package that the module of a command imports, wherever it does."""
    found = []
    for node in ast.walk(ast.parse((CLI / f"{command}.py").read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("flexmodal"):
            module = importlib.import_module(node.module or "")
            found += [getattr(module, alias.name, None) for alias in node.names]
    return found


def test_every_command_is_listed() -> None:
    commands = group.list_commands(click.Context(group))
    assert set(commands) == set(FUNCTIONS) | set(METHODS) | NONE


@pytest.mark.parametrize(("command", "name"), FUNCTIONS.items())
def test_a_command_calls_the_public_function(command: str, name: str) -> None:
    public = getattr(flexmodal, name)
    assert inspect.isfunction(public)
    assert any(one is public for one in taken(command))
    assert name in flexmodal.__all__


@pytest.mark.parametrize(("command", "name"), METHODS.items())
def test_a_command_calls_the_method_of_a_robot(command: str, name: str) -> None:
    called = [
        node.func.attr
        for node in ast.walk(ast.parse((CLI / f"{command}.py").read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    ]
    assert inspect.isfunction(getattr(flexmodal.Robot, name))
    assert name in called


@pytest.mark.parametrize("name", sorted({*FUNCTIONS.values(), "load", "read_campaign", "read_cut"}))
def test_a_public_function_says_what_it_takes(name: str) -> None:
    function = getattr(flexmodal, name)
    text = inspect.getdoc(function) or ""
    parameters = inspect.signature(function).parameters
    assert text
    if len(parameters) > 1:
        assert "Args:" in text
        assert [one for one in parameters if f"{one}:" not in text] == []


def test_names_cost_nothing_until_they_are_used() -> None:
    code = (
        "import sys, flexmodal; flexmodal.__all__; "
        "print([name for name in ('numpy', 'pinocchio', 'scipy', 'matplotlib') if name in sys.modules])"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[]"

"""The page on trust names tests that there are, and commands that write which chaos kills."""

import re
import sys
from pathlib import Path

import click
import pytest

from flexmodal.cli.main import _COMMANDS, group

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "trust.md").read_text(encoding="utf-8")
NAMED = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)
OUTPUTS = {"--out", "--plot", "--map", "--pictures", "--draft"}


@pytest.mark.parametrize(("file", "name"), NAMED)
def test_the_test_is_there(file, name):
    assert re.search(rf"^def {name}\(", (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)


def test_every_item_has_one():
    rows = [line for line in PAGE.splitlines() if line.startswith("|") and "tests/" in line]
    assert len(rows) >= 28
    assert len(NAMED) >= len(rows)


def test_chaos_kills_every_command_that_writes():
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        from chaos_cases import Inputs, cases
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))
    killed = {(case.words[0], case.option) for case in cases(Inputs(*"abcdefgh"))}
    killed.add(("atlas", "--out"))  # which has a function of its own there
    writing = set()
    for name in _COMMANDS:
        command = group.get_command(click.Context(group), name)
        inner = command.commands.values() if isinstance(command, click.Group) else [command]
        writing |= {(name, option) for one in inner for part in one.params for option in part.opts}
    asked = {pair for pair in writing if pair[1] in OUTPUTS}
    assert asked <= killed

"""What is compiled is said in one line, by whatever command; what comes from disk is not said."""

import importlib
import logging
import os
import subprocess
import sys

import pytest

from flexmodal.atlas import spread
from flexmodal.cli.compiling import COMPILER, compilations_said
from flexmodal.frf.kernels.compiled import together

from .conftest import PROGRAM

numba = pytest.importorskip("numba")

ONCE = "compiling twice a number, once on this machine"


def inner(number):
    return number + number


def twice(number):
    return inner(number)


def made(seconds=0.0):
    """As in a process that has not made it yet."""
    return together(inner, last=twice, purpose="twice a number", seconds=seconds)


ELSEWHERE = """
from flexmodal.frf.kernels.compiled import together

def twice(number):
    return 2.0 * number

def call(number):
    return together(last=twice, purpose="twice a number").compiled(number)

def command():
    import click
    from flexmodal.cli import frf, main
    quiet = click.Option(["--quiet"], is_flag=True)
    frf.frf = click.Command("frf", callback=lambda quiet: call(1.0) and None, params=[quiet])
    main.main()
"""


@pytest.fixture
def said(tmp_path, monkeypatch, capsys):
    """What is said while the function is made and called, over a cache of its own."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))

    def run(work=lambda: made().compiled(2.0)):
        with compilations_said():
            work()
        found = capsys.readouterr()
        assert found.out == ""
        return found.err.splitlines()

    return run


def test_what_is_compiled_is_said_and_what_is_on_disk_is_not(said, tmp_path):
    assert said() == [f"flexmodal: {ONCE}"]
    assert len(list(tmp_path.rglob("*.nbi"))) == 1
    assert said() == []


@pytest.mark.parametrize(("words", "lines"), [([], [f"flexmodal: {ONCE}"]), (["--quiet"], [])])
def test_the_program_says_it_unless_it_is_to_be_quiet(tmp_path, words, lines):
    (tmp_path / "elsewhere.py").write_text(ELSEWHERE)
    code = f"import sys; sys.argv = {['flexmodal', 'frf', *words]}; import elsewhere; elsewhere.command()"
    own = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", code], env=own, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr.splitlines()) == ("", lines)
    assert len(list(tmp_path.rglob("*.nbi"))) == 1


def test_two_functions_for_one_purpose_take_one_line(said):
    """As one function that is compiled for two types of arguments."""

    def both():
        function = made(3.6).compiled
        return function(1.0) + function(1)

    assert said(both) == [f"flexmodal: {ONCE}: some 4 s"]


def test_where_nothing_can_be_kept_it_is_compiled_in_each_run(said, monkeypatch):
    def refuse(*_, **options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return njit(*_, **options)

    njit = numba.njit
    monkeypatch.setattr(numba, "njit", refuse)
    for _ in range(2):
        (line,) = said()
        assert line.startswith("flexmodal: compiling twice a number, in each run")
        assert "NUMBA_CACHE_DIR" in line


def test_without_the_command_line_it_is_in_the_log(said, caplog):
    with caplog.at_level(logging.INFO, logger="flexmodal.engine"):
        made().compiled(2.0)
    assert caplog.messages == [ONCE]
    assert COMPILER.handlers == []


def test_what_other_processes_compile_is_said_here(said, tmp_path, monkeypatch):
    (tmp_path / "elsewhere.py").write_text(ELSEWHERE)
    monkeypatch.syspath_prepend(tmp_path)  # which the processes take over
    call = importlib.import_module("elsewhere").call
    found = []
    assert said(lambda: found.extend(spread(call, [3.0], workers=1))) == [f"flexmodal: {ONCE}"]
    assert found == [(3.0, 6.0)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "purpose"),
    [
        (["rig", "fanuc_s360", "--postures", "5", "--hide", "clearance"], "steps in time"),
        (["atlas", "six_link", "--sample", "600000", "--frequencies", "5"], "mass matrices of many postures"),
    ],
)
def test_commands_that_wait_for_the_compiler_say_so(tmp_path, words, purpose):
    """And the same once more, into another folder, does not."""
    own = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    told = []
    for name in ("first", "second"):
        done = subprocess.run(
            [PROGRAM, *words, "--out", str(tmp_path / name)],
            env=own,
            capture_output=True,
            text=True,
            check=True,
        )
        told.append([line for line in done.stderr.splitlines() if line.startswith("flexmodal: compiling")])
    assert any(line.startswith(f"flexmodal: compiling {purpose}, once") for line in told[0])
    assert told[1] == []

"""Run-time checks of types and shapes, by sample; and what is compiled while the tests begin.

`--jaxtyping-packages` puts `@jaxtyping.jaxtyped` on every function of the package as it is imported. To check
each of the million calls of a fit's inner loops takes three quarters of the time of its test and finds little
that the first calls have not shown, so here each function is checked in the first calls of each module of
tests and in one of many thereafter. Not in those of each test: checks were a fifth of the time of all tests
then, and the tests of a module call the same functions with arguments of the same kinds. A test that is about
a check asks for the fixture `checked`.
"""

import dataclasses
import functools
import inspect
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import jaxtyping
import pytest
from beartype import BeartypeConf, beartype

FIRST, THEN = 3, 1000
"""Calls of a function that are checked in every module of tests; the distance of those checked later."""

_compiling = pytest.StashKey[subprocess.Popen]()
_MEANWHILE = "FLEXMODAL_TESTS_COMPILING"
"""Variable with the name of a file that is there as long as another process compiles."""
_module: list[Any] = [None]
"""The module whose tests run."""
_seen: dict[tuple[str, str], list[int]] = {}
"""Calls until the next check, and checks so far in this module of tests, by module and name of the function;
closures are counted together."""
_always = jaxtyping.jaxtyped
_numbers = beartype(conf=BeartypeConf(is_pep484_tower=True))
"""The checker of types: an int is a float too, in a list as well, of which it looks at one item by chance."""


def afresh() -> None:
    """The next calls of every function are first calls."""
    for seen in _seen.values():
        seen[:] = 0, 0


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.path != _module[0]:
        _module[0] = item.path
        afresh()


@pytest.fixture
def checked() -> None:
    """Functions are checked in their first calls of this test, whatever the tests before it have called."""
    afresh()


def sampled(function: Any) -> Any:
    """The function, checked in some of its calls; it is wrapped for the check when that is first needed."""
    seen = _seen.setdefault((function.__module__, function.__qualname__), [0, 0])
    checked = None

    @functools.wraps(function)
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        nonlocal checked
        if seen[0] > 0:
            seen[0] -= 1
            return function(*args, **kwargs)
        seen[1] += 1
        if seen[1] >= FIRST:
            seen[0] = THEN - 1 if seen[1] > FIRST else THEN - FIRST - 1
        if checked is None:
            checked = _always(function, typechecker=_numbers)
        return checked(*args, **kwargs)

    return wrapper


def jaxtyped(*, typechecker: Any) -> Any:
    """In the place of `jaxtyping.jaxtyped`: for the functions and classes that the import hook decorates."""

    def decorate(thing: Any) -> Any:
        if not inspect.isclass(thing):
            return sampled(thing)
        own = vars(thing).get("__init__") if dataclasses.is_dataclass(thing) else None
        if own is not None and not hasattr(own, "__wrapped__"):
            thing.__init__ = sampled(own)
        return thing

    return decorate


jaxtyping.jaxtyped = jaxtyped


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Before all tests, where several processes share them: see `compiled_first.py`."""
    config = session.config
    of_all = config.args_source is pytest.Config.ArgsSource.TESTPATHS
    if of_all and config.getoption("numprocesses", None) and not hasattr(config, "workerinput"):
        script = Path(__file__).with_name("compiled_first.py")
        handle, os.environ[_MEANWHILE] = tempfile.mkstemp(prefix="compiling")
        os.close(handle)
        words = [sys.executable, script, os.environ[_MEANWHILE]]
        config.stash[_compiling] = subprocess.Popen(words, stderr=subprocess.PIPE)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """That it failed is a failure of the tests."""
    compiling = session.config.stash.get(_compiling, None)
    if compiling is not None:
        _, said = compiling.communicate()
        if compiling.returncode:
            sys.stderr.write(f"\n{compiling.args[1]} failed:\n{said.decode()}")
            session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope="session")
def descents_on_disk() -> None:
    """Wait for the compiled descents while another process compiles them: a minute of work done once."""
    from flexmodal.optimisation.compiled import descents

    meanwhile = os.environ.get(_MEANWHILE)
    while meanwhile and os.path.exists(meanwhile) and not descents().is_stored():
        time.sleep(0.5)

"""Run-time checks of types and shapes, by sample; and what is compiled while the tests begin.

`--jaxtyping-packages` puts `@jaxtyping.jaxtyped` on every function of the package as it is imported. To check
each of the million calls of a fit's inner loops takes three quarters of the time of its test and finds little
that the first calls have not shown, so here each function is checked in the first calls of each module of
tests. Not in those of each test: checks were a fifth of the time of all tests then, and the tests of a module
call the same functions with arguments of the same kinds. A test that is about a check asks for the fixture
`checked`.

A wrapper that only counts was another twelfth. So a function that was checked gets its own code back, in the
place of code that calls the check.
"""

import dataclasses
import functools
import inspect
import os
import subprocess
import sys
import tempfile
import time
import warnings
import zlib
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import jaxtyping
import pytest
from beartype import BeartypeConf, beartype

FIRST = 3
"""Calls of a function that are checked in every module of tests."""

_compiling = pytest.StashKey[subprocess.Popen]()
_MEANWHILE = "FLEXMODAL_TESTS_COMPILING"
"""Variable with the name of a file that is there as long as another process compiles."""
_module: list[Any] = [None]
"""The module whose tests run."""
_seen: dict[tuple[str, str], list[int]] = {}
"""Checks so far in this module of tests, by module and name of the function; those of closures together."""
_sampled: dict[Any, CodeType] = {}
"""Functions, and the code with which they are checked."""
_ANOTHER = "another function"
with warnings.catch_warnings():
    warnings.simplefilter("ignore", SyntaxWarning)  # for a constant that is called
    _CALL: CodeType = eval(f"lambda *args, **kwargs: {_ANOTHER!r}(*args, **kwargs)").__code__
_always = jaxtyping.jaxtyped
_numbers = beartype(conf=BeartypeConf(is_pep484_tower=True))
"""The checker of types: an int is a float too, in a list as well, of which it looks at one item by chance."""


def afresh() -> None:
    """The next calls of every function are first calls."""
    for seen in _seen.values():
        seen[0] = 0
    for function, checking in _sampled.items():
        function.__code__ = checking


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of tests that are marked with `some(k)` one case in `k` runs in `make test`, the others in `make slow`.

    Which ones follows from their names alone, as if by lot: neighbours differ in one thing only.
    """
    cases: dict[tuple[str, int], list[pytest.Item]] = {}
    for item in items:
        mark = item.get_closest_marker("some")
        if mark is not None and item.get_closest_marker("slow") is None:
            cases.setdefault((item.nodeid.partition("[")[0], mark.args[0]), []).append(item)
    for (_, one_in), every in cases.items():
        drawn = sorted(every, key=lambda item: zlib.crc32(item.name.encode()))
        for item in drawn[-(-len(drawn) // one_in) :]:
            item.add_marker(pytest.mark.slow)


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
    """The function, checked in its first calls; one that is made anew again and again is so in a wrapper."""
    seen = _seen.setdefault((function.__module__, function.__qualname__), [0])
    passing = "<locals>" in function.__qualname__
    if function in _sampled or (passing and seen[0] >= FIRST):
        return function
    code, defaults = function.__code__, function.__defaults__
    own = FunctionType(code, function.__globals__, function.__name__, defaults, function.__closure__)
    vars(own).update(vars(function))
    for name in ("__module__", "__qualname__", "__doc__", "__annotations__", "__kwdefaults__"):
        setattr(own, name, getattr(function, name))
    checked = None

    @functools.wraps(own)
    def check(*args: Any, **kwargs: Any) -> Any:
        nonlocal checked
        seen[0] += 1
        if seen[0] >= FIRST and not passing:
            function.__code__ = code
        elif seen[0] > FIRST:
            return own(*args, **kwargs)
        if checked is None:
            checked = _always(own, typechecker=_numbers)
        return checked(*args, **kwargs)

    if passing:
        return check
    function.__wrapped__ = own
    function.__code__ = _calling(check, code)
    _sampled[function] = function.__code__
    return function


def _calling(check: Any, code: CodeType) -> CodeType:
    """The code of a function that calls another one in its stead."""
    return _CALL.replace(
        co_consts=tuple(check if one == _ANOTHER else one for one in _CALL.co_consts),
        co_freevars=code.co_freevars,
        co_name=code.co_name,
        co_qualname=code.co_qualname,
        co_filename=code.co_filename,
        co_firstlineno=code.co_firstlineno,
    )


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
    os.environ.setdefault("FLEXMODAL_WORKERS", "1")  # for a diagnosis, as the tests run side by side
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

"""Whether to load a compiled function: told by the work done so far, counted and not timed."""

import os
import subprocess
import sys
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from flexmodal.frf.kernels import compiled, route, worth
from flexmodal.frf.kernels.route import choose
from flexmodal.frf.kernels.task import Task
from flexmodal.frf.kernels.worth import IMPORT, LOAD, is_worth_it
from flexmodal.frf.receptance import receptance
from flexmodal.modal import SecondOrderSystem


@pytest.fixture(autouse=True)
def nothing_spent(monkeypatch):
    """As in a process that has done nothing yet and has not loaded numba."""
    monkeypatch.setattr(worth, "_spent", type(worth._spent)(float))
    monkeypatch.setattr(worth, "_stored", {})
    monkeypatch.setattr(route, "_LOADED", set())
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "numba")
    monkeypatch.setattr(route, "has_numba", lambda: True)


def stored(is_stored):
    return lambda: is_stored


def calls_until_worth_it(seconds, is_stored):
    return next(n for n in count(1) if is_worth_it("this", seconds, 4.0, is_stored))


@pytest.mark.parametrize(("is_stored", "price"), [(True, IMPORT + LOAD), (False, IMPORT + LOAD + 4)])
def test_the_rent_reaches_the_price(is_stored, price):
    """Work of 10 ms a call: bought when all of it together would have paid."""
    assert calls_until_worth_it(0.01, stored(is_stored)) == pytest.approx(price / 0.01, abs=1.5)


def test_the_disk_is_looked_at_once_however_often_is_asked():
    looks = []
    found = [is_worth_it("this", 1.0, 4.0, lambda: looks.append(1) or False) for _ in range(20)]
    assert found == [False] * 4 + [True] * 16
    assert len(looks) == 1


def test_kinds_are_counted_by_themselves():
    assert not is_worth_it("one", 0.9 * (IMPORT + LOAD), 4.0, stored(True))
    assert not is_worth_it("other", 0.9 * (IMPORT + LOAD), 4.0, stored(True))
    assert is_worth_it("one", 0.2 * (IMPORT + LOAD), 4.0, stored(True))


def test_numba_is_paid_for_once(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", SimpleNamespace())
    assert is_worth_it("this", 1.1 * LOAD, 4.0, stored(True))


def task(lines):
    ones = np.eye(6)
    omega = np.linspace(1.0, 2.0, lines)
    return Task(1, lambda _: (ones[None], ones[None, :1]), 50 * ones, ones, 0 * ones, ((0, 0),), omega)


@pytest.mark.parametrize(
    ("is_stored", "price"), [(True, IMPORT + LOAD), (False, IMPORT + LOAD + compiled.COMPILATION)]
)
def test_a_loop_of_calls_comes_to_the_kernel(monkeypatch, is_stored, price):
    """20 000 lines a call, some 20 ms in numpy each; no single one is worth the kernel."""
    monkeypatch.setattr("flexmodal.frf.kernels.compiled.Kernel.is_stored", lambda _: is_stored)
    ways = [choose(task(20_000), None).way for _ in range(400)]
    bought = ways.index("compiled")
    assert set(ways[:bought]) == {"numpy"}
    assert set(ways[bought:]) == {"compiled"}
    a_call = 20_000 * (0.3e-6 + 3e-9 * 6**3 + 0.05e-6)
    assert (bought + 1) * a_call == pytest.approx(price, abs=a_call)


@pytest.mark.slow
def test_a_short_call_neither_takes_the_kernel_nor_counts(monkeypatch):
    monkeypatch.setattr("flexmodal.frf.kernels.compiled.Kernel.is_stored", lambda _: True)
    assert {choose(task(route.WORTH_A_CALL - 1), None).way for _ in range(100_000)} == {"LAPACK"}
    assert not worth._spent


def test_receptances_of_one_system_count(monkeypatch):
    """Also those that are too few for elimination in numpy."""
    asked = []
    monkeypatch.setattr("flexmodal.frf.kernels.route.is_worth_it", lambda *a: asked.append(a) or False)
    system = SecondOrderSystem(np.eye(2), 0.1 * np.eye(2), np.diag([3.0, 4.0]), ("a", "b"))
    row, axis = np.array([[1.0, 0.5]]), np.linspace(0.1, 1.0, route.WORTH_A_CALL)
    first = receptance(system, row, row, axis)
    again = receptance(system, row, row, axis)
    np.testing.assert_array_equal(first, again)
    assert len(asked) == 2
    assert asked[0][:2] == asked[1][:2]


def test_work_that_is_judged_by_itself_goes_one_way_as_long_as_the_process_lives(monkeypatch):
    """So that a simulation repeated gives the same numbers to the last digit."""
    monkeypatch.setattr(worth, "_stored_at_first", {})
    compilation, stored = 8.0, [False]

    def pays(seconds):
        return worth.pays_alone("a kind", seconds, compilation, lambda: stored[0])

    less, more = compilation, compilation + worth.IMPORT + worth.LOAD
    assert [pays(less) for _ in range(5)] == [False] * 5  # however often
    assert pays(more)
    stored[0] = True  # by now it is on disk
    assert not pays(less)
    assert pays(more)
    worth._stored_at_first.clear()  # another process
    assert pays(less)
    assert not pays(0.9 * (worth.IMPORT + worth.LOAD))


@pytest.mark.slow
def test_what_numba_keeps_is_found_without_loading_it(tmp_path):
    """In processes of their own; one file of code for a kernel and all it calls."""
    pytest.importorskip("numba")
    look = (
        "import sys; from flexmodal.frf.kernels.compiled import repair; "
        "print(repair().is_stored(), 'numba' in sys.modules)"
    )
    make = (
        "import numpy as np; from flexmodal.frf.kernels.compiled import repair; "
        "z = np.zeros; repair().compiled(z((1, 4)), z(0), z((1, 1)), z(1), z((0, 1)), z((1, 2), dtype=int), "
        "z((1, 1, 1), dtype=complex))"
    )
    found = []
    for code in (look, make, look):
        own = {"NUMBA_CACHE_DIR": str(tmp_path)}
        done = subprocess.run(
            [sys.executable, "-c", code], env=own, capture_output=True, text=True, check=True
        )
        found.append(done.stdout.strip())
    assert found == ["False False", "", "True False"]
    assert len(list(tmp_path.rglob("*.nbc"))) == 1


@pytest.mark.parametrize("chosen", ["", "/cache"])
def test_a_cache_that_may_not_be_read_holds_nothing(monkeypatch, chosen):
    """Such as that of a home folder that is somebody else's."""

    def refuses(path, pattern):
        raise PermissionError(13, "Permission denied", str(path))

    kernel = compiled.sweep_of_any_size()
    monkeypatch.setenv("NUMBA_CACHE_DIR", chosen)
    monkeypatch.setattr(Path, "glob", refuses)
    assert not kernel.is_stored()


def test_what_is_on_disk_is_known_by_what_its_source_says(monkeypatch, tmp_path):
    """Not by when that was written: a clone, or an editor that saves, gives files a new time."""
    source, cache = tmp_path / "loops.py", tmp_path / "cache"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(cache))

    def kernel(text):
        source.write_text(text, encoding="utf-8")
        compiled._text.cache_clear()
        scope = {"__name__": "loops"}
        exec(compile(text, str(source), "exec"), scope)
        return compiled.Kernel(scope["loop"])

    first = kernel("def loop(x):\n    return x\n")
    assert not first.is_stored()
    (cache / "here").mkdir(parents=True)
    (cache / "here" / f"loops.{first.name}-1.py311.nbi").touch()
    os.utime(source, (2e9, 2e9))
    assert first.is_stored()
    assert not kernel("def loop(x):\n    return x\n\n\nMORE = 1\n").is_stored()

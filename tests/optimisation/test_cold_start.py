"""Before anything is compiled: who waits for the compiler, and who does not. Counted, not timed."""

import os
import subprocess
import sys

import numpy as np
import pytest

from flexmodal.frf import PointDirection
from flexmodal.frf.kernels import worth
from flexmodal.frf.kernels.compiled import Kernel
from flexmodal.frf.kernels.worth import IMPORT, LOAD
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, SeparationObjective
from flexmodal.optimisation.compiled import COMPILATION
from flexmodal.optimisation.search import choose_way

pytestmark = pytest.mark.usefixtures("types_unchecked")


@pytest.fixture
def problem(arm):
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([5.0]))
    return PostureProblem(arm, judge, Hold.at(arm, (-2.0, 2.0)))


@pytest.fixture
def first(monkeypatch):
    """As in a process that has done nothing yet; tells whether the code is on disk."""
    monkeypatch.setattr(worth, "_spent", type(worth._spent)(float))
    monkeypatch.setattr(worth, "_stored", {})
    monkeypatch.setattr("flexmodal.optimisation.search.descents.has_numba", lambda: True)
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    return lambda is_stored: monkeypatch.setattr(Kernel, "is_stored", lambda _: is_stored)


def test_what_is_on_disk_is_loaded_for_an_ordinary_search(problem, first):
    first(True)
    assert choose_way(problem, 64) == "compiled"


def test_an_ordinary_search_does_not_wait_for_the_compiler(problem, first):
    first(False)
    assert choose_way(problem, 64) == "plain"


def test_a_large_search_does(problem, first):
    """Which would take longer in Python than the compiler does."""
    first(False)
    assert choose_way(problem, 4096) == "compiled"


def test_searches_add_up(problem, first):
    """64 starts take 2.56 s in Python; so many of them pay for the compiler together."""
    first(False)
    ways = [choose_way(problem, 64) for _ in range(30)]
    bought = ways.index("compiled")
    assert set(ways[:bought]) == {"plain"}
    assert set(ways[bought:]) == {"compiled"}
    assert (bought + 1) * 2.56 == pytest.approx(COMPILATION + IMPORT + LOAD, abs=2.56)


def test_a_few_starts_go_the_same_way_whatever_was_before(problem, first):
    """So that a small search repeated gives the same numbers to the last digit."""
    first(True)
    assert {choose_way(problem, 15) for _ in range(200)} == {"plain"}
    assert not worth._spent


def test_what_cannot_be_compiled_counts_for_nothing(arm, first):
    first(True)
    assert choose_way(PostureProblem(arm, SeparationObjective(20.0)), 4096) == "plain"
    assert not worth._spent


def test_the_first_command_compiles_nothing(tmp_path):
    words = ["optimise", "six_link", "--hold", "-2,2", "--frequency", "5", "--starts", "16"]
    code = f"import sys\nfrom flexmodal.cli.main import main\ntry:\n    main({words})\nexcept SystemExit:\n"
    code += "    print('numba' in sys.modules)"
    own = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", code], env=own, capture_output=True, text=True, check=True)
    assert done.stdout.endswith("False\n")
    assert list(tmp_path.rglob("*")) == []

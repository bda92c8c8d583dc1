"""When a compiled function is worth its start: it is rented from Python until the rent has reached its price.

Interpreted code is at hand at once. Compiled code costs the import of numba and, where the function is not on
disk, its compilation, and nobody knows how much work is still to come. Who goes on without it until that has
cost as much as compiling would have, and only then compiles, never takes more than twice as long as one who
knew (ski rental; Karlin, Manasse, Rudolph and Sleator, Algorithmica 3, 1988, section 2).
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable, Hashable, Mapping

IMPORT, LOAD = 0.7, 0.05
"""Seconds to import numba, and to read a function from disk; processor time of a core of 2020."""

_spent: defaultdict[Hashable, float] = defaultdict(float)
"""Seconds that compiled code would have saved this process so far, by kind of work."""

_stored: dict[Hashable, bool] = {}
"""Whether the code was on disk when that was looked up first, which takes as long as a small call."""


_stored_at_first: dict[Hashable, bool] = {}
"""The same, for work that is not counted."""


def spent() -> dict[Hashable, float]:
    """Seconds that compiled code would have saved this process so far, by kind of work."""
    return dict(_spent)


def count(elsewhere: Mapping[Hashable, float]) -> None:
    """Count work that another process has done for this one.

    Args:
        elsewhere: seconds by kind of work.
    """
    for kind, seconds in elsewhere.items():
        _spent[kind] += seconds


def is_worth_it(kind: Hashable, seconds: float, compilation: float, is_stored: Callable[[], bool]) -> bool:
    """Count work that is about to be done, and say whether to do it by compiled code.

    Args:
        kind: of work; each is counted by itself.
        seconds: that the work takes interpreted; what compiled code takes is next to nothing.
        compilation: seconds that it takes to compile that code.
        is_stored: says whether it is on disk already.
    """
    _spent[kind] += seconds
    price = LOAD + (0.0 if "numba" in sys.modules else IMPORT)
    if _spent[kind] < price:
        return False
    if kind not in _stored:
        _stored[kind] = is_stored()
    _stored[kind] = _stored[kind] or _spent[kind] >= price + compilation
    return _stored[kind]


def pays_alone(kind: Hashable, seconds: float, compilation: float, is_stored: Callable[[], bool]) -> bool:
    """Whether work is worth compiled code by itself, whatever was done before.

    So that the same work gives the same numbers to the last digit as long as the process lives.

    Args:
        kind: of work.
        seconds: that all of it takes interpreted.
        compilation: seconds that it takes to compile that code.
        is_stored: says whether it is on disk already; asked once.
    """
    if seconds < IMPORT + LOAD:
        return False
    if kind not in _stored_at_first:
        _stored_at_first[kind] = is_stored()
    return _stored_at_first[kind] or seconds >= IMPORT + LOAD + compilation

"""The same done with many things, on several cores of this machine: a `map` whose parts run side by side.

What a diagnosis tries does not depend on what else it tries. Helpers are copies of this process (`fork`), so
that nothing has to be handed to them and what is compiled already is; what they come to is sent back, with
whatever there was before told by name. This process works on the same things meanwhile, and what it keeps in
mind stays for later. Results come in the order of the things and are what one process alone comes to, but for
rounding. Where a process cannot be copied safely everything is done here, one after the other.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from flexmodal.diagnosis.parallel.pool import TOKENS, Pool
from flexmodal.diagnosis.parallel.workers import number_of_workers

Item = TypeVar("Item")
Result = TypeVar("Result")


def parallel_map(call: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """What a function makes of each of some things, in their order, each as soon as it and those before are.

    Who asks for no more ends what is still going on.

    Args:
        call: whose results can be pickled, but for what they hold that `call` and `items` hold already. What
            else it does is lost.
        items: fewer than some thousands.

    Raises:
        FlexmodalError: a helper was killed; and whatever `call` raises, when that thing's turn comes.
    """
    todo = list(items)
    number = min(number_of_workers(), len(todo)) if _can_be_copied() and len(todo) <= TOKENS else 1
    if number < 2:
        yield from map(call, todo)
        return
    pool = Pool(call, todo)
    try:
        pool.start(number - 1)
        for turn in range(len(todo)):
            yield pool.result(turn)
    finally:
        pool.end()


def _can_be_copied() -> bool:
    """Whether a process with threads of libraries may be copied: on Linux these see to it."""
    return sys.platform == "linux"

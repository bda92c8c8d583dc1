"""How long a diagnosis may go on looking; what has been found by then is what it says."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress

from flexmodal.diagnosis.parallel.workers import is_helper
from flexmodal.errors import Fault, InvalidRequest

FOR_EFFECTS = 0.85
"""Part of the time in which effects are added to several. The rest is for asking which of them are sure, and
there even if what was cut off has lasted longer: a fit is not cut off in its midst."""


class OutOfTime(Exception):
    """The time is up; caught where what was found so far is known."""


class TimeLimit:
    """The seconds since it was made, while something counts them; without a limit they never run out."""

    def __init__(self, seconds: float | None = None, clock: Callable[[], float] = time.monotonic) -> None:
        """Start.

        Args:
            seconds: it takes at most; None for as long as it takes.
            clock: that tells seconds.
        """
        self.seconds, self._clock, self._start = seconds, clock, clock()
        self._until: float | None = None
        self.was_hit = False
        """Whether something was cut off."""

    @contextmanager
    def counting(self, part: float = 1.0, *, at_least: float = 0.0) -> Iterator[None]:
        """What is done here is cut off when a part of the time is up.

        Args:
            part: of all the time.
            at_least: part of it from now on that there is in any case, however late it has become.
        """
        if self.seconds is not None:
            self._until = self._start + part * self.seconds
            if at_least:
                self._until = max(self._until, self._clock() + at_least * self.seconds)
        try:
            yield
        finally:
            self._until = None

    def check(self) -> None:
        """Ask; called often.

        Raises:
            OutOfTime: something counts the time, and it is up.
        """
        if self._until is not None and self._clock() > self._until:
            self.was_hit = True
            raise OutOfTime

    def watching(self, advance: Callable[[str, float], None]) -> Callable[[str, float], None]:
        """The same as a function that is told of progress, which asks each time.

        Args:
            advance: called with what is being done and the part of it that is done.
        """

        def told(doing: str, part: float) -> None:
            self.check()
            if not is_helper():  # whose things are told of where their results are awaited
                advance(doing, part)

        return told

    def words(self) -> tuple[str, ...]:
        """A sentence for those who read the verdict, if something was cut off."""
        if not self.was_hit or self.seconds is None:
            return ()
        return (f"Looking was cut off after {self.seconds:g} s: with more time more may be named.",)


def cut_short(allowed: object) -> AbstractContextManager[None]:
    """What is done here ends where time is up, and all goes on with what was found by then.

    Args:
        allowed: whether it does; else whoever counts the time is told, as everywhere.
    """
    return suppress(OutOfTime) if allowed else nullcontext()


def limit_of(within: float | None) -> TimeLimit:
    """The limit that a caller asks for.

    Args:
        within: seconds; None for no limit.

    Raises:
        InvalidRequest: it is not a time.
    """
    if within is not None and not 0 < within < float("inf"):
        raise InvalidRequest(Fault("call", "within", f"{within!r}", "seconds above 0, or none for no limit"))
    return TimeLimit(within)

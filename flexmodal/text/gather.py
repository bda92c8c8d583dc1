"""The errors of several steps, raised together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from flexmodal.errors import InvalidInput, InvalidRequest


@dataclass
class Gathering:
    """What was wrong in steps that do not depend on each other.

    >>> gathering = Gathering()
    >>> with gathering.step():
    ...     pass  # what raises an InvalidInput here is kept for later
    >>> gathering.done()
    """

    errors: list[InvalidInput] = field(default_factory=list)

    @contextmanager
    def step(self) -> Iterator[None]:
        """A step whose faults are kept; what it was to give is missing afterwards."""
        try:
            yield
        except InvalidInput as error:
            self.errors.append(error)

    def done(self) -> None:
        """Raise every fault kept, each once; of the class of the errors where they have one class.

        Raises:
            InvalidInput: there are any; InvalidRequest where they are of several classes.
        """
        kinds = {type(error) for error in self.errors}
        faults = dict.fromkeys(fault for error in self.errors for fault in error.faults)
        if faults:
            raise (kinds.pop() if len(kinds) == 1 else InvalidRequest)(faults)

"""Names of the coordinates of a structure: what is added twice to one place has names of its own."""

from __future__ import annotations

from collections.abc import Sequence


class Coordinates(list[str]):
    """Names in their order, each once; another owner's of one that is there has the owner's before it."""

    def add(self, names: Sequence[str], owner: str) -> slice:
        """New ones at the end; returns their place.

        Args:
            names: as their owner calls them.
            owner: whose they are.
        """
        start = len(self)
        known = set(self)
        self += [_owned(name, owner) if name in known else name for name in names]
        return slice(start, len(self))

    def number(self, name: str, owner: str) -> int:
        """Place of one, as its owner calls it.

        Args:
            name: without the owner.
            owner: who asks; what is nobody's has this name for everyone.

        Raises:
            ValueError: there is none.
        """
        own = _owned(name, owner)
        return self.index(own if own in self else name)


def _owned(name: str, owner: str) -> str:
    return f"{owner}: {name}"

"""A mapping that cannot be changed, and that survives pickling and copying."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Generic, TypeVar

Value = TypeVar("Value")


class FrozenDict(Mapping[str, Value], Generic[Value]):
    """A read-only dictionary with string keys, in the order it was given.

    `types.MappingProxyType` would do, but cannot be sent to another process.
    """

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, Value] | None = None) -> None:
        self._items: dict[str, Value] = dict(items or {})

    def __getitem__(self, key: str) -> Value:
        """The value under `key`; KeyError without one."""
        return self._items[key]

    def __iter__(self) -> Iterator[str]:
        """The keys in order."""
        return iter(self._items)

    def __len__(self) -> int:
        """How many keys there are."""
        return len(self._items)

    def __repr__(self) -> str:
        """As a dictionary is shown."""
        return repr(self._items)

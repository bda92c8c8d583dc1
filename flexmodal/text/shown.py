"""How results show themselves: a line in a prompt, a small table in a notebook, a picture when asked."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from html import escape
from importlib import import_module
from typing import Any, ClassVar

_LONGEST = 160


class Shown(ABC):
    """A result that says in a few words what it is; it adds nothing to what the result holds."""

    _PICTURE: ClassVar[str] = ""
    """`module:function` that draws it. Pictures stand above results and are found by name."""

    @abstractmethod
    def _facts(self) -> Mapping[str, object]:
        """What there is to say of it, the first without its name."""

    def __repr__(self) -> str:
        """One line of at most some 200 characters."""
        parts = [f"{key} {_short(value)}" if key else _short(value) for key, value in self._facts().items()]
        return f"<{type(self).__name__} {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(key or 'name')}</th>"
            f"<td style='text-align:left'>{escape(_short(value))}</td></tr>"
            for key, value in self._facts().items()
        )
        return f"<table><caption>{escape(type(self).__name__)}</caption>{rows}</table>"

    def plot(self, **options: Any) -> Any:
        """Draw it; the matplotlib figure.

        Args:
            options: of the function that draws it.

        Raises:
            TypeError: there is no picture of such a result.
        """
        if not self._PICTURE:
            raise TypeError(f"there is no picture of a {type(self).__name__}")
        module, _, name = self._PICTURE.partition(":")
        return getattr(import_module(module), name)(self, **options)


def _short(value: object) -> str:
    text = f"{value:.4g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def several(names: Iterable[object], most: int = 8) -> str:
    """Some names, and how many there are besides.

    Args:
        names: to be listed.
        most: how many are written out.
    """
    listed = [str(name) for name in names]
    rest = f" and {len(listed) - most} more" if len(listed) > most else ""
    return " ".join(listed[:most]) + rest

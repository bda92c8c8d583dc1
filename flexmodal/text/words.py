"""Faults gathered for one file, and values put into words."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from flexmodal.errors import Fault

LONGEST = 60
"""Characters of a value that are quoted back."""


@dataclass(frozen=True)
class FaultList:
    """The faults of one file, gathered before anything is raised."""

    file: Path
    faults: list[Fault] = field(default_factory=list)

    def add(self, key: str, found: str, allowed: str) -> None:
        """Note one fault at `key` of the file.

        Args:
            key: inside the file; empty for the file as a whole.
            found: what stands there.
            allowed: what may stand there.
        """
        self.faults.append(Fault(str(self.file), key, found, allowed))


def shown(value: object) -> str:
    """A value of a TOML file as its author wrote it, shortened where it is long."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, int) and abs(value) > 10**LONGEST:
        return "a whole number too large to use"
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


def nearest(name: str, names: Iterable[str]) -> str:
    """`did you mean "…"? ` where one of `names` resembles `name`, else nothing.

    Args:
        name: a name that there is not.
        names: those there are.
    """
    close = difflib.get_close_matches(name[:LONGEST], list(names), n=1)
    return f'did you mean "{close[0]}"? ' if close else ""


def strange(name: str, names: Iterable[str]) -> str:
    """A name that there is not, quoted, with the one of `names` that it resembles.

    Args:
        name: a name that there is not.
        names: those there are.
    """
    close = difflib.get_close_matches(name, list(names), n=1)
    return repr(name) + (f" (did you mean {close[0]}?)" if close else "")


def listing(names: Iterable[str], empty: str = "there is none") -> str:
    """Names joined by commas.

    Args:
        names: what to join.
        empty: what to say where there is none.
    """
    return ", ".join(names) or empty


def enumeration(parts: Sequence[str]) -> str:
    """Joined by commas and an "and"."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def safe_name(name: str) -> str:
    """A name for a card or a file, from any name."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", name)[:60] or "robot"


def is_card_name(name: str) -> bool:
    """Whether a card may call a point or a posture so."""
    return re.fullmatch(r"[A-Za-z0-9_.-]+", name) is not None

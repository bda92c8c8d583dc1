"""What other packages register under an entry point; one that fails is named, and the rest goes on."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

_LOG = logging.getLogger("flexmodal")


def plugins(group: str, name: str | None = None) -> Iterator[tuple[EntryPoint, Any]]:
    """Entry points of a group that can be loaded, each with what it names.

    Args:
        group: of the entry points.
        name: those of this name only.
    """
    for point in entry_points(group=group) if name is None else entry_points(group=group, name=name):
        try:
            found = point.load()
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # even one that leaves the program as it is imported
            left_out(group, point.name, f"{point.value}: {type(error).__name__}: {error}")
        else:
            yield point, found


@cache
def left_out(group: str, name: str, why: str) -> None:
    """Say once, on standard error unless logging is set up otherwise, that a plug-in is left out.

    Args:
        group: of its entry point.
        name: of its entry point.
        why: what is wrong with it.
    """
    plain = " ".join("".join(sign if sign.isprintable() else " " for sign in why).split())[:300]
    _LOG.warning("flexmodal: the plug-in %s of %s is left out: %s", name, group, plain)

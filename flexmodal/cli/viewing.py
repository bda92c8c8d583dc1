"""The viewer as the command line finds it: by entry point, for it stands above this package."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from flexmodal.cli.printing import say
from flexmodal.cli.waiting import hush
from flexmodal.errors import MissingExtra
from flexmodal.plugins import left_out, plugins

_GROUP = "flexmodal.viewer"


def viewer(name: str) -> Callable[..., Any]:
    """One of the viewer's functions, "show_robot" or "show_outcome".

    Raises:
        MissingExtra: no viewer is installed.
    """
    for entry, found in plugins(_GROUP, name):
        if callable(found):
            function: Callable[..., Any] = found
            return function
        left_out(_GROUP, entry.name, f"{entry.value}: no function but {type(found).__name__}")
    raise MissingExtra("no viewer is installed; reinstall flexmodal, which brings flexmodal_viewer")


def announce(text: str) -> None:
    """Say where the viewer is to be seen; from then on it waits for its user.

    Args:
        text: what it says.
    """
    say(text, err=True)
    hush()

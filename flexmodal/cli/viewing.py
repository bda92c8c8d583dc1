"""The viewer as the command line finds it: by entry point, for it stands above this package."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

from flexmodal.errors import MissingExtra


def viewer(name: str) -> Callable[..., Any]:
    """One of the viewer's functions, "show_robot" or "show_outcome".

    Raises:
        MissingExtra: no viewer is installed.
    """
    for entry in entry_points(group="flexmodal.viewer", name=name):
        function: Callable[..., Any] = entry.load()
        return function
    raise MissingExtra("no viewer is installed; reinstall flexmodal, which brings flexmodal_viewer")

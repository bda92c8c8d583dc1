"""The viewer as the command line finds it: by entry point, for it stands above this package."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from flexmodal.cli.options import refuse_existing
from flexmodal.cli.printing import say
from flexmodal.cli.waiting import hush
from flexmodal.errors import MissingExtra
from flexmodal.plugins import left_out, plugins

_GROUP = "flexmodal.viewer"
PAGES = (".html", ".png", ".gif", ".mp4")
"""What a page can be written as."""


def viewer(name: str) -> Callable[..., Any]:
    """One of the viewer's functions, such as "show_robot" or "show_outcome".

    Raises:
        MissingExtra: no viewer is installed.
    """
    for entry, found in plugins(_GROUP, name):
        if callable(found):
            function: Callable[..., Any] = found
            return function
        left_out(_GROUP, entry.name, f"{entry.value}: no function but {type(found).__name__}")
    raise MissingExtra("no viewer is installed; reinstall flexmodal, which brings flexmodal_viewer")


def page_option(what: str) -> Callable[[Any], Any]:
    """`--page FILE`, to be checked by `refuse_page` before the work.

    Args:
        what: is written, for the help.
    """
    words = f"Write {what} as a page (.html), a picture (.png) or a film (.gif, .mp4)."
    return click.option("--page", type=click.Path(path_type=Path), metavar="PAGE", help=words)


def refuse_page(page: Path | None, force: bool) -> None:
    """Complain of what `--page` names before the work starts.

    Args:
        page: the file, if one was asked for.
        force: whether it may be replaced.
    """
    refuse_existing(page, force, PAGES, option="--page")


def deliver(name: str, found: object, *, page: Path | None, show: bool, force: bool, **more: Any) -> None:
    """Write what was found as a page and show it in the browser, either if it was asked for.

    Args:
        name: of the viewer's function.
        found: what it shows.
        page: the file.
        show: in the browser.
        force: whether the file may be replaced.
        more: what else the function takes.
    """
    if page is not None:
        viewer(name)(found, out=page, overwrite=force, announce=announce, **more)
    if show:
        viewer(name)(found, announce=announce, **more)


def announce(text: str) -> None:
    """Say where the viewer is to be seen; from then on it waits for its user.

    Args:
        text: what it says.
    """
    say(text, err=True)
    hush()

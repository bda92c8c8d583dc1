"""Optional packages: imported when they are asked for, and named with their extra where they are missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from flexmodal.errors import MissingExtra


def extra(module: str, name: str, what: str) -> Any:
    """Import a module of an extra.

    Args:
        module: to import.
        name: of the extra that brings it.
        what: what needs it, for the error.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        needed = f"{what} needs {module.split('.', maxsplit=1)[0]}"
        raise MissingExtra(f"{needed}: pip install 'flexmodal[{name}]'") from None

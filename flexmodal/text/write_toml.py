"""A table of plain values as TOML text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def toml_text(table: Mapping[str, Any], path: str = "") -> str:
    """A table as TOML, tables within it after its own keys; text is escaped.

    Args:
        table: plain values, lists and tables.
        path: the name of the table; empty for a whole file.
    """
    lines, later = [], []
    for key, value in table.items():
        name = f"{path}.{_key(key)}" if path else _key(key)
        if isinstance(value, Mapping):
            header = "" if _only_tables(value) else f"\n[{name}]\n"
            later.append(f"{header}{toml_text(value, name)}")
        elif isinstance(value, list | tuple) and value and isinstance(value[0], Mapping):
            later += [f"\n[[{name}]]\n{toml_text(entry, name)}" for entry in value]
        elif isinstance(value, list | tuple) and not value:
            lines.append(f"{_key(key)} = []")
        else:
            lines.append(f"{_key(key)} = {_value(value)}")
    return "".join(line + "\n" for line in lines) + "".join(later)


def _only_tables(table: Mapping[str, Any]) -> bool:
    """Whether a table needs no header: the tables in it name it in theirs."""
    return bool(table) and all(isinstance(value, Mapping) for value in table.values())


def _key(key: str) -> str:
    return key if key.replace("_", "").isalnum() and key.isascii() else _text(key)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(float(value)) if isinstance(value, float) else str(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(entry) for entry in value) + "]"
    return _text(str(value))


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")

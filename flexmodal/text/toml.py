"""A TOML file of reasonable size as a dictionary, or the fault that kept it from being read."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from flexmodal.errors import Fault
from flexmodal.text.reading import read_regular

LARGEST = 1_000_000
"""The most a TOML file may hold [bytes]."""

# tomllib takes time quadratic in the parts of a dotted key; sixteen are many more than any key needs.
DOTTED = re.compile(r"(?<![^\s.=\[\]{},])(?:[^\s.=\[\]{},#]++[ \t]*+\.[ \t]*+){16}")


def parse_toml(file: Path, *, kind: str) -> dict[str, Any] | Fault:
    """Read a TOML file.

    Args:
        file: the file.
        kind: what it should be, for the sentence ("a robot card").

    Returns:
        Its content, or the one fault that kept it from being read.
    """
    content = read_regular(file, limit=LARGEST, kind=kind)
    if isinstance(content, Fault):
        return content
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return Fault(str(file), "", f"a byte that is not UTF-8, at {error.start}", f"{kind} in UTF-8")
    if DOTTED.search(text):
        return Fault(str(file), "", "a key of more than 16 parts", f"{kind} in TOML")
    try:
        return tomllib.loads(text.replace("\r\n", "\n"))
    except (ValueError, RecursionError) as error:
        reason = "nested too deep" if isinstance(error, RecursionError) else str(error)
        return Fault(str(file), "", f"text that is not TOML: {reason}", f"{kind} in TOML")

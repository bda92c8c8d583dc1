"""Datasets of nodes, read by pyuff: places (15, 2411), trace lines (82), shapes (55).

pyuff cuts some of them at white space and some at columns, and says of a spoilt one no more than its number.
So each goes to it alone, in the layout that it reads, and what comes back is compared with what stands there.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign.uff.scan import NODES, SHAPE, Other
from flexmodal.text.words import FaultList

WORDS = {15: "nodes", 2411: "nodes", 82: "trace line", 55: "shape"}
MODES = (2, 3, 7)
"""Kinds of analysis of a dataset 55 that give modes: normal, complex of displacement, of velocity."""
_NAMES = 5
"""Identification lines of a shape."""
_EXPONENT = re.compile(rb"(?<=[0-9.])[dD](?=[-+ ]?\d)")


def key_of(other: Other) -> str:
    """The name of a dataset in faults, such as dataset 3 (82, trace line)."""
    return f"dataset {other.number} ({other.kind}, {WORDS[other.kind]})"


def read_nodal(other: Other, faults: FaultList) -> dict[str, Any] | None:
    """The fields of one dataset as pyuff names them; None where it is spoilt.

    Args:
        other: the dataset.
        faults: where faults go.
    """
    import pyuff

    with tempfile.TemporaryDirectory(prefix="flexmodal-") as folder:
        scratch = Path(folder) / "one.uff"
        scratch.write_bytes(_canonical(other))
        try:
            found = pyuff.UFF(str(scratch)).read_sets()
        except Exception:  # pyuff raises nothing narrower
            found = None
    if not isinstance(found, dict) or not _is_whole(other.kind, found):
        faults.add(key_of(other), "fields that cannot be read", f"the fields of a dataset {other.kind}")
        return None
    return found


def _canonical(other: Other) -> bytes:
    """The dataset alone: D exponents as E, no empty lines, names blanked, in which pyuff looks for tags."""
    lines = [line.rstrip(b"\r") for line in other.body.split(b"\n")]
    if other.kind == SHAPE:
        lines = [b"NONE".ljust(80)] * _NAMES + lines[_NAMES:]
    lines = [line for line in lines if line.strip()]
    if other.kind in NODES:  # pyuff joins the lines of these without anything between them
        lines = [b" " + line + b" " for line in lines]
    lines = [line if line.startswith(b"NONE") else _EXPONENT.sub(b"E", line) for line in lines]
    head = b"    -1\n" + f"{other.kind:6d}".encode().ljust(80) + b"\n"
    return head + b"".join(line + b"\n" for line in lines) + b"    -1\n"


def _is_whole(kind: int, found: dict[str, Any]) -> bool:
    """As many of everything as there are nodes, all of it finite."""
    if kind == SHAPE and found.get("analysis_type") not in MODES:
        return True
    names: tuple[str, ...] = ("node_nums", "r1", "r2", "r3") if kind == SHAPE else ("nodes",)
    if kind in NODES:
        names = ("node_nums", "disp_cs", "x", "y", "z")
    columns = [np.asarray(found.get(name, ())) for name in names]
    counts = {len(column) for column in columns}
    return counts != {0} and len(counts) == 1 and all(bool(np.all(np.isfinite(one))) for one in columns)

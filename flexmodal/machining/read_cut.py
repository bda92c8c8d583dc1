"""From the text of a cut's TOML file to a `Cut`."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from flexmodal.errors import Fault, InvalidCut
from flexmodal.files import path_or_shipped, shipped
from flexmodal.machining.cut import (
    CUTTER,
    ENGAGEMENT,
    FORCE,
    FRAME,
    MODE,
    Cut,
    CutFrame,
    Cutter,
    CuttingForce,
    Engagement,
    ToolMode,
    immersion_angles,
)
from flexmodal.machining.fields import Field, number, read_table, text
from flexmodal.text.toml import parse_toml
from flexmodal.text.words import FaultList, listing, nearest, shown

_KEYS = ("format", "title", "source", "cutter", "force", "engagement", "frame", "mode")
_BY_IMMERSION = {
    "immersion": Field(
        number(1e-9, 1.0), "a number above 0 (from 1e-9) and at most 1, radial depth over diameter"
    ),
    "milling": Field(text("up", "down"), '"up" or "down"'),
}
_OPTIONAL = _BY_IMMERSION | {key: replace(ENGAGEMENT[key], required=False) for key in ("entry", "exit")}
_EITHER = "immersion and milling, or entry and exit"
_TEXT = "some text, not empty"

Record = TypeVar("Record")


def read_cut(path: str | os.PathLike[str]) -> Cut:
    """Read the TOML file of a cut.

    Args:
        path: the file, or the name of a cut that ships, `aluminium`.

    Raises:
        InvalidCut: with every fault of the file at once.
    """
    file = Path(os.path.abspath(path_or_shipped(path, "cuts", ".toml")))
    content = parse_toml(file, kind="a cut")
    if isinstance(content, Fault):
        names = (
            ""
            if file.exists()
            else f"; or the name of a cut that ships: {', '.join(shipped('cuts', '.toml'))}"
        )
        raise InvalidCut(replace(content, allowed=content.allowed + names))
    faults = FaultList(file)
    _check_head(content, faults)
    cutter = _record(Cutter, content.get("cutter"), CUTTER, "cutter", faults)
    force = _record(CuttingForce, content.get("force"), FORCE, "force", faults)
    engagement = _engagement(content.get("engagement"), faults)
    frame = _record(CutFrame, content.get("frame"), FRAME, "frame", faults)
    modes = _modes(content.get("mode", []), faults)
    if faults.faults or cutter is None or force is None or engagement is None or frame is None:
        raise InvalidCut(faults.faults)
    return Cut(cutter, force, engagement, frame, modes, content["title"], content["source"])


def _check_head(content: Mapping[str, Any], faults: FaultList) -> None:
    for key in content:
        if key not in _KEYS:
            hint = nearest(key, _KEYS)
            faults.add(key, "an unknown key", f"{hint}the keys here are {listing(_KEYS)}")
    version = content.get("format")
    if type(version) is not int or version != 1:
        faults.add("format", "nothing" if version is None else shown(version), "1")
    for key in ("title", "source"):
        given = content.get(key)
        if not isinstance(given, str) or not given.strip():
            faults.add(key, "nothing" if given is None else shown(given), _TEXT)


def _record(
    kind: Callable[..., Record], content: Any, table: Mapping[str, Field], section: str, faults: FaultList
) -> Record | None:
    """A dataclass from its table; faults that only the whole shows are noted under the same file."""
    values = read_table(content, table, section, faults)
    if values is None:
        return None
    try:
        return kind(**values)
    except InvalidCut as error:
        faults.faults.extend(replace(fault, file=str(faults.file)) for fault in error.faults)
        return None


def _engagement(content: Any, faults: FaultList) -> Engagement | None:
    """Entry and exit as they stand, or from the immersion."""
    if not isinstance(content, Mapping):
        return _record(Engagement, content, ENGAGEMENT | _BY_IMMERSION, "engagement", faults)
    by_immersion = sorted(set(content) & set(_BY_IMMERSION))
    by_angles = sorted(set(content) & {"entry", "exit"})
    if bool(by_immersion) == bool(by_angles):
        faults.add("engagement", listing(by_immersion + by_angles, "neither of the two"), _EITHER)
    if bool(by_immersion) == bool(by_angles):  # say so, and judge the rest
        read_table(content, {**_without_angles(), **_OPTIONAL}, "engagement", faults)
        return None
    required = {key: replace(field, required=True) for key, field in _BY_IMMERSION.items()}
    table = ENGAGEMENT if by_angles else _without_angles() | required
    values = read_table(content, table, "engagement", faults)
    if values is None:
        return None
    if by_immersion:
        entry, leaving = immersion_angles(values.pop("immersion"), values.pop("milling"))
        values |= {"entry": entry, "exit": leaving}
    return _record(Engagement, values, ENGAGEMENT, "engagement", faults)


def _without_angles() -> dict[str, Field]:
    return {key: field for key, field in ENGAGEMENT.items() if key not in ("entry", "exit")}


def _modes(content: Any, faults: FaultList) -> tuple[ToolMode, ...]:
    if not isinstance(content, list):
        faults.add("mode", shown(content), "tables [[mode]]")
        return ()
    found = [_record(ToolMode, one, MODE, f"mode[{place}]", faults) for place, one in enumerate(content)]
    return tuple(mode for mode in found if mode is not None)

"""From pydantic's complaints about a TOML file to sentences, by what the schema says may stand there.

A field or a type of the schema says it in its `description`; without one, what its table says holds.
pydantic is slow to load: only the schemas import it, and they are imported when a file is read.
"""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from flexmodal.text.words import FaultList, listing, nearest, shown

Model = TypeVar("Model")


class Contradiction(ValueError):
    """Keys of one table that do not go together; raised by a validator of a schema."""

    def __init__(self, key: str, found: str, allowed: str) -> None:
        super().__init__(found)
        self.key, self.found, self.allowed = key, found, allowed


def validated(model: type[Model], content: Mapping[str, Any], faults: FaultList) -> Model | None:
    """A file's content as its schema, which has a field `format`.

    Args:
        model: the schema, a pydantic model.
        content: what stands in the file.
        faults: where a fault for each of pydantic's complaints goes.

    Returns:
        The content; None where it is not what the schema says.
    """
    from pydantic import ValidationError

    schema: Any = model
    try:
        table: Model = schema.model_validate(content)
    except ValidationError as error:
        seen: set[str] = set()
        for one in error.errors(include_url=False):
            key, found, may = _sentence(model, one)
            if key not in seen:
                faults.add(key, found, may)
                seen.add(key)
        return None
    if type(content["format"]) is not int:  # true and 1.0 equal 1
        faults.add("format", shown(content["format"]), allowed(model, ["format"]))
    return table


def allowed(model: type, location: Sequence[str | int]) -> str:
    """What may stand at a place of a file, such as `["joint", "q1", "stiffness"]`.

    Args:
        model: the schema, a pydantic model.
        location: keys and numbers from the file to the place.
    """
    said = "a table"
    for kind, own in _descent(model, location):
        keys = _keys(kind)
        said = own or (f"a table with {listing(keys)}" if keys and kind is not model else said)
    return said


def _sentence(model: type, error: Mapping[str, Any]) -> tuple[str, str, str]:
    """Key, what was found there, and what is allowed."""
    is_name = bool(error["loc"]) and error["loc"][-1] == "[key]"
    location, nested = _without_tags(model, [part for part in error["loc"] if part != "[key]"])
    key, kind = _key(location), error["type"]
    if nested:
        return key, "something else", allowed(model, location)
    if kind == "extra_forbidden":
        names = _keys([step for step, _ in _descent(model, location[:-1])][-1])
        hint = nearest(str(location[-1]), names)
        return key, "an unknown key", f"{hint}the keys here are {listing(names)}"
    if kind == "value_error" and isinstance(error["ctx"]["error"], Contradiction):
        odd = error["ctx"]["error"]
        return ".".join(part for part in (key, odd.key) if part), odd.found, odd.allowed
    if is_name:
        table = [step for step, _ in _descent(model, location[:-1])][-1]
        name = _described(get_args(table)[0]) if get_origin(table) is dict else ""
        return key, f"the name {shown(location[-1])}", name or allowed(model, location[:-1])
    found = "nothing" if kind == "missing" else shown(error["input"])
    if kind == "too_short" and not error["input"] and len(location) == 1:
        found = "no table"
    return key, found, allowed(model, location)


def _without_tags(model: type, location: list[str | int]) -> tuple[list[str | int], bool]:
    """The place up to the first choice between kinds, and whether the complaint is of something in it."""
    for depth in range(1, len(location)):
        steps = [kind for kind, _ in _descent(model, location[:depth])]
        if get_origin(steps[-1]) in (Union, types.UnionType):
            return location[:depth], len(location) > depth + 1
    return location, False


def _descent(model: type, location: Sequence[str | int]) -> Iterator[tuple[Any, str]]:
    """The type at each step from the file to the place, and what it says of itself."""
    kind: Any = model
    yield kind, ""
    for part in location:
        fields = {field.alias or name: field for name, field in getattr(kind, "model_fields", {}).items()}
        if fields:
            if part not in fields:
                return
            kind, said = fields[str(part)].annotation, fields[str(part)].description or ""
        elif get_origin(kind) in (dict, list):
            kind = get_args(kind)[-1]
            said = _described(kind)
        else:
            return
        kind = _plain(kind)
        yield kind, said


def _plain(kind: Any) -> Any:
    """A type without what is annotated to it and without None."""
    if get_origin(kind) is Annotated:
        return _plain(get_args(kind)[0])
    if get_origin(kind) in (Union, types.UnionType):
        others = [one for one in get_args(kind) if one is not type(None)]
        return _plain(others[0]) if len(others) == 1 else kind
    return kind


def _described(kind: Any) -> str:
    """The description annotated to a type, if any."""
    notes = get_args(kind)[1:] if get_origin(kind) is Annotated else ()
    return next((note.description for note in notes if getattr(note, "description", None)), "")


def _keys(kind: Any) -> list[str]:
    """The keys that a table may have; none for what is no table of the schema."""
    return [field.alias or name for name, field in getattr(kind, "model_fields", {}).items()]


def _key(location: Sequence[str | int]) -> str:
    """`posture[0].q.q1` from its parts."""
    key = ""
    for part in location:
        key += f"[{part}]" if isinstance(part, int) else f"{'.' if key else ''}{part}"
    return key

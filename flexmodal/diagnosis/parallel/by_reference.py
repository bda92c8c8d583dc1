"""What is sent from a copy of a process to that one: what both hold already by its number, the rest whole."""

from __future__ import annotations

import copyreg
import io
import pickle
from dataclasses import fields, is_dataclass
from functools import partial
from types import FunctionType, MethodType
from typing import Any

_PLAIN = (str, bytes, int, float, complex, bool, type(None), type)


def sent(one: object, known: dict[int, Any]) -> bytes:
    """An object as bytes.

    Args:
        one: any that can be pickled, but for what is known.
        known: objects that were there before the process was copied, by number.

    Raises:
        pickle.PicklingError: something in it cannot be pickled; or `TypeError` or `AttributeError`.
    """
    buffer = io.BytesIO()
    _Sent(buffer, known).dump(one)
    return buffer.getvalue()


def received(told: bytes, known: dict[int, Any]) -> Any:
    """The object again.

    Args:
        told: the bytes.
        known: see `sent`.
    """
    return _Received(io.BytesIO(told), known).load()


def held_by(*roots: object) -> dict[int, Any]:
    """All that some objects hold, by number: in fields, containers, and what functions close over.

    Args:
        roots: the objects, which are among it.
    """
    found: dict[int, Any] = {}
    todo = list(roots)
    while todo:
        one = todo.pop()
        if id(one) in found or isinstance(one, _PLAIN):
            continue
        found[id(one)] = one
        if isinstance(one, dict):
            todo += [*one.keys(), *one.values()]
        elif isinstance(one, (tuple, list, set, frozenset)):
            todo += one
        elif isinstance(one, partial):
            todo += [one.func, one.args, one.keywords]
        elif isinstance(one, MethodType):
            todo.append(one.__self__)
        elif isinstance(one, FunctionType):
            todo += [cell.cell_contents for cell in one.__closure__ or () if _is_filled(cell)]
        elif type(one).__module__.startswith("flexmodal") and hasattr(one, "__dict__"):
            todo += vars(one).values()
    return found


class _Sent(pickle.Pickler):
    """Pickles; what was there before the process was copied by its number."""

    def __init__(self, file: io.BytesIO, known: dict[int, Any]) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self._known = known

    def persistent_id(self, obj: Any) -> int | None:
        return id(obj) if id(obj) in self._known else None

    def reducer_override(self, obj: Any) -> Any:
        """Of what has fields these alone: what else it keeps in mind follows from them."""
        if not is_dataclass(obj) or isinstance(obj, type) or not hasattr(obj, "__dict__"):
            return NotImplemented
        own = vars(obj)
        state = {field.name: own[field.name] for field in fields(obj) if field.name in own}
        return copyreg.__newobj__, (type(obj),), state  # type: ignore[attr-defined]  # typeshed lacks it


class _Received(pickle.Unpickler):
    """The other way."""

    def __init__(self, file: io.BytesIO, known: dict[int, Any]) -> None:
        super().__init__(file)
        self._known = known

    def persistent_load(self, pid: Any) -> Any:
        return self._known[pid]


def _is_filled(cell: Any) -> bool:
    try:
        cell.cell_contents  # noqa: B018  # which raises where there is nothing yet
    except ValueError:
        return False
    return True

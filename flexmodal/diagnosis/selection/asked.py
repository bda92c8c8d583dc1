"""Effects that a caller names, with their places or without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from flexmodal.diagnosis.effects import Context, Effect, catalogue
from flexmodal.diagnosis.selection.decision import Asked
from flexmodal.errors import Fault, InvalidRequest


def asked_of(effects: Sequence[str] | None) -> Asked | None:
    """Names with the places that were named along, `NAME` or `NAME@WHERE`; none for the whole catalogue.

    Raises:
        InvalidRequest: an effect that is not in the catalogue.
    """
    if effects is None:
        return None
    found: dict[str, tuple[str, ...]] = {}
    for one in effects:
        name, _, where = one.partition("@")
        found[name] = (*found.get(name, ()), *([where] if where else []))
    catalogue(list(found))  # says what is unknown
    return found


def effects_of(asked: Asked | None, context: Context) -> tuple[Effect, ...]:
    """The effects that are looked for, those that were named with places in these alone.

    Args:
        asked: what was named; None for the whole catalogue.
        context: whose places there are.

    Raises:
        InvalidRequest: a place where an effect cannot sit.
    """
    known = catalogue(None if asked is None else list(asked)).values()
    if asked is None:
        return tuple(known)
    faults = [
        Fault("call", "effects", f"{effect.name}@{where}", ", ".join(effect.places(context)))
        for effect in known
        for where in asked[effect.name]
        if where not in effect.places(context)
    ]
    if faults:
        raise InvalidRequest(faults)
    return tuple(_in_places(effect, asked[effect.name]) for effect in known)


def _in_places(effect: Effect, places: tuple[str, ...]) -> Effect:
    return replace(effect, places=lambda context: places) if places else effect

"""Effects that free functions alone tell, where no law of the catalogue explains what is missing.

Of the only place that explains everything, or of several that do so together and of which each can be told
from all others. What laws named in other places stays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from flexmodal.diagnosis.lawfree.effects_at import CLASSES_OF
from flexmodal.diagnosis.lawfree.result import Findings, Found
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.selection.confidence import AGREES, ALONE
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs

Key = tuple[str, str]
Search = Callable[[FittedFrfs, Key], Sequence[FittedFrfs]]
"""Models with an effect more than one has, at a place."""


def told_of(look: Findings) -> Mapping[Key, float]:
    """Names and places of the effects that the functions of a look tell, and how sure each is.

    Args:
        look: nothing is told where its places do not explain everything.
    """
    told = [(place.tells, place) for place in look.found if look.explains]
    return {
        (name, place.where): 1 / (1 + (AGREES if _is_of_class(name, place) else ALONE))
        for name, place in told
        if name is not None
    }


def _is_of_class(name: str, found: Found) -> bool:
    return any(one.name in CLASSES_OF.get(name, ()) for one in found.classes)


def wanted(
    told: Mapping[Key, float], named: Sequence[Key], *, lone: bool, explained: bool
) -> tuple[Key, ...]:
    """What is named in the end; nothing if that is what laws named, or these speak against what is told.

    Args:
        told: effects that functions tell.
        named: those that laws did.
        lone: whether one place explains everything. What laws name there otherwise gives way, as laws are
            wide and may do what no effect of their name does; and if laws leave more than noise what they
            name elsewhere, which makes up for that.
        explained: whether laws explain everything.
    """
    places = {where for _, where in told}
    against = [key for key in named if key not in told and key[1] in places]
    missing = [key for key in told if key not in named]
    elsewhere = [key for key in named if key[1] not in places]
    if not lone:
        return () if explained or against or not missing else (*named, *missing)
    if not explained:
        return tuple(told) if not named or (not missing and len(named) > len(told)) else ()
    return (*told, *elsewhere) if against else ()


def fitted_with(
    keys: Sequence[Key],
    root: FittedFrfs,
    tried: Sequence[FittedFrfs],
    search: Search,
    far: Callable[..., float],
) -> FittedFrfs | None:
    """The best model with some effects, of those that were tried, or else built up; None if one has no fit.

    Args:
        keys: names and places of the effects.
        root: the robot re-tuned.
        tried: fitted models.
        search: for one effect more.
        far: how far a model is from the measurement.
    """
    if same := _with(keys, tried):
        return min(same, key=far)
    model = root
    for key in keys:
        if not (found := _with((*model.hypothesis.keys, key), search(model, key))):
            return None
        model = min(found, key=far)
    return model


def _with(keys: Sequence[Key], models: Sequence[FittedFrfs]) -> list[FittedFrfs]:
    """Those that have some effects and nothing else, such as a mode with no structure."""
    plain = [one for one in models if one.key[0] != UNSTRUCTURED]
    return [one for one in plain if set(one.hypothesis.keys) == set(keys)]

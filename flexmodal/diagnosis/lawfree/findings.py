"""From a law-free look to its findings: what it means, and in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.diagnosis.lawfree.changing import changing
from flexmodal.diagnosis.lawfree.curve import classes_of, curve_of, undecided
from flexmodal.diagnosis.lawfree.losses import loss_of
from flexmodal.diagnosis.lawfree.pursuit import LawFree
from flexmodal.diagnosis.lawfree.reading_ports import CHANNEL
from flexmodal.diagnosis.lawfree.result import Class, Curve, Findings, Found, PlaceTried
from flexmodal.diagnosis.lawfree.sighting import Sighting
from flexmodal.diagnosis.lawfree.tells import told_by
from flexmodal.identification import Observations
from flexmodal.report.words import percent
from flexmodal.text.words import enumeration

OF_CLASS = 0.9
"""Part of the curve that a class has to take: 0.98 and more for a link bent at one hinge and a foundation on
a block, 0.7 and 0.8 for a neighbour and a hose, which are no effects of the catalogue."""


def summed_up(look: LawFree, seen: Observations | None = None) -> Findings:
    """Findings of a look.

    Args:
        look: what it came to.
        seen: all that was looked at, by which a sensor may be told that lies otherwise in each posture.
    """
    found = tuple(_found(look, number, seen) for number in range(len(look.members)))
    places = tuple(_place(one) for one in look.first.sightings)
    says, known = _words(look, found), len(look.whole.profile.model.root.space)
    return Findings(
        look.believed,
        look.whole.judged,
        places,
        found,
        look.explains,
        look.needed,
        says,
        look.whole.state.x[:known],
    )


def _found(look: LawFree, number: int, seen: Observations | None) -> Found:
    member, port = look.members[number], look.members[number].port
    curve: Curve | None = None
    classes: tuple[Class, ...] = ()
    if look.needed and look.whole.profile.model.cells == 1 and not port.kind.drops:
        curve, metric = curve_of(look.whole, number)
        every = undecided(classes_of(look.whole, curve, metric, number))
        classes = tuple(one for one in every if one.share >= OF_CLASS)
    alike = tuple(one.key for one in member.alike)
    rubs = look.needed and port.kind.by_blow and port.kind.reads is None
    loss = loss_of(look.whole, number) if rubs else None
    free = _free(look.whole, number)
    found = Found(
        port.kind.name, port.where, port.kind.says, member.without, alike, curve, classes, loss, free
    )
    if seen is not None and port.kind is CHANNEL and found.is_apart and look.explains:
        found = replace(found, changes=_changes(look, port.where, seen))
    return replace(found, tells=told_by(found))


def _changes(look: LawFree, where: str, seen: Observations) -> str | None:
    """Where it is the only place, so that the robot alone foretells the motion there."""
    root = look.whole.profile.model.root
    known, point = look.whole.state.x[: len(root.space)], root.context.point(where).id
    return changing(seen, root, known, point) if len(look.members) == 1 else None


def _place(one: Sighting) -> PlaceTried:
    kind = one.port.kind
    free = _free(one, len(one.ports) - 1)
    return PlaceTried(kind.name, one.port.where, kind.says, one.misfit, one.apart, one.unknowns, free)


def _free(one: Sighting, number: int) -> FreeFunction | None:
    """Of one of the ports."""
    model, x, kind = one.profile.model, one.state.x, one.ports[number].kind
    if model.cells != 1 or kind.drops:
        return None
    own, placed = model.spans[number], model.hypothesis.placed[number - len(one.ports)]
    values = model.hypothesis.values_of(placed, model.space.values(x))
    known = len(model.root.space)
    names = [one.name.removeprefix(f"{placed.label}.") for one in model.space.parameters[known:]]
    return FreeFunction(
        model.observations.axis.frequency[model.lines],
        one.state.z[0, own] * model.size[own],
        {name: values[name] for name in names if name in values},
        x[:known],
        _information(one, own, model.size[own]) if kind.informs else None,
        kind.turns,
    )


def _information(
    one: Sighting, own: slice, size: Float[np.ndarray, "function line"]
) -> Complex[np.ndarray, "line function function"]:
    """Of one port's functions in their unit, all others as they are."""
    zz = one.profile.equations(one.state, held=True).zz[0][:, own, own]
    return np.asarray(zz / size.T[:, :, None] / size.T[:, None, :])


def _words(look: LawFree, found: tuple[Found, ...]) -> str:
    if not look.needed:
        return "Without a law, no place takes more away than noise would: nothing stands out anywhere."
    where = enumeration([f"{one.says} ({one.where})" for one in found])
    free = "its function" if len(found) == 1 else "their functions"
    says = [
        f"Without a law, the data point to {where}: with {free} free the misfit falls to "
        f"{percent(look.whole.judged / look.believed)} of what it was"
        + ("." if look.explains else ", which is not enough: what is missing is not at these places alone.")
    ]
    for one in found:
        subject = "The function" if len(found) == 1 else f"That of {one.port}@{one.where}"
        others = [f"{kind}@{place}" for kind, place in one.alike if (kind, place) != (one.port, one.where)]
        if others:
            which = "it" if len(found) == 1 else f"{one.port}@{one.where}"
            says.append(f"These data cannot tell {which} from {', '.join(others)}.")
        if one.classes:
            says.append(f"{subject} is of this class: {one.classes[0].name}.")
        elif one.curve is not None:
            says.append(f"{subject} is of no class that is known here.")
        if look.explains and one.tells is not None:
            says.append(f"{subject} alone says: {one.tells.replace('_', ' ')}.")
    return " ".join(says)

"""From a law-free look to what it says."""

from __future__ import annotations

from flexmodal.diagnosis.lawfree.curve import classes_of, curve_of, undecided
from flexmodal.diagnosis.lawfree.look import LawFree, Sighting
from flexmodal.diagnosis.lawfree.result import Class, Curve, Findings, PlaceTried

SOUND = 1.6
"""Misfit up to which a port is said to explain what is missing: 0.6 if perfect. Tuned on single
effects of the virtual rig, whose true places had 0.6 to 1.5; how sharply was not measured."""
GAINS = 1.25
"""Times by which the misfit of the robot alone has to exceed that of the best port."""
OF_CLASS = 0.9
"""Part of the curve that a class has to take: 0.98 and more for a link bent at one hinge and a foundation on
a block, 0.7 and 0.8 for a neighbour and a hose, which are no effects of the catalogue."""


def summed_up(look: LawFree) -> Findings:
    """Findings of a look."""
    best, alone = look.best, look.believed
    needed = alone > GAINS * best.judged
    explains = needed and best.judged <= SOUND
    curve: Curve | None = None
    classes: tuple[Class, ...] = ()
    if needed and not best.port.kind.by_blow and not best.port.kind.drops:
        curve, metric = curve_of(best)
        classes = tuple(one for one in undecided(classes_of(best, curve, metric)) if one.share >= OF_CLASS)
    places = tuple(_place(one) for one in look.sightings)
    alike = tuple(_place(one) for one in look.alike)
    return Findings(
        alone, places, alike, explains, needed, curve, classes, _words(look, explains, needed, classes)
    )


def _place(one: Sighting) -> PlaceTried:
    kind = one.port.kind
    return PlaceTried(kind.name, one.port.where, kind.says, one.misfit, one.apart, one.unknowns)


def _words(look: LawFree, explains: bool, needed: bool, classes: tuple[Class, ...]) -> str:
    best = look.best
    if not needed:
        return "Without a law, no place takes more away than noise would: nothing stands out anywhere."
    says = f"Without a law, the data point to {best.port.kind.says} ({best.port.where})"
    says += (
        f": with its function free the misfit falls from {look.believed:.1f} to {best.judged:.1f} × the noise"
    )
    says += "." if explains else ", which is not enough: what is missing is not at one of these places alone."
    others = [one for one in look.alike if one is not best]
    if others:
        names = ", ".join(one.port.label for one in others)
        says += f" These data cannot tell it from {names}."
    if classes:
        says += f" The function has the form of this class: {classes[0].says}."
    elif not best.port.kind.by_blow and not best.port.kind.drops:
        says += " The function is of no class that is known here."
    return says

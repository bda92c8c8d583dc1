"""What decides in a diagnosis of FRFs, each figure with the margin within which nothing is decided."""

from __future__ import annotations

from collections.abc import Mapping

from flexmodal.diagnosis.lawfree.result import Found
from flexmodal.diagnosis.selection.comparison import MARGIN
from flexmodal.diagnosis.selection.decision import SIGNIFICANT, Answer, reaches

FORCE, FORCE_MARGIN = 1.6, 0.1
"""Change of FRFs with the force of the blow, over their noise, from which a structure is not linear."""
WORTH, WORTH_MARGIN = 0.025, 0.005
"""Part of the sum of squares that an effect has to take away besides."""
ANOTHER, ANOTHER_MARGIN = 0.33, 0.02
"""The same for every further effect: what a good but not perfect model leaves is not another effect."""
LARGER_PART, NEARLY_ALL = 0.5, 0.9
"""Part of the disagreement that an effect takes to be named where its law is not quite the catalogue's; the
second where no curve tells its class, or other places cannot be told from its own."""
LARGER_PART_MARGIN = 0.05
"""Of the first, where effects that take less have to leave clearly nothing but noise."""
ALL_BUT_LITTLE = 0.97
"""The same where the curve is of no class that is known, so that it speaks for no effect."""
MOST_OF_REST, SURE, IN_STEAD = 0.6, 0.8, 3
"""Part of what the others leave above the noise that one of several effects takes to be named whatever else
is missing, its confidence among what else might be in its place, and how many of those are fitted at most:
what was not far behind when it was added, or else the nearest. Of the effects in the models of 18 campaigns
that were looked at, all with more than noise left, 34 that are there took 0.36 to 0.998; eight that are not
took at most 0.50, or were not so sure."""
NOT_FAR_BEHIND, LIKELY = 1.5, 2
"""Times what an effect left when it was added that another one left, to be tried in its place once others are
there, and how many of these are."""
REMEMBERED = 4
"""Effects of the last comparison that are tried beside the one that was added, at most."""
CLEARLY = 2.0
"""Times by which the misfits of all other places have to exceed that of a single effect with its function
free, for it to be named where it leaves more than noise."""
ONCE_MORE = 2
"""Starts of an effect that are followed closely where another one that can do more is enough."""
HALF = 0.5
"""Part of the disagreement above the noise that a law leaves at most, for no wider one to be tried, and
beside several effects nothing elsewhere."""
HARDLY = 0.03
"""The same of an effect whose law is all but right: what is left may be due to it, not to something else."""
LAW_LEAVES = 2.0
"""Times what a place with free functions leaves from which an effect in it has too narrow a law."""
NEARER = 0.999
"""Part of the cost that a model may have for another search beside the same effects to be worth it."""
NOTHING_LEFT = 0.8
"""Misfit of one place without a law beside which no second effect is looked for; 0.6 if perfect. Of 27
campaigns with two to five effects that were looked at, three came to that; none of their second effects was
found either way."""
FLOOR_REACHED = 1.4
"""Distance of a model from the measurement, over that of the noise, that needs no explanation; a
perfect one is somewhat above 1, since what repeats share is not in the noise."""
CLOSE = 1.15
"""The same that is clearly nothing but noise, however little believable what leaves it is."""
PERFECT = 1.05
"""The same that more than half of single effects with a law of their own leave at most. Where an elastic one
leaves more, what touches its place is tried as well."""
NOTHING_HIDDEN = 1.1
"""The same up to which no further effect is looked for. Of 101 campaigns whose effects were all named, 71
ended below; of six that lacked one and ended below 1.25, three."""
EXPLAINED = 2.0
"""The same that a strong effect may leave."""
LEFT = 0.03
"""Part of the disagreement above the noise that may be left then."""
FROM_BEYOND, FROM_BEYOND_MARGIN = 0.5, 0.05
"""Part of how far parameters are from belief that the first effect takes away, where it does no more."""
THERE, THERE_MARGIN = 3.0, 0.3
"""Standard errors from nothing, from which what makes an effect is there."""
FLOOR_MARGIN = 0.035
"""The last 7 % up to these three are the border, which is told: a threshold with this relative margin."""


def least_share(met: Mapping[tuple[str, str], Found]) -> float:
    """Part of the disagreement that effects take at least, to be named where they leave more than noise.

    Args:
        met: the place without a law that each of them sits at, by name and place.
    """
    if any(one.curve is not None and not one.classes for one in met.values()):
        return ALL_BUT_LITTLE
    return LARGER_PART if all(one.surely(name) for (name, _), one in met.items()) else NEARLY_ALL


def at_the_noise(over: float, rest: float) -> Answer:
    """Whether a model is at the noise, or as near as a strong effect has to come.

    Args:
        over: its distance from the measurement over that of the noise.
        rest: part of the first model's disagreement above the noise that it leaves.
    """
    distance = min(over / FLOOR_REACHED, max(over / EXPLAINED, rest / LEFT))
    return reaches(-distance, FLOOR_MARGIN - 1, FLOOR_MARGIN)


def reached(over: float, rest: float, force: Answer) -> Answer:
    """Whether a model is at the noise; one that knows nothing of force is not, where FRFs change with it.

    Args:
        over: its distance from the measurement over that of the noise.
        rest: part of the first model's disagreement above the noise that it leaves.
        force: whether FRFs change with the force of the blow and the model does not.
    """
    return min(at_the_noise(over, rest), Answer(Answer.YES - force))


def takes_enough(taken: float, before: float, after: float, number: int) -> Answer:
    """Whether an effect takes enough of the misfit away.

    Args:
        taken: part of the sum of squares.
        before: −ln of the parameters' prior without it, up to a constant: how far they are from belief [nat].
        after: the same with it; an effect need not take much if that gains enough.
        number: how many effects were added before.
    """
    part = 1 - after / before if before > 0 else 0.0
    back = reaches(before - after, SIGNIFICANT, MARGIN), reaches(part, FROM_BEYOND, FROM_BEYOND_MARGIN)
    least = (ANOTHER, ANOTHER_MARGIN) if number else (WORTH, WORTH_MARGIN)
    return max(reaches(taken, *least), min(back))

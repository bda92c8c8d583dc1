"""Several ports at once: one after the other, each looked for again beside the others.

As in a matching pursuit (Mallat and Zhang, IEEE Trans. Signal Process. 41, 1993), but with all functions and
the robot's own parameters fitted together in every round. A place that was found while others were missing
may have been taken for one of them, so that each is looked for again among those that did nearly as well; a
port that nobody misses goes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.diagnosis.lawfree.effects_at import holds
from flexmodal.diagnosis.lawfree.look import SOUND, Field
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.screening import ALIKE
from flexmodal.diagnosis.lawfree.sighting import Round, Sighting
from flexmodal.diagnosis.time_limit import OutOfTime

GAINS = 1.25
"""Times by which the misfit without any port, or without one of several, has to exceed that with it."""
FURTHER = 1.1
"""The same for one more port on the way: what two explain together each of them may hardly touch."""
MOST = 5
"""Ports at once."""
RIVALS = 4
"""Other places that are tried again for each port."""
Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class Member:
    """One of the ports that were found."""

    port: Port
    without: float
    """Misfit of the others alone; of those found before it where time was up."""
    alike: tuple[Port, ...]
    """What cannot be told from it beside the others, itself included; the simplest first."""


@dataclass(frozen=True, eq=False)
class LawFree:
    """What a law-free look found."""

    believed: float
    """Misfit of the re-tuned robot without any port."""
    first: Round
    """One port alone."""
    whole: Sighting
    """All ports that are needed, in the order in which they were found."""
    members: tuple[Member, ...]
    """Each of them."""

    @property
    def needed(self) -> bool:
        """Whether anything is gained by a port."""
        return self.believed > GAINS * self.whole.judged

    @property
    def explains(self) -> bool:
        """Whether the ports take what is missing down to the noise."""
        return self.needed and self.whole.judged <= SOUND


def alone(field: Field, advance: Progress = lambda part: None) -> LawFree:
    """Look for one place of what is missing without a law for it.

    Args:
        field: what is looked at.
        advance: called with the part that is done.
    """
    first = field.round(advance=advance)
    members = (Member(first.best.port, field.bare, tuple(one.port for one in first.alike)),)
    return LawFree(field.bare, first, first.best, members)


def pursued(field: Field, found: LawFree, advance: Progress = lambda part: None) -> LawFree:
    """Look for several places, where one is not enough; those found by then, where time is up.

    Args:
        field: what is looked at.
        found: the look for one place.
        advance: called with the part that is done.
    """
    whole, rounds, others, came = found.whole, [found.first], Others(field), [field.bare]

    def further(part: float) -> None:
        advance((len(rounds) - 1) / MOST)

    gained = field.bare >= FURTHER * whole.judged
    try:
        while gained and whole.judged > SOUND and len(whole.ports) < MOST:
            tried = field.round(whole, advance=further)
            gained = bool(tried.sightings) and whole.judged >= FURTHER * tried.best.judged
            if gained:
                rounds.append(tried)
                came.append(whole.judged)
                whole = tried.best  # which stands if time is up meanwhile
                whole = _again(whole, rounds, others, further)
        least = _narrowed(field, _needed(whole, others), others, further)
        if len(least.ports) == 1 and least.port.key == found.whole.port.key:
            return found
        return LawFree(field.bare, found.first, *_settled(field, least, rounds, others, further))
    except OutOfTime:
        if len(whole.ports) == 1:
            return found
        return LawFree(field.bare, found.first, whole, _unsettled(whole, rounds, came))


def _unsettled(whole: Sighting, rounds: Sequence[Round], without: Sequence[float]) -> tuple[Member, ...]:
    """What is known of each port when time is up: what it was alike when it was found."""
    alike = {tried.best.port.key: tuple(one.port for one in tried.alike) for tried in rounds}
    told = zip(whole.ports, without, strict=True)
    return tuple(Member(port, before, alike.get(port.key, (port,))) for port, before in told)


def _rivals(rounds: list[Round], port: Port) -> list[Port]:
    """What did nearly as well when a port was found; what did well at first."""
    found: dict[tuple[str, str], Port] = {port.key: port}
    for tried in rounds:
        names = [one.port for one in tried.sightings]
        if port.key in [one.key for one in names] or tried is rounds[0]:
            for other in names[:RIVALS]:
                found.setdefault(other.key, other)
    return list(found.values())


class Others:
    """Ports without one of them, fitted, and with another in its stead; each once in a pursuit."""

    def __init__(self, field: Field) -> None:
        """Nothing is known yet.

        Args:
            field: what is looked at.
        """
        self._field = field
        self._known: dict[tuple[Port, ...], Sighting] = {}
        self._tried: dict[tuple[tuple[Port, ...], Port], list[Sighting]] = {}

    def beside(self, whole: Sighting, port: Port) -> Sighting | None:
        """All ports but one; None where there are no others.

        Args:
            whole: of all ports.
            port: the one to leave out.
        """
        rest = tuple(one for one in whole.ports if one.key != port.key)
        if rest and rest not in self._known:
            self._known[rest] = self._field.sighted(rest)
        return self._known[rest] if rest else None

    def round(self, whole: Sighting, port: Port, tried: Sequence[Port], advance: Progress) -> Round:
        """Ports in the stead of one, beside the others.

        Args:
            whole: of all ports.
            port: the one to leave out.
            tried: those in its stead, itself perhaps among them.
            advance: called with the part that is done.
        """
        rest = self.beside(whole, port)
        there = () if rest is None else rest.ports
        new = [one for one in tried if (there, one) not in self._tried]
        found = self._field.round(rest, new, advance).sightings if new else ()
        for one in new:
            self._tried[there, one] = [each for each in found if each.port == one]
        known = [each for one in tried for each in self._tried[there, one]]
        known = [one for one in known if np.isfinite(one.judged)] or known
        return Round(tuple(sorted(known, key=lambda one: one.judged)))


def _again(whole: Sighting, rounds: list[Round], others: Others, advance: Progress) -> Sighting:
    """Each port but the last looked for again beside the others."""
    for port in whole.ports[:-1]:
        if whole.judged <= SOUND:
            break
        tried = others.round(whole, port, _rivals(rounds, port), advance)
        if tried.sightings and tried.best.judged * FURTHER < whole.judged:
            whole = tried.best
    return whole


def _needed(whole: Sighting, others: Others) -> Sighting:
    """Without the ports that nobody misses."""
    for port in whole.ports:
        rest = others.beside(whole, port)
        if rest is not None and rest.judged < GAINS * whole.judged:
            whole = rest
    return whole


def _narrowed(field: Field, whole: Sighting, others: Others, advance: Progress) -> Sighting:
    """With ports that can do less in place of those that can do more, where that is as good."""
    for port in whole.ports:
        taken = {one.key for one in whole.ports}
        less = [one for one in field.ports if holds(port.key, one.key) and one.key not in taken]
        if less:
            tried = others.round(whole, port, less, advance)
            if tried.best.judged <= ALIKE * whole.judged:
                whole = tried.best
    return whole


def _settled(
    field: Field, whole: Sighting, rounds: list[Round], others: Others, advance: Progress
) -> tuple[Sighting, tuple[Member, ...]]:
    """Each port in its simplest form beside the others, and what cannot be told from it."""
    found: dict[tuple[str, str], Member] = {}
    for port in whole.ports:
        rest = others.beside(whole, port)
        tried = others.round(whole, port, _rivals(rounds, port), advance)
        if tried.best.port.key != port.key:
            whole = tried.best
        alike = tuple(one.port for one in tried.alike)
        without = field.bare if rest is None else rest.judged
        found[tried.best.port.key] = Member(tried.best.port, without, alike)
    return whole, tuple(found[port.key] for port in whole.ports)

"""One round of the law-free look: every port in every place, judged on postures that the fit has not seen."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree import screening
from flexmodal.diagnosis.lawfree.adjacent import between
from flexmodal.diagnosis.lawfree.afresh import Again
from flexmodal.diagnosis.lawfree.joint_ports import COUPLING
from flexmodal.diagnosis.lawfree.kinds import KINDS, NOTHING, RARE, TORQUE
from flexmodal.diagnosis.lawfree.link_ports import LINK
from flexmodal.diagnosis.lawfree.port import Port, PortKind
from flexmodal.diagnosis.lawfree.port_fits import PortFits
from flexmodal.diagnosis.lawfree.ported_fit import begun, finished, mended
from flexmodal.diagnosis.lawfree.records import endless, of_first_blow
from flexmodal.diagnosis.lawfree.related import parts
from flexmodal.diagnosis.lawfree.sighting import Round, Sighting, Start, carried_over
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.search.coarse import Look, look_at
from flexmodal.identification import Observations

SOUND = 1.6
"""Misfit up to which ports are said to explain what is missing: 0.6 if perfect. Tuned on single
effects of the virtual rig, whose true places had 0.6 to 1.5; how sharply was not measured."""
SEVERAL = 2.0
"""Times `SOUND` that the best leaves where several are missing, and none is fitted again; without any effect
only if it does not lower the misfit `HALVED` times either. Of ten looked-at campaigns whose best did not,
one gained more than a hundredth: a foundation in space, 11.7 to 10.7."""
HALVED = 2.0
FAR = 2.0
"""Times that the robot leaves more from its card than from where it was fitted, for ports to set out there
too. Not tuned: of one looked-at campaign with a link that bends 2.6 times. Always setting out there, a
foundation that radiates ended in a worse minimum. Where fits begin at a small model error ports do set
out there always, as the card is far: with 22 postures a link that bends was not among the places at all."""
SLOW = frozenset({LINK.name})
"""Kinds of port that are not fitted once more beside effects: two links took 77 of the 148 s of a look beside
three, and none came nearer by a hundredth. Without effects one did."""
LEADS, LEADS_ALONE = 1.4, 3.0
"""Times by which a port lowers the misfit for rare ones not to be tried, beside effects and where there are
none yet: of several effects each takes a part, and what is rare is tried where none does. The second is not
tuned."""
NEAR = 2.0
"""Times the misfit of the best up to which ports are brought to their ends; far more than rough fits differ
from ends, and not tuned."""


@dataclass(frozen=True, eq=False)
class Field(PortFits):
    """What is looked at, round by round."""

    @classmethod
    def of(
        cls,
        root: Hypothesis,
        x: Float[np.ndarray, " parameter"],
        fitted: Observations,
        held: Observations | None,
        *,
        by_force: bool = False,
        kinds: Sequence[PortKind] = KINDS,
        hinted: Collection[tuple[str, str]] = (),
    ) -> Field:
        """Lay it out.

        Args:
            root: the robot, perhaps with effects that are named already.
            x: its coordinates, re-tuned; fits set out there beside effects, and without any where the card
                is far: what is missing makes the robot much softer, and every port is wrong at the card.
            fitted: observations that the functions are fitted to.
            held: observations of other postures that judge; None where there are none.
            by_force: whether FRFs change with the force of the blow; torques that do so are tried then.
            kinds: sorts of ports.
            hinted: kinds and places of rare ones that are tried with the others.
        """
        rare = _every(RARE if kinds is KINDS else (), root)
        field = cls(
            root,
            x,
            _looked_at(fitted, root, x),
            None if held is None or not len(held) else _looked_at(held, root, x),
            (*_every(kinds, root), *(port for port in rare if port.key in hinted)),
            tuple(port for port in rare if port.key not in hinted),
            _every([TORQUE], root) if by_force else (),
        )
        card = replace(field, fitted=None)
        return field if root.placed or field._late or card.bare >= FAR * field.bare else card

    def round(
        self,
        before: Sighting | None = None,
        ports: Sequence[Port] | None = None,
        advance: Callable[[float], None] = lambda part: None,
    ) -> Round:
        """Every port in turn, those that do best fitted well.

        Args:
            before: ports that are there already.
            ports: those that are tried, all of them fitted well; everything that might be there by default.
            advance: called with the part that is done.
        """
        tried = self._possible(self.torques if ports is None else ports, before)
        if before is not None and not self._leaves_enough(before):
            tried = [port for port in tried if not port.kind.by_blow]
        if ports is None:
            tried = self._torques_that_lead(tried, before)
        found, kept, part = [], [], 1.0 if ports is not None else 0.2
        roughly = ports is None and bool(self.root.placed)
        each = parallel_map(lambda port: self.sighted((port,), before, roughly=roughly), tried)
        for number, one in enumerate(each, start=1):
            found.append(one)
            advance(part * number / len(tried))
        if ports is None:
            # What depends on force only a torque explains, or a reading; what is left beside effects may not.
            told = not self.root.placed and any(one.judged <= SOUND for one in found)
            others = [port for port in self.ports if port.kind.reads is not None or not told]
            kept = self._screened(others, before, lambda part: advance(0.2 + 0.4 * part))
        each = parallel_map(lambda one: self.sighted((one[0],), before, one[1], roughly=True), kept)
        for number, one in enumerate(each, start=1):
            found.append(one)
            advance(0.6 + 0.4 * number / len(kept))
        if found and ports is None:
            found = self._ended(found)
            best = min(found, key=lambda one: one.judged)
            found += self._parts_of(best, before, {one.port.key for one in found})
            found += self._between(best, before, {one.port.key for one in found})
        if ports is None:
            found = self._seen_through(found, before, min((misfit for *_, misfit in kept), default=np.inf))
        found = [one for one in found if np.isfinite(one.judged)] or found
        return Round(tuple(sorted(found, key=lambda one: one.judged)))

    def _seen_through(
        self, found: Sequence[Sighting], before: Sighting | None, least: float
    ) -> list[Sighting]:
        """The best fitted once more; rare ports too, where these do not lead on.

        Args:
            found: of a round.
            before: ports that are there already.
            least: reduced χ² of the best in the first round.
        """
        again = Again(self.sighted, self.root.context, before, self._most, SLOW if self.root.placed else ())
        better = again.better(found)
        if not self.rare or self._leads_on(better, before):
            return better
        more = self._screened(self.rare, before, lambda part: None)
        leading = [one for one in more if one[2] < least]
        rare = list(parallel_map(lambda one: self.sighted((one[0],), before, one[1]), leading))
        return again.better([*better, *rare], {one.port.key for one in better})

    def _ended(self, found: Sequence[Sighting]) -> list[Sighting]:
        """The best brought to their ends, but where several effects are missing."""
        least = min(one.judged for one in found)
        if least > self._most:
            return list(found)
        near = [one for one in found if one.judged <= NEAR * least]
        ended = dict(zip(near, parallel_map(self.ended, near), strict=True))
        return [ended.get(one, one) for one in found]

    @property
    def _most(self) -> float:
        """Misfit of the best up to which it pays to fit on; beyond it more than one effect is missing."""
        return max(SEVERAL * SOUND, 0.0 if self.root.placed else self.bare / HALVED)

    def _leads_on(self, found: Sequence[Sighting], before: Sighting | None) -> bool:
        """Whether a port explains what is missing, or a good part of it."""
        if not found:
            return False
        good = self.bare / (LEADS if self.root.placed else LEADS_ALONE)
        return found[0].judged <= (max(SOUND, good) if before is None else SOUND)

    def _parts_of(
        self, one: Sighting, before: Sighting | None, known: set[tuple[str, str]]
    ) -> list[Sighting]:
        """Narrower ports that one holds, but those that are known or there already."""
        begins = [pair for pair in parts(one, self.root.context) if pair[0].key not in known]
        new = self._possible([port for port, _ in begins], before)
        some = [one for one in begins if one[0] in new]
        return list(parallel_map(lambda one: self.sighted((one[0],), before, one[1]), some))

    def _between(self, one: Sighting, before: Sighting | None, known: set[tuple[str, str]]) -> list[Sighting]:
        """The link between two joints whose coupling explains what is missing, if it was not tried well.

        It does what that one does, and its many hinges come near to their end slowly.
        """
        if one.port.kind is not COUPLING or one.judged > SOUND:
            return []
        keys = between(self.root.context, one.port.where) - known
        links = [port for port in self.ports if port.key in keys]
        possible = self._possible(links, before)
        return list(parallel_map(lambda port: self.sighted((port,), before), possible))

    def _screened(
        self,
        ports: Sequence[Port],
        before: Sighting | None,
        advance: Callable[[float], None],
    ) -> list[tuple[Port, Start, float]]:
        """Those of some ports that go on, after a look at a part of the lines, where that ended, and how."""
        begins: list[tuple[Port, screening.Fit]] = []
        possible = self._possible(ports, before)
        roughly = parallel_map(lambda port: self._begun(port, before, roughly=True), possible)
        for number, (port, fit) in enumerate(zip(possible, roughly, strict=True), start=1):
            begins.append((port, fit))
            advance(0.7 * number / len(possible))
        begins = screening.with_places(
            begins, self.root.context, lambda port: self._begun(port, before, roughly=False)
        )
        without = self._unexplained if before is None else None
        first, ends, going = [], {}, screening.near(begins, without)
        further = parallel_map(self._screened_further, [fit for _, fit in going])
        for number, ((port, _), found) in enumerate(zip(going, further, strict=True)):
            misfit = screening.misfit_of(found)
            first.append((misfit, port))
            ends[port.key] = (found[1].x, screening.on_all(found[1].z, len(self.seen.lines))), misfit
            advance(0.7 + 0.3 * (number + 1) / len(going))
        first.sort(key=lambda one: one[0])
        return [(port, *ends[port.key]) for port in screening.kept(first, without)]

    def _possible(self, ports: Sequence[Port], before: Sighting | None) -> list[Port]:
        """Those that are not there already, and of those that leave observations out any that leave some.

        To fit, roughly too, and to judge: what leaves nothing explains everything.
        """
        there = before.ports if before else ()
        taken = {port.key for port in there}

        def leaves_some(port: Port) -> bool:
            every = [self._few, self.seen.merged, *([] if self.away is None else [self.away.merged])]
            models = [self._model((*there, port), some, self.seen.lines) for some in every]
            return all(len(model.observations) for model in models)

        new = [port for port in ports if port.key not in taken]
        return [port for port in new if not port.kind.drops or leaves_some(port)]

    def _leaves_enough(self, before: Sighting) -> bool:
        """Whether one function more leaves a third of what was read of every blow to judge at least."""
        model = before.profile.model
        if model.cells == 1:
            return True
        torques = sum(len(port.names) for port in before.ports if port.kind.by_blow)
        read = float(np.median(np.bincount(model.cell)))
        return 3 * (torques + 1) <= 2 * read

    def _torques_that_lead(self, torques: list[Port], before: Sighting | None) -> list[Port]:
        """The few that do best by a look at some postures and lines: each has many functions."""
        if len(torques) <= screening.TORQUES:
            return torques

        def ended(port: Port) -> screening.Fit:
            return self._screened_further(mended(*self._begun(port, before, roughly=True)))

        misfit = [screening.misfit_of(one) for one in parallel_map(ended, torques)]
        return [torques[k] for k in np.argsort(misfit, kind="stable")[: screening.TORQUES]]

    def _screened_further(self, fit: screening.Fit) -> screening.Fit:
        """A first fit to a part of the data at the model errors that follow."""
        return finished(*fit, floors=self._floors[1:], steps=screening.STEPS)

    def _begun(self, port: Port, before: Sighting | None, *, roughly: bool) -> screening.Fit:
        """A port's first fit to a part of the data."""
        every = (*(before.ports if before else ()), port)
        model = self._model(every, self._seen(every, self._few, self.seen.some), self._some_lines)
        state = None if before is None else carried_over(before, model, screening.LINES)
        return begun(model, state, floor=self._floors[0], steps=screening.STEPS, roughly=roughly)

    @cached_property
    def _unexplained(self) -> float | None:
        """Reduced χ² without any port at the model error of a first round that begins late, else None."""
        if not self._late:
            return None
        model = self._model((Port.at(NOTHING, "", self.root.context),), self._few, self._some_lines)
        return screening.misfit_of(begun(model, floor=self._floors[0], steps=screening.STEPS))

    @property
    def _some_lines(self) -> Int[np.ndarray, " line"]:
        return self.seen.lines[:: screening.LINES]

    @cached_property
    def _few(self) -> Observations:
        """Some of the observations of each posture."""
        return screening.thinned(self.seen.merged)


def _looked_at(observations: Observations, root: Hypothesis, x: Float[np.ndarray, " parameter"]) -> Look:
    seen = endless(observations, root, x)
    if not root.by_force:
        return look_at(seen)
    return replace(look_at(seen), merged=look_at(of_first_blow(seen, root, x)).merged)


def _every(kinds: Sequence[PortKind], root: Hypothesis) -> tuple[Port, ...]:
    context = root.context
    return tuple(Port.at(kind, where, context) for kind in kinds for where in kind.places(context))

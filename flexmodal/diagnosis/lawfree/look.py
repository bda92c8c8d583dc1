"""One round of the law-free look: every port in every place, judged on postures that the fit has not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.kinds import KINDS, NOTHING, TORQUE
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port, PortKind
from flexmodal.diagnosis.lawfree.ported_fit import FLOORS, begun, finished, profiled
from flexmodal.diagnosis.lawfree.profile import Profile, State
from flexmodal.diagnosis.lawfree.records import endless
from flexmodal.diagnosis.search.coarse import Look, look_at
from flexmodal.identification import Observations

SCREENED = (0.2, 0.05)
"""Model errors of the first round over all ports."""
SCREEN_STEPS, STEPS = 5, 20
"""Most at each model error, in the first round and for those that go on."""
SCREEN_LINES = 2
"""The first round takes every so many of the lines."""
HOPELESS = 16.0
"""Times the best reduced χ² at the first model error; ports beyond it are not followed to the next, but the
best of each kind. On 26 campaigns looked at, no port that came to stand among the best was beyond 10."""
KEPT = 6
"""Ports that go on."""
WITHIN = 3.0
"""And others up to so many times the misfit of the best."""
MOST_KEPT = 10
MOST_ALIKE, EXPLAINED = 20, 1.5
"""More go on where one place explains everything, to this reduced χ², and others as well: a mass at the end
of a link is one on the next link, and neither is to be left out for want of room."""
BEST_OF_KIND = 15.0
"""And of each kind the best up to so many times: a coupling of two joints is near its end after a few steps,
the link between them that does the same, with its many hinges, is not."""
ALIKE = 1.25
"""Ports whose misfits are within this factor cannot be told apart; the one with the fewest unknowns is taken.

Tuned on twelve campaigns of the rig with a single effect: the next best place had at least 1.4 times the
misfit where its port does not contain that of the true one. How sharply was not measured."""
SMALLEST = 5e-4
"""Model error at least, with which the last fits are judged."""


Fit = tuple[Profile, State]


@dataclass(frozen=True, eq=False)
class Sighting:
    """Ports with free functions, fitted together."""

    ports: tuple[Port, ...]
    misfit: float
    """Root of the reduced χ² on the postures fitted, in units of the noise of the averages; about 0.6 if
    perfect, since Huber's function and the smallest model error take their part."""
    apart: float | None
    """The same on the postures held out; None where there are none, or the functions differ by posture."""
    unknowns: int
    """Functions, and parameters of the ports' geometry."""
    profile: Profile
    state: State

    @property
    def port(self) -> Port:
        """The one that came last."""
        return self.ports[-1]

    @property
    def judged(self) -> float:
        """The larger of both misfits."""
        return self.misfit if self.apart is None else max(self.misfit, self.apart)


@dataclass(frozen=True, eq=False)
class Round:
    """Ports tried beside others that are there already."""

    sightings: tuple[Sighting, ...]
    """The best first."""

    @cached_property
    def alike(self) -> tuple[Sighting, ...]:
        """What cannot be told apart from the best, itself included; the simplest first."""
        found = [one for one in self.sightings if one.judged <= ALIKE * self.sightings[0].judged]
        return tuple(sorted(found, key=lambda one: (one.unknowns, one.judged)))

    @property
    def best(self) -> Sighting:
        """Of those that cannot be told apart the one with the fewest unknowns."""
        return self.alike[0]


@dataclass(frozen=True, eq=False)
class Field:
    """What is looked at: observations to fit and to judge, and the ports that might be in them."""

    root: Hypothesis
    fitted: Float[np.ndarray, " parameter"]
    """Its coordinates, re-tuned."""
    seen: Look
    away: Look | None
    ports: tuple[Port, ...]
    torques: tuple[Port, ...]
    """Those that depend on the blow."""

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
    ) -> Field:
        """Lay it out.

        Args:
            root: the robot, perhaps with effects that are named already.
            x: its coordinates, re-tuned.
            fitted: observations that the functions are fitted to.
            held: observations of other postures that judge; None where there are none.
            by_force: whether FRFs change with the force of the blow; torques that do so are tried then.
            kinds: sorts of ports.
        """
        return cls(
            root,
            x,
            look_at(endless(fitted, root, x)),
            None if held is None or not len(held) else look_at(endless(held, root, x)),
            _every(kinds, root),
            _every([TORQUE], root) if by_force else (),
        )

    @cached_property
    def bare(self) -> float:
        """Misfit without any port: a reading that is nothing."""
        return self.sighted((Port.at(NOTHING, "", self.root.context),)).judged

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
        taken = {port.key for port in before.ports} if before else set()
        if ports is None:
            kept = self._screened(before, taken, lambda part: advance(0.6 * part))
            kept += [port for port in self.torques if port.key not in taken]
        else:
            kept = [port for port in ports if port.key not in taken]
        found = []
        for number, port in enumerate(kept):
            found.append(self.sighted((port,), before))
            advance(0.6 + 0.4 * (number + 1) / len(kept))
        return Round(tuple(sorted(found, key=lambda one: one.judged)))

    def _screened(
        self, before: Sighting | None, taken: set[tuple[str, str]], advance: Callable[[float], None]
    ) -> list[Port]:
        """Those of all ports that go on, after a look at a part of the lines."""
        begins: list[tuple[float, Port, Fit]] = []
        for number, port in enumerate(self.ports):
            if port.key not in taken:
                ports = (*(before.ports if before else ()), port)
                model = self._model(ports, self._seen(ports), self.seen.lines[::SCREEN_LINES])
                state = None if before is None else carried_over(before, model, SCREEN_LINES)
                fit = begun(model, state, floor=SCREENED[0], steps=SCREEN_STEPS)
                begins.append((_misfit(fit), port, fit))
            advance(0.7 * (number + 1) / len(self.ports))
        first, going = [], _near(begins)
        for number, (port, fit) in enumerate(going):
            found = finished(*fit, floors=SCREENED[1:], steps=SCREEN_STEPS)
            first.append((_misfit(found), port))
            advance(0.7 + 0.3 * (number + 1) / len(going))
        first.sort(key=lambda one: one[0])
        return _kept(first)

    def _model(
        self, ports: Sequence[Port], observations: Observations, lines: Int[np.ndarray, " line"]
    ) -> PortedModel:
        return PortedModel.of(ports, self.root, observations, lines, self.fitted)

    def _seen(self, ports: Sequence[Port]) -> Observations:
        return self.seen.apart if any(port.kind.by_blow for port in ports) else self.seen.merged

    def sighted(self, ports: tuple[Port, ...], before: Sighting | None = None) -> Sighting:
        """Ports fitted well and judged.

        Args:
            ports: which; one after the other where there are several.
            before: others that are there already.
        """
        *first, port = ports
        if first:
            before = self.sighted(tuple(first), before)
        every = (*(before.ports if before else ()), port)
        observations, lines = self._seen(every), self.seen.lines
        model = self._model(every, observations, lines)
        noise = noise_of(observations, lines)
        state = None if before is None else carried_over(before, model)
        profile, state = profiled(model, state, floors=(*FLOORS, noise), steps=STEPS)
        apart = None
        if self.away is not None and model.cells == 1:
            other = Profile(self._model(every, self.away.merged, lines), noise)
            residual = other.state(state.x, state.z).residual
            apart = float(np.sqrt(other.mean(residual))) if residual.size else np.inf
        dropped = len(observations) - len(model.observations)
        unknowns = max(len(model.names), dropped) + len(model.space) - len(self.root.space)
        return Sighting(
            every, float(np.sqrt(profile.reduced(state.residual))), apart, unknowns, profile, state
        )


def carried_over(before: Sighting, model: PortedModel, stride: int = 1) -> State:
    """Where a fit of some ports ended, as the beginning of one with one more.

    Args:
        before: the fit.
        model: with the same ports and one more, which may leave observations out.
        stride: the model has every so many of the lines.
    """
    z = model.in_cells(before.state.z, before.profile.model)
    return replace(before.state, z=z[..., ::stride])


def _every(kinds: Sequence[PortKind], root: Hypothesis) -> tuple[Port, ...]:
    context = root.context
    return tuple(Port.at(kind, where, context) for kind in kinds for where in kind.places(context))


def _misfit(fit: Fit) -> float:
    profile, state = fit
    return profile.reduced(state.residual)


def _near(begins: Sequence[tuple[float, Port, Fit]]) -> list[tuple[Port, Fit]]:
    """Of all ports at the first model error those that are not hopeless, and of each kind the best."""
    order = sorted(begins, key=lambda one: one[0])
    best: dict[str, Port] = {}
    for _, port, _ in order:
        best.setdefault(port.kind.name, port)
    limit = HOPELESS * order[0][0] if order else 0.0
    return [(port, fit) for misfit, port, fit in order if misfit <= limit or best[port.kind.name] is port]


def _kept(first: Sequence[tuple[float, Port]]) -> list[Port]:
    """Of all ports with their misfits, the best first, those that go on."""
    limit, far = WITHIN * first[0][0], BEST_OF_KIND * first[0][0]
    alike = ALIKE**2 * first[0][0] if first[0][0] < EXPLAINED else 0.0
    kept = [
        port
        for k, (misfit, port) in enumerate(first[:MOST_ALIKE])
        if k < KEPT or (k < MOST_KEPT and misfit < limit) or misfit < alike
    ]
    kinds = {port.kind.name for port in kept}
    for misfit, port in first:
        if misfit < far and port.kind.name not in kinds:
            kept.append(port)
            kinds.add(port.kind.name)
    return kept


def noise_of(observations: Observations, lines: Int[np.ndarray, " line"]) -> float:
    """Typical noise of the averages: the model error at which fits are judged.

    Args:
        observations: measured receptances.
        lines: those that are looked at.
    """
    used = observations.used[:, lines]
    if not used.any():
        return SMALLEST
    return max(0.5 * float(np.sqrt(np.median(observations.variance[:, lines][used]))), SMALLEST)

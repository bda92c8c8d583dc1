"""The law-free look: every port in every place, judged on postures that the fit has not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree.kinds import KINDS, NOTHING, TORQUE
from flexmodal.diagnosis.lawfree.model import PortedModel
from flexmodal.diagnosis.lawfree.port import Port, PortKind
from flexmodal.diagnosis.lawfree.profile import FLOORS, Profile, State, profiled
from flexmodal.diagnosis.lawfree.records import endless
from flexmodal.diagnosis.search.coarse import Look, look_at
from flexmodal.identification import Observations

SCREENED = (0.2, 0.05)
"""Model errors of the first round over all ports."""
SCREEN_STEPS, STEPS = 5, 20
"""Most at each model error, in the first round and for those that go on."""
SCREEN_LINES = 2
"""The first round takes every so many of the lines."""
KEPT = 6
"""Ports that go on."""
WITHIN = 3.0
"""And others up to so many times the misfit of the best."""
MOST_KEPT = 10
BEST_OF_KIND = 15.0
"""And of each kind the best up to so many times: a coupling of two joints is near its end after a few steps,
the link between them that does the same, with its many hinges, is not."""
ALIKE = 1.25
"""Ports whose misfits are within this factor cannot be told apart; the one with the fewest unknowns is taken.

Tuned on twelve campaigns of the rig with a single effect: the next best place had at least 1.4 times the
misfit where its port does not contain that of the true one. How sharply was not measured."""
SMALLEST = 5e-4
"""Model error at least, with which the last fits are judged."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """A port, fitted."""

    port: Port
    misfit: float
    """Root of the reduced χ² on the postures fitted, in units of the noise of the averages; about 0.6 if
    perfect, since Huber's function and the smallest model error take their part."""
    apart: float | None
    """The same on the postures held out; None where there are none, or the functions differ by posture."""
    unknowns: int
    """Functions, and parameters of the port's geometry."""
    profile: Profile
    state: State

    @property
    def judged(self) -> float:
        """The larger of both."""
        return self.misfit if self.apart is None else max(self.misfit, self.apart)


@dataclass(frozen=True, eq=False)
class LawFree:
    """What a law-free look found."""

    believed: float
    """Misfit of the re-tuned robot without any port."""
    sightings: tuple[Sighting, ...]
    """The best first."""
    alike: tuple[Sighting, ...]
    """What cannot be told apart from the best, itself included; the simplest first."""

    @property
    def best(self) -> Sighting:
        """Of those that cannot be told apart the one with the fewest unknowns."""
        return self.alike[0]


def law_free(
    root: Hypothesis,
    x: Float[np.ndarray, " parameter"],
    fitted: Observations,
    held: Observations | None,
    *,
    by_force: bool = False,
    kinds: Sequence[PortKind] = KINDS,
    advance: Callable[[float], None] = lambda part: None,
) -> LawFree:
    """Look for the place of what is missing without a law for it.

    Args:
        root: the robot, perhaps with effects that are named already.
        x: its coordinates, re-tuned.
        fitted: observations that the functions are fitted to.
        held: observations of other postures that judge; None where there are none.
        by_force: whether FRFs change with the force of the blow; torques that do so are tried then.
        kinds: sorts of ports.
        advance: called with the part that is done.
    """
    seen = look_at(endless(fitted, root, x))
    away = None if held is None or not len(held) else look_at(endless(held, root, x))
    ports = [Port.at(kind, where, root.context) for kind in kinds for where in kind.places(root.context)]
    first = []
    for number, port in enumerate(ports):
        model = PortedModel.of(port, root, seen.merged, seen.lines[::SCREEN_LINES])
        profile, state = profiled(model, floors=SCREENED, steps=SCREEN_STEPS)
        first.append((profile.reduced(state.residual), port))
        advance(0.6 * (number + 1) / len(ports))
    first.sort(key=lambda one: one[0])
    kept = _kept(first)
    if by_force:
        kept += [Port.at(TORQUE, where, root.context) for where in TORQUE.places(root.context)]
    found = []
    for number, port in enumerate(kept):
        found.append(sighted(port, root, seen, away))
        advance(0.6 + 0.4 * (number + 1) / len(kept))
    found.sort(key=lambda one: one.judged)
    alike = [one for one in found if one.judged <= ALIKE * found[0].judged]
    alike.sort(key=lambda one: (one.unknowns, one.judged))
    return LawFree(_without(root, seen), tuple(found), tuple(alike))


def _kept(first: Sequence[tuple[float, Port]]) -> list[Port]:
    """Of all ports with their misfits, the best first, those that go on."""
    limit, far = WITHIN * first[0][0], BEST_OF_KIND * first[0][0]
    kept = [port for k, (misfit, port) in enumerate(first[:MOST_KEPT]) if k < KEPT or misfit < limit]
    kinds = {port.kind.name for port in kept}
    for misfit, port in first:
        if misfit < far and port.kind.name not in kinds:
            kept.append(port)
            kinds.add(port.kind.name)
    return kept


def sighted(port: Port, root: Hypothesis, seen: Look, away: Look | None) -> Sighting:
    """A port fitted well and judged.

    Args:
        port: which.
        root: the robot.
        seen: observations to fit.
        away: of other postures, to judge.
    """
    observations = seen.apart if port.kind.by_blow else seen.merged
    model = PortedModel.of(port, root, observations, seen.lines)
    noise = noise_of(observations, seen.lines)
    profile, state = profiled(model, floors=(*FLOORS, noise), steps=STEPS)
    apart = None
    if away is not None and not port.kind.by_blow:
        other = Profile(PortedModel.of(port, root, away.merged, seen.lines), noise)
        residual = other.state(state.x, state.z).residual
        apart = float(np.sqrt(other.mean(residual))) if residual.size else np.inf
    dropped = len(observations) - len(model.observations)
    unknowns = max(len(port.names), dropped) + len(model.space) - len(root.space)
    return Sighting(port, float(np.sqrt(profile.reduced(state.residual))), apart, unknowns, profile, state)


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


def _without(root: Hypothesis, seen: Look) -> float:
    """Misfit without any port: a reading that is nothing."""
    port = Port.at(NOTHING, "", root.context)
    model = PortedModel(port, root, seen.merged, seen.lines)
    profile, state = profiled(model, floors=(*FLOORS, noise_of(seen.merged, seen.lines)), steps=STEPS)
    return float(np.sqrt(profile.reduced(state.residual)))

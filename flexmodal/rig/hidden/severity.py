"""How severe a hidden effect has to be to stand a given height above the noise.

The height is the root mean square of |ln(H with / H without)| over the lines of the band that have a
coherence of 0.8 or more, over the same figure for the noise of one record: half the squared difference of
two repeats of the same blows with other noise and scatter. It is judged without re-tuning anything: what a
re-tuned model can absorb of an effect counts too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Complex

from flexmodal.campaign import CampaignPosture, Trial, is_coherent
from flexmodal.rig.clean import strike_all_points
from flexmodal.rig.effects import Site, Stand
from flexmodal.rig.effects.effect import Effect, Parameters
from flexmodal.rig.hammer_test import (
    Conduct,
    h1,
    reference_rows,
    response_rows,
    strike_posture,
)
from flexmodal.rig.plant.build import Hidden, build, sensors

MOST_POSTURES = 3
"""Postures that the height is judged in."""
MOST_LINES = 250
"""Lines that it is judged at, evenly spaced in the band."""
CLOSE = 0.08
"""Logarithm of height over target at which the search ends."""
_ROUNDS = 9
_LEAST = 1e-5


@dataclass(frozen=True, eq=False)
class Floor:
    """The noise that an effect is measured against."""

    postures: tuple[CampaignPosture, ...]
    lines: np.ndarray
    """Numbers of the lines inside the band."""
    keep: np.ndarray
    """[posture, trial, reference, point, axis, line]: coherent enough."""
    height: float
    """Root mean square of |ln| for the noise of one record."""


def noise_floor(stand: Stand, conduct: Conduct) -> Floor:
    """Measure the noise on some of the postures, nothing hidden.

    Args:
        stand: the true robot and its plan.
        conduct: noise, scatter and seed.
    """
    plan = stand.plan
    pick = np.unique(np.linspace(0, len(plan.postures) - 1, MOST_POSTURES).round().astype(int))
    postures = tuple(plan.postures[k] for k in pick)
    frequency = np.fft.rfftfreq(plan.analyser.samples, plan.analyser.interval)
    lines = np.flatnonzero((frequency >= plan.band[0]) & (frequency <= plan.band[1]))
    lines = lines[:: max(1, len(lines) // MOST_LINES)]
    keep, squared = [], []
    for posture in postures:
        pair = [
            h1(strike_posture(stand, posture, [], replace(conduct, seed=conduct.seed + shift)))
            for shift in (0, 1)
        ]
        (one, coherence), (other, again) = ((h[..., lines], c[..., lines]) for h, c in pair)
        keep.append(is_coherent(coherence) & is_coherent(again) & (np.abs(one) > 0) & (np.abs(other) > 0))
        squared.append(np.abs(_log_ratio(one[keep[-1]], other[keep[-1]])) ** 2 / 2)
    every = np.concatenate(squared)
    return Floor(postures, lines, np.array(keep), float(np.sqrt(every.mean())) if every.size else 0.0)


def height(stand: Stand, hidden: Sequence[Hidden], floor: Floor) -> float:
    """Root mean square of |ln(H with / H without)| [1], without noise or scatter.

    Args:
        stand: the true robot and its plan.
        hidden: effects put in.
        floor: lines and postures to take it on.
    """
    if all(effect.linear for effect, _ in hidden):
        ratios = _linear(stand, hidden, floor)
    else:
        ratios = _struck(stand, hidden, floor)
    return float(np.sqrt(np.mean(np.abs(ratios) ** 2))) if ratios.size else 0.0


def limit(effect: Effect, parameters: Parameters) -> float:
    """The highest severity of these parameters, short of where rounding would carry one over its limit.

    Args:
        effect: which.
        parameters: its numbers.
    """
    return effect.most(parameters) * (1 - 1e-9)


def severity_for(
    stand: Stand, effect: Effect, site: Site, target: float, floor: Floor
) -> tuple[float, float]:
    """Severity at which an effect stands `target` times the noise floor, and how high it then stands.

    The logarithm of the height is taken as a straight line in that of the severity, first of slope 1, then
    through the two severities that hold the target between them, or the last two.

    Where the effect cannot stand that high, the highest severity that makes sense, and its height.

    Args:
        stand: the true robot and its plan.
        effect: which, in which form.
        site: where it sits, and its numbers.
        target: height over the noise floor.
        floor: the noise.
    """
    most = limit(effect, site.parameters)
    found: dict[float, float] = {}

    def off(severity: float) -> float:
        """Logarithm of height over target."""
        scaled = effect.scaled(site.parameters, severity)
        reached = height(stand, [(effect, replace(site, parameters=scaled))], floor) / floor.height
        found[severity] = max(reached, 1e-9)
        return float(np.log(found[severity] / target))

    severity = min(1.0, most)
    while abs(off(severity)) > CLOSE and len(found) < _ROUNDS:
        following = _next_severity(found, target, most)
        if following in found:
            break
        severity = following
    best = min(found, key=lambda tried: abs(np.log(found[tried] / target)))
    return best, found[best]


def _next_severity(found: dict[float, float], target: float, most: float) -> float:
    """Where to look next, from the heights found so far, the last one last."""
    off = {severity: float(np.log(reached / target)) for severity, reached in found.items()}
    below = max((s for s, high in off.items() if high < 0), default=None)
    above = min((s for s, high in off.items() if high >= 0 and (below is None or s > below)), default=None)
    if below is not None and above is not None:
        part = -off[below] / (off[above] - off[below])
        return float(below * (above / below) ** np.clip(part, 0.1, 0.9))
    last, *rest = reversed(off)
    slope = 1.0
    if rest and off[last] != off[rest[0]]:
        slope = float(np.clip((off[last] - off[rest[0]]) / np.log(last / rest[0]), 0.25, 4.0))
    return float(np.clip(last * np.exp(-off[last] / slope), _LEAST, most))


def _log_ratio(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore"):
        return np.log(one / other)


def _linear(stand: Stand, hidden: Sequence[Hidden], floor: Floor) -> np.ndarray:
    plain, spoilt = (predicted(stand, items, floor) for items in ([], hidden))
    usable = usable_lines(floor) & (np.abs(plain) > 0) & (np.abs(spoilt) > 0)
    return _log_ratio(spoilt[usable], plain[usable])


def usable_lines(floor: Floor) -> Bool[np.ndarray, "posture reference point axis line"]:
    """Those that are coherent enough in every trial.

    Args:
        floor: the noise.
    """
    return np.asarray(floor.keep.all(axis=1))


def predicted(
    stand: Stand, hidden: Sequence[Hidden], floor: Floor
) -> Complex[np.ndarray, "posture reference point axis line"]:
    """Inertance as the sensors would tell it, without noise or scatter.

    Args:
        stand: the true robot and its plan.
        hidden: effects put in, linear ones.
        floor: postures and lines to take it on.
    """
    plan = stand.plan
    frequency = np.fft.rfftfreq(plan.analyser.samples, plan.analyser.interval)[floor.lines]
    return np.stack([_predicted(stand, posture, hidden, frequency) for posture in floor.postures])


def _predicted(
    stand: Stand, posture: CampaignPosture, hidden: Sequence[Hidden], frequency: np.ndarray
) -> np.ndarray:
    """The same in one posture [reference, point, axis, line]."""
    plan = stand.plan
    mounted = sensors(stand, hidden, posture)
    shared = None if any(s.weighs for s in mounted.values()) else build(stand, posture, hidden)
    by_point = []
    for point in plan.points:
        sensor = mounted[point.name]
        plant = shared or build(stand, posture, hidden, (point.name, sensor))
        pushed = reference_rows(stand, plant, [(None, reference) for reference in plan.references])
        rows = response_rows(stand, plant, point, sensor)
        value = plant.inertance(rows, pushed, frequency)
        value = value * sensor.response(frequency)[:, None, None]
        value = value * sensor.skew(2 * np.pi * frequency, len(rows)).T[:, :, None]
        by_point.append(np.transpose(value, (2, 1, 0)))
    return np.stack(by_point, axis=1)


def struck_numbers(floor: Floor) -> list[int]:
    """Which of the floor's postures are struck: the first and the last.

    Args:
        floor: the noise.
    """
    return sorted({0, len(floor.postures) - 1})


def struck(
    stand: Stand, hidden: Sequence[Hidden], floor: Floor
) -> Complex[np.ndarray, "posture trial reference point axis line"]:
    """The same by blows: one of each level, all points at once, in the first and last of the postures.

    Args:
        stand: the true robot and its plan.
        hidden: effects put in.
        floor: postures and lines to take it on.
    """
    trials = list(_levels(stand).values())
    return np.stack(
        [
            strike_all_points(stand, floor.postures[k], hidden, trials)[..., floor.lines]
            for k in struck_numbers(floor)
        ]
    )


def usable_blows(stand: Stand, floor: Floor) -> Bool[np.ndarray, "posture trial reference point axis line"]:
    """Lines of those that are coherent enough.

    Args:
        stand: with its plan.
        floor: the noise.
    """
    numbers = [stand.plan.trials.index(trial) for trial in _levels(stand).values()]
    return np.asarray(floor.keep[struck_numbers(floor)][:, numbers])


def _levels(stand: Stand) -> dict[float, Trial]:
    """The first trial of each typical peak."""
    return {trial.force_peak: trial for trial in reversed(stand.plan.trials)}


def _struck(stand: Stand, hidden: Sequence[Hidden], floor: Floor) -> np.ndarray:
    plain, spoilt = (struck(stand, items, floor) for items in ([], hidden))
    usable = usable_blows(stand, floor) & (np.abs(plain) > 0) & (np.abs(spoilt) > 0)
    return _log_ratio(spoilt[usable], plain[usable])

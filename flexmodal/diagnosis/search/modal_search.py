"""From an effect in a place to its best fit: many starts looked at quickly, the best of them fitted well.

Where pairs of measured and modelled modes are left to the frequencies at the start, a fit ends in the nearest
of many minima. So every way in which the modes of the model can be measured modes, in order of frequency, is
tried for itself, those first that ask for the smallest shifts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from jaxtyping import Float

from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.modal_model import ModalModel
from flexmodal.diagnosis.names import UNSTRUCTURED
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification.evidence.likelihood.fit import fit_modes
from flexmodal.identification.evidence.likelihood.forecast import Forecast
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.likelihood.likelihood import Pairs
from flexmodal.identification.evidence.likelihood.predictive import granted
from flexmodal.identification.evidence.likelihood.scatter import Beliefs
from flexmodal.identification.evidence.measured_modes import ModeObservations
from flexmodal.modal import NO_MODES

WAYS = 5
"""Ways to pair that are tried from each start."""
QUICK = 12
"""Starts with a way to pair that are looked at from each state of the robot: those of the smallest shifts."""
CLOSE = 3
"""Quick fits that are followed up."""
NEAR = 8
"""Starts that are looked at from each state of the robot: those whose modes come nearest to the measured
ones."""
FORCED = 2
"""Of those, how many are tried with every way to pair."""
SIZES = ("stiffness", "gain", "mass")
FACTORS = (1.0, 0.5, 0.25, 0.1, 0.05, 0.02)
"""On the sizes that an effect starts from: a mode that is to be met lies lower than a slight change puts
it."""
PEAKED = 0.5
"""Damping ratio up to which a mode of the model may be one that was measured."""

Start = tuple[Float[np.ndarray, " parameter"], Pairs | None]


def best_fits(
    explanation: ModalModel, measured: ModeObservations, starts: Sequence[Start], beliefs: Beliefs
) -> list[ModalFit]:
    """Fits from several starts, the highest posterior first; none where no start is a model at all.

    Args:
        explanation: the model.
        measured: modes that it is to have.
        starts: coordinates, and ways to pair or None where the fit is to pair by itself.
        beliefs: about scatter and peaks.
    """
    quick = []
    for x, pairs in starts:
        try:
            quick.append(fit_modes(explanation, measured, x, beliefs, pairs=pairs, quick=True))
        except NO_MODES:
            continue
    quick.sort(key=lambda one: -one.log_posterior)
    return followed(explanation, measured, _distinct(quick)[:CLOSE], beliefs)


def followed(
    explanation: ModalModel, measured: ModeObservations, near: Sequence[ModalFit], beliefs: Beliefs
) -> list[ModalFit]:
    """Fits that begin where others ended, the highest posterior first.

    Args:
        explanation: the model.
        measured: modes that it is to have.
        near: fits to begin from.
        beliefs: about scatter and peaks.
    """
    found = []
    for one in near:
        try:
            found.append(fit_modes(explanation, measured, one.x, beliefs, scales=one.scales))
        except NO_MODES:
            continue
    return sorted(found, key=lambda one: -one.log_posterior)


def _distinct(fits: Sequence[ModalFit]) -> list[ModalFit]:
    """Without those that have gone the same way as a better one."""
    kept: list[ModalFit] = []
    for one in fits:
        if all(np.max(np.abs(one.x - other.x)) > 0.05 or one.pairs != other.pairs for other in kept):
            kept.append(one)
    return kept


def bare_starts(explanation: ModalModel, measured: ModeObservations, x: np.ndarray) -> list[Start]:
    """Of the robot as it is, from given coordinates.

    Args:
        explanation: the model.
        measured: modes that it is to have.
        x: coordinates.
    """
    return _nearest([(shift, (x, pairs)) for shift, pairs in ways(explanation, measured, x)])


def effect_starts(
    placed: Placed,
    explanation: ModalModel,
    states: Sequence[tuple[Float[np.ndarray, " before"], Mapping[int, float]]],
    measured: ModeObservations,
) -> list[Start]:
    """Of one effect more: its own starts, a frequency of its own where modes are missing.

    Args:
        placed: the effect, last in the explanation.
        explanation: with it.
        states: of the robot without it: coordinates, and the measured modes that it then lacks [Hz].
        measured: all modes.
    """
    context = explanation.hypothesis.context
    own = _spread(placed, context, list(placed.effect.starts(context, placed.where)))
    chosen: list[Start] = []
    for x, lacks in states:
        given = _at_peaks(own, lacks or _centres(measured)) if own and "frequency" in own[0] else own
        starts = [explanation.hypothesis.start(placed, one, x) for one in given]
        ranked = sorted(
            (
                (likely, k)
                for k, start in enumerate(starts)
                if (likely := _likely(explanation, measured, start)) is not None
            ),
            reverse=True,
        )
        chosen += [(starts[k], None) for _, k in ranked[:NEAR]]
        for _, k in ranked[:FORCED]:
            chosen += [(starts[k], pairs) for _, pairs in ways(explanation, measured, starts[k])]
    return chosen


def _likely(explanation: ModalModel, measured: ModeObservations, x: np.ndarray) -> float | None:
    """Ln likelihood at a start that is granted to be far off; None where there is no model."""
    try:
        return granted(explanation, measured, x)
    except NO_MODES:
        return None


def _spread(
    placed: Placed, context: Context, own: Sequence[Mapping[str, float]]
) -> list[Mapping[str, float]]:
    """Starts with stiffnesses, masses and gains smaller too."""
    sizes = [
        p.name
        for p in placed.effect.parameters(context, placed.where)
        if p.log and any(p.name.endswith(word) for word in SIZES)
    ]
    found: list[Mapping[str, float]] = []
    for one in own:
        for factor in FACTORS:
            moved = {**one, **{name: one[name] * factor for name in sizes if name in one}}
            if moved not in found:
                found.append(moved)
    return found


def free_starts(explanation: ModalModel, measured: ModeObservations, x: np.ndarray) -> list[Start]:
    """Of one mode without structure more, at each of the measured modes in turn.

    Args:
        explanation: the model, whose last free mode is the one more.
        measured: modes that it is to have.
        x: coordinates without that mode.
    """
    name = f"{UNSTRUCTURED}.{explanation.free}.frequency"
    parameter = explanation.space.parameters[explanation.space.index[name]]
    found: list[tuple[float, Start]] = []
    for number, frequency in _centres(measured).items():
        start = np.concatenate([x, np.zeros(len(explanation.space) - len(x))])
        start[explanation.space.index[name]] = parameter.coordinate(frequency)
        some = ways(explanation, measured, start, taken=number)
        found += [(shift, (start, pairs)) for shift, pairs in some]
    return _nearest(found)


def _nearest(found: Sequence[tuple[float, Start]]) -> list[Start]:
    return [start for _, start in sorted(found, key=lambda one: one[0])[:QUICK]]


def unmatched(fit: ModalFit) -> dict[int, float]:
    """Measured modes that the robot itself lacks in at least half the postures, frequencies [Hz]."""
    found: dict[int, list[tuple[float, bool]]] = {}
    for mode, partner in zip(fit.measured.modes, fit.pairs, strict=True):
        structured = fit.forecasts[mode.posture].structured
        found.setdefault(mode.number, []).append((mode.frequency, not 0 <= partner < structured))
    return {
        number: float(np.median([f for f, _ in some]))
        for number, some in found.items()
        if 2 * sum(lacks for _, lacks in some) >= len(some)
    }


def _centres(measured: ModeObservations) -> dict[int, float]:
    return {
        number: float(np.median([m.frequency for m in measured.modes if m.number == number]))
        for number in measured.numbers
    }


def _at_peaks(given: Sequence[Mapping[str, float]], peaks: Mapping[int, float]) -> list[Mapping[str, float]]:
    found: list[Mapping[str, float]] = []
    for frequency in peaks.values():
        for one in given:
            moved = {**one, "frequency": frequency}
            if moved not in found:
                found.append(moved)
    return found


def ways(
    explanation: ModalModel, measured: ModeObservations, x: np.ndarray, *, taken: int | None = None
) -> list[tuple[float, Pairs]]:
    """Pairs in order of frequency, the smallest shifts first; one without a posture's measured mode has −1.

    Args:
        explanation: whose modes.
        measured: which are to be they.
        x: coordinates.
        taken: number of the measured mode that the last free mode is.

    Returns:
        The sum of squared logarithmic shifts, and the pairs; nothing where there is no model.
    """
    try:
        seen = explanation.forecasts(x, measured.responses, slopes=False)
    except NO_MODES:
        return []
    numbers = [n for n in _ordered(measured) if n != taken]
    first = seen[0]
    bound = len(first.log_frequency) - (taken is not None)
    modes = [m for m in range(bound) if first.log_damping[m] < np.log(PEAKED)]
    modes.sort(key=lambda m: first.log_frequency[m])
    size = min(len(numbers), len(modes))
    centre = {n: np.log(f) for n, f in _centres(measured).items()}
    tried = []
    for some in combinations(numbers, size):
        for those in combinations(modes, size):
            shift = sum((centre[n] - first.log_frequency[m]) ** 2 for n, m in zip(some, those, strict=True))
            tried.append((float(shift), dict(zip(some, those, strict=True))))
    tried.sort(key=lambda one: one[0])
    return [(shift, _pairs(measured, seen, table, taken)) for shift, table in tried[:WAYS]]


def _ordered(measured: ModeObservations) -> list[int]:
    centre = _centres(measured)
    return sorted(centre, key=lambda number: centre[number])


def _pairs(
    measured: ModeObservations, seen: Sequence[Forecast], table: Mapping[int, int], taken: int | None
) -> Pairs:
    found = []
    for mode in measured.modes:
        count = len(seen[mode.posture].log_frequency)
        m = count - 1 if mode.number == taken else table.get(mode.number, -1)
        found.append(m if m < count else -1)
    return tuple(found)

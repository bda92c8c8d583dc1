"""A step in figures: what was added, how large it is and how surely, and what was weighed against it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmodal.diagnosis.figures import gap_of, gaps_of
from flexmodal.diagnosis.names import NONE
from flexmodal.diagnosis.outcome import Step, Weighed
from flexmodal.diagnosis.preparation import Bench
from flexmodal.diagnosis.weigh import Scales, Weighable
from flexmodal.identification import uncertainty

TIE = 0.05
"""Probability from which another explanation counts as tied with the best."""


def describe(bench: Bench, looked: Sequence[Weighable], scales: Scales, best: int, before: Weighable) -> Step:
    """What a step added.

    Args:
        bench: what the diagnosis works with.
        looked: what was weighed, the model before it first.
        scales: what came of that.
        best: number of the explanation that was added.
        before: the model before it.
    """
    chosen = looked[best]
    placed = chosen.hypothesis.placed[-1]
    order = [int(k) for k in np.argsort(-scales.scores) if k != best]
    alternatives = tuple(weighed(bench, looked[k], before, scales, k) for k in order)
    ties = tuple((one.effect, one.where) for one in alternatives if one.confidence >= TIE)
    parameters, units, errors = _parameters(bench, chosen, placed.key)
    return Step(
        effect=placed.effect.name,
        where=placed.where,
        parameters=parameters,
        units=units,
        uncertainty=errors,
        confidence=float(scales.probability[best]),
        gaps=gaps_of(bench, before, chosen),
        alternatives=alternatives,
        ties=ties,
    )


def weighed(bench: Bench, one: Weighable, before: Weighable, scales: Scales, number: int) -> Weighed:
    """An explanation on the scales, in figures."""
    return Weighed(
        effect=one.key[0] if one is not before else NONE,
        where=one.key[1] if one is not before else "",
        gap=gap_of(bench, one, ~bench.held),
        held_out_gap=gap_of(bench, one, bench.held) if bench.held.any() else None,
        evidence=float(scales.scores[number]),
        confidence=float(scales.probability[number]),
        parameters=one.parameters - before.parameters,
    )


def _parameters(
    bench: Bench, one: Weighable, key: tuple[str, str]
) -> tuple[dict[str, float], dict[str, str], dict[str, float]]:
    """Physical parameters of an effect, their units and standard errors, by finite differences."""
    space, x = one.hypothesis.space, one.fitted.x
    placed = next(p for p in one.hypothesis.placed if p.key == key)
    sure = uncertainty(space, one.fitted.normal, bench.fitted)

    def physical(at: np.ndarray) -> dict[str, float]:
        values = one.hypothesis.values_of(placed, space.values(at))
        own = {p.name for p in placed.effect.parameters(bench.scene, placed.where)}
        found = placed.effect.physical(bench.scene, placed.where, values)
        return {k: v for k, v in found.items() if k in own or "." not in k}

    here = physical(x)
    slopes = np.zeros((len(here), len(x)))
    for k in range(len(x)):
        if space.names[k].startswith(f"{placed.label}.") or "." in space.names[k]:
            moved = x.copy()
            moved[k] += 1e-5
            slopes[:, k] = (np.array(list(physical(moved).values())) - list(here.values())) / 1e-5
    errors = np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", slopes, sure.covariance, slopes), 0.0))
    units = {p.name: p.unit for p in placed.effect.parameters(bench.scene, placed.where)}
    units = {name: placed.effect.units.get(name, units.get(name, "")) for name in here}
    return here, units, dict(zip(here, errors.tolist(), strict=True))

"""Which measurement would separate two explanations best.

Over the robot's own postures and random ones within the limits, every response and hammer point of the
campaign and every level of force, the two fitted models' receptances are compared: root mean square of
|ln(α₁/α₂)| over the noise of the campaign, which is taken to be as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import CampaignPosture
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.outcome import NONE, NextMeasurement
from flexmodal.identification import Observations, predict
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.gap import Gap, gap

RANDOM = 24
"""Random postures that are tried beside the card's."""
LINES = 80
_WIDEST = np.radians(150)


def next_measurement(
    observations: Observations,
    one: tuple[Hypothesis, Float[np.ndarray, " parameter"]],
    other: tuple[Hypothesis, Float[np.ndarray, " parameter"]],
    seed: int = 0,
) -> NextMeasurement:
    """The posture, response, hammer point and level at which two fitted models differ most.

    Args:
        observations: the campaign's.
        one: a hypothesis and its coordinates.
        other: the one it is tied with.
        seed: of the random postures.
    """
    context = one[0].context
    planned = _planned(observations, postures_to_try(context, seed))
    there = replace(context, postures=planned.postures)
    stride = max(1, len(planned.axis) // LINES)
    lines = slice(stride // 2, None, stride)
    values = []
    for hypothesis, x in (one, other):
        moved = Hypothesis(there, hypothesis.base, hypothesis.placed)
        values.append(predict(moved, x, planned, lines))
    apart = np.sqrt(np.mean(np.minimum(np.abs(residual(*values)) ** 2, 4.0), axis=1))
    best = int(np.argmax(apart))
    floor = gap(observations, observations.value).noise_floor
    response, reference = planned.response[best].tolist(), planned.reference[best].tolist()
    return NextMeasurement(
        posture=dict(planned.postures[int(planned.posture[best])].q),
        response=(response[0], response[1]),
        reference=(reference[0], reference[1]),
        separates=(_label(one[0]), _label(other[0])),
        expected=float(Gap(float(apart[best]), floor).over_floor),
        force_peak=planned.peak(int(planned.level[best])),
    )


def _label(hypothesis: Hypothesis) -> str:
    return "@".join(hypothesis.keys[-1]) if hypothesis.placed else NONE


def postures_to_try(context: Context, seed: int) -> list[Mapping[str, float]]:
    """The card's postures, those of the campaign, and random ones."""
    robot, random = context.robot, np.random.default_rng(seed)
    found: list[Mapping[str, float]] = [dict(q) for q in robot.postures.values()]
    found += [dict(p.q) for p in context.postures]
    for _ in range(RANDOM):
        values = {}
        for name, joint in robot.commanded.items():
            wide = _WIDEST if not joint.is_prismatic else 0.5
            low, high = max(joint.lower, -wide), min(joint.upper, wide)
            values[name] = float(random.uniform(low, high)) if low < high else float(joint.lower)
        found.append(values)
    return found


def _planned(observations: Observations, postures: list[Mapping[str, float]]) -> Observations:
    """Every response, hammer point and level of the campaign in other postures; nothing measured yet."""
    key = np.unique(
        np.column_stack([observations.response, observations.reference, observations.level]), axis=0
    )
    count, lines = len(postures), observations.value.shape[1]
    table = np.tile(key, (count, 1))
    return replace(
        observations,
        postures=tuple(CampaignPosture(k + 1, f"planned_{k + 1}", q) for k, q in enumerate(postures)),
        posture=np.repeat(np.arange(count), len(key)),
        response=table[:, :2],
        reference=table[:, 2:4],
        level=table[:, 4],
        value=np.ones((len(table), lines), dtype=complex),
        variance=np.zeros((len(table), lines)),
        used=np.ones((len(table), lines), dtype=bool),
    )

"""Ports in the measurement: what a sensor or a hammer says of the motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.lawfree.port import PortKind, constant
from flexmodal.identification import Observations


def _of_sensor(observations: Observations, context: Context, where: str) -> np.ndarray:
    return np.asarray(observations.response[:, 0] == context.point(where).id)


def _of_hammer(observations: Observations, context: Context, where: str) -> np.ndarray:
    return np.asarray(observations.reference[:, 0] == context.point(where).id)


SENSOR = PortKind(
    name="sensor",
    says="what the sensor reads",
    places=lambda context: context.sensors,
    functions=lambda context, where: ("ln gain",),
    sizes=lambda context, where, frequency: constant([1.0], frequency),
    unit="",
    reads=_of_sensor,
)
HAMMER = replace(
    SENSOR,
    name="hammer",
    says="what the hammer reads",
    places=lambda context: tuple(
        context.point(number).name for number in sorted({number for number, _ in context.references})
    ),
    reads=_of_hammer,
)

CHANNEL = replace(
    SENSOR,
    name="channel",
    says="a sensor that reads something else, posture for posture differently",
    drops=True,
)
BLOWS = replace(
    HAMMER,
    name="blows",
    says="blows that go elsewhere, posture for posture differently",
    places=lambda context: HAMMER.places(context) if len(HAMMER.places(context)) > 1 else (),
    drops=True,
)
NOTHING = replace(
    SENSOR,
    name="nothing",
    says="nothing",
    places=lambda context: ("",),
    reads=lambda observations, context, where: np.zeros(len(observations), dtype=bool),
)
"""The re-tuned robot."""

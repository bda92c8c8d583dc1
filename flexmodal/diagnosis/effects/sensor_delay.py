"""A sensor that lags: a delay, low passes, an all-pass, an average over a time.

At the next level with another low pass, later and later, or earlier, from the first posture to the last, and
later along one axis than along another, as of a converter that takes its channels in turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Effect, Level, Placement, positive, signed
from flexmodal.structure import Parameter
from flexmodal.structure.structure import Axis

BUTTERWORTH = 0.5
"""How much of second order Butterworth's filter of that order has."""
DELAYS = (1e-4, 1e-3, 2e-3, 4e-3, 7e-3, 0.011, 0.016)
"""Where fits start [s]: phases beyond half a turn are told apart by these only."""


LAGS = (1e-5, 1e-3, 6e-3)
"""Time constants from which fits start [s]; the first is none to speak of."""
FILTERS, BESSEL = (1e-3, 3e-3, 8e-3), 1 / 3
"""Times of a low pass of second order from which fits start [s], and how much of second order it has there:
1/3 is Bessel's, 1/2 Butterworth's."""
TURNS = (3e-3, 8e-3, 0.02)
"""Times of an all-pass from which fits start [s]: its phase bends where a delay's goes on."""


FURTHER = ("further_time", "further_order")
"""Of another low pass up to second order, which the wider law has besides: both are one of fourth order."""
AVERAGED = (1e-3, 3e-3, 5e-3, 7e-3, 0.01, 0.014)
"""Times over which a sensor averages, from which fits start [s]."""
DRIFT = "drift"
"""By how much later the sensor is in the last posture than in the first, as of a clock of its own."""
DRIFTS = (-4e-3, -1e-3, 1e-3, 4e-3)
"""From which fits start [s]."""
LATER = ("second_later", "third_later")
"""By how much later it reads its second and its third axis than its first."""
SKEWS = tuple(sign * skew for skew in (2e-4, 6e-4, 2e-3) for sign in (1, -1))
"""From which fits start [s]."""
LEAST = 1e-6
"""Size of the average of a whole period, which is nothing."""


def _lag(placement: Placement, axis: Axis) -> np.ndarray:
    """A pure delay behind a low pass up to second order, an all-pass, and an average over a time.

    The low pass is 1/(1 + sT + q s²T²), of first order with q = 0.

    The average, or a value held for as long: (1 − e^{−sT})/(sT) (Åström and Wittenmark, Computer-Controlled
    Systems, Prentice-Hall 1997).
    """
    low, turn = axis.s * placement["time_constant"], axis.s * placement["all_pass_time"] / 2
    low = low + placement["second_order"] * low**2
    x = axis.s * placement["averaged_over"]
    small = np.abs(x) < LEAST
    mean = np.where(small, 1.0, -np.expm1(-x) / np.where(small, 1.0, x))
    mean = np.where(np.abs(mean) < LEAST, LEAST, mean)
    lag = -axis.s * placement["delay"] - np.log1p(low) + np.log1p(-turn) - np.log1p(turn)
    if FURTHER[0] in placement.values:
        low = axis.s * placement[FURTHER[0]]
        lag = lag - np.log1p(low + placement[FURTHER[1]] * low**2)
    if placement.values.get(DRIFT):
        lag = lag - (placement[DRIFT] * placement.progress)[:, None] * axis.s
    if LATER[0] in placement.values:
        later = np.array([0.0, *(placement[name] for name in LATER)])
        lag = lag - later[placement.response[:, 1] - 1][:, None] * axis.s
    return np.asarray(lag + np.log(mean))


def _lag_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    return (
        signed("delay", "s", 5e-3, -0.03, 0.03),
        positive("time_constant", "s", 1e-5, 2.5, 1e-6, 0.1),
        signed("second_order", "", 0.3, 0.0, 2.25),
        positive("all_pass_time", "s", 1e-5, 2.5, 1e-6, 0.1),
        positive("averaged_over", "s", 1e-5, 2.5, 1e-6, 0.05),
    )


def _further_parameters(context: Context, where: str) -> tuple[Parameter, ...]:
    time, order = FURTHER
    return (
        *_lag_parameters(context, where),
        positive(time, "s", 1e-5, 2.5, 1e-6, 0.1),
        signed(order, "", 0.6, 0.0, 4.0),
        signed(DRIFT, "s", 2e-3, -0.03, 0.03),
        *(signed(name, "s", 1e-3, -0.02, 0.02) for name in LATER),
    )


def _further_starts(context: Context, where: str, values: Mapping[str, float]) -> list[Mapping[str, float]]:
    """From where the narrower law was, and Butterworth's filters of order 4 alone."""
    time, order = FURTHER
    found = [{**values, time: share, order: BUTTERWORTH} for share in FILTERS]
    slow, fast = 2 * np.cos(np.pi * np.array([1, 3]) / 8)
    alone = {**values, "delay": 0.0, "all_pass_time": 1e-6, "averaged_over": 1e-6}
    sections = {"second_order": 1 / slow**2, order: 1 / fast**2}
    found += [{**one, DRIFT: drift} for one in (values, alone) for drift in DRIFTS]
    second, third = LATER
    found += [
        {**one, second: part * skew, third: skew}
        for one in (values, alone)
        for skew in SKEWS
        for part in (0.5, 1.0)
    ]
    return [
        *found,
        *({**alone, **sections, "time_constant": slow * one, time: fast * one} for one in FILTERS),
    ]


WIDE = Effect(
    name="time_delay",
    says="a sensor lags",
    places=lambda context: context.sensors,
    parameters=_further_parameters,
    starts=lambda context, where: [
        *({"delay": delay, "time_constant": lag} for delay in (0.0, *DELAYS) for lag in LAGS),
        *({"delay": 0.0, "time_constant": time, "second_order": BESSEL} for time in FILTERS),
        *({"delay": 0.0, "all_pass_time": turn} for turn in TURNS),
        *({"delay": 0.0, "averaged_over": time} for time in AVERAGED),
    ],
    read=_lag,
)
EFFECT = replace(WIDE, parameters=_lag_parameters, next_level=Level(WIDE, _further_starts))

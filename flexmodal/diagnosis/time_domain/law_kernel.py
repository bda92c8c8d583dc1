"""Laws of torque and their slopes for many blows side by side, compiled by `integration`.

Loops over lanes have no branch and call nothing that has one, so that a compiler makes them loops over vector
registers: exponential and logarithm are written out, right but for the last digit or two, and what does not
apply is worked out all the same and not taken. Codes and formulas of the laws are those of `law`.
"""

from __future__ import annotations

from typing import no_type_check

import numpy as np

from flexmodal.diagnosis.time_domain.law import NUMBERS

OLD, END, BEFORE, HELD, FOUND, GUESS, SLOPE, FREE, SIZE, MOST, STUCK, STUCK_BEFORE = range(12)
"""What is kept of a law for each lane: elongation (of a law by speed that speed) one step ago and now; torque
two steps and one step ago, now, and at the elongation that is tried; its slope there; the elongation that
there would be without torques now; the largest so far; the limit of friction, and what of its torque is no
damping one and two steps ago."""
GIVEN, QUANTITIES = 12, 12 + NUMBERS
"""Where the parameters begin, and how much is kept."""

ROUNDING = 6755399441055744.0
"""1.5 · 2⁵²: a number that is added to it is rounded to a whole one, which stands in the last bits."""
PER_OCTAVE, OCTAVE, OCTAVE_REST = 1.4426950408889634, 0.6931471803691238, 1.9082149292705877e-10
"""1 / ln 2, and ln 2 in two parts, the first of which times a whole number of octaves is exact."""
MIDDLE, POINT = 4604544271217802189, 4841369599423283200
"""Bits of √½ and of 2⁵²."""
LARGEST, NOTHING = 700.0, 1e-300
SLOW_WAY = 0.01
"""Part of the way to sliding in a step below which what follows a moving limit comes from its series."""
SERIES = 0.0025
"""x² below which tanh x comes from its series: there 1 − e^(−2x) would lose digits."""


@no_type_check  # a checker's wrapper cannot be compiled
def exponential(x):
    """Power of e to a number; beyond ±700 as there.

    Args:
        x: the number.
    """
    x = LARGEST if x > LARGEST else x
    x = -LARGEST if x < -LARGEST else x
    shifted = np.float64(x * PER_OCTAVE + ROUNDING)
    octaves = shifted - ROUNDING
    r = (x - octaves * OCTAVE) - octaves * OCTAVE_REST
    p = r * (1.0 / 6227020800.0) + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = p * r + 1.0
    p = p * r + 1.0
    return p * np.int64((shifted.view(np.int64) << 52) + (1023 << 52)).view(np.float64)


@no_type_check
def logarithm(x):
    """Natural logarithm of a positive number; of what is not, something.

    Args:
        x: the number.
    """
    bits = np.float64(x).view(np.int64)
    exponent = np.int64(np.uint64(bits - MIDDLE + (1023 << 52)) >> np.uint64(52))
    mantissa = np.int64(bits - ((exponent - 1023) << 52)).view(np.float64)
    octaves = np.int64(exponent | POINT).view(np.float64) - 4503599627370496.0 - 1023.0
    s = (mantissa - 1.0) / (mantissa + 1.0)
    q = s * s
    p = q * (1.0 / 23.0) + 1.0 / 21.0
    p = p * q + 1.0 / 19.0
    p = p * q + 1.0 / 17.0
    p = p * q + 1.0 / 15.0
    p = p * q + 1.0 / 13.0
    p = p * q + 1.0 / 11.0
    p = p * q + 1.0 / 9.0
    p = p * q + 1.0 / 7.0
    p = p * q + 1.0 / 5.0
    p = p * q + 1.0 / 3.0
    return octaves * OCTAVE + (2.0 * s + (2.0 * s * q * p + octaves * OCTAVE_REST))


@no_type_check
def hardened(w):
    """Torques of a spring that hardens, and their slopes.

    Args:
        w: quantities of the law, [quantity, lane]; torques that are tried and their slopes are filled.
    """
    end, guess, slope = w[END], w[GUESS], w[SLOPE]
    stiffness, bend, wound, linear = w[GIVEN], w[GIVEN + 1], w[GIVEN + 2], w[GIVEN + 3]
    for b in range(len(end)):
        rest, ratio = wound[b] / bend[b], (end[b] + wound[b]) / bend[b]
        rest, ratio = rest * rest, ratio * ratio
        part = ratio / (1.0 + ratio)
        held = stiffness[b] * wound[b] * rest / (1.0 + rest)
        guess[b] = stiffness[b] * (end[b] + wound[b]) * part - held + linear[b] * end[b]
        slope[b] = stiffness[b] * part * (3.0 + ratio) / (1.0 + ratio) + linear[b]


@no_type_check
def knee(w):
    """Torques of a spring that has another slope beyond a deflection, and their slopes.

    Args:
        w: see `hardened`.
    """
    end, guess, slope = w[END], w[GUESS], w[SLOPE]
    stiffness, bend, wound, linear = w[GIVEN], w[GIVEN + 1], w[GIVEN + 2], w[GIVEN + 3]
    over = w[GIVEN + 4]
    for b in range(len(end)):
        d, e, rest, now = bend[b], over[b] * over[b], wound[b], end[b] + wound[b]
        low, high = rest - d, rest + d
        held = rest * (1.0 - 2.0 * d / (np.sqrt(low * low + e) + np.sqrt(high * high + e)))
        low, high = now - d, now + d
        near, far = np.sqrt(low * low + e), np.sqrt(high * high + e)
        guess[b] = stiffness[b] * (now * (1.0 - 2.0 * d / (near + far)) - held) + linear[b] * end[b]
        slope[b] = stiffness[b] * (1.0 + 0.5 * (low / near - high / far)) + linear[b]


@no_type_check
def slow(w):
    """Torques of friction that is viscous when slow, and their slopes.

    Args:
        w: see `hardened`; instead of elongations there are speeds.
    """
    end, guess, slope = w[END], w[GUESS], w[SLOPE]
    most, speed = w[GIVEN], w[GIVEN + 1]
    for b in range(len(end)):
        x = end[b] / speed[b]
        left = exponential(-2.0 * abs(x))
        share = (1.0 - left) / (1.0 + left)
        share = -share if x < 0.0 else share
        q = x * x
        p = 62.0 / 2835.0 - q * (1382.0 / 155925.0)
        p = 17.0 / 315.0 - q * p
        p = 2.0 / 15.0 - q * p
        p = x - x * q * (1.0 / 3.0 - q * p)
        share = p if q < SERIES else share
        guess[b] = most[b] * share
        slope[b] = most[b] / speed[b] * (1.0 - share * share)


@no_type_check
def limits(w):
    """What friction slips at, by the speed in the step and what the joint carries in its middle.

    Args:
        w: see `hardened`; the limits are filled.
    """
    old, end, most = w[OLD], w[END], w[MOST]
    torque, more, speed, growing, wound = w[GIVEN], w[GIVEN + 3], w[GIVEN + 4], w[GIVEN + 6], w[GIVEN + 7]
    for b in range(len(end)):
        x = (end[b] - old[b]) / speed[b] if more[b] > 0.0 else 0.0
        carried = growing[b] * abs(0.5 * (old[b] + end[b]) + wound[b])
        most[b] = torque[b] * (1.0 + more[b] * exponential(-x * x)) + carried


@no_type_check
def rubbed(w):
    """Torques of dry friction, and their slopes.

    The damping of what sticks goes by a backward difference of second order. Where a torque falls back to a
    lower limit its derivative is given as 0: the equations of a step then stay far from singular, and settle
    all the same. A limit that grows with the elongation is followed exponentially, which is exact at an
    exponent of 1, and at once where it slips at once; its derivative is near enough to settle.

    Args:
        w: see `hardened`; the limits are those of the step, see `limits`.
    """
    old, end, most, guess, slope = w[OLD], w[END], w[MOST], w[GUESS], w[SLOPE]
    stiffness, exponent, lag, growing, wound = (
        w[GIVEN + 1], w[GIVEN + 2], w[GIVEN + 5], w[GIVEN + 6], w[GIVEN + 7],
    )  # fmt: skip
    stuck, before = w[STUCK], w[STUCK_BEFORE]
    for b in range(len(end)):
        moved, power = end[b] - old[b], 1.0 - exponent[b]
        limit = most[b] if moved >= 0.0 else -most[b]
        share = 1.0 - stuck[b] / limit  # of the way to sliding that is left; negative where the limit fell
        size, way = abs(share), stiffness[b] * abs(moved) / most[b]
        decayed = exponential(-way)
        smooth = abs(power) < 1e-9
        root = 1.0 if smooth else power
        shrunk = size * decayed
        left = exponential(root * logarithm(size)) - root * way
        sharp = exponential(logarithm(left) / root)
        sharp = 0.0 if (size < NOTHING) | (left < NOTHING) else sharp
        size = shrunk if smooth else sharp
        ratio = size if smooth else sharp / (left if left > NOTHING else 1.0)
        followed = 0.5 * (1.0 + decayed) - (1.0 - decayed) / (way if way > 0.0 else 1.0)
        followed = way * way / 12.0 if way < SLOW_WAY else followed
        outer, middle = abs(end[b] + wound[b]), abs(0.5 * (old[b] + end[b]) + wound[b])
        followed *= (outer - abs(old[b] + wound[b])) * (1.0 if smooth else exponent[b])
        grows = growing[b] * (followed if smooth | (size > 0.0) else outer - middle)
        grows = grows if moved >= 0.0 else -grows
        size = -size if share < 0.0 else size
        falls = stiffness[b] * ratio
        grown = 1.0 + 1.5 * lag[b]
        guess[b] = grown * (limit - limit * size + grows) - lag[b] * (2.0 * stuck[b] - 0.5 * before[b])
        outward = growing[b] if (moved >= 0.0) == (end[b] + wound[b] >= 0.0) else -growing[b]
        slope[b] = grown * (falls + outward * (1.0 - size) * (1.0 - ratio)) if share > 0.0 else 0.0


@no_type_check
def stuck_of(w):
    """Keep what of the torques of friction that were found is no damping.

    Args:
        w: see `hardened`.
    """
    found, lag, stuck, before = w[FOUND], w[GIVEN + 5], w[STUCK], w[STUCK_BEFORE]
    for b in range(len(found)):
        now = (found[b] + lag[b] * (2.0 * stuck[b] - 0.5 * before[b])) / (1.0 + 1.5 * lag[b])
        before[b] = stuck[b]
        stuck[b] = now

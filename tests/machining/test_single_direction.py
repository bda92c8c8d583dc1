"""Tlusty's closed form: against one mode on paper, and against the delay equation's own roots."""

import cmath
import math

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest
from flexmodal.machining import oriented, single_direction


def mode(line, frequency=250.0, ratio=0.05, stiffness=2e7):
    return 1 / (stiffness * (1 - (line / frequency) ** 2 + 2j * ratio * line / frequency))


def test_one_mode_on_paper():
    """b = 2 k ζ (1 + ζ) / K_s at ω_n √(1 + 2ζ)."""
    line = np.linspace(1, 2000, 400001)
    found = single_direction(line, mode(line), 1.5e9)
    assert found.limiting_width == pytest.approx(
        2 * 2e7 * 0.05 * 1.05 / 1.5e9, rel=1e-7
    )  # a grid of 0.005 Hz
    assert found.frequency[found.width.argmin()] == pytest.approx(250 * math.sqrt(1.1), abs=0.01)


@pytest.mark.parametrize("teeth", [1, 2])
def test_every_point_solves_the_delay_equation(teeth):
    """1 + b K_s G(ω) (1 − exp(−iωT)) = 0."""
    line = np.linspace(251, 400, 41)
    found = single_direction(line, mode(line), 1.5e9, teeth=teeth, lobes=4)
    for lobe in range(4):
        for f, width, speed in zip(found.frequency, found.width, found.speed[lobe], strict=True):
            period = 60 / (teeth * speed)
            assert lobe <= f * period < lobe + 1  # so many whole waves
            left = 1 + width * 1.5e9 * complex(mode(f)) * (1 - cmath.exp(-2j * math.pi * f * period))
            assert abs(left) < 1e-9


def test_no_negative_real_part_no_limit():
    line = np.linspace(1, 100, 50)
    found = single_direction(line, np.full(50, 1e-8 + 0j), 1e9)
    assert found.limiting_width == math.inf
    assert found.speed.shape == (10, 0)


def test_orientation():
    """A boring bar soft along y, the force at 60° to it, the chip along y: u = cos 60°."""
    receptance = np.zeros((3, 3, 3), dtype=complex)
    receptance[:, 1, 1] = [1e-7, 2e-7 - 1e-7j, -1e-7j]
    force = np.array([math.sin(math.radians(60)), math.cos(math.radians(60)), 0]) * 5
    found = oriented(receptance, force, np.array([0, 2.0, 0]))
    np.testing.assert_allclose(found, 0.5 * receptance[:, 1, 1])


@pytest.mark.parametrize("bad", [np.zeros(3), np.array([1.0, np.nan, 0.0]), np.ones(2)])
def test_directions_that_are_none(bad):
    with pytest.raises(InvalidRequest, match="three finite numbers"):
        oriented(np.zeros((1, 3, 3), dtype=complex), bad, np.array([1.0, 0, 0]))


@pytest.mark.parametrize("options", [{"specific_force": 0.0}, {"teeth": 0}, {"lobes": 0}])
def test_bad_numbers(options):
    line = np.array([1.0, 2.0])
    values = {"specific_force": 1e9} | options
    with pytest.raises(InvalidRequest, match="arguments"):
        single_direction(line, mode(line), values.pop("specific_force"), **values)

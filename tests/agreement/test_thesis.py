"""Numbers printed in the thesis that follow from its own tables, through flexmodal."""

from __future__ import annotations

import csv
import itertools
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.model import Robot

from .planar_chain import FANUC, FANUC_DAMPING, FANUC_STIFFNESS

TABLES = Path(__file__).parent.parent / "data" / "thesis"


def table(name: str) -> list[dict[str, str]]:
    with (TABLES / f"{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def arm() -> Robot:
    return flexmodal.load("six_link")


@pytest.fixture(scope="module")
def fanuc() -> Robot:
    return flexmodal.load("fanuc_s360")


def stiffness_within_rounding(robot: Robot, angles: np.ndarray, decimals: int) -> tuple[float, float]:
    """Smallest and largest stiffness over the box of angles that print alike.

    The measure is smooth over a box this small, so its extremes lie at corners.
    """
    half = 0.5 * 10.0**-decimals
    found = [
        robot.measures(dict(zip(robot.moving, angles + half * np.array(corner), strict=True))).stiffness
        for corner in itertools.product((-1, 1), repeat=6)
    ]
    return min(found), max(found)


@pytest.mark.parametrize("number", ["1", "2", "3"])
def test_stiffness_of_appendix_f(arm, number):
    """Initial postures are known to four decimals (Tables 3.8, 3.9) or exactly, finals to two."""
    printed = {
        row["stage"]: row for row in table("six_link_stiffness_check") if row["table"] == f"F.{number}"
    }
    start = np.array(list(arm.postures[f"start_{number}"].values()))
    low, high = stiffness_within_rounding(arm, start, 4)
    value = float(printed["initial"]["printed_n_per_m"])
    # three digits are printed, so half a unit of the third on either side
    assert low - 5 <= value <= high + 5
    final = np.array(list(arm.postures[f"f{number}_final"].values()))
    low, high = stiffness_within_rounding(arm, final, 2)
    value = float(printed["final"]["printed_n_per_m"])
    assert low - 50 <= value <= high + 50
    # and the box is narrow enough for that to say something
    assert high - low <= 0.06 * value
    # the extremes beside the table were sampled inside the box, to four digits
    assert low <= float(printed["final"]["min_over_angle_rounding"]) * 1.0005
    assert high >= float(printed["final"]["max_over_angle_rounding"]) * 0.9995


def test_as_printed_the_stiffness_is_ten_times_too_small(arm):
    as_printed = flexmodal.load(
        arm.urdf.path,
        stiffness={name: joint.stiffness / 10 for name, joint in arm.joints.items()},
        tool="tool",
    )
    for posture in ("start_1", "start_2", "start_3", "f1_final"):
        values = arm.postures[posture]
        assert as_printed.measures(values).stiffness == pytest.approx(arm.measures(values).stiffness / 10)


def test_static_receptance(arm):
    measures = arm.measures("start_3", frequency=0.0)
    assert measures.static_receptance == pytest.approx(6.85e-4, abs=5e-7)  # Table E.3 prints three digits
    assert measures.receptance == pytest.approx(measures.static_receptance, rel=1e-13)


@pytest.mark.parametrize("posture", ["configuration_1", "configuration_4", "configuration_7"])
def test_unit_multiplier_sum_of_chapter_3(fanuc, posture):
    """|Σ 1/(iω − λ)| over eight poles. Far above them it is nearly 8/ω, so the posture hardly matters."""
    poles, _ = fanuc.modes(posture).expanded()
    assert len(poles) == 8

    def total(frequency: float) -> float:
        return float(abs(np.sum(1 / (2j * np.pi * frequency - poles))))

    # Four and three digits; with every length and posture the fourth stays within two units.
    assert total(1000) == pytest.approx(1.278e-3, abs=2e-6)
    assert total(1500) == pytest.approx(8.50e-4, abs=1e-6)
    assert total(500) == pytest.approx(2.585e-3, abs=8e-6)  # 2.29 is printed, a misprint of 2.59


FREQUENCIES = {
    "configuration_1": (7.64, 51.3, 56.9, 94.4),
    "configuration_2": (7.66, 51.3, 56.1, 93.1),
    "configuration_6": (7.70, 51.0, 56.1, 93.1),
    "configuration_7": (7.71, 50.9, 56.5, 93.9),
}


@pytest.mark.parametrize("posture", FREQUENCIES)
def test_natural_frequencies_of_the_fanuc(fanuc, posture):
    modes = fanuc.modes(posture)
    # a unit of the last digit: some of the listed values were rounded from rounded ones
    np.testing.assert_allclose(modes.frequency, FREQUENCIES[posture], atol=0.06)
    np.testing.assert_allclose(modes.frequency[0], FREQUENCIES[posture][0], atol=0.006)
    low, high = (0.104, 0.071, 0.026, 0.055), (0.108, 0.0725, 0.0475, 0.062)
    assert np.all(
        (modes.damping_ratio > np.array(low) - 1e-3) & (modes.damping_ratio < np.array(high) + 1e-3)
    )


FINALS = {"e10_final": (-3.5, 1), "e11_final": (-2, 2), "e15_final": (0, 1.5), "f2_final": (-2, 2)}


@pytest.mark.parametrize("posture", FINALS)
def test_printed_finals_reach_their_place(arm, posture):
    x, _, z = arm.at(posture).position("tool")
    # ±0.005 rad in each of six angles with lever arms of up to 4 m: some centimetres, millimetres mostly
    assert (x, z) == pytest.approx(FINALS[posture], abs=0.06)


def test_two_routes_to_the_frequencies(fanuc):
    """|λ| from the modes, and from the companion matrix of the independent chain."""
    posed = fanuc.at("configuration_6")
    angles = np.array([posed.posture.values.get(joint, 0.0) for joint in fanuc.moving])
    mass = FANUC.mass_matrix(angles)
    lower = -np.linalg.solve(mass, np.hstack([np.diag(FANUC_STIFFNESS), np.diag(FANUC_DAMPING)]))
    poles = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((4, 4)), np.eye(4)]), lower]))
    expected = np.sort(np.abs(poles[poles.imag > 0])) / (2 * np.pi)
    np.testing.assert_allclose(posed.modes().frequency, expected, rtol=1e-10)  # eigenvalues to ~cond × 1e-16

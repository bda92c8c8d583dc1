"""The gradient of the receptance against the complex step through a planar chain of our own."""

from __future__ import annotations

import numpy as np
import pytest

import flexmodal
from flexmodal.frf import PointDirection
from flexmodal.model import PosedRobot
from flexmodal.model.gradient import receptance_and_gradient

from .planar_chain import (
    FANUC,
    FANUC_DAMPING,
    FANUC_STIFFNESS,
    SIX_LINK,
    SIX_LINK_DAMPING,
    SIX_LINK_STIFFNESS,
    PlanarChain,
)

STEP = 1e-30
"""No difference is taken, so the step can be as small as one likes: its error, STEP², is nothing."""


def real_form(
    chain: PlanarChain,
    angles: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    omega: float,
    pick: list[int],
) -> np.ndarray:
    """Real and imaginary part of the 2 × 2 receptance (x, z) of the tool, apart.

    The imaginary unit of the complex step must not mix with that of the receptance, so Z = A + iC is
    written as [[A, −C], [C, A]].
    """
    rows = chain.tool(angles)[:2, pick]
    a = np.diag(stiffness[pick]) - omega**2 * chain.mass_matrix(angles)[np.ix_(pick, pick)]
    c = np.diag(omega * damping[pick])
    solved = np.linalg.solve(np.block([[a, -c], [c, a]]), np.vstack([rows.T, np.zeros_like(rows.T)]))
    count = len(pick)
    return np.array([rows @ solved[:count], rows @ solved[count:]])


def complex_step(*arguments) -> tuple[np.ndarray, np.ndarray]:
    chain, angles, *rest = arguments
    value = real_form(chain, angles, *rest)
    slopes = []
    for unit in np.eye(len(angles)):
        real, imaginary = real_form(chain, angles + 1j * STEP * unit, *rest).imag / STEP
        slopes.append(real + 1j * imaginary)
    return value[0] + 1j * value[1], np.stack(slopes, axis=-1)


CASES = {
    "six_link": (SIX_LINK, SIX_LINK_STIFFNESS, SIX_LINK_DAMPING, list(range(6))),
    "six_link, three joints rigid": (SIX_LINK, SIX_LINK_STIFFNESS, SIX_LINK_DAMPING, [0, 3, 5]),
    "fanuc_s360": (FANUC, FANUC_STIFFNESS, FANUC_DAMPING, list(range(4))),
}


@pytest.mark.parametrize("case", CASES)
def test_gradient(case: str):
    chain, stiffness, damping, pick = CASES[case]
    robot = flexmodal.load(case.split(",", maxsplit=1)[0])
    if len(pick) < len(robot.joints):
        names = [list(robot.joints)[place] for place in pick]
        robot = flexmodal.load(
            robot.urdf.path,
            stiffness={name: robot.joints[name].stiffness for name in names},
            damping={name: robot.joints[name].damping for name in names},
        )
    directions = (PointDirection.parse("tool:+x"), PointDirection.parse("tool:+z"))
    generator = np.random.default_rng(6)
    for _ in range(6):
        posture = robot.posture(
            {
                name: generator.uniform(max(joint.lower, -3.0), min(joint.upper, 3.0))
                for name, joint in robot.commanded.items()
            }
        )
        posed = PosedRobot(robot, posture)
        angles = np.array([posture.values.get(name, 0.0) for name in robot.moving])
        resonance = float(posed.modes().frequency[0])
        lines = np.unique([0.0, 1.0, 20.0, 100.0, resonance, resonance * 1.001])
        value, slope = receptance_and_gradient(posed, directions, lines)
        for line, frequency in enumerate(lines):
            expected, steps = complex_step(chain, angles, stiffness, damping, 2 * np.pi * frequency, pick)
            # Two exact derivatives: what is left is rounding, times the condition of Z (some 1e3).
            assert np.max(np.abs(value[line] - expected)) <= 1e-12 * np.max(np.abs(expected))
            assert np.max(np.abs(slope[line] - steps)) <= 1e-12 * np.max(np.abs(steps))


def test_undamped_near_resonance():
    """Without damping the slopes grow like 1/Δ² near a resonance; the relative error only like 1/Δ."""
    robot = flexmodal.load("six_link")
    bare = flexmodal.load(
        robot.urdf.path, stiffness={name: joint.stiffness for name, joint in robot.joints.items()}
    )
    posed = bare.at(dict(robot.postures["start_2"]))
    angles = np.array(list(robot.postures["start_2"].values()))
    resonance = float(posed.modes().frequency[2])
    directions = (PointDirection.parse("tool:+x"), PointDirection.parse("tool:+z"))
    for gap in (1e-2, 1e-4, 1e-6):
        line = resonance * (1 + gap)
        _, slope = receptance_and_gradient(posed, directions, np.array([line]))
        _, steps = complex_step(
            SIX_LINK, angles, SIX_LINK_STIFFNESS, np.zeros(6), 2 * np.pi * line, list(range(6))
        )
        assert np.max(np.abs(slope[0] - steps)) <= 1e-12 / gap * np.max(np.abs(steps))

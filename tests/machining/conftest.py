"""Cuts and tips that the tests share; the published benchmark among them."""

import math

import jaxtyping
import numpy as np
import pytest

import flexmodal
from flexmodal.machining import (
    Cut,
    CutFrame,
    Cutter,
    CuttingForce,
    Engagement,
    ToolMode,
    immersion_angles,
    modal_tip,
)

STIFFNESS = 0.03993 * (2 * math.pi * 922) ** 2
"""The benchmark's modal mass is given, 0.03993 kg at 922 Hz."""


@pytest.fixture(scope="session")
def benchmark():
    """The cutter of Insperger and Stépán (2004), used by most papers on milling stability since.

    0.03993 kg, 922 Hz, 1.1 %, two teeth, K_t = 6e8 and K_n = 2e8 N/m²; flexible along x alone or along both.
    """

    def build(immersion=1.0, milling="down", axes="x", teeth=2, helix=0.0, speeds=(5000.0, 25000.0), **more):
        entry, leaving = immersion_angles(immersion, milling)
        modes = tuple(ToolMode(axis, 922.0, 0.011, STIFFNESS) for axis in axes)
        cut = Cut(
            Cutter(teeth, 0.01, helix=helix),
            CuttingForce(6e8, 1 / 3, more.pop("axial_ratio", 0.0), **more.pop("edge", {})),
            Engagement(entry, leaving, speeds, **more),
            CutFrame("tool", "+z", "+x"),
            modes,
        )
        return cut, modal_tip(modes)

    return build


@pytest.fixture(scope="session")
def two_modes():
    """The half immersion up-milling of Weck, Altintas and Beer, as Altintas and Budak (1995) compute it.

    603 and 666 Hz, 3.9 and 3.5 %, 5.59 and 5.715 kN/mm, three teeth, K_t = 600 N/mm², K_r / K_t = 0.07.
    """
    entry, leaving = immersion_angles(0.5, "up")
    modes = (ToolMode("x", 603.0, 0.039, 5.59e6), ToolMode("y", 666.0, 0.035, 5.715e6))
    cut = Cut(
        Cutter(3, 0.02),
        CuttingForce(6e8, 0.07),
        Engagement(entry, leaving, (3000.0, 20000.0)),
        CutFrame("tool", "+z", "+x"),
        modes,
    )
    return cut, modal_tip(modes)


@pytest.fixture(scope="session")
def fanuc():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="session")
def ur10():
    return flexmodal.load("ur10", stiffness=5e4, damping=40.0)


@pytest.fixture(scope="session")
def across():
    """A cut in the Fanuc's plane of motion, the cutter across it, without modes of its own."""

    def build(speeds=(600.0, 20000.0), modes=(), **frame):
        entry, leaving = immersion_angles(0.5, "down")
        settings = {"relative_to": "world", "axis": "+y", "feed": "+x"} | frame
        return Cut(
            Cutter(2, 0.016),
            CuttingForce(7e8, 0.3),
            Engagement(entry, leaving, speeds),
            CutFrame(**settings),
            modes,
        )

    return build


@pytest.fixture
def untyped():
    """Callers whose types nobody checks: what they pass is for flexmodal itself to judge."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


def rpm(*speeds):
    return np.array(speeds, dtype=float)

from dataclasses import replace
from pathlib import Path

import jaxtyping
import pytest

import flexmodal
from flexmodal.cards import CouplingCard, FrozenDict
from flexmodal.model import Robot

from ..model.writing import planar


@pytest.fixture(scope="session")
def arm() -> Robot:
    return flexmodal.load("six_link")


@pytest.fixture(scope="session")
def fanuc() -> Robot:
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="session")
def lossy(fanuc) -> Robot:
    """Springs of causal hysteresis, the stiffest the most, and two of them tied."""
    joints = {
        name: replace(joint, loss_factor=0.1 * (1 + place))
        for place, (name, joint) in enumerate(fanuc.joints.items())
    }
    tied = FrozenDict({"q1+q2": CouplingCard(("q1", "q2"), 4e4)})
    return replace(fanuc, joints=FrozenDict(joints), couplings=tied, loss_frequency=20.0)


@pytest.fixture(scope="session")
def always_lossy(lossy) -> Robot:
    """K (1 + iη) at every frequency, no coupling."""
    return replace(lossy, couplings=FrozenDict({}), loss_frequency=None)


@pytest.fixture(scope="session")
def ur5() -> Robot:
    return flexmodal.load("ur5", stiffness=2e4, damping=20.0, tool="tool0")


@pytest.fixture(scope="session")
def xarm7() -> Robot:
    return flexmodal.load("xarm7", stiffness=2e4, damping=20.0, tool="link_eef")


@pytest.fixture(scope="session")
def robots(arm, fanuc, ur5) -> dict[str, Robot]:
    return {"six_link": arm, "fanuc_s360": fanuc, "ur5": ur5}


@pytest.fixture(scope="session")
def tight(tmp_path_factory) -> Robot:
    """The six-link arm with limits that are nearly always in the way."""
    path = planar(
        Path(tmp_path_factory.mktemp("tight")) / "tight.urdf",
        [1.0] * 6,
        [10.0] * 6,
        [0.83] * 6,
        [0.5] * 6,
        limits=[(0.0, 2.0), (-0.8, 0.8), (-0.7, 0.7), (-0.9, 0.9), (-0.6, 1.2), (-1.0, 1.0)],
    )
    stiffness = dict(zip([f"q{i}" for i in range(1, 7)], [3e4, 2e4, 1.5e4, 1.5e4, 1e4, 1e4], strict=True))
    return flexmodal.load(path, stiffness=stiffness, damping=500.0)


@pytest.fixture
def types_unchecked():
    """Whole searches without the type checks, which would take three quarters of the time.

    The same functions are called with types checked in test_objectives, test_hold and test_quadratic.
    """
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)

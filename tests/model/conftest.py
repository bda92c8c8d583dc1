from pathlib import Path

import jaxtyping
import pytest

import flexmodal
from flexmodal.model import Robot

from .writing import mixed


@pytest.fixture(scope="session")
def mixed_path(tmp_path_factory) -> Path:
    """Prismatic, continuous and revolute joints, fixed links with mass, two branches."""
    return mixed(tmp_path_factory.mktemp("mixed") / "mixed.urdf")


@pytest.fixture(scope="session")
def mixed_robot(mixed_path: Path) -> Robot:
    return flexmodal.load(mixed_path, stiffness=2e4, damping=30.0, tool="tool")


@pytest.fixture(scope="session")
def fanuc() -> Robot:
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="session")
def arm() -> Robot:
    return flexmodal.load("six_link")


@pytest.fixture(scope="session")
def ur5() -> Robot:
    return flexmodal.load("ur5", stiffness=2e4, damping=20.0)


@pytest.fixture(scope="session")
def robots(arm, fanuc, ur5, mixed_robot) -> dict[str, Robot]:
    """Planar, planar with a pseudo-joint, spatial, and a tree with a prismatic and a continuous joint."""
    return {"six_link": arm, "fanuc_s360": fanuc, "ur5": ur5, "mixed": mixed_robot}


@pytest.fixture
def untyped():
    """Callers whose types nobody checks: what they pass is for flexmodal itself to judge."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)

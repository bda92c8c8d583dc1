"""How much gravity, left out of every model, would move a natural frequency: a pendulum's closed form."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

import flexmodal

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
URDF = """<robot name="pendulum">
<link name="base"/>
<link name="arm"><inertial><origin xyz="{c} 0 0"/><mass value="{m}"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="{moment}" iyz="0" izz="{moment}"/></inertial></link>
<joint name="q1" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 -1 0"/>
<limit lower="-3.2" upper="3.2" effort="1" velocity="1"/></joint>
</robot>
"""


@pytest.fixture(scope="module")
def accuracy():
    sys.path.insert(0, str(BENCHMARKS))
    try:
        import accuracy
    finally:
        sys.path.remove(str(BENCHMARKS))
    return accuracy


@pytest.mark.parametrize("angle", [-math.pi / 2, -0.7, 0.0, 1.0, math.pi / 2])
def test_a_pendulum_on_a_spring(accuracy, tmp_path, angle):
    """V = m g c sin q, so that V'' = −m g c sin q adds to k: hanging it is stiffer, standing softer."""
    mass, centre, stiffness = 3.0, 0.4, 200.0
    path = tmp_path / "pendulum.urdf"
    path.write_text(URDF.format(m=mass, c=centre, moment=0.2))
    arm = flexmodal.load(path, stiffness=stiffness)
    (shift,) = accuracy.gravity_shift(arm, {"q1": angle})
    slope = -mass * accuracy.GRAVITY * centre * math.sin(angle)
    assert shift == pytest.approx(math.sqrt((stiffness + slope) / stiffness) - 1, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(("name", "most"), [("fanuc_s360", 1e-3), ("six_axis", 1e-3), ("six_link", 0.07)])
def test_what_the_page_on_limits_says(accuracy, name, most):
    arm = flexmodal.load(name)
    rng = np.random.default_rng(7)
    low = np.maximum([joint.lower for joint in arm.commanded.values()], -np.pi)
    high = np.minimum([joint.upper for joint in arm.commanded.values()], np.pi)
    postures = (dict(zip(arm.commanded, rng.uniform(low, high).tolist(), strict=True)) for _ in range(50))
    assert most / 10 < max(np.abs(accuracy.gravity_shift(arm, one)).max() for one in postures) < most

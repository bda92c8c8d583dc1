import numpy as np
import pytest

from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.optimisation import Hold, Optimum, Outcome, PostureProblem, ReceptanceObjective, Start


@pytest.fixture(scope="session")
def fanuc():
    return load("fanuc_s360")


@pytest.fixture(scope="session")
def six_link():
    return load("six_link")


@pytest.fixture(scope="session")
def outcome(six_link):
    """Built by hand from a named posture, so that no search needs to run."""
    best, start = six_link.posture("e6_final"), six_link.posture("start_3")
    objective = ReceptanceObjective((PointDirection("tool", "z"),), np.array([2.0]))
    value = objective.value(six_link.at(start))
    x, _, z = six_link.at(best).position("tool")
    return Outcome(
        problem=PostureProblem(six_link, objective, Hold.at(six_link, (x, z))),
        optima=(Optimum(best, objective.value(six_link.at(best)), 12),),
        compared=Start(start, value, 0.0, start, value),
        converged=True,
        starts=64,
        unbounded=0,
        method="newton",
    )


BARE = """<robot name="{name}">
  <link name="base">{base}</link>
  <link name="{link}">
    <inertial><mass value="2"/><origin xyz="0.2 0 0"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    {arm}
  </link>
  <joint name="{joint}" type="revolute"><parent link="base"/><child link="{link}"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <link name="tip"/>
  <joint name="end" type="fixed"><parent link="{link}"/><child link="tip"/><origin xyz="0.5 0 0"/></joint>
</robot>"""


@pytest.fixture
def bare(tmp_path):
    """A one-joint robot from URDF text with holes in it."""

    def build(*, name="bare", link="arm", joint="q", base="", arm=""):
        path = tmp_path / "bare.urdf"
        path.write_text(BARE.format(name=name, link=link, joint=joint, base=base, arm=arm))
        return load(path, stiffness=1e4, damping=1.0)

    return build

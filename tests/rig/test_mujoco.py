"""Other people's physics: MuJoCo's FRFs beside flexmodal's, with nothing hidden and with what both hide."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import check_campaign, read_campaign
from flexmodal.errors import InvalidRequest
from flexmodal.rig import Hide, simulate
from flexmodal.rig.believed import Body

pytest.importorskip("mujoco")
BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
SHORT = {
    "postures": 1, "points": 2, "references": 1, "trials": 1, "averages": 1, "peaks": (100.0,),
    "band": (2.0, 100.0), "record_length": 6.0,
}  # fmt: skip


def load(name: str):
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


model, campaigns = load("mujoco_model"), load("mujoco_campaign")


@pytest.mark.parametrize("name", ["fanuc_s360", "six_axis"])
def test_nothing_hidden_is_the_receptance(name):
    """Off by the integration, (ωh)²/24 of a force that stands still in a step: 6e-4 at 100 Hz, and by what a
    record of 6 s cuts off of the slowest mode."""
    result = campaigns.simulate_mujoco(flexmodal.load(name), **SHORT, **campaigns.QUIET)
    norm, most = campaigns.off_the_model(result)
    assert norm < 1e-2
    assert most < 2e-2  # deep antiresonances among them
    assert norm > 1e-7  # another route, not the same one


@pytest.mark.parametrize("effect", ["added_mass", "base_flexibility", "local_absorber", "sensor_mass"])
def test_what_is_the_same_physics_gives_the_same_frfs(effect):
    robot = flexmodal.load("six_axis")
    hide = [Hide(effect, severity=4.0)]
    mine = campaigns.simulate_mujoco(robot, **SHORT, **campaigns.QUIET, hide=hide, seed=2)
    rig = simulate(robot, **SHORT, **campaigns.QUIET, hide=hide, seed=2)
    bare = simulate(robot, **SHORT, **campaigns.QUIET)
    assert mine.truth == rig.truth
    assert campaigns.apart(mine, rig) < 3e-3
    assert campaigns.apart(mine, bare) > 10 * campaigns.apart(mine, rig)


@pytest.mark.parametrize("effect", ["link_flexibility@link_1", "coulomb_friction@q1"])
def test_what_is_other_physics_of_the_same_kind_comes_near(effect):
    """Stiff pieces for a beam, Jenkins for Dahl: nearer to each other than to nothing hidden."""
    robot = flexmodal.load("fanuc_s360")
    mine = campaigns.simulate_mujoco(robot, **SHORT, **campaigns.QUIET, hide=[effect], seed=2)
    rig = simulate(robot, **SHORT, **campaigns.QUIET, hide=[effect], seed=2)
    bare = simulate(robot, **SHORT, **campaigns.QUIET)
    assert campaigns.apart(mine, bare) > 0.01
    assert 1e-3 < campaigns.apart(mine, rig) < 0.6 * campaigns.apart(mine, bare)


def test_a_campaign_by_mujoco_is_a_campaign(tmp_path):
    robot = flexmodal.load("fanuc_s360")
    hide = ["added_mass@link_3,mass=0.5"]
    one, two = (
        campaigns.simulate_mujoco(
            robot, **{**SHORT, "averages": 2, "trials": 2, "record_length": 2.0}, hide=hide, seed=4
        )
        for _ in "12"
    )
    truth = one.write(tmp_path / "test")
    assert truth.exists()
    assert check_campaign(tmp_path / "test").is_sound
    back = read_campaign(tmp_path / "test")
    assert len(back.blows) == 4  # each measured at both points at once
    np.testing.assert_array_equal(back.frfs.value, two.campaign.frfs.value)
    inside = (back.frfs.frequency > 5) & (back.frfs.frequency < 80)
    assert 0.9 < np.median(back.frfs.coherence[:, inside]) < 1  # there is noise in it
    assert not (back.frfs.coherence[:, inside] == 1).any()


def test_what_mujoco_has_nothing_for_is_refused():
    with pytest.raises(InvalidRequest, match="servo_compliance"):
        campaigns.simulate_mujoco(flexmodal.load("fanuc_s360"), hide=["servo_compliance"])


@pytest.mark.parametrize("moment", [0.4, 0.08])
def test_pieces_keep_the_whole_inertia(moment):
    body = Body(3.0, np.array([0.5, 0.1, 0.0]), np.diag([0.02, moment, moment + 0.01]))
    axis = np.array([1.0, 0, 0])
    parts = model.pieces(body, 1.0, axis, 3)
    assert sum(part.mass for part in parts) == pytest.approx(body.mass, rel=1e-12)
    com = sum(part.mass * part.com for part in parts) / body.mass
    np.testing.assert_allclose(com, body.com)
    total = np.zeros((3, 3))
    for part in parts:
        lever = part.com - com
        total += part.inertia + part.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        moments = np.linalg.eigvalsh(part.inertia)
        assert moments[0] > 0
        assert moments[0] + moments[1] >= moments[2] * (1 - 1e-9)
    np.testing.assert_allclose(total, body.inertia, atol=1e-12)
    assert np.all(np.diff([part.com[0] for part in parts]) > 0)

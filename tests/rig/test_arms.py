"""Arms drawn at random: sound cards, of every kind that was promised, the same again from the same seed."""

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidRequest, OutputExists
from flexmodal.rig import simulate
from flexmodal.rig.arms import draw_arm
from flexmodal.rig.plan import default_axes
from flexmodal.structure.arm import plane_normal


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arms")
    return [flexmodal.load(draw_arm(folder / str(seed), seed)) for seed in range(40)]


def test_arms_are_of_every_kind(drawn):
    counts = [len(robot.joints) for robot in drawn]
    assert set(counts) == {3, 4, 5, 6, 7}
    planar = [plane_normal(robot) is not None for robot in drawn]
    assert 8 < sum(planar) < 32  # 20 expected, standard deviation 3
    sliding = [any(joint.is_prismatic for joint in robot.urdf.joints) for robot in drawn]
    assert 6 < sum(sliding) < 27  # 16 expected, standard deviation 3
    assert any(s and p for s, p in zip(sliding, planar, strict=True))
    assert any(s and not p for s, p in zip(sliding, planar, strict=True))


def test_arms_swing_where_arms_do(drawn):
    """The lowest resonance in the band, damped a little; every pole on the left."""
    for robot in drawn:
        for posture in robot.postures:
            poles = robot.modes(posture).pole
            lowest = np.abs(poles).min() / 2 / np.pi
            assert 3 < lowest < 25
            assert np.all(poles.real < 0)
            assert -poles.real[np.argmin(np.abs(poles))] / np.abs(poles).min() < 0.1


def test_the_same_seed_draws_the_same_arm(tmp_path):
    one, two = (draw_arm(tmp_path / name, 11) for name in "ab")
    assert one.read_bytes() == two.read_bytes()
    assert (one.parent / "arm.urdf").read_bytes() == (two.parent / "arm.urdf").read_bytes()
    assert draw_arm(tmp_path / "c", 12).read_bytes() != one.read_bytes()


@pytest.mark.parametrize("spatial", [False, True])
def test_planar_and_spatial_arms_to_order(tmp_path, spatial):
    for seed in range(6):
        robot = flexmodal.load(draw_arm(tmp_path / str(seed), seed, spatial=spatial))
        assert default_axes(robot) == ("xyz" if spatial else "z")
        assert (plane_normal(robot) is None) == spatial


def test_a_campaign_of_a_drawn_arm(drawn):
    robot = next(robot for robot in drawn if any(j.is_prismatic for j in robot.urdf.joints))
    result = simulate(robot, postures=2, points=2, trials=2, hide=["coulomb_friction:tanh"], time=False)
    assert np.all(np.isfinite(result.campaign.frfs.value))


def test_faults_of_a_drawing(tmp_path):
    with pytest.raises(InvalidRequest, match="seed: found -1; allowed: 0 or more"):
        draw_arm(tmp_path / "a", -1)
    draw_arm(tmp_path / "a", 1)
    with pytest.raises(OutputExists):
        draw_arm(tmp_path / "a", 2)

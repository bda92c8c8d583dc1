"""Locked joints and masses bolted on, beside Pinocchio's matrices with a joint struck out or a mass added."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import read_campaign, write_campaign
from flexmodal.errors import InvalidCampaign, InvalidRequest
from flexmodal.identification import observe, predict
from flexmodal.identification.compatibility import check_compatible
from flexmodal.identification.model import RobotModel
from flexmodal.rig import simulate
from flexmodal.rig.asked import Asked
from flexmodal.rig.continued import measured_besides
from flexmodal.structure import robot_space

SMALL = {
    "postures": 1, "points": 2, "references": 1, "trials": 2, "averages": 2, "record_length": 2.0,
    "band": (2.0, 120.0), "seed": 3, "time": False,
}  # fmt: skip


@pytest.fixture(scope="module", params=["fanuc_s360", "six_axis"])
def struck(request):
    return simulate(flexmodal.load(request.param), **SMALL, parameter_error=0.0)


def changed(made, **fixtures):
    """The campaign as if its posture had had fixtures."""
    posture = replace(made.campaign.postures[0], **fixtures)
    return replace(made.campaign, postures=(posture,))


def predicted(robot, campaign):
    model = RobotModel(robot, robot_space(robot))
    seen = observe(campaign)
    return seen, predict(model, np.zeros(len(model.space)), replace(seen, lengths=(0.0,) * len(seen.lengths)))


def by_matrices(robot, seen, mass=None, without=None):
    """Receptances from Pinocchio's matrices: the second route."""
    posed = robot.at(dict(seen.postures[0].q))
    m, b, k = (np.array(one) for one in (posed.system.mass, posed.system.damping, posed.system.stiffness))
    ways = "xyz"

    def row(place):
        point = seen.campaign.point(int(place[0]))
        return posed.rows(posed.directions([f"{point.name}:+{ways[int(place[1]) - 1]}"]))[0]

    if mass is not None:
        name, size = mass
        jacobian = posed.jacobian(name)[:3]
        m = m + size * jacobian.T @ jacobian
    kept = [n for n, joint in enumerate(robot.joints) if joint != without]
    found = []
    for n in range(len(seen)):
        u, v = row(seen.response[n])[kept], row(seen.reference[n])[kept]
        w = 2j * np.pi * seen.axis.frequency[:, None, None]
        part = np.ix_(kept, kept)
        z = k[part] + w * b[part] + w**2 * m[part]
        found.append(np.linalg.solve(z, np.broadcast_to(v, (len(w), len(v)))[..., None])[..., 0] @ u)
    return np.array(found)


def test_a_mass_at_a_point_adds_its_mass_along_the_motion_of_that_point(struck):
    name = struck.campaign.points[1].name
    seen, value = predicted(struck.robot, changed(struck, masses={name: 3.0}))
    expected = by_matrices(struck.robot, seen, mass=(name, 3.0))
    np.testing.assert_allclose(value, expected, rtol=1e-8, atol=1e-12 * np.abs(expected).max())


def test_a_locked_joint_is_none(struck):
    joint = list(struck.robot.joints)[1]
    seen, value = predicted(struck.robot, changed(struck, locked=(joint,)))
    expected = by_matrices(struck.robot, seen, without=joint)
    bare = by_matrices(struck.robot, seen)
    away = np.abs(value - expected).max() / np.abs(expected).max()
    assert (
        away < 0.05
    )  # a lock is 10⁴ times as stiff as the joint: resonances move by some 10⁻⁴, Q is some 50
    assert np.abs(bare - expected).max() / np.abs(expected).max() > 0.3


@pytest.mark.parametrize("fixtures", [{"locked": True}, {"masses": True}], ids=["locked", "mass"])
def test_the_rig_strikes_what_was_locked_and_bolted_on(struck, fixtures):
    """Simulated in time by plants of its own, and predicted: the same within noise and what a clamp gives."""
    robot, campaign = struck.robot, struck.campaign
    locked = (next(iter(robot.joints)),) if "locked" in fixtures else ()
    masses = {campaign.points[0].name: 4.0} if "masses" in fixtures else {}
    asked = Asked(dict(campaign.postures[0].q), locked=locked, masses=masses)
    found = measured_besides(campaign, struck.truth, robot, asked)
    assert [one.locked for one in found.campaign.postures] == [(), locked]
    seen, value = predicted(robot, found.campaign)
    away = np.abs(np.log(value / seen.value))
    new, both = seen.posture == 1, seen.used
    assert np.median(away[new][both[new]]) < 0.03  # 1 % of noise over the mean of a record
    plain = predicted(robot, replace(found.campaign, postures=(
        found.campaign.postures[0], replace(found.campaign.postures[1], locked=(), masses={}),
    )))[1]  # fmt: skip
    assert np.median(np.abs(np.log(plain / seen.value))[new][both[new]]) > 0.06


def test_they_go_to_a_file_and_back(struck, tmp_path):
    name = struck.campaign.points[0].name
    campaign = changed(struck, locked=(next(iter(struck.robot.joints)),), masses={name: 2.5})
    again = read_campaign(write_campaign(campaign, tmp_path / "c"))
    assert again.postures[0].locked == campaign.postures[0].locked
    assert dict(again.postures[0].masses) == {name: 2.5}


def test_faults_are_told_at_once(struck, tmp_path):
    folder = write_campaign(changed(struck, locked=("q1",)), tmp_path / "c")
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    file.write_text(
        text.replace('locked = ["q1"]', 'locked = ["q1", "q1"]\nmasses = { nowhere = 1.0 }'), encoding="utf-8"
    )
    with pytest.raises(InvalidCampaign) as caught:
        read_campaign(folder)
    assert {fault.key for fault in caught.value.faults} == {"posture[0].masses", "posture[0].locked"}
    with pytest.raises(InvalidRequest, match=r"locked: .*'elbow'"):
        check_compatible(changed(struck, locked=("elbow",)), struck.robot)

"""A simulated campaign that goes on: the same arm, whatever was hidden, in one posture more."""

import json

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.errors import InvalidRequest
from flexmodal.rig import simulate
from flexmodal.rig.asked import Asked, read_asked
from flexmodal.rig.continued import continued, measured_besides

POSTURES = ("configuration_1", "configuration_3", "configuration_6")
SMALL = {
    "points": 3, "references": 2, "trials": 2, "averages": 2, "record_length": 1.0, "band": (2.0, 120.0),
    "seed": 5, "parameter_error": 0.05,
}  # fmt: skip
HIDDEN = {
    "a link that bends": ["link_flexibility@link_2"],
    "another form, and a sensor": ["base_flexibility:block@base", "sensor_gain"],
    "nothing": [],
}


@pytest.fixture
def asked(tmp_path):
    """The third posture as a diagnosis would ask for it."""
    robot = flexmodal.load("fanuc_s360")
    angles = {name: float(robot.posture(POSTURES[2]).values.get(name, 0.0)) for name in robot.commanded}
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps({"next_measurement": {"posture": angles, "gain": 12.0}}), encoding="utf-8")
    return path


@pytest.mark.parametrize("hide", HIDDEN.values(), ids=HIDDEN)
def test_it_is_the_campaign_that_would_have_been(hide, asked, tmp_path):
    """Two postures and then a third are the three of one campaign."""
    robot = flexmodal.load("fanuc_s360")
    first = simulate(robot, postures=POSTURES[:2], hide=hide, time=False, **SMALL)
    first.write(tmp_path / "first")
    found = continued(tmp_path / "first", read_asked(asked))
    known = [f"{one.effect}:{one.form}@{one.where}" for one in first.truth.effects]
    known = [
        ",".join([head, *(f"{name}={value!r}" for name, value in one.parameters.items())])
        for head, one in zip(known, first.truth.effects, strict=True)
    ]
    whole = simulate(robot, postures=POSTURES, hide=known, time=False, **SMALL)
    assert len(found.campaign.postures) == 3
    assert len(found.campaign.frfs) == len(whole.campaign.frfs)
    size = np.abs(whole.campaign.frfs.value).max()
    np.testing.assert_allclose(
        found.campaign.frfs.value, whole.campaign.frfs.value, rtol=1e-6, atol=1e-9 * size
    )
    assert found.truth == first.truth


def test_the_command_takes_what_a_diagnosis_asked_for(asked, tmp_path, cli):
    simulate(flexmodal.load("fanuc_s360"), postures=POSTURES[:2], **SMALL).write(tmp_path / "test")
    before = (tmp_path / "test" / "campaign.toml").read_bytes()
    for number in (2, 3):
        ran = cli("rig", "--continue", tmp_path / "test", "--as", asked, "--quiet", "--json")
        assert ran.status == 0, ran.err
        new = tmp_path / f"test_{number}"
        told = json.loads(ran.out)
        assert told["campaign"] == str(new)
        assert told["postures"] == 3
        again = read_campaign(new)
        assert [one.id for one in again.postures] == [1, 2, 3]
        assert len(again.blows) == len(read_campaign(tmp_path / "test").blows) * 3 // 2
        assert flexmodal.load(str(new / "robot" / "robot.toml")).postures
        assert new.with_name(f"test_{number}.truth.toml").exists()
    assert (tmp_path / "test" / "campaign.toml").read_bytes() == before


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("no json", "cannot be read"),
        ('{"next_measurement": null}', "nothing was asked for"),
        ('{"next_measurement": {}}', "posture"),
        ('{"posture": {"q1": "up"}}', "'up'"),
        ('{"posture": {"q1": NaN}}', "nan"),
        ('{"posture": {"elbow": 0.1}}', "elbow"),
    ],
)
def test_what_is_no_measurement_is_refused(text, says, tmp_path, cli):
    simulate(flexmodal.load("fanuc_s360"), postures=POSTURES[:1], time=False, **SMALL).write(tmp_path / "t")
    (tmp_path / "next.json").write_text(text, encoding="utf-8")
    cli("rig", "--continue", tmp_path / "t", "--as", tmp_path / "next.json").refused(says)
    assert not (tmp_path / "t_2").exists()


def test_a_campaign_without_its_truth_is_refused(asked, tmp_path):
    simulate(flexmodal.load("fanuc_s360"), postures=POSTURES[:1], time=False, **SMALL).write(tmp_path / "t")
    (tmp_path / "t.truth.toml").unlink()
    with pytest.raises(InvalidRequest, match=r"t\.truth\.toml"):
        continued(tmp_path / "t", read_asked(asked))
    (tmp_path / "t.truth.toml").write_text("format = 1\n", encoding="utf-8")
    with pytest.raises(InvalidRequest, match="cannot be read"):
        continued(tmp_path / "t", read_asked(asked))


@pytest.fixture(scope="module")
def driven():
    """An arm with a soft position loop, which has to die down however it is held."""
    return simulate(
        flexmodal.load("fanuc_s360"), postures=POSTURES[:1], hide=["servo_compliance@q2"], **SMALL
    )


def test_one_frf_is_taken_at_a_new_point_with_a_mass_and_a_lock(driven):
    campaign, robot = driven.campaign, driven.robot
    new = next(name for name in robot.points if name not in {point.name for point in campaign.points})
    response = (17, 3)
    asked = Asked(
        {"q1": 0.3, "q2": 0.2, "q3": -0.1}, response, (campaign.points[0].id, 3), None, {17: new},
        ("q3",), {new: 1.5},
    )  # fmt: skip
    found = measured_besides(campaign, driven.truth, robot, asked).campaign
    rows = found.frfs.posture == found.postures[-1].id
    assert found.postures[-1].locked == ("q3",)
    assert dict(found.postures[-1].masses) == {new: 1.5}
    assert {tuple(one) for one in found.frfs.response[rows].tolist()} == {response}
    assert sorted(found.frfs.trial[rows].tolist()) == [trial.id for trial in campaign.trials]
    assert {blow.channels for blow in found.blows[len(campaign.blows) :]} == {(response,)}
    again = measured_besides(found, driven.truth, robot, asked).campaign
    assert len(again.postures) == len(found.postures) + 1  # the same once more is another posture


def test_a_force_that_was_not_struck_is_a_new_pair_of_trials(driven):
    campaign, posture = driven.campaign, dict(driven.campaign.postures[0].q)
    place = (campaign.points[1].id, 1)
    asked = Asked(posture, place, (campaign.points[0].id, 3), 500.0)
    found = measured_besides(campaign, driven.truth, driven.robot, asked).campaign
    more = found.trials[len(campaign.trials) :]
    assert [(one.force_peak, one.repeat_of) for one in more] == [(500.0, None), (500.0, more[0].id)]
    assert len(found.postures) == 1  # it stands there already
    assert len(found.frfs) == len(campaign.frfs) + 2


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"response": [1, 4]}, "direction"),
        ({"response": [99, 1], "reference": [1, 3]}, "99"),
        ({"response": [1, 1]}, "reference"),
        ({"locked": ["elbow"]}, "elbow"),
        ({"masses": {"nowhere": 1.0}}, "nowhere"),
        ({"masses": {"location_1": -1.0}}, "above 0"),
        ({"force_peak": 0}, "force_peak"),
        ({"new_points": {"x": "tip"}}, "new_points"),
        ({"new_points": {"40": "nowhere"}}, "nowhere"),
    ],
)
def test_what_cannot_be_done_is_refused(change, says, asked, driven, tmp_path, cli):
    driven.write(tmp_path / "t")
    told = json.loads(asked.read_text(encoding="utf-8"))["next_measurement"]
    (tmp_path / "next.json").write_text(json.dumps([{**told, **change}]), encoding="utf-8")
    cli("rig", "--continue", tmp_path / "t", "--as", tmp_path / "next.json").refused(says)
    assert not (tmp_path / "t_2").exists()

"""A simulated campaign that goes on: the same arm, whatever was hidden, in one posture more."""

import json

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.errors import InvalidRequest
from flexmodal.rig import simulate
from flexmodal.rig.asked import read_asked
from flexmodal.rig.continued import continued

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

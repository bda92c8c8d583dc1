"""`flexmodal check` says whether a test is sound, and the commands that use it say so first."""

import json
from dataclasses import replace

import jsonschema
import pytest

import flexmodal
from flexmodal.campaign import read_campaign, write_campaign
from flexmodal.cli.main import SCHEMAS
from flexmodal.rig import simulate
from flexmodal.rig.laboratory import with_mishaps


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=2, points=2, references=1, trials=2, averages=2,
        peaks=(100.0,), band=(2.0, 80.0), record_length=1.5, seed=6,
    )  # fmt: skip
    place = tmp_path_factory.mktemp("sound")
    made.write(place / "right")
    spoilt, _ = with_mishaps(made.campaign, ["scale"], seed=1)
    write_campaign(replace(spoilt, robot="fanuc_s360"), place / "wrong")
    return place


def test_a_sound_test_is_sound(cli, folders):
    ran = cli("check", folders / "right")
    assert (ran.status, ran.out) == (0, f"{folders / 'right'}: sound\n")


def test_a_finding_is_said_with_its_remedy(cli, folders):
    ran = cli("check", folders / "wrong")
    assert ran.status == 1
    assert "finding: scale, every record: too small some ten times, as in g for m/s²" in ran.out
    assert "multiply these records" in ran.out
    assert ran.out.endswith("wrong: 1 finding\n")


def test_json_has_the_findings(cli, folders):
    told = cli("check", folders / "wrong", "--json").json()
    jsonschema.validate(told, json.loads((SCHEMAS / "check.json").read_text(encoding="utf-8")))
    (checked,) = told["checked"]
    assert not checked["sound"]
    assert [one["kind"] for one in checked["findings"]] == ["scale"]


def test_identify_says_it_first(cli, folders):
    ran = cli("identify", folders / "wrong", "--kinds", "stiffness", "--hold-out", "configuration_1")
    assert "finding: scale" in ran.err


def test_a_robot_that_is_not_there_is_said_and_the_data_are_looked_at(cli, folders, tmp_path):
    campaign = replace(read_campaign(folders / "wrong"), robot="nobody")
    write_campaign(campaign, tmp_path / "alone")
    ran = cli("check", tmp_path / "alone")
    assert ran.status == 0
    assert "looked at without the robot" in ran.err

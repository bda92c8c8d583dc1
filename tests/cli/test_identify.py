"""`flexmodal identify`: JSON, the improved card, what is refused."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import flexmodal
from flexmodal.campaign import read_campaign
from flexmodal.cli.main import group
from flexmodal.identification import identify
from flexmodal.identification.observations import observe
from flexmodal.identification.spot import Spot
from flexmodal.rig import simulate

ROOT = Path(__file__).parents[2]

POSTURES = ["configuration_1", "configuration_3", "configuration_7"]
THESIS = str(ROOT / "robots/fanuc_s360/campaigns/thesis")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = simulate(
        flexmodal.load("fanuc_s360"),
        postures=POSTURES,
        points=3,
        trials=2,
        peaks=(100.0,),
        seed=2,
        record_length=2.0,
        time=False,
    )
    place = tmp_path_factory.mktemp("identify") / "campaign"
    made.write(place)
    return place


@pytest.fixture(scope="module")
def identified(folder, tmp_path_factory):
    """What one identification with `--out` printed, and its folder."""
    out = tmp_path_factory.mktemp("identified") / "found"
    return CliRunner().invoke(group, ["identify", str(folder), "--out", str(out)]), out


def test_json_is_as_the_page_fixes_it(cli, folder):
    found = cli("identify", folder, "--json").json()
    assert {"parameters", "correlated", "gap"} <= set(found)
    assert {"before", "after", "held_out_before", "held_out_after", "noise_floor"} <= set(found["gap"])
    assert len(found["parameters"]) == 16
    for one in found["parameters"].values():
        assert {"value", "unit", "standard_error", "card", "at_bound"} <= set(one)
        assert one["standard_error"] > 0
        assert one["interval"][0] < one["value"] < one["interval"][1]
    assert found["gap"]["after"] < found["gap"]["before"]
    for a, b, r in found["correlated"]:
        assert {a, b} <= set(found["parameters"])
        assert 0.9 <= abs(r) <= 1


def test_the_improved_card_has_the_fitted_receptance(folder, identified):
    ran, out = identified
    assert ran.exit_code == 0, ran.stderr
    assert "before the fit: " in ran.stderr
    assert {path.name for path in out.iterdir()} == {
        "robot",
        "identification.json",
        "report.html",
        "fit.png",
        "fit.svg",
    }
    old, new = flexmodal.load(folder / "robot" / "robot.toml"), flexmodal.load(out / "robot" / "robot.toml")
    outcome = identify(read_campaign(folder), old)
    lines = np.array([5.0, 30.0, 51.0, 120.0])
    q = dict(outcome.problem.campaign.postures[1].q)
    point = outcome.problem.campaign.points[0]
    made = outcome.problem.evidence.model.structure_at(
        outcome.at,
        q,
        [Spot(point.link, np.array(point.xyz), np.eye(3)[2])],
        [Spot(point.link, np.array(point.xyz), np.eye(3)[2])],
    )
    direct = []
    for omega in 2j * np.pi * lines:
        z = made.stiffness + omega * (made.damping + omega * made.mass)
        direct.append(made.response[0] @ np.linalg.solve(z, made.reference[0]))
    value = new.frf(q, lines, response=f"{point.name}:+z").value[:, 0, 0]
    np.testing.assert_allclose(value, direct, rtol=1e-9)
    stored = json.loads((out / "identification.json").read_text())
    assert new.joints["q2"].stiffness == pytest.approx(stored["parameters"]["stiffness.q2"]["value"])
    assert set(new.postures) == set(old.postures)
    assert set(new.points) == set(old.points)
    observed = observe(read_campaign(folder))
    assert len(observed) == 18


def test_the_page_stands_alone(identified):
    text = (identified[1] / "report.html").read_text(encoding="utf-8")
    assert "stiffness.q2" in text
    assert text.count("<svg") == 2
    for outside in ('src="', "<link", "@import", 'href="http'):
        assert outside not in text


def test_nothing_is_written_over_unasked(cli, folder, identified, tmp_path):
    out = tmp_path / "found"
    shutil.copytree(identified[1], out)
    card = out / "robot" / "robot.toml"
    card.write_text("before", encoding="utf-8")
    cli("identify", folder, "--out", out).refused("robot", "--force")
    assert card.read_text(encoding="utf-8") == "before"
    assert cli("identify", folder, "--out", out, "--force", "--kinds", "stiffness").status == 0
    assert "joint" in card.read_text(encoding="utf-8")


def test_the_old_card_is_never_the_new_one(cli, folder):
    """The campaign carries its robot in `robot/`: the very name the improved one gets."""
    before = (folder / "robot" / "robot.toml").read_text()
    cli("identify", folder, "--out", folder, "--force").refused("the folder of the card's own URDF")
    assert (folder / "robot" / "robot.toml").read_text() == before


def test_modes_alone_are_enough(cli):
    found = cli("identify", THESIS, "--json").json()
    assert found["provenance"]["source"] == "modes"
    assert found["gap"]["after"] < found["gap"]["before"]
    assert any("scale together" in one["says"] for one in found["not_identified"])


def test_a_posture_can_be_held_out(cli):
    found = cli("identify", THESIS, "--hold-out", "configuration_2", "--hold-out", "7", "--json").json()
    assert [one["name"] for one in found["held_out"]] == ["configuration_2", "configuration_7"]


def test_from_modes_of_the_frfs(cli, folder):
    found = cli("identify", folder, "--from", "modes", "--json").json()
    assert found["provenance"]["source"] == "modes"
    assert found["parameters"]["stiffness.q2"]["identified"]


def test_people_get_a_table(cli, folder):
    ran = cli("identify", folder, "--kinds", "stiffness,damping", "--trust", "stiffness=0.5")
    assert ran.status == 0
    assert "stiffness.rho" in ran.out
    assert "mass" not in ran.out.split("gap")[0].replace("mass.", "")
    assert "held out" in ran.out


def test_what_is_wrong_is_said(cli, folder, tmp_path):
    cli("identify", folder, "--hold-out", "configuration_9").refused("configuration_9", "configuration_1")
    cli("identify", folder, "--kinds", "colour").refused("colour")
    cli("identify", folder, "--trust", "0.3").refused("--trust", "GROUP=FACTOR")
    cli("identify", folder, "--robot", "six_link").refused("unknown link")
    cli("identify", THESIS, "--from", "frf").refused("no FRFs and no blows")
    cli("identify", tmp_path / "nowhere").refused("nowhere")
    cli("identify", folder, "--out", tmp_path / "no" / "such").refused("no such folder")
    cli("identify", THESIS, "--use", "colour").refused("colour")

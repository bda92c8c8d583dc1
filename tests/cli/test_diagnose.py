"""`flexmodal diagnose`: what it prints and writes, its exit status, and what it refuses."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

import flexmodal
from flexmodal.rig import Hide, simulate

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """A folder: a payload on the hand that the card does not know of."""
    hide = [replace(Hide.parse("added_mass@link_3"), height=12.0)]
    result = simulate(
        flexmodal.load("fanuc_s360_rigid_link"), hide=hide, postures=3, points=3, references=2, seed=11,
        record_length=2.0, band=(2.0, 150.0),
    )  # fmt: skip
    folder = tmp_path_factory.mktemp("tested") / "campaign"
    result.write(folder)
    return folder


@pytest.fixture(scope="module")
def explained(campaign, tmp_path_factory):
    """Exit status, what was printed and the folder of one diagnosis among few effects."""
    from click.testing import CliRunner

    from flexmodal.cli.main import group

    out = tmp_path_factory.mktemp("found") / "out"
    words = ["diagnose", str(campaign), "--out", str(out), "--effects", "added_mass,sensor_gain", "--json"]
    ran = CliRunner().invoke(group, words)
    return ran, out


def test_prints_the_object_that_it_writes(explained, valid):
    ran, out = explained
    assert ran.exit_code == 0, ran.output
    printed = valid("diagnose", json.loads(ran.stdout))
    assert ran.stdout.count("\n") == 1
    assert printed == json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert printed["verdict"]["effects"] == [["added_mass", "link_3"]]
    assert printed["gap"]["after"] < printed["gap"]["before"]
    assert printed["gap"]["after"] < 1.2 * printed["gap"]["noise_floor"]
    assert "wrote" in ran.stderr


def test_writes_a_robot_that_carries_the_payload(explained):
    _, out = explained
    assert sorted(path.name for path in out.iterdir()) == ["diagnosis.json", "report.html", "robot"]
    robot = flexmodal.load(out / "robot" / "robot.toml")
    (payload,) = [joint for joint in robot.urdf.joints if "payload" in joint.name]
    assert payload.parent == "link_3"
    found = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    mass = robot.urdf.link_by_name[payload.child].mass
    before = found["steps"][0]["parameters"]["mass"]
    assert mass == pytest.approx(before, rel=0.2)  # it is fitted once more with all


@pytest.mark.slow
def test_not_explained(cli, campaign, valid, tmp_path):
    out = tmp_path / "out"
    ran = cli("diagnose", campaign, "--out", out, "--effects", "time_delay", "--quiet")
    assert ran.status == 1, ran.err
    assert "gap between model and measurement" in ran.out
    verdict = valid("diagnose", json.loads((out / "diagnosis.json").read_text(encoding="utf-8")))["verdict"]
    assert verdict["explained"] is False
    assert verdict["effects"][0][0] == "unknown"
    assert "the catalogue does not know" in (out / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--effects", "added_mas"], "added_mas"),
        (["--effects", ","], "effects"),
        (["--hold-out", "nowhere"], "nowhere"),
        (["--trust", "mass"], "GROUP=FACTOR"),
        (["--trust", "mass=-1"], "-1"),
        (["--trust", "weight=0.1"], "weight"),
        (["--robot", "no_such_robot"], "no_such_robot"),
        (["--robot", "six_link"], "link"),
        (["--seed", "-1"], "seed"),
    ],
)
def test_bad_requests_write_nothing(cli, campaign, tmp_path, words, says):
    ran = cli("diagnose", campaign, "--out", tmp_path / "out", *words)
    ran.refused(says)
    assert os.listdir(tmp_path) == []


def test_refuses_what_stands_there_before_the_work(cli, campaign, tmp_path):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "letter.txt").write_text("dear")
    cli("diagnose", campaign, "--out", mine).refused("mine", "letter.txt")
    cli("diagnose", campaign, "--out", mine, "--force").refused("nothing in it but")
    cli("diagnose", campaign, "--out", tmp_path / "no" / "where").refused("no such folder")
    assert os.listdir(mine) == ["letter.txt"]


def test_no_campaign(cli, tmp_path):
    cli("diagnose", tmp_path / "none", "--out", tmp_path / "out").refused("none", "no such file or folder")
    assert os.listdir(tmp_path) == []


THESIS = str(ROOT / "robots/fanuc_s360/campaigns/thesis")


@pytest.mark.parametrize(
    ("option", "value", "allowed"),
    [("--effects", "link_flexibilty", "link_flexibility"), ("--hold-out", "nope", "configuration_1")],
)
def test_a_name_that_is_not_there_is_told_by_its_option(cli, tmp_path, option, value, allowed):
    words = ("diagnose", THESIS, "--robot", "fanuc_s360_rigid_link", "--out", tmp_path / "out", option, value)
    cli(*words).refused(f"command line: {option}: found '{value}'", allowed)


@pytest.mark.slow
def test_data_that_may_count_twice_are_warned_of_once(campaign, tmp_path):
    from click.testing import CliRunner

    from flexmodal.campaign import read_campaign, write_campaign
    from flexmodal.cli.main import group
    from flexmodal.ema import fit, mode_table

    measured = read_campaign(campaign)
    with_modes = replace(measured, modes=mode_table(fit(measured, "least-squares", per="posture")))
    folder = write_campaign(with_modes, tmp_path / "both")
    words = ["diagnose", str(folder), "--effects", "sensor_gain", "--json", "--quiet"]
    words += ["--robot", str(campaign / "robot" / "robot.toml"), "--out"]
    ran = CliRunner().invoke(group, [*words, str(tmp_path / "warned")])
    assert ran.stderr.count("count twice") == 1
    warnings = json.loads(ran.stdout)["warnings"]
    assert sum("count twice" in one for one in warnings) == 1
    assert "count twice" in (tmp_path / "warned" / "report.html").read_text(encoding="utf-8")
    ran = CliRunner().invoke(group, [*words, str(tmp_path / "chosen"), "--from", "frf"])
    assert "count twice" not in ran.stderr
    assert not any("count twice" in one for one in json.loads(ran.stdout)["warnings"])

"""`flexmodal show` of a campaign: a page from the command line, and what it refuses."""

import json
import re
from pathlib import Path

import pytest

THESIS = Path(__file__).parents[2] / "robots" / "fanuc_s360" / "campaigns" / "thesis"


@pytest.fixture(scope="module")
def tested(tmp_path_factory):
    """A small campaign of the rig, with the robot in it."""
    from flexmodal.model import load
    from flexmodal.rig import simulate

    folder = tmp_path_factory.mktemp("campaigns") / "tested"
    robot = load("fanuc_s360")
    postures = ["configuration_1", "configuration_4"]
    simulate(robot, postures=postures, points=3, references=1, trials=2, averages=2, seed=2).write(folder)
    return folder


def scene_of(page):
    text = page.read_text(encoding="utf-8")
    return json.loads(re.search(r'id="scene">(.*?)</script>', text, re.DOTALL)[1]), text


def test_a_campaign_knows_its_robot(cli, tested, tmp_path):
    page = tmp_path / "tested.html"
    ran = cli("show", tested, "--out", page)
    assert (ran.status, ran.out) == (0, "")
    scene, text = scene_of(page)
    still = [motion for motion in scene["motions"] if not motion["animations"]]
    assert len(still) == 2
    moving = [motion for motion in scene["motions"] if motion["animations"]]
    assert len(moving) >= 6  # three modes at least in each posture
    assert "configuration_4" in text
    assert 'src="http' not in text


def test_one_posture_and_another_robot(cli, tested, tmp_path):
    page = tmp_path / "one.html"
    assert cli("show", "fanuc_s360", "--campaign", tested, "--posture", "2", "--out", page).status == 0
    scene, text = scene_of(page)
    assert sum(not motion["animations"] for motion in scene["motions"]) == 1
    assert "configuration_1" not in text
    cli("show", tested, "--posture", "5", "--out", tmp_path / "x.html").refused("'5'", "1 or configuration_1")
    lines = cli("show", "six_link", "--campaign", tested, "--out", tmp_path / "x.html").refused(
        "link_2_outer"
    )
    assert len(lines) == 1  # one of the three points rides on a link that the robot does not have


def test_a_campaign_of_modes_alone_shows_its_postures(cli, tmp_path):
    page = tmp_path / "thesis.html"
    assert cli("show", THESIS, "--out", page).status == 0
    scene, _ = scene_of(page)
    assert scene["motions"]
    assert all(not motion["animations"] for motion in scene["motions"])


def test_what_does_not_go_with_a_campaign_is_refused(cli, tested, tmp_path):
    page = tmp_path / "x.html"
    lines = cli("show", tested, "--modes", "--frequency", "8", "--out", page).refused(
        "--modes", "--frequency"
    )
    assert len(lines) == 2
    cli("show", "fanuc_s360", "--campaign", tmp_path, "--out", page).refused("campaign.toml")
    assert not page.exists()

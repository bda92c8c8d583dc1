"""`flexmodal import` and `flexmodal campaign new`."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import estimate_frfs, is_campaign, read_campaign, write_campaign
from flexmodal.campaign.records import place_text
from flexmodal.rig import simulate

SAMPLES = Path(__file__).parents[1] / "data" / "dialects"


@pytest.fixture
def folder(cli, tmp_path):
    ran = cli(
        "campaign", "new", "fanuc_s360", "--out", tmp_path / "test", "--points", "location_1,location_6"
    )
    assert ran.status == 0, ran.err
    assert "7 postures, 2 points" in ran.out
    return tmp_path / "test"


def test_from_a_table_to_a_campaign(cli, folder):
    table, drafted = SAMPLES / "decibels.txt", folder / "map.toml"
    ran = cli("import", table, "--draft", drafted)
    assert ran.status == 0, ran.err
    assert "guessed" in ran.out
    ran = cli("import", drafted, "--out", folder.parent / "campaign")
    assert ran.status == 0, ran.err
    assert "2 FRFs, 0 blows" in ran.out
    made = read_campaign(folder.parent / "campaign")
    assert made.robot == "fanuc_s360"
    assert len(made.frfs) == 2


def test_what_is_wrong_is_said(cli, folder, tmp_path):
    table = SAMPLES / "decibels.txt"
    cli("import", table).refused("--draft and --out", "neither")
    cli("import", table, "--out", tmp_path / "x").refused("--draft MAP.toml writes one")
    cli("import", table, "--draft", tmp_path / "map.txt").refused("ending in .toml")
    cli("import", tmp_path / "none.csv", "--draft", tmp_path / "m.toml").refused("no such file")
    (tmp_path / "there.toml").write_text("")
    cli("import", table, "--draft", tmp_path / "there.toml").refused("existing file")
    cli("import", SAMPLES / "magnitude_only.csv", "--draft", tmp_path / "m.toml").refused("lacks the phase")
    cli("campaign", "new", "fanuc_s360", "--out", tmp_path / "y", "--points", "nose").refused("nose")
    cli("campaign", "new", "fanuc_s360", "--out", folder).refused("--force")
    assert not (tmp_path / "m.toml").exists()


def test_fit_of_a_table_says_what_to_do(cli):
    cli("fit", SAMPLES / "decibels.txt").refused("flexmodal import", "--draft map.toml")


def test_a_map_is_a_campaign_for_every_command(cli, folder):
    """As are the folders and universal files: nothing has to be written first."""
    drafted = folder / "map.toml"
    assert cli("import", SAMPLES / "decibels.txt", "--draft", drafted).status == 0
    told = cli("fit", drafted, "--per", "posture", "--json").json()
    assert {round(row["frequency"]) for row in told["modes"]} == {9, 24}
    assert len(read_campaign(drafted).frfs) == 2
    assert is_campaign(drafted)
    assert not is_campaign(folder / "robot.toml")
    cli("fit", "robots/fanuc_s360/robot.toml").refused("a robot goes to the other commands")
    drafted.write_text(
        drafted.read_text(encoding="utf-8").replace("magnitude =", "magnitud ="), encoding="utf-8"
    )
    cli("fit", drafted).refused("magnitud")


def test_a_corner_is_taken_out_on_request(cli, tmp_path):
    """FRFs as behind a high pass come back; the force's corner is in every one, the other way round."""
    true = read_campaign("tests/data/real/laboratory_hammer")
    frfs = estimate_frfs(true) if true.frfs is None else true.frfs
    place = frfs.response[0].tolist()
    passed = 1j * frfs.frequency / (1j * frfs.frequency + 0.8)
    behind = np.all(np.abs(frfs.response) == np.abs(place), axis=1)[:, None]
    spoilt = replace(frfs, value=np.where(behind, frfs.value * passed, frfs.value))
    write_campaign(replace(true, frfs=spoilt, blows=()), tmp_path / "spoilt")
    channel = place_text(tuple(place))
    ran = cli(
        "import", tmp_path / "spoilt", "--without-coupling", f"{channel}=0.8", "--out", tmp_path / "mended"
    )
    assert ran.status == 0, ran.err
    assert "1 corner taken out" in ran.out
    mended = read_campaign(tmp_path / "mended").frfs
    high = frfs.frequency > 0
    np.testing.assert_allclose(mended.value[:, high], frfs.value[:, high], rtol=1e-6)
    forced = cli(
        "import", tmp_path / "spoilt", "--without-coupling", "force=0.8", "--out", tmp_path / "forced"
    )
    assert forced.status == 0, forced.err
    other = read_campaign(tmp_path / "forced").frfs.value[~behind[:, 0]]
    np.testing.assert_allclose(other[:, high], (frfs.value * passed)[~behind[:, 0]][:, high], rtol=1e-6)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("99:+z=0.8", "99:+z"),
        ("tip=0.8", "the id of a point"),
        ("force=none", "a corner in Hz"),
        ("force=-1", "above 0 Hz"),
    ],
)
def test_a_corner_that_cannot_be_taken_out(cli, tmp_path, given, says):
    source = "tests/data/real/laboratory_hammer"
    cli("import", source, "--without-coupling", given, "--out", tmp_path / "x").refused(says)
    assert not (tmp_path / "x").exists()
    cli("import", source, "--without-coupling", given, "--draft", tmp_path / "m.toml").refused("with --draft")


def test_a_record_with_several_blows_says_how_long_each_may_be(cli, folder):
    table, drafted = SAMPLES / "continuous.csv", folder / "map.toml"
    assert cli("import", table, "--draft", drafted).status == 0
    ran = cli("import", drafted, "--out", folder.parent / "whole")
    assert "1 blows" in ran.out
    length = re.search(r"3 pulses far apart; length = ([\d.]+)", ran.out)[1]
    text = drafted.read_text().replace("# length = 2.0 ", f"length = {length} ")
    drafted.write_text(text)
    ran = cli("import", drafted, "--out", folder.parent / "parts")
    assert "3 blows" in ran.out, ran.out
    assert "pulses far apart" not in ran.out


@pytest.mark.slow
def test_what_check_finds_is_mended_by_what_it_says(cli, tmp_path):
    """A channel behind a high pass of 1.5 Hz: found, taken out by the command in the finding, and gone."""
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=2, points=3, references=1, trials=2, band=(1.0, 60.0),
        record_length=4.0, seed=3, time=False,
    )  # fmt: skip
    frfs = made.campaign.frfs
    behind = np.all(frfs.response == frfs.response[0], axis=1)[:, None]
    passed = 1j * frfs.frequency / (1j * frfs.frequency + 1.5)
    spoilt = replace(frfs, value=np.where(behind, frfs.value * passed, frfs.value))
    replace(made, campaign=replace(made.campaign, frfs=spoilt)).write(tmp_path / "spoilt")
    told = cli("check", tmp_path / "spoilt")
    assert told.status == 1
    asked = re.search(r"--without-coupling (\d:\+z=[\d.]+)", told.out)[1]
    assert float(asked.partition("=")[2]) == pytest.approx(1.5, rel=0.3)
    ran = cli("import", tmp_path / "spoilt", "--without-coupling", asked, "--out", tmp_path / "mended")
    assert ran.status == 0, ran.err
    after = cli("check", tmp_path / "mended")
    assert "AC coupling" not in after.out
    assert "looked at without the robot" not in after.err
    assert after.status == 0, after.out

"""`flexmodal import` and `flexmodal campaign new`."""

from pathlib import Path

import pytest

from flexmodal.campaign import is_campaign, read_campaign

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

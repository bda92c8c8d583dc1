"""`--clearance`, obstacles of a card, and the word that none was checked."""

import pytest


@pytest.fixture
def card(cli, tmp_path):
    out = tmp_path / "ur5"
    assert cli("card", "new", "ur5", "--out", out).status == 0
    with (out / "robot.toml").open("a") as file:
        file.write("\n[obstacle.table]\nbox = [1.6, 1.6, 0.05]\nxyz = [0.0, 0.0, -0.03]\n")
    return out


ASKED = ("--hold", "0.5,0.1,0.3", "--frequency", "20", "--starts", "2")


@pytest.mark.slow
def test_obstacles_of_a_card_are_kept_away_from(cli, card):
    found = cli("optimise", card, *ASKED, "--json").json()["collisions"]
    assert found["checked"] is True
    assert found["distance"] >= found["asked"] == 0.01
    said = cli("optimise", card, *ASKED, "--clearance", "0.011").out
    assert "checked against table and itself" in said
    assert "(11 mm asked)" in said


def test_it_is_said_when_none_was_checked(cli, card):
    assert "collisions: none checked" in cli("optimise", card, *ASKED, "--no-collisions").out
    ran = cli("optimise", "six_axis", "--hold", "0.8,0.1,0.9", "--frequency", "20", "--starts", "2")
    assert "collisions: none checked" in ran.out
    cli("optimise", card, *ASKED, "--no-collisions", "--clearance", "0.1").refused("--no-collisions")
    cli("optimise", "six_axis", *ASKED, "--clearance", "0.1").refused("no two shapes", "docs/collisions.md")

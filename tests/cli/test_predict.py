"""`flexmodal predict`: table, files, JSON by its schema, an improved card, what is refused."""

import pytest

import flexmodal
from flexmodal.rig import simulate

POSTURE = "q1=60deg,q2=-70deg,q3=10deg"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=3, points=2, references=1, trials=2, peaks=(100.0,),
        band=(2.0, 60.0), record_length=1.0, seed=2, time=False,
    )  # fmt: skip
    place = tmp_path_factory.mktemp("predict") / "campaign"
    made.write(place)
    return place


@pytest.mark.slow
def test_table_verdict_and_page(cli, folder, tmp_path):
    ran = cli(
        "predict", "fanuc_s360", "--campaign", folder, "--posture", POSTURE, "--out", tmp_path / "p.html"
    )
    assert ran.status == 0, ran.err
    assert "chosen anew" in ran.out
    assert "angles shuffled" in ran.out
    assert "tell the postures apart" not in ran.out
    assert "predicted by hybrid" in ran.out
    assert "3 postures were struck: the band rests on as many errors" in ran.out
    assert (tmp_path / "p.html").read_text(encoding="utf-8").count("<svg") == 2


@pytest.mark.slow
def test_json_and_csv_are_what_the_schema_and_the_header_say(cli, valid, folder, tmp_path):
    words = ("predict", folder / "robot" / "robot.toml", "--campaign", folder, "--posture", "configuration_1")
    asked = ("--poor-card", "--method", "hybrid", "--json", "--out", tmp_path / "p.csv")
    told = valid("predict", cli(*words, *asked).json())
    assert told["method"] == "hybrid"
    ways = told["left_out"]["methods"]
    assert ways["angles shuffled"]["typical"] > 2 * ways["physics"]["typical"]
    assert len((tmp_path / "p.csv").read_text().splitlines()) == 1 + 2 * len(told["frequency"])


def test_what_is_wrong_is_said(cli, folder, tmp_path):
    words = ("predict", "fanuc_s360", "--campaign", folder)
    cli(*words, "--posture", "q9=1").refused("q9")
    cli(*words, "--posture", POSTURE, "--out", tmp_path / "p.docx").refused(".csv")
    cli("predict", "fanuc_s360", "--campaign", tmp_path / "none", "--posture", POSTURE).refused("none")
    thesis = "robots/fanuc_s360/campaigns/thesis"
    cli("predict", "fanuc_s360", "--campaign", thesis, "--posture", POSTURE).refused("no FRFs and no blows")

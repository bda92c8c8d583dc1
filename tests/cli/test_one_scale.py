"""How far a model is from a campaign is said in one scale and one phrase, in every terminal and page."""

import json
import re

import pytest
from click.testing import CliRunner

import flexmodal
from flexmodal.cli.main import group
from flexmodal.report.words import DASH, times_noise
from flexmodal.rig import simulate

PHRASE = re.compile(r"(?<![\d.])(\d+|\d\.\d) × the noise")
OTHER = re.compile(r"times the noise|times as far from the measure|× the noise floor|\d\.\d\d+ × the noise")


def run(*words):
    ran = CliRunner().invoke(group, list(map(str, words)))
    assert ran.exit_code in (0, 1), ran.exception
    return re.sub(r"\s+", " ", ran.stdout)


def text_of(path):
    """What a reader sees of a page, without scripts and pictures."""
    page = re.sub(r"<(script|style|svg)\b.*?</\1>", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page).replace("\u00a0", " "))


def test_one_decimal_below_ten_and_two_figures_above():
    assert [times_noise(x) for x in (1.04, 9.94, 9.96, 15.3, 147.0, float("nan"))] == [
        "1.0 × the noise", "9.9 × the noise", "10 × the noise", "15 × the noise", "150 × the noise",
        f"{DASH} × the noise",
    ]  # fmt: skip


@pytest.mark.slow
def test_every_command_says_it_alike(tmp_path):
    """A sensor off by a third: identify leaves what diagnose explains, predict stands between."""
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=4, points=2, references=1, trials=2, peaks=(100.0,),
        band=(2.0, 100.0), record_length=2.0, hide=["sensor_gain@location_1,error=0.3"], seed=4, time=False,
    )  # fmt: skip
    struck = tmp_path / "struck"
    made.write(struck)
    told = {
        "identify": run("identify", struck, "--out", tmp_path / "better", "--quiet"),
        "diagnose": run("diagnose", struck, "--out", tmp_path / "found", "--quiet"),
        "predict": run(
            "predict", "fanuc_s360", "--campaign", struck, "--posture", "q1=1,q2=-1,q3=0.1", "--quiet",
            "--out", tmp_path / "there.html",
        ),
        "check": run("check", struck),
        "fit": run("fit", struck, "--per", "posture", "--out", tmp_path / "modes.html"),
    }  # fmt: skip
    pages = {
        "identify": text_of(tmp_path / "better" / "report.html"),
        "diagnose": text_of(tmp_path / "found" / "report.html"),
        "predict": text_of(tmp_path / "there.html"),
        "fit": text_of(tmp_path / "modes.html"),
    }
    for name, text in [*told.items(), *pages.items()]:
        assert not OTHER.search(text), (name, OTHER.search(text))
    for name in ("identify", "diagnose", "predict"):
        said, shown = PHRASE.findall(told[name]), PHRASE.findall(pages[name])
        assert said, name
        assert said[0] in shown, name
    before = json.loads((tmp_path / "better" / "identification.json").read_text())["over_noise"]
    assert PHRASE.findall(told["identify"])[0] == PHRASE.match(times_noise(before))[1]
    assert float(PHRASE.findall(told["diagnose"])[0]) < 1.4 < before  # what it found was all that was missing
    confidence = re.search(r"confidence (\S+ ?\d* %)", told["diagnose"])[1].replace("> ", "")
    assert re.search(rf"Confidence (> |&gt; )?{re.escape(confidence)}", pages["diagnose"])

"""`optimise` and `atlas` with receptances predicted from a campaign, from the command line."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import flexmodal
from flexmodal.atlas import open_atlas
from flexmodal.campaign import read_campaign
from flexmodal.cli.main import group
from flexmodal.rig import simulate


@pytest.fixture(scope="module")
def struck(tmp_path_factory):
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=3, points=2, references=["location_1:+z"],
        trials=2, peaks=(100.0,), band=(2.0, 60.0), record_length=1.5, seed=5, time=False,
    )  # fmt: skip
    folder = tmp_path_factory.mktemp("struck") / "campaign"
    made.write(folder)
    return folder


def run(*words):
    return CliRunner().invoke(group, list(map(str, words)))


ASKED = ("--direction", "location_1:+z", "--frequency", "12")


@pytest.mark.slow
def test_the_best_posture_has_the_receptance_that_predict_gives_there(struck, tmp_path):
    axis = read_campaign(struck).frfs.frequency
    line = int(np.argmin(abs(axis - 12.0)))
    found = run(
        "optimise", "fanuc_s360", "--campaign", struck, "--family", "second_link_horizontal",
        "--direction", "tool:+z", "--frequency", repr(float(axis[line])), "--json",
    )  # fmt: skip
    assert found.exit_code == 0, found.stderr
    assert "receptances predicted by" in found.stderr
    told = json.loads(found.stdout)
    assert told["prediction"]["factor"] > 1
    where = ",".join(f"{name}={value!r}" for name, value in told["posture"].items())
    there = run("predict", "fanuc_s360", "--campaign", struck, "--posture", where, "--json", "--quiet")
    predicted = json.loads(there.stdout)
    one = next(f for f in predicted["frfs"] if f["response"] == f["reference"] == "location_1:+z")
    line -= int(np.argmin(abs(axis - predicted["frequency"][0])))
    assert told["objective"] == pytest.approx(abs(complex(one["re"][line], one["im"][line])), rel=1e-6)
    assert told["prediction"]["factor"] == pytest.approx(one["high"][line] / told["objective"], rel=1e-6)
    assert told["prediction"]["beyond"] == predicted["beyond"]


def test_the_answer_is_told_with_its_band_and_where_it_stands(struck):
    found = run(
        "optimise", "fanuc_s360", "--campaign", struck, "--family", "second_link_horizontal", *ASKED,
        "--predict-by", "nearest",
    )  # fmt: skip
    assert found.exit_code == 0, found.stderr
    assert "predicted by nearest; with its 95 % band " in found.stdout
    assert "data alone: physics has no part in it" in found.stdout


@pytest.mark.slow
def test_an_atlas_of_predictions_is_read_with_its_band(struck, tmp_path):
    store = tmp_path / "a.zarr"
    made = run(
        "atlas", "fanuc_s360", "--campaign", struck, "--grid", "q1=0.5:1.5:2,q2=-1,q3=3",
        "--frequencies", "12", "--direction", "location_1:+z", "--out", store, "--workers", "1", "--quiet",
    )  # fmt: skip
    assert made.exit_code == 0, made.stderr
    told = run("lookup", store, "--best", "2", "--frequency", "12")
    assert "95 % band [m/N]" in told.stdout
    assert "outside" in told.stdout  # nobody struck with q3 at 3 rad
    assert "receptances predicted by" in told.stdout
    best = json.loads(run("lookup", store, "--best", "1", "--frequency", "12", "--json").stdout)["best"][0]
    assert best["prediction"]["low"] < best["value"] < best["prediction"]["high"]
    page = tmp_path / "map.html"
    assert run("lookup", store, "--map", page, "--frequency", "12", "--quiet").exit_code == 0
    assert "Joints outside what was struck" in page.read_text()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--predict-by", "hybrid"), "allowed: --campaign DIR"),
        (
            ("--campaign", "CAMPAIGN", "--objective", "stiffness"),
            "with --campaign: the others are of a model",
        ),
        (("--campaign", "CAMPAIGN", "--robust", "worst", *ASKED), "a prediction has a band of its own"),
        (("--campaign", "CAMPAIGN", "--direction", "tool:+x", "--frequency", "12"), "struck and measured"),
        (
            ("--campaign", "CAMPAIGN", "--direction", "location_1:+z", "--frequency", "400"),
            r"to 59\.\d+ Hz, the band that was measured",
        ),
    ],
)
def test_what_is_refused(struck, words, says):
    given = [str(struck) if word == "CAMPAIGN" else word for word in words]
    ran = run("optimise", "fanuc_s360", "--free", "--starts", "1", *given)
    assert ran.exit_code != 0
    with pytest.raises(flexmodal.FlexmodalError, match=says):
        raise ran.exception


def test_an_atlas_of_anything_else_is_refused(struck, tmp_path):
    ran = run(
        "atlas", "fanuc_s360", "--campaign", struck, "--grid", "q1=1,q2=-1,q3=0", "--quantity", "modes",
        "--out", tmp_path / "a.zarr",
    )  # fmt: skip
    with pytest.raises(flexmodal.FlexmodalError, match="receptance or depth with --campaign"):
        raise ran.exception


@pytest.mark.slow
def test_an_atlas_of_predicted_depths_is_read_with_its_band(struck, tmp_path):
    """Its depth is that which `lobes` finds there at the same two speeds."""
    store = tmp_path / "d.zarr"
    made = run(
        "atlas", "fanuc_s360", "--campaign", struck, "--grid", "q1=1.2,q2=-1.2,q3=0.1", "--quantity", "depth",
        "--cut", "aluminium", "--speeds", "2", "--out", store, "--workers", "1", "--quiet",
    )  # fmt: skip
    assert made.exit_code == 0, made.stderr
    best = json.loads(run("lookup", store, "--best", "1", "--json").stdout)["best"][0]
    assert best["prediction"]["low"] < best["value"] < best["prediction"]["high"]
    assert best["prediction"]["beyond"] == 1  # nobody struck with q3 at 0.1 rad
    there = run(
        "lobes", "fanuc_s360", "--campaign", struck, "--posture", "q1=1.2,q2=-1.2,q3=0.1",
        "--cut", "aluminium", "--speeds", "2", "--json", "--quiet",
    )  # fmt: skip
    assert json.loads(there.stdout)["depth"][0] == pytest.approx(
        float(open_atlas(store).dataset["limiting_depth"].values.ravel()[0]), rel=1e-6
    )

"""`flexmodal fit`: real measurements through the command line, files it writes, requests it refuses."""

import csv
import json
from pathlib import Path

import pytest

from flexmodal.campaign import read_campaign

DATA = Path(__file__).parents[1] / "data"
REAL = DATA / "real"
BEAM, PLATE = REAL / "free_free_beam", REAL / "mssp_plate_sweep"


def reference(dataset, peer):
    with (REAL / "reference_results.csv").open(newline="") as file:
        rows = [
            row for row in csv.DictReader(file) if row["dataset"] == dataset and row["peer"].startswith(peer)
        ]
    return [(float(row["natural_frequency_hz"]), float(row["damping_ratio"])) for row in rows]


def test_the_beam_as_other_programs_find_it(cli):
    modes = cli("fit", BEAM, "--per", "posture", "--json").json()["modes"]
    first = [mode for mode in modes if mode["response"] == [1, 1] and mode["reference"] == [1, 1]]
    peers = reference("pyuff_accelerance_points", "own single-mode LS")
    assert len(first) == len(peers) == 6
    for mode, (frequency, damping) in zip(first, peers, strict=True):
        assert mode["frequency"] == pytest.approx(frequency, rel=0.005)  # half a per cent
        low, high = mode["uncertainty"]["damping_ratio_95"]
        # The peers scatter among themselves by a sixth; our interval reaches one of them or lies that near.
        assert low * 0.8 <= damping <= high * 1.2


# The plate's peaks by hand, one at a time: the sweep is jagged round them, see docs/tables/ema_real.md.
@pytest.mark.parametrize(("band", "number"), [("62:95", 0), ("110:145", 1), ("190:240", 2), ("245:285", 3)])
def test_the_plate_from_its_time_histories(cli, band, number):
    low, high = map(float, band.split(":"))
    options = ("--band", band, "--at", f"{(low + high) / 2}", "--weighting", "logarithmic", "--json")
    (mode,) = cli("fit", PLATE, *options).json()["modes"]
    frequency, _ = reference("mssp_plate_sweep", "sdypy-EMA")[number]
    assert mode["frequency"] == pytest.approx(frequency, rel=0.005)


def test_methods_and_json(cli):
    for method in ("peaks", "circle", "least-squares", "lscf"):
        options = ("--method", method, "--band", "110:145", "--at", "126", "--json")
        found = cli("fit", PLATE, *options).json()
        assert set(found) == {"modes", "refused"}
        for mode in found["modes"]:
            keys = {
                "posture",
                "response",
                "reference",
                "frequency",
                "damping_ratio",
                "residue",
                "uncertainty",
            }
            assert keys | {"quality"} <= set(mode)
            assert mode["frequency"] == pytest.approx(126.0, rel=0.01)  # four readings of one jagged peak


def test_a_ratio_forced_by_hand_is_kept(cli):
    options = ("--band", "110:145", "--at", "126", "--damping", "126=0.02", "--json")
    (mode,) = cli("fit", PLATE, *options).json()["modes"]
    assert mode["damping_ratio"] == pytest.approx(0.02, abs=1e-12)


def test_modes_csv_goes_back_into_the_campaign(cli, tmp_path):
    folder = tmp_path / "beam"
    folder.mkdir()
    for name in ("campaign.toml", "frf.uff"):
        (folder / name).write_bytes((BEAM / name).read_bytes())
    ran = cli("fit", folder, "--per", "posture", "--out", folder / "modes.csv")
    assert ran.status == 0
    table = read_campaign(folder).modes
    assert table is not None
    assert len(table) == 18  # six modes at three places
    assert table.natural_frequency.min() == pytest.approx(51.52, rel=0.005)
    cli("fit", folder, "--out", folder / "modes.csv").refused("an existing file", "--force")


def test_picture_of_one_frf(cli, tmp_path):
    ran = cli("fit", PLATE, "--band", "110:145", "--at", "126", "--out", tmp_path / "fit.png")
    assert ran.status == 0
    assert (tmp_path / "fit.png").stat().st_size > 20_000
    cli("fit", BEAM, "--out", tmp_path / "beam.png").refused("one picture")


def test_refused(cli, tmp_path):
    cli("fit", tmp_path / "nowhere").refused("nowhere")
    thesis = Path(__file__).parents[2] / "robots" / "fanuc_s360" / "campaigns" / "thesis"
    cli("fit", thesis).refused("neither FRFs nor blows", "frf.uff or time.uff")
    cli("fit", PLATE, "--damping", "126").refused("--damping", "HZ=RATIO")
    cli("fit", PLATE, "--band", "9:3").refused("--band", "LOW:HIGH")
    cli("fit", BEAM, "--estimator", "H2").refused("no blows")


def test_exit_1_where_no_mode_is_found(cli):
    ran = cli("fit", PLATE, "--band", "150:180", "--forbid", "150:180", "--json")
    assert ran.status == 1
    assert json.loads(ran.out)["modes"] == []


@pytest.mark.parametrize(
    ("options", "headings"),
    [
        ((BEAM, "--per", "posture", "--method", "lscf"), ["Measured and synthesised", "Stabilisation"]),
        ((PLATE, "--band", "110:145", "--at", "126", "--method", "circle"), ["Circles", "Coherence"]),
    ],
)
def test_one_page_with_every_picture(cli, tmp_path, options, headings):
    page = tmp_path / "fit.html"
    assert cli("fit", *options, "--out", page).status == 0
    text = page.read_text(encoding="utf-8")
    for heading in headings:
        assert f"<h2>{heading}</h2>" in text
    assert text.count("<svg") >= len(headings)
    assert 'src="http' not in text
    assert 'href="http' not in text


def test_the_laboratory_hammer_test_as_other_programs_find_it(cli):
    (mode,) = cli("fit", REAL / "laboratory_hammer", "--json").json()["modes"]
    peers = [
        peer
        for name in ("own single-mode LS", "sdypy-EMA", "vibrationtesting")
        for peer in reference("vibrationtesting_lab_frf/case1", name)
    ]
    assert len(peers) == 3
    low, high = mode["uncertainty"]["damping_ratio_95"]
    assert all(mode["frequency"] == pytest.approx(frequency, rel=0.005) for frequency, _ in peers)
    assert any(low <= damping <= high for _, damping in peers)  # they scatter among themselves by 9 %

"""`flexmodal fit`: real measurements through the command line, files it writes, requests it refuses."""

import importlib.util
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import read_campaign

ROOT = Path(__file__).parents[2]

DATA = Path(__file__).parents[1] / "data"
REAL = DATA / "real"
BEAM, PLATE = REAL / "free_free_beam", REAL / "mssp_plate_sweep"


PATH = Path(__file__).parents[2] / "benchmarks" / "ema_real.py"


def bench():
    """The calls of docs/tables/ema_real.md."""
    spec = importlib.util.spec_from_file_location("ema_real", PATH)
    module = importlib.util.module_from_spec(spec)
    sys.modules["ema_real"] = module
    spec.loader.exec_module(module)
    return module


REFINED = [case for case in bench().CASES if case.refined]


ONE_MODE = ("--band", "400:490", "--at", "445")
"""Two modes of the plate fitted as one, in the table as a warning."""
OUTSIDE = {
    # Half-power bands of a quarter of a line: one-mode least squares is held, LSCF 7 and 9 % above it is not.
    ("free_free_beam", 5): 1,
    ("free_free_beam", 6): 1,
    # vibrationtesting's mdof_cf, 7 % below the three others.
    ("laboratory_hammer", 1): 1,
    # One pole, picked three times, of an LSCF that ripples pull down: see test_ripples in tests/ema.
    ("mssp_plate_sweep", 5): 3,
    # Where several poles of order 80 lie, one of them is damped by 1.1 %.
    ("mssp_plate_sweep", 6): 1,
}
"""How many reference dampings the stated interval does not hold, by folder and mode."""
OUTSIDE_AVERAGED = {("mssp_plate_sweep", 6): 1}


@pytest.mark.some(3)
@pytest.mark.parametrize("case", REFINED, ids=lambda case: " ".join([case.folder, *case.options[:4]]))
def test_real_measurements_as_other_programs_find_them(cli, case):
    """Frequencies within half a per cent of every reference, their dampings within the stated interval.

    The references disagree among themselves (docs/tables/ema_real.md): those outside are named one by one.
    """
    found = list(bench().compared(case, cli(*case.arguments(), "--json").json()))
    assert len(found) == (6 if case.folder == "free_free_beam" else 1)
    for one in found:
        given = [peer.frequency for peer in one.references if not peer.averaged]
        assert all(abs(one.row["frequency"] / frequency - 1) < 0.005 for frequency in given)
        if case.options[:4] == ONE_MODE:
            continue
        where = case.folder, one.number
        assert len(one.dampings()) - one.held() == OUTSIDE.get(where, 0), one
        outside = len(one.dampings(averaged=True)) - one.held(averaged=True)
        assert outside == OUTSIDE_AVERAGED.get(where, 0), one


def test_one_mode_for_two_is_too_sure_of_itself(cli):
    """The number of modes is no part of the interval, and complex residual terms hide the second one."""
    sixth = {case.options[:4] == ONE_MODE: case for case in REFINED if "400:490" in case.options}
    (one,), both = (cli(*sixth[alone].arguments(), "--json").json()["modes"] for alone in (True, False))
    assert len(both) == 2
    assert both[1]["frequency"] == pytest.approx(472, abs=5)
    low, high = both[0]["uncertainty"]["damping_ratio_95"]
    assert low < one["damping_ratio"] < high  # the fit of both knows of the choice
    assert one["uncertainty"]["damping_ratio_95"][0] > both[0]["damping_ratio"]  # that of one mode does not


def test_methods_and_json(cli):
    for method in ("peaks", "circle", "least-squares", "lscf"):
        options = ("--method", method, "--band", "110:145", "--at", "126", "--json")
        found = cli("fit", PLATE, *options).json()
        assert set(found) == {"modes", "refused", "flags"}
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
    cli("fit", BEAM, "--out", tmp_path / "beam.png").refused("one picture", "--pictures")


@pytest.mark.slow
def test_every_picture_into_a_folder(cli, tmp_path):
    folder = tmp_path / "pictures"
    options = ("--per", "posture", "--band", "400:990", "--no-vary", "--pictures", folder, "--svg")
    ran = cli("fit", BEAM, *options)
    assert (ran.status, ran.out) == (0, "")
    names = {path.name for path in folder.iterdir()}
    places = ("1+x_per_1+x", "1+x_per_2+x", "1+x_per_3+x")
    assert names == {
        *(f"{kind}_1_{place}.svg" for kind in ("frf", "nyquist") for place in places),
        "stabilisation_1.svg",
        "shapes_1_sensor_1+x.svg",  # the hammer went from point to point
        "mac_1_sensor_1+x.svg",
    }
    for path in folder.iterdir():
        text = path.read_text(encoding="utf-8")
        assert text.rstrip().endswith("</svg>")
        assert "nan" not in text
    cli("fit", BEAM, *options).refused("an existing folder with", "--force")
    assert cli("fit", BEAM, *options, "--force").status == 0
    (tmp_path / "file").write_text("")
    cli("fit", BEAM, "--pictures", tmp_path / "file").refused("a file", "not a folder")
    cli("fit", BEAM, "--pictures", tmp_path / "no" / "where").refused("no such folder")


@pytest.mark.slow
def test_circles_are_among_the_pictures(cli, tmp_path):
    options = ("--band", "110:145", "--at", "126", "--method", "circle", "--pictures", tmp_path / "p")
    assert cli("fit", PLATE, *options).status == 0
    names = {path.name for path in (tmp_path / "p").iterdir()}
    assert {"circle_1_2+z_per_1+z_1.png", "coherence_1.png", "stabilisation_1.png"} <= names


def test_what_is_odd_about_the_data_is_said(cli):
    """The sweep of the plate: its force dips at the resonances; it is no series of double hits."""
    options = ("--band", "110:145", "--at", "126", "--no-vary")
    flags = cli("fit", PLATE, *options, "--json").json()["flags"]
    assert {flag["kind"] for flag in flags} == {"low energy in band"}
    assert len(flags) == 5  # one a run
    assert set(flags[0]) == {"kind", "posture", "trial", "blow", "point", "says"}
    assert flags[0]["point"] == [1, 3]
    said = [line for line in cli("fit", PLATE, *options).out.splitlines() if line.startswith("flag:")]
    assert len(said) == 1  # the five runs in one line
    assert "low energy in band" in said[0]
    assert "5 blows in all" in said[0]


@pytest.mark.slow
def test_choices_of_the_analyst_can_be_made_by_hand(cli):
    options = ("--band", "110:145", "--at", "126", "--json")
    (varied,) = cli("fit", PLATE, *options).json()["modes"]
    (fixed,) = cli("fit", PLATE, *options, "--no-vary").json()["modes"]
    assert fixed["uncertainty"]["choices"] == {"frequency": 0.0, "damping_ratio": 0.0, "residue": 0.0}
    assert fixed["uncertainty"]["noise"] == varied["uncertainty"]["noise"]
    (real,) = cli("fit", PLATE, *options, "--residuals", "real").json()["modes"]
    assert real["damping_ratio"] != varied["damping_ratio"]
    lscf = ("--band", "60:500", "--method", "lscf", "--no-refine", "--json")
    wide = cli("fit", PLATE, *lscf).json()["modes"]
    tight = cli("fit", PLATE, *lscf, "--order", "20", "--tolerances", "0.001,0.001").json()["modes"]
    assert len(tight) < len(wide)
    cli("fit", PLATE, "--tolerances", "0.01").refused("--tolerances", "FREQUENCY,DAMPING")
    cli("fit", PLATE, "--tolerances", "0,0.5").refused("above 0")


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
        (
            (BEAM, "--per", "posture", "--method", "lscf", "--band", "400:990", "--no-vary"),
            ["Measured and synthesised", "Choose the modes"],
        ),
        pytest.param(
            (PLATE, "--band", "110:145", "--at", "126", "--method", "circle"),
            ["Circles", "Coherence"],
            marks=pytest.mark.slow,
        ),
    ],
)
@pytest.mark.slow
def test_one_page_with_every_picture(cli, tmp_path, options, headings):
    page = tmp_path / "fit.html"
    assert cli("fit", *options, "--out", page).status == 0
    text = page.read_text(encoding="utf-8")
    for heading in [*headings, "Quality of the data", "Nyquist plots"]:
        assert f"<h2>{heading}</h2>" in text
    assert text.count("<svg") >= len(headings)
    assert 'src="http' not in text
    assert 'href="http' not in text


def test_a_folder_of_universal_files_is_told_that_one_will_do(cli, tmp_path):
    (tmp_path / "bare").mkdir()
    cli("fit", tmp_path / "bare").refused("bare: found a folder without a campaign.toml", "universal file")
    shutil.copy(ROOT / "tests/data/real/laboratory_hammer/frf.uff", tmp_path / "bare" / "mine.uff")
    cli("fit", tmp_path / "bare").refused("such as", tmp_path / "bare" / "mine.uff")


def test_a_table_keeps_the_uncertainties(cli, tmp_path):
    """In modes.csv as in JSON, and a campaign with that table is read again."""
    table, folder = tmp_path / "modes.csv", tmp_path / "beam"
    rows = cli("fit", BEAM, "--per", "posture", "--json").json()["modes"]
    assert cli("fit", BEAM, "--per", "posture", "--out", table).status == 0
    shutil.copytree(BEAM, folder)
    shutil.copy(table, folder / "modes.csv")
    modes = read_campaign(folder).modes
    np.testing.assert_array_equal(modes.frequency_error, [row["uncertainty"]["frequency"] for row in rows])
    np.testing.assert_array_equal(modes.damping_error, [row["uncertainty"]["damping_ratio"] for row in rows])
    sizes = np.array([np.hypot(*row["amplitude"]) / np.hypot(*row["residue"]) for row in rows])
    residues = np.array([row["uncertainty"]["residue"] for row in rows])
    np.testing.assert_allclose(modes.amplitude_error, sizes * residues, rtol=1e-12)
    broken = table.read_text(encoding="utf-8").replace(",amplitude_error", "")
    (folder / "modes.csv").write_text(broken, encoding="utf-8")
    cli("fit", folder).refused("line 1", "amplitude_error")


@pytest.mark.parametrize("kind", ["time histories", "spectra"])
def test_output_only_data_are_not_supported_and_said_so(cli, tmp_path, kind):
    text = (ROOT / "tests/data/real/pyuff_accelerance_points/measurement.uff").read_text(encoding="utf-8")
    lines = text.splitlines()
    at = [number for number, line in enumerate(lines) if line.strip() == "58"]
    for number in at:
        head = lines[number + 6]
        function = "    1" if kind == "time histories" else "    2"
        lines[number + 6] = f"{function}{head[5:66]}{0:>10d}{0:>4d}"
    path = tmp_path / "responses.uff"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    cli("fit", path).refused("responses", "output-only data are not supported", "pyOMA2")


def test_progress_is_told_posture_by_posture():
    from flexmodal.ema import Choices, fit

    told = []
    fit(read_campaign(BEAM), choices=Choices(vary=False), advance=lambda *step: told.append(step))
    assert told == [("fitting, posture 1 of 1", 0.0)]

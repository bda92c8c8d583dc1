"""The files that `frf --out` writes, read back by other programs' readers."""

import csv
import html
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import pyuff
from PIL import Image

import flexmodal

ENDINGS = (".csv", ".uff", ".npz", ".png", ".svg", ".html")
FANUC = ("frf", "fanuc_s360", "--posture", "configuration_2")
PAIRS = (
    *("--response", "location_1:-z", "--response", "tool:+x"),
    *("--reference", "location_2:+z"),
)


@pytest.fixture(scope="module")
def expected():
    return flexmodal.load("fanuc_s360").frf(
        "configuration_2",
        np.arange(1, 60.25, 0.25),
        response=["location_1:-z", "tool:+x"],
        reference="location_2:+z",
        form="mobility",
    )


@pytest.fixture
def write(cli, tmp_path):
    def run(ending, *options):
        path = tmp_path / f"frf{ending}"
        ran = cli(*FANUC, "--frequencies", "1:60:0.25", *PAIRS, "--form", "mobility", "--out", path, *options)
        assert (ran.status, ran.out) == (0, ""), ran.err
        assert ran.err == f"wrote {path}\n"
        assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
        return path

    return run


def test_csv(write, expected):
    with write(".csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 237
    for pair, response in enumerate(("location_1:-z", "tool:+x")):
        part = [row for row in rows if row["response"] == response]
        assert {(row["reference"], row["form"], row["unit"]) for row in part} == {
            ("location_2:+z", "mobility", "m/(s·N)")
        }
        value = [complex(float(row["re"]), float(row["im"])) for row in part]
        np.testing.assert_array_equal(value, expected.value[:, pair, 0])
        np.testing.assert_array_equal([float(row["frequency_hz"]) for row in part], expected.frequency)


def test_npz(write, expected):
    with np.load(write(".npz"), allow_pickle=False) as found:
        assert set(found) == {"frequency", "value", "response", "reference", "form"}
        np.testing.assert_array_equal(found["value"], expected.value)
        np.testing.assert_array_equal(found["frequency"], expected.frequency)
        assert found["response"].tolist() == ["location_1:-z", "tool:+x"]
        assert found["reference"].tolist() == ["location_2:+z"]
        assert found["form"] == "mobility"


def test_uff(write, expected):
    records = pyuff.UFF(str(write(".uff"))).read_sets()
    assert len(records) == 2
    for pair, record in enumerate(records):
        assert (record["type"], record["binary"], record["func_type"]) == (58, 0, 4)
        assert (record["load_case_id"], record["ver_num"]) == (2, 1)  # the second posture of the card
        assert (record["rsp_node"], record["rsp_dir"]) == [(1, -3), (12, 1)][pair]
        assert (record["ref_node"], record["ref_dir"]) == (2, 3)
        assert (record["ordinate_spec_data_type"], record["orddenom_spec_data_type"]) == (11, 13)
        assert (record["abscissa_spec_data_type"], record["abscissa_spacing"]) == (18, 1)
        assert record["abscissa_axis_units_lab"].strip() == "Hz"
        np.testing.assert_allclose(record["x"], expected.frequency, rtol=1e-6)  # six digits in the format
        # Twelve digits of real and imaginary part each.
        np.testing.assert_allclose(record["data"], expected.value[:, pair, 0], rtol=1e-11)


@pytest.mark.parametrize(("form", "code"), [("receptance", 8), ("mobility", 11), ("inertance", 12)])
def test_uff_says_which_form_and_takes_uneven_lines(cli, tmp_path, form, code):
    path = tmp_path / "frf.uff"
    assert cli(*FANUC, "--frequencies", "0,1,5,20.5", "--form", form, "--out", path).status == 0
    record = pyuff.UFF(str(path)).read_sets()
    assert (record["ordinate_spec_data_type"], record["abscissa_spacing"]) == (code, 0)
    np.testing.assert_allclose(record["x"], [0, 1, 5, 20.5])
    expected = flexmodal.load("fanuc_s360").frf("configuration_2", [0.0, 1.0, 5.0, 20.5], form=form)
    np.testing.assert_allclose(record["data"], expected.value[:, 0, 0], rtol=1e-11)


def test_uff_of_a_posture_without_a_name_and_a_single_line(cli, tmp_path):
    path = tmp_path / "frf.uff"
    ran = cli("frf", "fanuc_s360", "--posture", "q1=1", "--frequencies", "7.5", "--out", path)
    assert ran.status == 0, ran.err
    record = pyuff.UFF(str(path)).read_sets()
    assert record["load_case_id"] == 1
    assert record["x"].tolist() == [7.5]
    assert record["data"].shape == (1,)


def test_png(write):
    with Image.open(write(".png")) as image:
        image.load()
        assert image.format == "PNG"
        assert min(image.size) > 500
        grey = np.asarray(image.convert("L"))
        assert len(image.convert("RGB").getcolors(1 << 24)) > 20
    assert 0.005 < np.mean(grey < 200) < 0.5  # ink on it, and paper between


def test_svg(write):
    root = ElementTree.parse(write(".svg")).getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    texts = {"".join(element.itertext()).strip() for element in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"Frequency [Hz]", "Phase [°]", "Mobility amplitude [m/(s·N)]"} <= texts
    assert "location_1:-z per location_2:+z" in texts
    assert len(list(root.iter("{http://www.w3.org/2000/svg}path"))) > 20


def test_html(write):
    text = write(".html").read_text(encoding="utf-8")
    assert not re.search(r"(?:src|href)\s*=\s*[\"']?\s*(?:https?:)?//", text)
    assert "@import" not in text
    assert text.count("<svg") == 1
    assert "fanuc_s360 at configuration_2" in text
    assert text.count("<details>") == 2
    assert "237 lines from 1 to" in text


NAMES = [
    "<script>alert(1)</script>",
    "a$\\frac$b",
    "_under",
    "{{ 7*7 }}",
    "two\nlines",
    'quo"te&amp;',
    "größe",
]


@pytest.mark.some(3)
@pytest.mark.parametrize("name", NAMES)
def test_odd_names_do_no_harm(cli, urdf, tmp_path, name):
    quoted = html.escape(name).replace("\n", "&#10;")
    path = urdf(('<link name="tool"/>', f'<link name="{quoted}"/>'), ('link="tool"', f'link="{quoted}"'))
    flexible = (path, "--stiffness", "1e4", "--damping", "1", "--posture", "q1=0.3")
    pairs = ("--response", f"{name}:+z", "--response", "hand:+z", "--reference", f"{name}:+z")
    for ending in (".csv", ".uff", ".svg", ".html"):
        ran = cli("frf", *flexible, "--frequencies", "1:5:1", *pairs, "--out", tmp_path / f"frf{ending}")
        assert ran.status == 0, ran.err
    legend = f"{name}:+z per {name}:+z"
    page = (tmp_path / "frf.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert html.escape(legend, quote=False).split("\n")[0] in html.escape(html.unescape(page), quote=False)
    root = ElementTree.parse(tmp_path / "frf.svg").getroot()
    texts = " ".join(
        "".join(element.itertext()).strip() for element in root.iter("{http://www.w3.org/2000/svg}text")
    )
    assert " ".join(legend.split()) in " ".join(texts.split())
    with (tmp_path / "frf.csv").open(newline="", encoding="utf-8") as file:
        assert next(csv.DictReader(file))["response"] == f"{name}:+z"
    records = pyuff.UFF(str(tmp_path / "frf.uff")).read_sets()
    assert [(record["rsp_node"], record["rsp_dir"]) for record in records] == [(5, 3), (4, 3)]
    assert all(len(record["data"]) == 5 for record in records)


@pytest.mark.parametrize("ending", ENDINGS)
def test_an_existing_file_is_left_alone_unless_forced(cli, tmp_path, ending):
    path = tmp_path / f"frf{ending}"
    path.write_bytes(b"somebody's work")
    ran = cli(*FANUC, "--frequencies", "1:5:1", "--out", path)
    ran.refused(path, "an existing file", "--force")
    assert path.read_bytes() == b"somebody's work"
    assert cli(*FANUC, "--frequencies", "1:5:1", "--out", path, "--force").status == 0
    assert path.read_bytes() != b"somebody's work"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("command", ["frf", "show", "demo"])
def test_every_command_that_writes_refuses_first(cli, tmp_path, command):
    name = {"frf": "frf.csv", "show": "page.html", "demo": "six_link.html"}[command]
    path = tmp_path / name
    path.write_text("somebody's work")
    words = {
        "frf": (*FANUC, "--frequencies", "1", "--out", path),
        "show": ("show", "fanuc_s360", "--out", path),
        "demo": ("demo", "--out", tmp_path),
    }[command]
    cli(*words).refused(name, "--force")
    assert path.read_text() == "somebody's work"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["frf.txt", "frf", "frf.", ".csv", "frf.csv.gz", "frf.xlsx", ""])
def test_unknown_endings(cli, tmp_path, name):
    out = tmp_path / name if name else ""
    cli(*FANUC, "--frequencies", "1", "--out", out).refused("--out", ", ".join(ENDINGS))
    assert list(tmp_path.iterdir()) == []


def test_an_ending_in_capitals_is_the_same(cli, tmp_path):
    assert cli(*FANUC, "--frequencies", "1,2", "--out", tmp_path / "FRF.SVG").status == 0
    assert ElementTree.parse(tmp_path / "FRF.SVG").getroot().tag.endswith("svg")


def test_json_and_a_file_at_once(cli, tmp_path):
    path = tmp_path / "frf.csv"
    ran = cli(*FANUC, "--frequencies", "1,2", "--out", path, "--json")
    assert len(ran.json()["re"]) == 2
    assert ran.err == f"wrote {path}\n"


@pytest.mark.parametrize("ending", ENDINGS)
def test_folders_that_cannot_be_written_to(cli, tmp_path, ending):
    path = tmp_path / f"frf{ending}"
    path.mkdir()
    for force in ((), ("--force",)):
        cli(*FANUC, "--frequencies", "1", "--out", path, *force).refused(path, "a folder")
    cli(*FANUC, "--frequencies", "1", "--out", tmp_path / "no" / path.name).refused("no such folder")
    cli(*FANUC, "--frequencies", "1", "--out", f"/proc/frf{ending}").refused("/proc")  # even for root
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_full_disk_leaves_what_was_there(cli, tmp_path, ending):
    """A limit on the size of files stands in for the disk: the write fails in the midst of the file."""
    import resource
    import signal

    path = tmp_path / f"frf{ending}"
    path.write_text("yesterday's")
    words = (*FANUC, "--frequencies", "1:2000:1", "--out", path, "--force")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        ran = cli(*words)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    ran.refused("File too large")
    assert path.read_text() == "yesterday's"
    assert list(tmp_path.iterdir()) == [path]

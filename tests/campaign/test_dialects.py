"""Tables as analysers export them: drafted, read, and the numbers that were put in come out."""

from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import draft_map, import_table
from flexmodal.campaign.description.read import read_toml
from flexmodal.campaign.new import new_campaign_toml
from flexmodal.campaign.tables.draft import form_of
from flexmodal.errors import InvalidCampaign

SAMPLES = Path(__file__).parents[1] / "data" / "dialects"
FREQUENCY = np.arange(2.0, 42.0)


def inertance(point):
    """Of two modes at 9 and 24 Hz, as tests/data/dialects/README.md says."""
    s = 2j * np.pi * FREQUENCY
    total = np.zeros(len(s), complex)
    for hertz, ratio, size in ((9.0, 0.03, 1.0), (24.0, 0.02, 0.5 * (-1) ** point)):
        omega = 2 * np.pi * hertz
        total += size * s**2 / (omega**2 + s**2 + 2 * ratio * omega * s)
    return total / 5


@pytest.fixture
def folder(tmp_path):
    points = {name: ("link_3", (0.1, 0.0, 0.0)) for name in ("one", "two")}
    text = new_campaign_toml("a test", "fanuc_s360", {"p": {"q1": 0.5}, "q": {"q1": 1.0}}, points)
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    return tmp_path


def imported(folder, table, change=lambda text: text):
    text = change(draft_map(table, beside=folder / "map.toml"))
    (folder / "map.toml").write_text(text, encoding="utf-8")
    return import_table(folder / "map.toml")


def long(seconds):
    """The map with blows of that length."""
    return lambda text: text.replace("# length = 2.0", f"length = {seconds}")


@pytest.mark.parametrize(
    ("name", "count", "tolerance"),
    [
        ("decimal_commas.csv", 1, 2e-6),
        ("decibels.txt", 2, 1e-7),
        ("lying.csv", 1, 1e-7),
        ("columns.txt", 1, 1e-7),
    ],
)
def test_what_was_exported_comes_in(folder, name, count, tolerance):
    frfs = imported(folder, SAMPLES / name).frfs
    assert len(frfs) == count
    assert frfs.form == "inertance"
    np.testing.assert_allclose(frfs.frequency, FREQUENCY)
    for row in range(count):
        np.testing.assert_allclose(frfs.value[row], inertance(row + 1), rtol=tolerance, atol=tolerance)
    assert (frfs.coherence is not None) == (name in ("decimal_commas.csv", "lying.csv"))


def test_a_magnitude_alone_is_refused_with_the_reason(folder):
    with pytest.raises(InvalidCampaign, match="a magnitude alone lacks the phase"):
        draft_map(SAMPLES / "magnitude_only.csv")
    text = draft_map(SAMPLES / "columns.txt").replace('re = "real_H1"\nim = ', "magnitude = ")
    (folder / "map.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InvalidCampaign, match="modes, directions and the fit of a model are in the phase"):
        import_table(folder / "map.toml")


def test_a_continuous_record_is_cut_into_blows(folder):
    whole = imported(folder, SAMPLES / "continuous.csv")
    assert len(whole.blows) == 1
    made = imported(
        folder, SAMPLES / "continuous.csv", lambda text: text.replace("# length = 2.0", "length = 1.5")
    )
    assert [blow.sequence for blow in made.blows] == [1, 2, 3]
    peaks = [blow.force.max() for blow in made.blows]
    np.testing.assert_allclose(peaks, [100.0, 120.0, 90.0], rtol=1e-3)
    for blow, peak in zip(made.blows, peaks, strict=True):
        assert len(blow.time) == 300
        assert blow.time[int(np.argmax(blow.force))] == pytest.approx(0.03, abs=0.016)
        later = blow.time - 0.03 > 0.5
        expected = peak / 100 * np.exp(-1.5 * 0.5)
        assert np.abs(blow.response[0][later]).max() == pytest.approx(expected, rel=0.1)
    with pytest.raises(InvalidCampaign, match="no blow that long"):
        imported(
            folder, SAMPLES / "continuous.csv", lambda text: text.replace("# length = 2.0", "length = 50.0")
        )


def test_waveforms_of_labview_are_the_same_record_as_the_text(folder):
    """Two routes to one record: columns of text, and channels with step, start and units beside them."""
    pytest.importorskip("nptdms")
    text, wave = (imported(folder, SAMPLES / f"continuous.{kind}", long(1.5)) for kind in ("csv", "tdms"))
    assert len(wave.blows) == 3
    for one, other in zip(text.blows, wave.blows, strict=True):
        np.testing.assert_allclose(other.time, one.time, atol=1e-9)
        np.testing.assert_allclose(other.force, one.force, rtol=1e-6)  # single precision there
        np.testing.assert_allclose(other.response, one.response, rtol=1e-6)


def test_a_tdms_file_of_two_rates_has_no_common_time(folder, tmp_path):
    nptdms = pytest.importorskip("nptdms")
    table = tmp_path / "two.tdms"
    channels = [
        nptdms.ChannelObject("g", name, np.arange(8.0), {"wf_increment": step, "wf_start_offset": 0.0})
        for name, step in (("force", 1e-3), ("acc", 2e-3))
    ]
    with nptdms.TdmsWriter(table) as writer:
        writer.write_segment(channels)
    with pytest.raises(InvalidCampaign, match="columns 'g/force', 'g/acc'; allowed: one whose header says"):
        draft_map(table)
    table.write_bytes(table.read_bytes()[:60])
    with pytest.raises(InvalidCampaign, match=r"two\.tdms: found"):
        draft_map(table)


@pytest.mark.parametrize("kind", ["mat", "h5"])
def test_arrays(folder, kind):
    matrix = np.stack([inertance(1), inertance(2)])  # lies down; the abscissa stands
    table = folder / f"measured.{kind}"
    if kind == "mat":
        from scipy.io import savemat

        savemat(table, {"frequency": FREQUENCY[:, None], "data": {"H_acc": matrix}})
    else:
        h5py = pytest.importorskip("h5py")
        with h5py.File(table, "w") as file:
            file["frequency"] = FREQUENCY
            file["data/H_acc"] = matrix
    frfs = imported(folder, table).frfs
    assert len(frfs) == 2
    np.testing.assert_array_equal(frfs.value, matrix)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("data/H_acc[2]", "data/H_acc[3]", "column 3"),
        ("data/H_acc[2]", "data/H_acc", "a matrix of 2 × 40"),
        ("data/H_acc[2]", "data/K[2]", "no such variable"),
    ],
)
def test_faults_of_arrays_name_the_variable(folder, old, new, says):
    from scipy.io import savemat

    table = folder / "measured.mat"
    savemat(table, {"frequency": FREQUENCY, "data": {"H_acc": np.stack([inertance(1), inertance(2)])}})
    with pytest.raises(InvalidCampaign, match="variable") as caught:
        imported(folder, table, lambda text: text.replace(old, new))
    assert says in str(caught.value)


def test_several_files_of_one_test(folder):
    for number in (1, 2):
        pairs = zip(FREQUENCY.tolist(), inertance(number).tolist(), strict=True)
        lines = ["f,re,im", *(f"{f},{v.real!r},{v.imag!r}" for f, v in pairs)]
        (folder / f"{number}.csv").write_text("\n".join(lines))
    text = draft_map(folder / "1.csv", beside=folder / "map.toml")
    second = text[text.index("[[frf]]") :].replace("[1, 3]  # guessed", '[2, 3]\ntable = "2.csv"  #')
    (folder / "map.toml").write_text(text + "\n" + second)
    np.testing.assert_allclose(import_table(folder / "map.toml").frfs.value, [inertance(1), inertance(2)])
    shorter = (folder / "2.csv").read_text().splitlines()[:-3]
    (folder / "2.csv").write_text("\n".join(shorter))
    with pytest.raises(InvalidCampaign, match=r"2\.csv.*another frequency axis"):
        import_table(folder / "map.toml")


def test_an_excel_sheet_behind_an_empty_one(folder):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    sheet = book.create_sheet("FRF")
    sheet.append(["Frequency", "Real", "Imaginary"])
    sheet.append(["Hz", "mm/N", "mm/N"])
    for f, v in zip(FREQUENCY, inertance(1), strict=True):
        sheet.append([float(f), v.real, v.imag])
    book.save(folder / "frf.xlsx")
    frfs = imported(folder, folder / "frf.xlsx").frfs
    assert frfs.form == "receptance"
    np.testing.assert_allclose(frfs.value[0], 1e-3 * inertance(1), rtol=1e-12)


@pytest.mark.parametrize(
    ("unit", "form", "scale"),
    [("g/N", "inertance", 9.80665), ("(m/s^2)/N", "inertance", 1.0), ("m/s/N", "mobility", 1.0),
     ("mm/N", "receptance", 1e-3), ("dB", "inertance", 1.0)],
)  # fmt: skip
def test_units_tell_the_form(unit, form, scale):
    assert form_of(unit)[:2] == (form, scale)
    assert form_of(unit)[2] == (unit != "dB")


def test_no_table_is_said(tmp_path):
    (tmp_path / "letter.txt").write_text("Dear colleague,\nthe test went well.\n")
    with pytest.raises(InvalidCampaign, match="no table of numbers"):
        draft_map(tmp_path / "letter.txt")
    (tmp_path / "a.csv").write_text("x,y\n1,2\n2,3\n3,4\n")
    with pytest.raises(InvalidCampaign, match="says frequency or time"):
        draft_map(tmp_path / "a.csv")
    (tmp_path / "a.mat").write_bytes(b"no arrays at all")
    with pytest.raises(InvalidCampaign, match="cannot be read"):
        draft_map(tmp_path / "a.mat")


def test_a_new_campaign_reads_as_it_stands(folder):
    tested = read_toml(folder / "campaign.toml")
    assert [posture.name for posture in tested.postures] == ["p", "q"]
    assert [point.link for point in tested.points] == ["link_3", "link_3"]
    assert [trial.repeat_of for trial in tested.trials] == [None, 1]
    assert tested.band == (2.0, 200.0)

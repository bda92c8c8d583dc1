"""CSV and XLSX by a column map."""

from pathlib import Path

import numpy as np
import openpyxl
import pytest

from flexmodal.campaign import Campaign, import_table, read_campaign, write_campaign
from flexmodal.campaign.write_campaign import campaign_toml
from flexmodal.errors import InvalidCampaign

MAP = """\
format = 1
campaign = "campaign.toml"
table = "frf.csv"
abscissa = "f [Hz]"
[[frf]]
posture = 1
trial = 1
response = [1, 3]
reference = [2, -3]
form = "inertance"
re = "re"
im = "im"
coherence = "g"
[[frf]]
posture = 1
trial = 1
response = [3, 1]
reference = [2, -3]
form = "inertance"
magnitude = "mag"
phase = "deg"
scale = 9.80665
"""
BLOWS = """\
format = 1
campaign = "campaign.toml"
table = "time.csv"
abscissa = "t"
[[blow]]
posture = 1
trial = 1
reference = [2, -3]
quantity = "acceleration"
force = "F"
force_scale = 0.5
[[blow.channel]]
response = [1, 3]
column = "a"
"""
FREQUENCY = np.array([0.5, 1.0, 1.5])
ROWS = [(0.5, 1.0, 2.0, 0.9, 2.0, 90.0), (1.0, 3.0, -4.0, 0.8, 1.0, 180.0), (1.5, 5.0, 0.0, 1.0, 4.0, 0.0)]
NAMES = ("f [Hz]", "re", "im", "g", "mag", "deg")


@pytest.fixture
def folder(campaign: Campaign, tmp_path: Path) -> Path:
    (tmp_path / "campaign.toml").write_text(campaign_toml(campaign), encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAP)
    text = ",".join(NAMES) + "\n" + "".join(",".join(map(str, row)) + "\n" for row in ROWS)
    (tmp_path / "frf.csv").write_text(text)
    return tmp_path


def check(made: Campaign) -> None:
    frfs = made.frfs
    assert frfs is not None
    np.testing.assert_array_equal(frfs.frequency, FREQUENCY)
    np.testing.assert_array_equal(frfs.value[0], [1 + 2j, 3 - 4j, 5])
    g = 9.80665
    np.testing.assert_allclose(frfs.value[1], [2j * g, -1 * g, 4 * g], atol=1e-14)
    assert frfs.coherence is not None
    np.testing.assert_array_equal(frfs.coherence, [[0.9, 0.8, 1.0], [1, 1, 1]])
    assert frfs.response.tolist() == [[1, 3], [3, 1]]


def test_csv(folder: Path) -> None:
    made = import_table(folder / "map.toml")
    check(made)
    check(read_campaign(write_campaign(made, folder / "written")))
    check(read_campaign(folder / "map.toml"))


def test_semicolons_decimal_commas_and_lines_above_the_header(folder: Path) -> None:
    (folder / "map.toml").write_text('delimiter = ";"\ndecimal = ","\nskip = 2\n' + MAP)
    text = "Analyser 3000\n\n" + ";".join(NAMES) + "\n"
    text += "".join(";".join(str(cell).replace(".", ",") for cell in row) + "\n" for row in ROWS)
    (folder / "frf.csv").write_text(text)
    check(import_table(folder / "map.toml"))


def test_xlsx(folder: Path) -> None:
    book = openpyxl.Workbook()
    book.create_sheet("Data").append(NAMES)
    for row in ROWS:
        book["Data"].append(row)
    book.save(folder / "frf.xlsx")
    (folder / "map.toml").write_text(MAP.replace("frf.csv", "frf.xlsx").replace("[[frf]]", "", 0))
    with pytest.raises(InvalidCampaign, match="no such column"):
        import_table(folder / "map.toml")  # the first sheet is empty
    (folder / "map.toml").write_text('sheet = "Data"\n' + MAP.replace("frf.csv", "frf.xlsx"))
    check(import_table(folder / "map.toml"))
    (folder / "map.toml").write_text('sheet = "Date"\n' + MAP.replace("frf.csv", "frf.xlsx"))
    with pytest.raises(InvalidCampaign, match='did you mean "Data"'):
        import_table(folder / "map.toml")


def test_blows(folder: Path) -> None:
    (folder / "map.toml").write_text(BLOWS)
    (folder / "time.csv").write_text("t,F,a\n" + "".join(f"{0.01 * n:.2f},{n + 1},{-n}\n" for n in range(5)))
    (blow,) = import_table(folder / "map.toml").blows
    np.testing.assert_array_equal(blow.force, 0.5 * np.arange(1, 6))
    np.testing.assert_array_equal(blow.response, [-np.arange(5.0)])
    assert blow.sequence == 1


@pytest.mark.parametrize(
    ("file", "old", "new", "says"),
    [
        ("map.toml", "format = 1", "format = 2", "format: found 2; allowed: 1"),
        ("map.toml", 're = "re"\n', "", "re and im, or magnitude and phase"),
        ("map.toml", "response = [1, 3]", "response = [1, 4]", "±1 ±2 ±3"),
        ("map.toml", "posture = 1", "posture = 9", "posture 9"),
        ("map.toml", "response = [3, 1]", "response = [7, 1]", "response point 7"),
        ("map.toml", "scale", "scael", 'did you mean "scale"'),
        ("map.toml", '"frf.csv"', '"nowhere.csv"', "no such file"),
        ("map.toml", 're = "re"', 're = "real"', "no such column"),
        ("frf.csv", "3.0", "nan", "row 3, column"),
        ("frf.csv", "3.0", "x", "row 3, column"),
        ("frf.csv", "1.5,", "0.7,", "followed by 0.7"),
        ("frf.csv", "0.9", "1.9", "coherence outside 0 to 1"),
        ("frf.csv", ",re,", ",im,", "no such column"),
    ],
)
def test_faults_are_sentences(folder: Path, file: str, old: str, new: str, says: str) -> None:
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1))
    with pytest.raises(InvalidCampaign) as caught:
        import_table(folder / "map.toml")
    assert says in str(caught.value)


def test_a_bomb_and_a_broken_workbook_are_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import flexmodal.campaign.tables.columns as columns

    (folder / "map.toml").write_text(MAP.replace("frf.csv", "frf.xlsx"))
    (folder / "frf.xlsx").write_bytes(b"PK\3\4 not a workbook")
    with pytest.raises(InvalidCampaign, match="cannot be read"):
        import_table(folder / "map.toml")
    openpyxl.Workbook().save(folder / "frf.xlsx")
    monkeypatch.setattr(columns, "LARGEST", 7000)
    with pytest.raises(InvalidCampaign, match="unpacked"):
        import_table(folder / "map.toml")


@pytest.mark.parametrize(
    ("change", "file", "words"),
    [
        (("posture = 1", "posture = 9"), "map.toml", "posture 9"),
        (("trial = 1", "trial = 9"), "map.toml", "trial 9"),
        (("[2, -3]", "[9, -3]"), "map.toml", "point 9"),
        (("0.9", "1.9"), "frf.csv", "outside 0 to 1, 1.9"),
    ],
)
def test_what_contradicts_the_campaign_names_its_file(folder: Path, change, file, words) -> None:  # type: ignore[no-untyped-def]
    path = folder / file
    path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    with pytest.raises(InvalidCampaign) as caught:
        import_table(folder / "map.toml")
    assert all(fault.file == str(path) for fault in caught.value.faults)
    assert any(words in str(fault) for fault in caught.value.faults)

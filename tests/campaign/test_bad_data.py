"""Files that are spoilt on purpose: each is a clear sentence, in time and in little memory."""

import re
import resource
import shutil
import struct
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyuff

from flexmodal.campaign import Campaign, check_campaign, read_campaign, write_campaign
from flexmodal.campaign.uff.write import frf_datasets
from flexmodal.errors import InvalidCampaign

HEADER = 13
"""Lines of a dataset before its data: tag, number, five of names, six of fields."""


@pytest.fixture(params=[False, True], ids=["ASCII", "binary"])
def folder(request: pytest.FixtureRequest, written: dict[bool, Path], tmp_path: Path) -> Path:
    return Path(shutil.copytree(written[request.param], tmp_path / "c"))


@pytest.fixture
def text(written: dict[bool, Path], tmp_path: Path) -> Path:
    return Path(shutil.copytree(written[False], tmp_path / "c"))


def refused(folder: Path, *says: str) -> str:
    with pytest.raises(InvalidCampaign) as caught:
        read_campaign(folder)
    for part in says:
        assert part in str(caught.value)
    return str(caught.value)


def change(file: Path, old: str | bytes, new: str | bytes, count: int = 1) -> None:
    content = file.read_bytes()
    old, new = (part.encode() if isinstance(part, str) else part for part in (old, new))
    assert old in content
    file.write_bytes(content.replace(old, new, count))


def change_line(file: Path, number: int, edit: Callable[[str], str]) -> None:
    """Edit one line of the first dataset, counted from 1."""
    lines = file.read_bytes().split(b"\n")
    lines[number - 1] = edit(lines[number - 1].decode()).encode()
    file.write_bytes(b"\n".join(lines))


def column(start: int, text: str) -> Callable[[str], str]:
    return lambda line: line[:start] + text + line[start + len(text) :]


def test_a_truncated_file(folder: Path) -> None:
    content = (folder / "frf.uff").read_bytes()
    (folder / "frf.uff").write_bytes(content[: int(0.49 * len(content))])
    refused(folder, "frf.uff: dataset ", "no end tag")


def test_a_hundred_million_declared_points_cost_nothing(folder: Path) -> None:
    change_line(folder / "frf.uff", 9, column(10, f"{10**8:10d}"))
    before, started = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    refused(folder, "dataset 1", "as its count and type declare")
    assert time.process_time() - started < 2
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 100_000  # kB; the declared values would take 1.6 GB


@pytest.mark.parametrize("points", ["39", "41"])
def test_a_count_that_lies_by_one(folder: Path, points: str) -> None:
    change_line(folder / "frf.uff", 9, column(10, f"{points:>10}"))
    refused(folder, "dataset 1", "as its count and type declare")


def test_a_missing_end_tag_and_a_missing_start_tag(text: Path) -> None:
    content = (text / "frf.uff").read_bytes()
    (text / "frf.uff").write_bytes(content[: content.rindex(b"    -1")])
    refused(text, "no end tag")
    (text / "frf.uff").write_bytes(content[7:])
    refused(text, "no start tag at byte 0")


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_values_that_are_not_finite(folder: Path, value: str) -> None:
    content = (folder / "frf.uff").read_bytes()
    if content.split(b"\n")[1].startswith(b"    58b"):
        lines = content.split(b"\n", HEADER)
        start = len(content) - len(lines[HEADER])
        (folder / "frf.uff").write_bytes(
            content[: start + 16] + struct.pack("<d", float(value)) + content[start + 24 :]
        )
    else:
        change_line(folder / "frf.uff", HEADER + 1, column(20, f"{value:>20}"))
    refused(folder, "dataset 1", "finite")


def test_a_wrong_byte_order(campaign: Campaign, tmp_path: Path) -> None:
    folder = write_campaign(campaign, tmp_path / "c")
    change(folder / "frf.uff", b"58b     1", b"58b     2")
    refused(folder, "dataset 1", "byte order")


def test_a_big_endian_file_reads_the_same(campaign: Campaign, tmp_path: Path) -> None:
    folder = write_campaign(campaign, tmp_path / "c")
    content, pieces = (folder / "frf.uff").read_bytes(), []
    size = 40 * 16
    while content:
        lines = content.split(b"\n", HEADER)
        width = size if b"         6        40" in lines[8] else size // 2
        head, rest = b"\n".join(lines[:HEADER]) + b"\n", lines[HEADER]
        pieces += [
            head.replace(b"58b     1", b"58b     2"),
            np.frombuffer(rest[:width], "<f8").astype(">f8").tobytes(),
        ]
        pieces.append(rest[width : width + 7])
        content = rest[width + 7 :]
    (folder / "frf.uff").write_bytes(b"".join(pieces))
    back = read_campaign(folder)
    assert back.frfs is not None
    assert campaign.frfs is not None
    np.testing.assert_array_equal(back.frfs.value, campaign.frfs.value)


def test_an_uneven_axis_flagged_even(folder: Path) -> None:
    file = folder / "time.uff"  # written uneven in binary: 1/2048 s has more than six digits
    change_line(file, 9, lambda line: column(20, f"{1 - int(line[20:30]):10d}")(line))
    refused(folder, "time.uff: dataset 1")


def test_mixed_abscissas(text: Path) -> None:
    change_line(text / "frf.uff", 9, column(43, f"{0.26:13.5e}"))
    message = refused(text, "dataset 2: abscissa", "that of dataset 1")
    assert "40 lines from 0 to 9.75 Hz" in message


@pytest.mark.parametrize(
    ("line", "start", "field", "says"),
    [
        (8, 20, f"{9:10d}", "load case: found 9; allowed: the id of a posture: 1, 2"),
        (8, 15, f"{7:5d}", "version number: found 7; allowed: the id of a trial: 1, 2, 3, 4"),
        (8, 41, f"{77:10d}", "response node: found 77"),
        (8, 66, f"{78:10d}", "reference node: found 78"),
        (8, 51, f"{4:4d}", "response direction: found 4; allowed: ±1 ±2 ±3"),
        (8, 76, f"{0:4d}", "reference direction: found 0"),
        (8, 30, "long_names_", "shifted"),
        (8, 20, "1234567890123", "shifted"),
        (9, 0, f"{3:10d}", "ordinate data type: found 3"),
        (9, 20, f"{2:10d}", "abscissa spacing: found 2"),
        (9, 30, "          nan", "abscissa minimum"),
        (9, 43, f"{-0.25:13.5e}", "a step above 0"),
        (10, 0, f"{17:10d}", "abscissa data type: found 17; allowed: 18"),
        (10, 47, "rad/s", "unit of the abscissa: found 'rad/s'; allowed: SI units"),
        (11, 0, f"{13:10d}", "ordinate numerator data type: found 13"),
        (11, 47, "g      ", "unit of the ordinate numerator: found 'g'"),
        (11, 47, "mm/s^2 ", "unit of the ordinate numerator: found 'mm/s^2'"),
        (12, 0, f"{8:10d}", "ordinate denominator data type: found 8; allowed: 13 force"),
        (12, 47, "lbf    ", "unit of the ordinate denominator: found 'lbf'"),
        (12, 10, "\x85\x85", "bytes that are no text"),
        (11, 0, f"{8:10d}", "unit of the ordinate numerator: found 'm/s^2'; allowed: SI units: m for data"),
        (11, 47, "m/s    ", "found 'm/s'; allowed: SI units: m/s^2 for data type 12"),
        (11, 47, "kg     ", "unit of the ordinate numerator: found 'kg'"),
        (11, 47, "banana ", "unit of the ordinate numerator: found 'banana'"),
        (12, 47, "m      ", "unit of the ordinate denominator: found 'm'; allowed: SI units: N"),
        (10, 47, "s      ", "unit of the abscissa: found 's'; allowed: SI units: Hz"),
    ],
)
def test_a_header_field(folder: Path, line: int, start: int, field: str, says: str) -> None:
    change_line(folder / "frf.uff", line, column(start, field))
    refused(folder, says)


@pytest.mark.parametrize("label", ["", "NONE", "M/S**2", "(m/s^2)/N", "m / sec^2", "metres/s^2"])
def test_labels_that_say_the_same(folder: Path, label: str) -> None:
    change_line(folder / "frf.uff", 11, column(47, f"{label:20}"))
    read_campaign(folder)


@pytest.mark.parametrize(
    ("part", "says"), [(0.34, "no FRF of posture"), (0.9, "fewer kinds of FRF of posture")]
)
def test_a_file_that_lost_its_end_where_a_record_ends(folder: Path, part: float, says: str) -> None:
    """The first posture is whole; of the last nothing is left, or half. Its blows are all there."""
    assert check_campaign(folder).warnings == ()
    file = folder / "frf.uff"
    ends = [found.end() for found in re.finditer(rb"    -1\n(?=    -1\n|\Z)", file.read_bytes())]
    file.write_bytes(file.read_bytes()[: ends[int(part * len(ends))]])
    report = check_campaign(folder)
    assert report.is_sound
    assert [one for one in report.warnings if f"{file}: {says}" in one]


def test_a_time_history_of_an_unknown_quantity(folder: Path) -> None:
    change_line(folder / "time.uff", 11, column(0, f"{10:10d}"))
    refused(
        folder, "time.uff: dataset 1: ordinate numerator data type: found 10; allowed: 8 displacement or 11"
    )
    lines = (folder / "time.uff").read_bytes()
    place = lines.index(b"        12    1    0    0 ")  # the first response
    (folder / "time.uff").write_bytes(lines[:place] + b"        10" + lines[place + 10 :])
    refused(folder, "time.uff: dataset 2: ordinate numerator data type: found 10")


def test_unit_exponents_that_contradict_are_a_warning(text: Path) -> None:
    change_line(text / "frf.uff", 11, column(10, f"{0:5d}{1:5d}"))
    (warning,) = read_campaign(text).warnings
    assert "dataset 1: unit exponents 0 1 0 of type 12 (acceleration) are passed over" in warning


def test_unit_exponents_of_an_unknown_type_are_no_crash(text: Path) -> None:
    change_line(text / "frf.uff", 10, column(0, f"{0:10d}{1:5d}"))
    assert "unit exponents 1 0 0 of type 0 (unknown) are passed over" in "".join(read_campaign(text).warnings)


def test_units_other_than_si_in_dataset_164(text: Path) -> None:
    units = (
        "    -1\n   164\n         5mm (milli newton)             2\n" + f"{1000.0:25.17e}" * 3 + "\n    -1\n"
    )
    content = (text / "frf.uff").read_text()
    (text / "frf.uff").write_text(units + content)
    refused(text, "dataset 1: length factor: found 1000; allowed: 1: SI units", "force factor")
    (text / "frf.uff").write_text(
        units.replace("1.00000000000000000e+03", "1.00000000000000000e+00") + content
    )
    assert check_campaign(text).is_sound


def test_coherence_above_one_and_below_zero(folder: Path, campaign: Campaign) -> None:
    for value, says in ((1.25, "a coherence of 1.25 at 0 Hz"), (-0.1, "a coherence of -0.1 at 0 Hz")):
        spoilt = bytearray((folder / "frf.uff").read_bytes())
        assert campaign.frfs is not None
        assert campaign.frfs.coherence is not None
        first = float(campaign.frfs.coherence[0, 0])
        old, new = f"{first:20.11e}".encode(), f"{value:20.11e}".encode()
        if spoilt.find(old) < 0:
            old, new = struct.pack("<d", first), struct.pack("<d", value)
        place = spoilt.find(old)
        spoilt[place : place + len(new)] = new
        copy = folder.parent / f"copy{value}"
        copy.mkdir()
        (copy / "campaign.toml").write_bytes((folder / "campaign.toml").read_bytes())
        (copy / "frf.uff").write_bytes(bytes(spoilt))
        refused(copy, says)


def test_a_force_of_zero(campaign: Campaign, tmp_path: Path) -> None:
    folder = write_campaign(campaign, tmp_path / "c")
    content = (folder / "time.uff").read_bytes()
    lines = content.split(b"\n", HEADER)
    start = len(content) - len(lines[HEADER])
    axis = np.frombuffer(content[start : start + 16 * 64], "<f8").copy()
    axis[1::2] = 0
    (folder / "time.uff").write_bytes(content[:start] + axis.tobytes() + content[start + 16 * 64 :])
    refused(folder, "time.uff: dataset 1: found a force that is zero throughout")


def test_a_response_without_its_force(text: Path) -> None:
    lines = (text / "time.uff").read_text().split("\n")
    end = lines.index("    -1", 2)
    (text / "time.uff").write_text("\n".join(lines[end + 1 :]))
    refused(text, "a response without its force", "the force at 2 -3, posture 1, trial 1, sequence 1")


def test_a_record_twice(text: Path) -> None:
    content = (text / "frf.uff").read_text()
    (text / "frf.uff").write_text(content + content)
    refused(text, "the same posture, trial, response and reference as dataset 1")


def test_a_posture_without_records_is_a_warning(text: Path) -> None:
    change(text / "campaign.toml", "[[point]]", '[[posture]]\nid = 3\nname = "third"\nq = {}\n\n[[point]]')
    assert any("no FRF of posture third" in warning for warning in read_campaign(text).warnings)


def test_a_file_cut_between_two_datasets_lacks_a_trial_or_posture(text: Path) -> None:
    content = (text / "frf.uff").read_text()
    datasets = content.split("    -1\n")
    (text / "frf.uff").write_text("    -1\n".join(datasets[: len(datasets) // 4 * 2]) + "    -1\n")
    assert any("no FRF of posture bent" in warning for warning in read_campaign(text).warnings)


def test_a_coherence_of_arrays_names_its_record(campaign: Campaign) -> None:
    assert campaign.frfs is not None
    assert campaign.frfs.coherence is not None
    coherence = campaign.frfs.coherence.copy()
    coherence[3, 7] = 1.25
    posture, trial = campaign.frfs.posture[3], campaign.frfs.trial[3]
    says = rf"1\.25 at .* Hz of posture {posture}, trial {trial}, record 4"
    with pytest.raises(InvalidCampaign, match=says):
        replace(campaign, frfs=replace(campaign.frfs, coherence=coherence))


def test_missing_coherence_is_a_warning_and_taken_as_one(text: Path) -> None:
    content = (text / "frf.uff").read_text()
    first = content.index("    -1\n", content.index("    -1\n", 10) + 7)
    second = content.index("    -1\n", content.index("    58", first)) + 7
    start = content.index("    -1\n", 10) + 7
    (text / "frf.uff").write_text(content[:start] + content[second:])
    back = read_campaign(text)
    assert back.frfs is not None
    assert back.frfs.coherence is not None
    np.testing.assert_array_equal(back.frfs.coherence[0], 1.0)
    assert any("1 of 24 FRFs have no coherence" in warning for warning in back.warnings)


def test_other_datasets_and_functions_are_named_and_left_out(text: Path) -> None:
    content = (text / "frf.uff").read_text()
    other = "    -1\n   151\nmodel\n    -1\n    -1\n   757\n 1 0 0 0\n    -1\n"
    (text / "frf.uff").write_text(other + content)
    (warning,) = read_campaign(text).warnings
    assert warning.endswith("1 dataset 757 left out")
    (text / "frf.uff").write_text(content + (text / "time.uff").read_text())
    assert any("left out: time response (type 1)" in warning for warning in read_campaign(text).warnings)


def test_ids_left_at_zero_belong_to_the_only_one(campaign: Campaign, tmp_path: Path) -> None:
    assert campaign.frfs is not None
    one = replace(
        campaign,
        postures=campaign.postures[:1],
        trials=campaign.trials[:1],
        frfs=campaign.frfs.select(posture=1, trial=1),
        blows=(),
        modes=None,
    )
    folder = write_campaign(one, tmp_path / "c", binary=False)
    lines = (folder / "frf.uff").read_text().split("\n")
    lines = [
        column(15, f"{0:5d}{0:10d}")(line) if line[30:31] == " " and "tip" in line else line for line in lines
    ]
    (folder / "frf.uff").write_text("\n".join(lines))
    back = read_campaign(folder)
    assert back.frfs is not None
    assert set(back.frfs.posture.tolist()) == {1}
    assert any("load case 0, taken for the only one" in warning for warning in back.warnings)


def test_records_that_pyuff_wrote_with_its_own_byte_count(campaign: Campaign, tmp_path: Path) -> None:
    """pyuff declares eight bytes a value, complex or not; other tools do as they like."""
    folder = write_campaign(campaign, tmp_path / "c")
    (folder / "frf.uff").unlink()
    file = pyuff.UFF(str(folder / "frf.uff"))
    assert campaign.frfs is not None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves closing to the garbage collector
        file.write_sets(list(frf_datasets(campaign.frfs, campaign.points, True)), mode="add")
    back = read_campaign(folder)
    assert back.frfs is not None
    np.testing.assert_array_equal(back.frfs.value, campaign.frfs.value)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("format = 1", "format = 2", "format: found 2; allowed: 1"),
        ("format = 1", "format = true", "format"),
        ("band = [2.0, 9.0]", "band = [9.0, 2.0]", "band: found 9 to 2"),
        ("band = [2.0, 9.0]", "band = [nan, 2.0]", "band[0]: found nan"),
        ("band = [2.0, 9.0]", "band = [2.0, 1e18]", "band[1]: found 1e+18; allowed: two frequencies"),
        ("id = 2", "id = 1", "posture[1].id: found 1, as in posture[0]"),
        ("id = 1", "id = 0", "posture[0].id: found 0; allowed: a whole number from 1"),
        ("averages = 3", "averages = 0", "trial[0].averages: found 0"),
        ("force_peak = 180.0", "force_peak = 0.0", "trial[0].force_peak: found 0.0; allowed: a number in N"),
        ("force_peak", "force_peek", 'did you mean "force_peak"'),
        ("repeat_of = 3", "repeat_of = 9", "trial[3].repeat_of: found 9; allowed: the id of another trial"),
        ('kind = "exponential"', 'kind = "hann"', "trial[2].window"),
        ("[[posture]]", '[[posture]]\nwindow = "none"', "posture[0].window: found an unknown key"),
        (
            "[[point]]",
            '[[point]]\nwindow = { kind = "force", decay = 1.0 }',
            "point[0].window: found an unknown",
        ),
        ("format = 1", 'format = 1\nwindow = "none"', "window: found an unknown key"),
        ("q1 = 0.0", "q1 = 1e300", "posture[0].q.q1: found 1e+300"),
        ("xyz = [0.5, 0.0, -0.1]", "xyz = [0.5, 0.0]", "point[0].xyz: found a list of 2"),
        ('robot = "two_link"\n', "", "robot: found nothing; allowed: a card's name"),
        ("[[trial]]", "[[trail]]", 'did you mean "trial"'),
        ('title = "A', "title = A", "text that is not TOML"),
    ],
)
def test_campaign_toml(text: Path, old: str, new: str, says: str) -> None:
    change(text / "campaign.toml", old, new)
    refused(text, says)


def test_every_fault_of_every_file_at_once(text: Path) -> None:
    change_line(text / "frf.uff", 8, column(20, f"{9:10d}"))
    change_line(text / "time.uff", 8, column(41, f"{99:10d}"))
    change(text / "modes.csv", "7.4", "-7.4")
    refused(text, "load case: found 9", "response node: found 99", 'line 2: natural_frequency: found "-7.4"')


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("posture,response", "pose,response", "line 1"),
        ("1,1,2,1,7.4", "5,1,2,1,7.4", "line 2: posture: found 5"),
        ("1,1,2,1,7.4", "1,1,2,1.5,7.4", 'line 2: mode: found "1.5"'),
        ("7.4", "nan", "line 2: natural_frequency"),
        ("0.075", "1e999", "line 2: damping_ratio"),
        ("0.00044,", ",", "half an amplitude"),
        ("amplitude:missing", "a,b", "10 fields"),
        ("0.075", '"0.075', "text that is no table"),
    ],
)
def test_modes_csv(text: Path, old: str, new: str, says: str) -> None:
    change(text / "modes.csv", old, new)
    refused(text, says)


def test_no_data_no_folder_and_odd_files(text: Path, tmp_path: Path) -> None:
    refused(tmp_path / "nowhere", "no such file")
    for name in ("frf.uff", "time.uff", "modes.csv"):
        (text / name).unlink()
    refused(text, "no data; allowed: one of frf.uff, time.uff and modes.csv")
    (text / "frf.uff").mkdir()
    refused(text, "found a folder")
    (text / "frf.uff").rmdir()
    (text / "frf.uff").write_bytes(b"")
    refused(text, "no dataset 58")
    (text / "frf.uff").write_bytes(b"    -1\n" * 200_000)
    refused(text, "no dataset number after the start tag")
    assert check_campaign(text).faults


def test_a_force_far_from_the_stated_peak_is_a_warning(campaign: Campaign, tmp_path: Path) -> None:
    folder = write_campaign(campaign, tmp_path / "c")
    change(folder / "campaign.toml", "force_peak = 180.0", "force_peak = 1.8")
    assert any("is it in N?" in warning for warning in read_campaign(folder).warnings)

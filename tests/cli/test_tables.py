"""Tables on narrow terminals: no number is cut, no name that a command takes is cut where it need not be."""

import re

import pytest
from rich.cells import cell_len

from flexmodal.cli.tables import middle_cut, table_text

NAMES = ["stiffness.shoulder_pan_joint", "stiffness.shoulder_lift_joint", "damping.shoulder_pan_joint"]
ROWS = [[name, f"{1.539e5 + k:.6g} N·m/rad", "31000", f"{4 + k}52070 to 580340", "not identified"]
        for k, name in enumerate(NAMES)]  # fmt: skip
COLUMNS = ["parameter", "value", "standard error", "95 % interval", "remarks"]


@pytest.mark.parametrize("width", range(40, 121, 8))
def test_every_number_is_whole_at_every_width(width):
    text = table_text("A title that is rather longer than forty columns are", COLUMNS, ROWS, width)
    assert all(cell_len(line) <= width for line in text.splitlines())
    for row in ROWS:
        for cell in row[1:4]:
            assert cell in text


def test_a_wide_table_is_cut_between_columns_and_each_part_has_the_names():
    text = table_text("", COLUMNS, ROWS, 60)
    parts = text.split("\n\n\n")
    assert len(parts) > 1
    assert all(name in part for part in parts for name in NAMES)


def test_names_that_are_shortened_stay_apart():
    rows = [[f"stiffness.of_a_rather_long_name_{k}", "1.5"] for k in range(3)]
    text = table_text("", ["name", "value"], rows, 40)
    short = [line.split()[0] for line in text.splitlines() if "1.5" in line]
    assert len(set(short)) == 3
    assert all("…" in name for name in short)


def test_a_name_without_its_middle():
    assert middle_cut("stiffness.shoulder", 9) == "stif…lder"
    assert middle_cut("q1", 9) == "q1"


@pytest.mark.parametrize("width", [50, 80])
def test_commands_keep_to_their_width(cli, width):
    commands = [
        ("robots",),
        ("modes", "six_axis", "--posture", "work"),
    ]
    for command in commands:
        ran = cli(*command, "--width", width)
        assert ran.status == 0
        table = [line for line in ran.out.splitlines() if line.startswith(" ")]
        assert all(len(line) <= width for line in table if "  " in line.strip())
        assert not re.search(r"\d…", ran.out)


def test_width_has_limits(cli):
    cli("robots", "--width", "10").refused("40<=x<=1000")


def test_a_command_that_was_meant(cli):
    ran = cli("optimize", "six_axis")
    assert ran.status == 2
    assert "'optimise'" in ran.err
    assert "The commands are robots, check" in cli("xyzzy").err


def test_angles_are_shown_in_the_unit_that_was_typed(cli):
    assert "q1=50deg, q2=0" in cli("modes", "six_axis", "--posture", "q1=50deg").out
    assert "q1=0.2, q2=0" in cli("modes", "six_axis", "--posture", "q1=0.2").out
    asked = ("optimise", "six_link", "--hold=-2,2", "--frequency", "5", "--starts", "1", "--width", 200)
    typed = "q1=0.8,q2=0.5,q3=0.5,q4=0.5,q5=0.5,q6=0.5"
    in_radians = cli(*asked, "--start", typed).out
    assert "q1 [rad]" in in_radians
    assert "°" not in in_radians
    assert "°" in cli(*asked, "--start", "start_1").out


@pytest.mark.parametrize("command", ["frf", "measures"])
def test_a_direction_in_which_the_arm_cannot_move(cli, command):
    asked = {"frf": ("--response", "tool:+y", "--frequencies", "5"), "measures": ("--direction", "tool:+y")}
    ran = cli(command, "six_link", "--posture", "start_1", *asked[command])
    assert ran.status == 0
    assert "note: no flexible joint moves tool:+y (a planar arm moves in its plane only)" in ran.err
    other = [word.replace("+y", "+z") for word in asked[command]]
    assert cli(command, "six_link", "--posture", "start_1", *other).err == ""


def test_a_table_is_no_campaign(cli, tmp_path):
    (tmp_path / "x.csv").write_text("1,2\n")
    cli("fit", tmp_path / "x.csv").refused("import_table", "docs/campaign.md")


@pytest.mark.parametrize("command", [("show",), ("show", "six_axis", "--campaign"), ("identify",)])
def test_a_universal_file_names_no_robot(cli, tmp_path, command):
    campaign = tmp_path / "mine.uff"
    cli("frf", "six_axis", "--posture", "work", "--frequencies", "1:20:1", "--out", campaign)
    ran = cli(*command, campaign)
    ran.refused("names neither a robot", "flexmodal fit FILE --out modes.html")


def test_texts_begin_below_their_heading_and_numbers_end_below_theirs():
    rows = [["sweep_8", "8.5", "a sentence"], ["e1", "12.25", "another, longer sentence"]]
    head, _, *body = table_text("", ["name", "value", "what"], rows, 80).splitlines()[-4:]
    assert {line.index(row[2]) for line, row in zip(body, rows, strict=True)} == {head.index("what")}
    assert {line.index(row[1]) + len(row[1]) for line, row in zip(body, rows, strict=True)} == {
        head.index("value") + len("value")
    }

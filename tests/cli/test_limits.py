"""Numbers, files and names beyond what is meant: one clear sentence, at once, in little memory."""

import os
import re
import subprocess

import pytest

TUNE = ("tune", "fanuc_s360", "--posture", "configuration_1")
RIG = ("rig", "fanuc_s360", "--postures", "1", "--points", "1", "--trials", "1", "--no-time")
PATH = ("path", "fanuc_s360", "--feed", "0.1", "--frequency", "5", "--toolpath")


@pytest.mark.parametrize("kind", ["pipe", "device", "large"])
def test_a_toolpath_that_is_no_table(shell, tmp_path, kind):
    file = {"pipe": tmp_path / "pipe", "device": "/dev/zero", "large": tmp_path / "large.csv"}[kind]
    if kind == "pipe":
        os.mkfifo(file)
    if kind == "large":
        file.write_bytes(b"0" * 30_000_000)
    shell(*PATH, file, timeout=30).refused(file, "MB" if kind == "large" else "a pipe or device")


@pytest.mark.parametrize("peaks", ["1e99", "1e-50", "1e-99", "60,1e-4", "2e6"])
def test_peaks_that_no_hammer_has(cli, tmp_path, peaks):
    cli(*RIG, "--out", tmp_path / "t", f"--peaks={peaks}").refused("--peaks", "0.001 to 1e+06 N")
    assert list(tmp_path.iterdir()) == []


def test_a_band_below_anything(cli):
    cli(*TUNE, "--band", "1e-300:1e-299").refused("--band", "1e-09")


def test_an_frf_that_would_fill_the_memory(cli):
    many = [word for axis in "xyz" for k in (1, 2, 3) for word in ("--response", f"location_{k}:+{axis}")]
    ran = cli("frf", "fanuc_s360", "--posture", "configuration_1", "--frequencies", "1:1000000:1", *many)
    ran.refused("1000000 lines × 9 responses × 9 references", "20,000,000 values")


@pytest.mark.parametrize("command", [("optimise", "fanuc_s360", "--free"), ("identify", "x"), ("studies",)])
def test_starts_without_bound(cli, command):
    cli(*command, "--starts", "1000000000").refused("--starts", "100000")


def test_somebody_who_is_not_there(cli):
    cli("check", "~nobody_of_this_name").refused("~nobody_of_this_name", "no such file")


@pytest.mark.parametrize("value", ["1e-300", "1e18", "0.0"])
def test_a_loss_frequency_beyond_reason(cli, card, value):
    path = card(("format = 1", f"format = 1\nloss_frequency = {value}"))
    ran = cli("check", path)
    assert ran.status == 1
    assert "loss_frequency: found" in ran.out
    assert "1e-6 to 1e9" in ran.out


def test_coordinates_beyond_reason(cli, card, urdf):
    ran = cli("check", card(("[0.5, 0.0, 0.0]", "[1e300, 0.0, 0.0]")))
    assert ran.status == 1
    assert "point.end.xyz[0]: found 1e+300" in ran.out
    ran = cli("check", urdf(('<origin xyz="1 0 0"/>', '<origin xyz="1e300 0 0"/>')))
    assert ran.status == 1
    assert "origin.xyz" in ran.out


def test_a_stiffness_of_nearly_nothing(cli, card):
    ran = cli("check", card(("stiffness = 1000.0", "stiffness = 1e-300")))
    assert ran.status == 1
    assert "joint.q1.stiffness: found 1e-300" in ran.out


def test_a_long_key_is_not_quoted_whole(cli, card):
    ran = cli("check", card(("[joint.q1]", f'["{"k" * 900_000}"]\na = 1\n[joint.q1]')))
    assert ran.status == 1
    assert len(ran.out) < 3000
    assert "an unknown key" in ran.out


def test_a_tool_link_with_a_colon(cli, card, urdf):
    path = card(('tool = "tool"', 'tool = "ns:tool0"'))
    arm = path.with_name("arm.urdf")
    arm.write_text(arm.read_text().replace('"tool"', '"ns:tool0"'))
    ran = cli("frf", path, "--posture", "bent", "--frequencies", "1,2", "--json")
    assert ran.json()["response"] == "ns:tool0:+z"
    asked = ("--response", "ns:tool0:-x", "--json")
    assert (
        cli("frf", path, "--posture", "bent", "--frequencies", "1", *asked).json()["response"]
        == "ns:tool0:-x"
    )


CLEAR = '"\\u001b]0;mine\\u0007\\u001b[31mred\\u202e"'


def test_titles_do_not_steer_the_terminal(cli, card, tmp_path):
    path = card(('"An arm"', CLEAR))
    out = tmp_path / "t"
    words = ("--postures", "1", "--points", "1", "--trials", "1", "--no-time", "--record-length", "1")
    ran = cli("rig", path, "--out", out, *words)
    assert ran.status == 0, ran.err
    for said in (ran, cli("fit", out), cli("check", out / "robot")):
        assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", said.out + said.err)
    assert "mine" in cli("fit", out).out


def test_a_full_standard_output_is_named(program):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [program, "robots"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (2, "flexmodal: standard output: No space left on device\n")


@pytest.mark.parametrize("command", ["robots", "modes fanuc_s360 --posture configuration_1"])
def test_a_reader_that_has_enough(program, command):
    """As `| head -1`, but gone before the first line."""
    words = [program, *command.split()]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.close()
    told = process.stderr.read()
    process.stderr.close()
    assert (process.wait(60), told) == (0, "")


@pytest.mark.parametrize(
    "words", [("frf", "--starts" + "x" * 3000), ("optimise", "six_link", "--starts", "9" * 3000)]
)
def test_a_long_word_is_not_quoted_whole(cli, words):
    lines = cli(*words).refused()
    assert max(map(len, lines)) < 1000


def test_a_word_does_not_steer_the_terminal(cli):
    assert "\x1b" not in "".join(cli("optimise", "six_link", "--starts", "\x1b[31m").refused("--starts"))


def test_two_points_in_one_place_name_the_file(cli, tmp_path):
    file = tmp_path / "path.csv"
    file.write_text("x,z\n0.9,0.6\n0.9,0.6\n")
    cli(*PATH, file).refused(file, "point 2", "where the one before is")


def test_lines_of_a_toolpath_end_where_csv_ends_them(cli, tmp_path):
    """A vertical tab is white space in a cell, not the end of a row."""
    file = tmp_path / "path.csv"
    file.write_bytes(b"x,z\n0.9,0.6\x0b0.92,0.6\n0.95,0.6\n")
    cli(*PATH, file).refused(file, "row 2", "3 cells")

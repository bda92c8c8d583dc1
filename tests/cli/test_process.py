"""The program as a process: start-up, Ctrl-C, broken pipes, odd standard outputs."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

HEAVY = (
    "numpy",
    "scipy",
    "matplotlib",
    "pinocchio",
    "lxml",
    "pydantic",
    "pyuff",
    "meshcat",
    "yourdfpy",
    "rich",
)


def loaded(code):
    """Which of the heavy modules are loaded after this code."""
    report = f"import sys; print([name for name in {HEAVY} if name in sys.modules], file=sys.stderr)"
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\n{report}"], check=True, capture_output=True, text=True, timeout=60
    )
    return done.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize("words", [["--help"], ["frf", "--help"], ["optimise", "--help"], ["--version"]])
def test_help_does_not_wait_for_libraries(words):
    code = (
        "from flexmodal.cli.main import main\n"
        f"try: main({words})\n"
        "except SystemExit as left: assert left.code == 0"
    )
    assert loaded(code) == "[]"


def test_importing_flexmodal_does_not_wait_either():
    assert loaded("import flexmodal") == "[]"
    found = loaded("import flexmodal; flexmodal.InvalidInput; flexmodal.PointDirection")
    for name in ("pinocchio", "scipy", "matplotlib"):
        assert name not in found


def test_the_program_and_the_module_are_one(shell):
    """The installed script, and `python -m`, end to end."""
    ran = shell("modes", "six_link", "--posture", "start_2", "--json")
    assert (ran.status, ran.err) == (0, "")
    assert sum(1 if mode["overdamped"] else 2 for mode in ran.json()["modes"]) == 12  # poles of six joints
    done = subprocess.run(
        [sys.executable, "-m", "flexmodal.cli", "modes", "six_link", "--posture", "start_2", "--json"],
        check=True, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.stdout == ran.out
    shell("modes", "six_link", "--posture", "q9=1").refused("q9")


def processor_time(process):
    """What a running process has used [s]."""
    assert process.poll() is None
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.fixture
def ctrl_c():
    """Children heed Ctrl-C: what a shell runs in the background ignores it, and its children would too."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


LONG = ("optimise", "six_link", "--hold=-2,2", "--frequency", "5", "--starts", "100000")


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize(
    ("number", "status", "says"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "")],
)
@pytest.mark.slow
def test_stopped_in_the_midst_of_a_search(program, number, status, says):
    # The first large search on a machine compiles its kernels; only from then on does time go into searching.
    subprocess.run((program, *LONG[:-1], "4096"), capture_output=True, check=True, timeout=300)
    with subprocess.Popen(
        [program, *LONG], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            # It would search for minutes. Some seconds of its own time see it start.
            while processor_time(process) < 6:
                time.sleep(0.05)
            process.send_signal(number)
            out, err = process.communicate(timeout=120)  # a first run compiles before it looks up
        finally:
            process.kill()
    assert process.returncode == status
    if number == signal.SIGINT:  # the best so far is kept
        assert "optimum 1" in out
        assert "interrupted after" in out
    else:
        assert out == ""
    assert "Traceback" not in err
    assert says in err


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_stopped_in_the_midst_of_a_file(program, tmp_path, number):
    words = (
        *("frf", "fanuc_s360", "--posture", "configuration_1", "--frequencies", "1:1000000:0.5"),
        *("--out", tmp_path / "frf.csv"),
    )
    with subprocess.Popen([program, *words], stderr=subprocess.PIPE, text=True) as process:
        try:
            until = time.monotonic() + 60
            while not any(tmp_path.iterdir()) and time.monotonic() < until:
                time.sleep(0.01)
            assert [entry.suffix for entry in tmp_path.iterdir()] == [".flexmodal"]
            process.send_signal(number)
            _, err = process.communicate(timeout=30)
        finally:
            process.kill()
    assert process.returncode in (130, 143)
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ("robots",),
        ("frf", "fanuc_s360", "--posture", "configuration_1", "--frequencies", "0:2000:0.1", "--json"),
    ],
)
def test_a_reader_that_leaves(program, words):
    with subprocess.Popen([program, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.read(10)
        process.stdout.close()
        err = process.stderr.read().decode()
        process.wait(timeout=30)
    assert err == ""


def test_a_pipe_to_head(program):
    done = subprocess.run(
        ["bash", "-c", f"{program} robots | head -1"], capture_output=True, text=True, timeout=60, check=True
    )
    assert len(done.stdout.splitlines()) == 1
    assert done.stderr == ""


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_a_full_standard_output(shell, options):
    with open("/dev/full", "w") as full:
        ran = shell("robots", *options, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert ran.status == 2
    assert ran.err == "flexmodal: standard output: No space left on device\n"


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_a_closed_standard_output(program, options):
    words = " ".join([program, "robots", *options])
    done = subprocess.run(
        ["sh", "-c", f"{words} >&-"], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_a_terminal_without_the_signs(shell):
    plain = os.environ | {"PYTHONIOENCODING": "ascii"}
    ran = shell("frf", "six_link", "--posture", "start_1", "--frequencies", "5", env=plain)
    assert (ran.status, ran.err) == (0, "")
    assert "phase [?]" in ran.out  # the degree sign
    ran = shell(
        "frf",
        "six_link",
        "--posture",
        "start_1",
        "--frequencies",
        "5",
        "--form",
        "inertance",
        "--json",
        env=plain,
    )
    assert json.loads(ran.out)["unit"] == "m/(s²·N)"


def test_a_name_that_is_not_text(shell, urdf, tmp_path):
    odd = os.fsdecode(b"arm\xff.urdf")
    urdf().rename(tmp_path / odd)
    ran = shell("check", odd, "--json")
    assert (ran.status, ran.json()["checked"][0]["path"]) == (0, odd)
    assert shell("check", odd, errors="surrogateescape").status == 0

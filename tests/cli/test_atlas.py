"""`flexmodal atlas` and `flexmodal lookup`: what they write, say and refuse."""

import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip("zarr")
ATLAS = ("atlas", "fanuc_s360", "--quiet")
GRID = ("--grid", "q1=0:90deg:5,q2=-1:0:4", "--grid", "q3=-0.5")


@pytest.fixture
def store(cli, valid, tmp_path):
    out = tmp_path / "arm.zarr"
    told = valid("atlas", cli(*ATLAS, *GRID, "--frequencies", "1:10:1", "--out", out, "--json").json())
    assert (told["postures"], told["standing"]) == (20, 0)
    return out


def test_made_once_and_read_back(cli, valid, store):
    def asked(*question):
        return valid("lookup", cli("lookup", store, *question, "--json").json())

    again = valid("atlas", cli(*ATLAS, *GRID, "--frequencies", "1:10:1", "--out", store, "--json").json())
    assert again["standing"] == again["chunks"] == 1
    assert asked()["sizes"]["frequency"] == 10
    near = asked("--nearest", "q1=0.3,q2=-0.4")
    assert near["posture"]["q3"] == -0.5
    between = asked("--interpolate", "q1=0.3,q2=-0.4")
    assert len(between["receptance"]["re"]) == 10
    best = asked("--best", "3", "--frequency", "5")
    assert [one["value"] for one in best["best"]] == sorted(one["value"] for one in best["best"])


def test_a_map(cli, valid, store, tmp_path):
    drawn = cli("lookup", store, "--map", tmp_path / "map.html", "--frequency", "5", "--json")
    assert valid("lookup", drawn.json()) == {"out": str(tmp_path / "map.html")}
    assert "Content-Security-Policy" in (tmp_path / "map.html").read_text()
    cli("lookup", store, "--map", tmp_path / "map.html", "--frequency", "5").refused("an existing file")


BAD = {
    (*GRID,): ["--frequencies", "missing"],
    ("--frequencies", "1"): ["either --grid"],
    (*GRID, "--sample", "5", "--frequencies", "1"): ["both of them"],
    ("--grid", "q1=0:1:3", "--frequencies", "1"): ["nothing for q2, q3"],
    (*GRID, "--grid", "q9=0", "--frequencies", "1"): ["unknown joint 'q9'"],
    (*GRID, "--grid", "q1=0", "--frequencies", "1"): ["q1 twice"],
    ("--grid", "q1=0:99:3,q2=0,q3=0", "--frequencies", "1"): ["--grid q1", "limits"],
    ("--grid", "q1=0:1:1e9,q2=0,q3=0", "--frequencies", "1"): ["a count from 1"],
    ("--grid", "q1=1:0:3,q2=0,q3=0", "--frequencies", "1"): ["ascending"],
    ("--sample", "5", "--range", "q1=nan:1", "--frequencies", "1"): ["--range q1"],
    ("--sample", "5", "--range", "q1=0:1:2", "--frequencies", "1"): ["START:STOP"],
    ("--sample", "5", "--frequencies", "1", "--direction", "hip:+z"): ["hip"],
    ("--sample", "5", "--frequencies", "1", "--scheduler", "banana"): ["--scheduler", "tcp://HOST:8786"],
    ("--sample", "5", "--quantity", "modes", "--direction", "tool:+z"): ["--direction"],
    ("--sample", "5", "--quantity", "depth"): ["--cut", "missing"],
    ("--sample", "100000000000", "--frequencies", "1:400:1"): ["the room there"],
}


@pytest.mark.parametrize("words", BAD, ids=" ".join)
def test_bad_requests(cli, tmp_path, words):
    cli(*ATLAS, *words, "--out", tmp_path / "a.zarr").refused(*BAD[words])


def test_bad_questions(cli, store, tmp_path):
    cli("lookup", tmp_path).refused(tmp_path, "a store that flexmodal atlas made")
    cli("lookup", store, "--best", "1", "--map", tmp_path / "m.png").refused("several questions")
    cli("lookup", store, "--best", "1", "--speed", "3000").refused("--speed", "an atlas of receptance")
    cli("lookup", store, "--interpolate", "q1=3,q2=0").refused("which the atlas covers")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_stopped_on_the_way_it_goes_on(program, cli, tmp_path, number):
    """Processes that compute end with the command, and the next call ends it."""
    out = tmp_path / "s.zarr"
    words = [*ATLAS, "--sample", "60000", "--quantity", "stiffness", "--out", str(out), "--workers", "1"]
    with subprocess.Popen([program, *words], stderr=subprocess.PIPE) as child:
        for _ in range(600):
            if any(out.glob("stiffness/c/*/*")):
                break
            time.sleep(0.1)
        child.send_signal(number)
        assert child.wait(30) in (143, -signal.SIGKILL)
    standing = len(list(out.glob("stiffness/c/*/0")))
    told = cli("lookup", out, "--json").json()
    assert 0 < standing <= told["standing"] + 1
    assert told["standing"] < told["chunks"]
    assert sys.platform != "linux" or not list(tmp_path.glob("*.partial"))

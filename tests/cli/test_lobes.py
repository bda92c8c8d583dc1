"""`flexmodal lobes`: its object, its files, what it refuses."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import flexmodal
from flexmodal.machining import critical_depth, read_cut

CUT = Path(__file__).parents[2] / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml"
LOBES = ("lobes", "fanuc_s360", "--cut", CUT)
ONE = (*LOBES, "--posture", "configuration_1")


@pytest.fixture
def edited(tmp_path):
    def write(*replacements):
        text = CUT.read_text(encoding="utf-8")
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "edited.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_one_posture(cli):
    found = cli(*ONE, "--json").json()
    assert set(found) == {
        "robot", "posture", "cut", "method", "critical_depth", "critical_speed", "critical_frequency",
        "best_depth", "best_speed", "unconditional_depth", "mode_coupling", "best", "spindle_speed", "depth",
        "chatter_frequency", "lobe", "period_doubling", "forced",
    }  # fmt: skip
    robot, cut = flexmodal.load("fanuc_s360"), read_cut(CUT)
    assert found["critical_depth"] == pytest.approx(critical_depth(robot, "configuration_1", cut), rel=1e-4)
    assert found["robot"] == "fanuc_s360"
    assert found["cut"] == cut.title
    assert found["posture"]["q1"] == pytest.approx(0.8726646)
    assert len(found["forced"]["surface_error"]) == len(found["spindle_speed"])


def test_for_people(cli):
    ran = cli(*ONE, "--speeds", "20")
    assert ran.status == 0
    for words in ("critical depth over the range", "mode coupling", "rev/min", "stable depth [mm]"):
        assert words in ran.out


def test_methods(cli, edited):
    path = edited(("[3000, 24000]", "[8000, 12000]"))
    depths = {}
    for method in ("zero-order", "multi-frequency", "semi-discretisation"):
        options = ("--method", method, "--speeds", "3", "--json")
        found = cli("lobes", "fanuc_s360", "--cut", path, "--posture", "configuration_1", *options).json()
        assert found["method"] == method
        depths[method] = dict(zip(found["spindle_speed"], found["depth"], strict=True))[8000.0]
    assert depths["multi-frequency"] == pytest.approx(depths["semi-discretisation"], rel=5e-3)
    assert depths["zero-order"] == pytest.approx(depths["multi-frequency"], rel=0.15)


def test_several_postures_and_a_family(cli):
    found = cli(
        *LOBES, "--posture", "configuration_1", "--posture", "q1=2,q2=-2", "--speeds", "20", "--json"
    ).json()
    assert [entry["name"] for entry in found["postures"]] == ["configuration_1", None]
    assert found["family"] is None
    assert found["best"] in (0, 1)
    ran = cli(*LOBES, "--family", "second_link_horizontal", "--members", "3", "--speeds", "20")
    assert ran.status == 0
    assert "best by critical depth" in ran.out
    family = cli(
        *LOBES, "--family", "second_link_horizontal", "--members", "3", "--speeds", "20", "--json"
    ).json()
    assert family["postures"][0]["parameter"] == pytest.approx(np.pi / 4)


@pytest.mark.some(2)
@pytest.mark.parametrize("ending", [".csv", ".json", ".png", ".svg", ".html"])
@pytest.mark.parametrize("kind", ["one", pytest.param("several", marks=pytest.mark.slow)])
def test_files(cli, tmp_path, ending, kind):
    path = tmp_path / f"lobes{ending}"
    words = (
        (*ONE, "--speeds", "20")
        if kind == "one"
        else (*LOBES, "--family", "second_link_horizontal", "--members", "2", "--speeds", "9")
    )
    ran = cli(*words, "--out", path)
    assert (ran.status, ran.out) == (0, ""), ran.err
    assert ran.err == f"wrote {path}\n"
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    if ending == ".png":
        with Image.open(path) as image:
            image.load()
    elif ending == ".csv":
        with path.open(newline="", encoding="utf-8") as file:
            assert len(list(csv.DictReader(file))) >= 2
    before = path.read_bytes()
    cli(*words, "--out", path).refused(path, "--force")
    assert path.read_bytes() == before
    assert cli(*words, "--out", path, "--force").status == 0


def test_a_measured_spindle(cli, tmp_path, edited):
    """The FRF of another robot's tool, written by flexmodal itself, stands in for the measurement."""
    table = tmp_path / "spindle.csv"
    pairs = [word for axis in "xz" for word in ("--response", f"tool:+{axis}")]
    ran = cli(
        "frf", "fanuc_s360", "--posture", "configuration_4", "--frequencies", "2:900:0.5", *pairs,
        "--out", table,
    )  # fmt: skip
    assert ran.status == 0
    text = table.read_text(encoding="utf-8").replace("tool:+z", "tool:+y")
    table.write_text(text, encoding="utf-8")
    alone = cli(*ONE, "--speeds", "20", "--json").json()
    ran = cli(*ONE, "--spindle", table, "--speeds", "20", "--json")
    assert "between 2 and 900 Hz" in ran.err
    assert "both added" in ran.err
    assert ran.json()["critical_depth"] < alone["critical_depth"]
    refused = cli(*ONE, "--spindle", table, "--method", "semi-discretisation", "--speeds", "2")
    refused.refused("semi-discretisation of a measured receptance", "multi-frequency")


REQUESTS = {
    "no posture": (LOBES, ["exactly one of --posture, --prediction, --family and --hold", "none"]),
    "both": (
        (*ONE, "--family", "second_link_horizontal"),
        ["exactly one of --posture, --prediction, --family and --hold", "--posture and --family"],
    ),
    "unknown family": ((*LOBES, "--family", "x"), ["--family", "'x'", "second_link_horizontal"]),
    "no cut": (("lobes", "fanuc_s360", "--posture", "configuration_1"), ["--cut"]),
    "no such cut": ((*LOBES[:3], "x.toml", "--posture", "configuration_1"), ["no such file"]),
    "bad posture": ((*LOBES, "--posture", "q1=99"), ["--posture", "limits"]),
    "bad method": ((*ONE, "--method", "luck"), ["--method", "'luck'"]),
    "speeds 1": ((*ONE, "--speeds", "1"), ["speeds", "2 to 100,000"]),
    "ending": ((*ONE, "--out", "x.pdf"), ["--out", ".csv, .json, .png"]),
    "members 1": ((*LOBES, "--family", "second_link_horizontal", "--members", "1"), ["members"]),
    "method of several": (
        (*LOBES, "--family", "second_link_horizontal", "--method", "multi-frequency"),
        ["--method", "zero-order"],
    ),
    "one speed of several": (
        (*LOBES, "--family", "second_link_horizontal", "--speeds", "1"),
        ["2 to 100,000"],
    ),
    "no such spindle": ((*ONE, "--spindle", "nothing.csv"), ["no such file"]),
    "too slow": (
        ("lobes", "ur10", "--stiffness", "1e5", "--damping", "10", "--posture", "elbow_joint=1",
         "--cut", CUT, "--method", "semi-discretisation", "--speeds", "x"),
        ["--speeds"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", REQUESTS)
def test_requests(cli, kind):
    words, sentences = REQUESTS[kind]
    cli(*words).refused(*sentences)


def test_every_fault_of_a_cut(cli, edited):
    path = edited(("teeth = 2", "teeth = 0"), ('axis = "+y"', 'axis = "up"'), ("7.0e8", "-7.0e8"))
    lines = cli("lobes", "fanuc_s360", "--posture", "configuration_1", "--cut", path).refused(path)
    assert len(lines) == 3


def test_undamped_joints_are_the_answer_no(cli):
    ran = cli(
        "lobes", "ur10", "--stiffness", "1e5", "--posture", "elbow_joint=1", "--cut", CUT,
    )  # fmt: skip
    ran.refused("has no damping", "no depth of cut is stable", status=1)


def test_a_point_the_robot_does_not_have(cli, edited):
    path = edited(('feed = "+x"', 'feed = "+x"\npoint = "spindle"'))
    cli("lobes", "fanuc_s360", "--posture", "configuration_1", "--cut", path).refused(
        "cut: frame.point", "'spindle'", "location_1"
    )


def test_a_process_of_its_own(shell):
    ran = shell(*ONE, "--speeds", "20", "--json")
    assert ran.json()["method"] == "zero-order"
    assert ran.err == ""


@pytest.mark.slow
def test_the_posture_that_cuts_deepest(cli):
    """Held where configuration 4 stands, the search finds one that cuts deeper."""
    words = ("lobes", "fanuc_s360", "--cut", CUT, "--json", "--quiet")
    before = json.loads(cli(*words, "--posture", "configuration_4").out)
    ran = cli(*words, "--hold", "1.3,0.85", "--starts", "1")
    assert ran.status == 0, ran.err
    found = json.loads(ran.out)
    best = found["postures"][found["best"]]
    assert best["critical_depth"] > before["critical_depth"]
    tool = flexmodal.load("fanuc_s360").at(best["posture"]).position("tool")
    np.testing.assert_allclose(tool[[0, 2]], [1.3, 0.85], atol=1e-9)
    assert cli(*words, "--hold", "9,9", "--starts", "1").status == 1

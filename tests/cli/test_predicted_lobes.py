"""From a hammer test to the lobes of a posture that nobody struck, and folders of a robot as ROBOT."""

import json

import pytest
from click.testing import CliRunner

import flexmodal
from flexmodal.cli.main import group
from flexmodal.rig import simulate


@pytest.fixture(scope="module")
def struck(tmp_path_factory):
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=3, points=2, references=["location_1:+z", "location_1:+x"],
        trials=2, peaks=(100.0,), band=(2.0, 120.0), record_length=2.0, axes="xz", seed=5, time=False,
    )  # fmt: skip
    folder = tmp_path_factory.mktemp("struck") / "campaign"
    made.write(folder)
    return folder


def run(*words):
    return CliRunner().invoke(group, list(map(str, words)))


@pytest.mark.slow
def test_lobes_of_a_prediction(struck, tmp_path):
    there = tmp_path / "there.json"
    where = "q1=1.3,q2=-1.3,q3=0.1"
    ran = run("predict", struck, "--campaign", struck, "--posture", where, "--out", there, "--quiet")
    assert ran.exit_code == 0, ran.stderr
    told = run("lobes", struck, "--prediction", there, "--cut", "aluminium", "--json", "--quiet")
    assert told.exit_code == 0, told.stderr
    assert "along one direction nothing was predicted" in told.stderr
    assert "within the 95 % band of the FRFs" in told.stderr
    own = run("lobes", "fanuc_s360", "--posture", where, "--cut", "aluminium", "--json", "--quiet")
    depths = [json.loads(one.stdout)["critical_depth"] for one in (told, own)]
    assert depths[0] == pytest.approx(depths[1], rel=0.25)  # the true robot is 5 % off the card


@pytest.mark.slow
def test_lobes_at_any_posture_are_those_of_the_file(struck, tmp_path):
    """Two routes to one depth: what predict wrote, and the source asked on its own; then a family by it."""
    there, where = tmp_path / "there.json", "q1=1.3,q2=-1.3,q3=0.1"
    ran = run("predict", "fanuc_s360", "--campaign", struck, "--posture", where, "--out", there, "--quiet")
    assert ran.exit_code == 0, ran.stderr
    words = ("--cut", "aluminium", "--json", "--quiet")
    by_file = run("lobes", "fanuc_s360", "--prediction", there, *words)
    by_source = run("lobes", "fanuc_s360", "--campaign", struck, "--posture", where, *words)
    depths = [json.loads(one.stdout)["critical_depth"] for one in (by_file, by_source)]
    assert depths[1] == pytest.approx(depths[0], rel=1e-6)
    bands = [
        [line for line in one.stderr.splitlines() if "95 % band" in line] for one in (by_file, by_source)
    ]
    assert len(bands[0]) == 1
    assert bands[0] == bands[1]
    family = run(
        "lobes", "fanuc_s360", "--campaign", struck, "--family", "second_link_horizontal",
        "--members", "2", "--predict-by", "physics", *words,
    )  # fmt: skip
    assert family.exit_code == 0, family.stderr
    assert len(json.loads(family.stdout)["postures"]) == 2
    assert "95 % band" in family.stderr


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--posture", "q1=1", "--method", "semi-discretisation"), "a prediction is a receptance"),
        (("--prediction", "there.json"), "one of the two"),
    ],
)
def test_what_a_campaign_is_refused_with(struck, words, says):
    ran = run("lobes", "fanuc_s360", "--campaign", struck, "--cut", "aluminium", *words)
    assert ran.exit_code != 0
    assert says in str(ran.exception)


@pytest.mark.parametrize("command", ["path", "tune"])
def test_commands_without_predictions_say_what_takes_them(struck, command):
    ran = run(command, "fanuc_s360", "--campaign", struck)
    assert ran.exit_code != 0
    assert f"flexmodal {command} FOLDER" in str(ran.exception)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--posture", "q1=1"), "exactly one of --posture, --prediction, --family and --hold"),
        (("--method", "semi-discretisation"), "a prediction is a receptance, not a system"),
        ((), "no such file"),
    ],
)
def test_what_is_refused(struck, tmp_path, words, says):
    ran = run("lobes", struck, "--prediction", tmp_path / "none.json", "--cut", "aluminium", *words)
    assert ran.exit_code != 0
    assert says in str(ran.exception)


def test_a_folder_with_a_robot_is_a_robot(struck):
    """As identify, diagnose and rig write them: every command takes the card in it."""
    by_folder, by_card = (
        run("modes", place, "--posture", "configuration_1", "--json")
        for place in (struck, struck / "robot" / "robot.toml")
    )
    assert by_folder.exit_code == 0, by_folder.stderr
    assert by_folder.stdout == by_card.stdout
    assert "found no robot of the name" in str(run("modes", "x" * 5000, "--posture", "a").exception)

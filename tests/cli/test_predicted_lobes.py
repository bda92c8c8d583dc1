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

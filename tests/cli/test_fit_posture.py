"""`flexmodal fit --posture`: one posture of several, as if it had been measured alone."""

import pytest

import flexmodal
from flexmodal.rig import simulate

QUICK = ("--per", "posture", "--no-vary", "--json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = simulate(
        flexmodal.load("fanuc_s360"), postures=["configuration_1", "configuration_5"], points=2, references=1,
        trials=2, averages=2, band=(2.0, 80.0), record_length=1.5, seed=6, time=False,
    )  # fmt: skip
    place = tmp_path_factory.mktemp("fit") / "campaign"
    made.write(place)
    return place


def test_by_name_and_by_id_it_is_the_same_posture(cli, folder):
    every = cli("fit", folder, *QUICK).json()["modes"]
    one = cli("fit", folder, *QUICK, "--posture", "configuration_5").json()["modes"]
    assert one == cli("fit", folder, *QUICK, "--posture", "2").json()["modes"]
    assert one == [mode for mode in every if mode["posture"] == one[0]["posture"]]
    assert 0 < len(one) < len(every)


def test_a_posture_that_is_not_there_is_refused(cli, folder):
    cli("fit", folder, "--posture", "configuration_9").refused("1 or configuration_1")

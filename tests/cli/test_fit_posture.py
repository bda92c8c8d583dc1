"""`flexmodal fit --posture`: one posture of several, as if it had been measured alone."""

import pytest

import flexmodal
from flexmodal.campaign import read_campaign
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


def place_of(mode):
    return tuple(mode["response"]), tuple(mode["reference"])


def test_an_frf_by_itself_is_that_of_the_whole(cli, folder):
    """By ids and by names, with its own choices; the other FRFs are not touched."""
    every = cli("fit", folder, "--no-vary", "--json").json()["modes"]
    assert len({place_of(mode) for mode in every}) > 1
    points = read_campaign(folder).points
    names = {point.id: point.name for point in points}
    frfs = read_campaign(folder).frfs
    ends = [frfs.response[0].tolist(), frfs.reference[0].tolist()]
    by_id, by_name = (
        "/".join(f"{table[number]}:{'-' if way < 0 else '+'}{'xyz'[abs(way) - 1]}" for number, way in ends)
        for table in ({point.id: point.id for point in points}, names)
    )
    one = cli("fit", folder, "--no-vary", "--json", "--frf", by_id).json()["modes"]
    assert one == cli("fit", folder, "--no-vary", "--json", "--frf", by_name).json()["modes"]
    own = {place_of(mode) for mode in one}
    assert len(own) == 1
    same = [mode for mode in every if place_of(mode) in own]  # but for the noise, which neighbours tell too
    found, expected = ([mode["frequency"] for mode in some] for some in (one, same))
    assert found == pytest.approx(expected, rel=1e-3)
    forced = cli("fit", folder, "--json", "--frf", by_id, "--at", str(one[0]["frequency"])).json()["modes"]
    assert len(forced) == len({mode["posture"] for mode in one})


def test_an_frf_that_is_not_there_is_refused(cli, folder):
    cli("fit", folder, "--frf", "9:+z/1:+z").refused("RESPONSE/REFERENCE among", "1:z/")

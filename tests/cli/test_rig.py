"""`flexmodal rig`: what it takes where little is asked for."""

from flexmodal.campaign import read_campaign


def test_one_point_measured_one_way_is_struck_there_alone(cli, tmp_path):
    words = ("rig", "six_link", "--points", "1", "--postures", "1", "--trials", "1", "--no-time")
    ran = cli(*words, "--out", tmp_path / "one", "--quiet")
    assert ran.status == 0
    frfs = read_campaign(tmp_path / "one").frfs
    assert len(frfs.value) == 1
    cli(*words, "--references", "2", "--out", tmp_path / "two").refused("--references", "found 2", "1 to 1")

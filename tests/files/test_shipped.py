"""Data that ship are found by name from any folder, and never before a file of one's own."""

import pytest

from flexmodal.campaign import is_campaign, read_campaign
from flexmodal.errors import InvalidCut
from flexmodal.files import catalogue_folder, path_or_shipped, shipped
from flexmodal.machining import read_cut


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_cut_by_name():
    file = catalogue_folder() / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml"
    assert read_cut("aluminium") == read_cut("fanuc_s360/aluminium") == read_cut(file)


def test_a_campaign_by_name():
    assert is_campaign("fanuc_s360/thesis")
    folder = catalogue_folder() / "robots" / "fanuc_s360" / "campaigns" / "thesis"
    assert read_campaign("thesis").path == read_campaign(folder).path


def test_a_file_of_ones_own_comes_first(tmp_path):
    (tmp_path / "aluminium").write_text("not a cut")
    assert path_or_shipped("aluminium", "cuts", ".toml").read_text() == "not a cut"
    with pytest.raises(InvalidCut, match="not TOML"):
        read_cut("aluminium")


def test_names_that_two_robots_have_need_the_robot(tmp_path, monkeypatch):
    for robot in ("one", "two"):
        (tmp_path / "robots" / robot / "cuts").mkdir(parents=True)
        (tmp_path / "robots" / robot / "cuts" / "steel.toml").write_text("")
    monkeypatch.setenv("FLEXMODAL_CATALOGUE", str(tmp_path))
    assert list(shipped("cuts", ".toml")) == ["one/steel", "two/steel"]


def test_a_name_that_is_none_lists_those_that_are():
    with pytest.raises(InvalidCut, match="the name of a cut that ships: aluminium"):
        read_cut("granite")


def test_no_catalogue_ships_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMODAL_CATALOGUE", str(tmp_path / "nowhere"))
    assert shipped("cuts", ".toml") == {}

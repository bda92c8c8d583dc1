import importlib.metadata

import pytest

from flexmodal.cards import example_arms, find, shipped_cards
from flexmodal.errors import RobotNotFound
from flexmodal.files import catalogue_folder


def test_find_by_name_and_by_path(folder, monkeypatch):
    assert find("six_link") == shipped_cards()["six_link"]
    assert find("ur5") == example_arms()["ur5"]
    monkeypatch.chdir(folder)
    assert find(".").resolve() == folder / "robot.toml"
    assert find("robot.toml").resolve() == folder / "robot.toml"
    assert find("two_link.urdf").resolve() == folder / "two_link.urdf"
    assert find(str(folder)) == folder / "robot.toml"


@pytest.mark.parametrize("reference", ["", "fanuc_s630", "no/such/robot.toml", "x" * 5000, "a\0b", "*"])
def test_what_is_not_found_says_what_there_is(tmp_path, monkeypatch, reference):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RobotNotFound) as caught:
        find(reference)
    (fault,) = caught.value.faults
    assert "six_link" in fault.allowed
    assert len(str(fault)) < 500


def test_the_nearest_name_is_offered():
    with pytest.raises(RobotNotFound, match='did you mean "fanuc_s360"'):
        find("fanuc_s36")


def test_a_file_of_another_kind(tmp_path):
    (tmp_path / "arm.urdf.xacro").write_text("<robot/>")
    with pytest.raises(RobotNotFound, match="expand xacro first"):
        find(str(tmp_path / "arm.urdf.xacro"))


def test_another_catalogue(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMODAL_CATALOGUE", str(tmp_path))
    with pytest.raises(RobotNotFound, match="FLEXMODAL_CATALOGUE"):
        catalogue_folder()
    (tmp_path / "robots" / "mine").mkdir(parents=True)
    (tmp_path / "robots" / "mine" / "robot.toml").write_text("")
    assert shipped_cards() == {"mine": tmp_path / "robots" / "mine" / "robot.toml"}
    assert find("mine") == tmp_path / "robots" / "mine" / "robot.toml"


def test_without_the_optional_arms(monkeypatch):
    def missing(name: str) -> None:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "distribution", missing)
    assert example_arms() == {}
    with pytest.raises(RobotNotFound, match=r"pip install 'flexmodal\[arms\]'.*editable '\.\[arms\]'"):
        find("ur5")

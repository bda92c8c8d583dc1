"""The folder of a diagnosis: whole or not at all, and never over something else."""

import json
import os
import stat

import pytest

import flexmodal
from flexmodal.diagnosis import write
from flexmodal.diagnosis.write import write_diagnosis
from flexmodal.errors import OutputExists


def drawn_elsewhere(diagnosis, path, **_):
    """In the place of the page, whose pictures take seconds: `test_report.py` draws it, and the command."""
    path.write_text(f"page of {diagnosis.campaign}")


def test_folder(diagnosed, tmp_path, monkeypatch):
    monkeypatch.setattr(write, "write_report", drawn_elsewhere)
    write_diagnosis(diagnosed, tmp_path / "found")
    folder = tmp_path / "found"
    assert sorted(path.name for path in folder.iterdir()) == ["diagnosis.json", "report.html", "robot"]
    found = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
    assert found["verdict"]["effects"] == [["link_flexibility", "link_2"]]
    assert (folder / "report.html").read_text() == f"page of {diagnosed.campaign}"
    robot = flexmodal.load(folder / "robot" / "robot.toml")
    assert "link_2_bend_1" in robot.pseudo_joints
    assert os.listdir(tmp_path) == ["found"]
    assert stat.S_IMODE(folder.stat().st_mode) & 0o700 == 0o700


def test_never_over_something(diagnosed, tmp_path):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "letter.txt").write_text("dear")
    for overwrite in (False, True):  # --force replaces diagnoses, nothing else
        with pytest.raises(OutputExists):
            write_diagnosis(diagnosed, mine, overwrite=overwrite)
    file = tmp_path / "file"
    file.write_text("x")
    with pytest.raises(OutputExists):
        write_diagnosis(diagnosed, file, overwrite=True)
    with pytest.raises(OutputExists, match="no such folder"):
        write_diagnosis(diagnosed, tmp_path / "no" / "where")
    assert (mine / "letter.txt").read_text() == "dear"
    assert sorted(os.listdir(tmp_path)) == ["file", "mine"]


def test_replaces_an_earlier_diagnosis_when_asked(diagnosed, tmp_path, monkeypatch):
    monkeypatch.setattr(write, "write_report", drawn_elsewhere)
    folder = tmp_path / "found"
    folder.mkdir()
    (folder / "diagnosis.json").write_text("{}")
    (folder / "robot").mkdir()
    (folder / "robot" / "old.urdf").write_text("")
    with pytest.raises(OutputExists):
        write_diagnosis(diagnosed, folder)
    write_diagnosis(diagnosed, folder, overwrite=True)
    assert not (folder / "robot" / "old.urdf").exists()
    assert (folder / "report.html").read_text() == f"page of {diagnosed.campaign}"
    assert json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))["format"] == 1


def test_failure_leaves_nothing(diagnosed, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(write, "write_report", fail)
    with pytest.raises(KeyboardInterrupt):
        write_diagnosis(diagnosed, tmp_path / "found")
    assert os.listdir(tmp_path) == []


def test_failure_leaves_what_was_there(diagnosed, tmp_path, monkeypatch):
    folder = tmp_path / "found"
    folder.mkdir()
    (folder / "diagnosis.json").write_text("old")

    def fail(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(write, "write_report", fail)
    with pytest.raises(KeyboardInterrupt):
        write_diagnosis(diagnosed, folder, overwrite=True)
    assert (folder / "diagnosis.json").read_text() == "old"
    assert os.listdir(tmp_path) == ["found"]

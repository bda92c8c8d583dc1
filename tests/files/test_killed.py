"""A writer killed at each of its file events leaves the old or the new, whole, and bars nobody's way."""

import sys
from pathlib import Path

import pytest

from flexmodal.errors import OutputExists
from flexmodal.files import exchange, whole_file, whole_folder, whole_set

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from killing import killed_everywhere

OWN = ("mark.json", "in/*.txt")


def folder_work(target, overwrite=False):
    with whole_folder(target, own=OWN, overwrite=overwrite) as scratch:
        (scratch / "mark.json").write_text("new")
        (scratch / "in").mkdir()
        for name in "ab":
            with whole_file(scratch / "in" / f"{name}.txt") as inner:
                inner.write_text(f"new {name}" * 100)


def old_folder(target):
    (target / "in").mkdir(parents=True)
    (target / "mark.json").write_text("old")
    (target / "in" / "d.txt").write_text("old d")


@pytest.fixture(params=["exchange", pytest.param("journal", marks=pytest.mark.slow)])
def system(request, monkeypatch):
    """With what Linux can do, and without, which `make slow` runs."""
    if request.param == "journal":
        monkeypatch.setattr(exchange, "_renameat2", lambda: None)
    elif exchange._renameat2() is None:
        pytest.skip("a system that cannot exchange two names")


@pytest.mark.parametrize("overwrite", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_folder(tmp_path, system, overwrite):
    target = tmp_path / "there" / "out"
    target.parent.mkdir()
    if overwrite:
        old_folder(target)
    found = killed_everywhere(lambda: folder_work(target, overwrite), target.parent, target)
    assert found.new != found.old
    assert len(found.events) > 20
    assert {"write", "fsync", "renameat2", "os.mkdir"} <= {event.split()[0] for event in found.events}
    assert found.broken() == []
    assert found.old in found.read
    assert found.new in found.read


@pytest.mark.slow
def test_without_this_program_too_where_names_are_exchanged(tmp_path):
    if exchange._renameat2() is None:
        pytest.skip("a system that cannot exchange two names")
    target = tmp_path / "out"
    old_folder(target)
    found = killed_everywhere(lambda: folder_work(target, True), tmp_path, target)
    assert set(found.seen) == {found.old, found.new}


@pytest.mark.slow
def test_a_set(tmp_path, system):
    """A folder and the file beside it appear together: once one is seen, a reader makes the other appear."""
    target, beside = tmp_path / "out", tmp_path / "out.truth.toml"

    def work():
        with whole_set([target, beside]) as scratch:
            (scratch / "out").mkdir()
            (scratch / "out" / "a").write_text("a" * 1000)
            (scratch / "out.truth.toml").write_text("truth")

    found = killed_everywhere(work, tmp_path, target)
    assert found.broken() == []
    assert set(found.read) == {found.old, found.new}


@pytest.mark.parametrize("overwrite", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_file(tmp_path, system, overwrite):
    target = tmp_path / "file.csv"
    if overwrite:
        target.write_text("old")

    def work():
        with whole_file(target, overwrite=overwrite) as scratch:
            scratch.write_text("new" * 1000)

    found = killed_everywhere(work, tmp_path, target)
    assert found.broken() == []
    assert set(found.seen) == {found.old, found.new}


@pytest.mark.slow
def test_two_files_replaced_together(tmp_path, system):
    one, other = tmp_path / "robot.toml", tmp_path / "arm.urdf"
    one.write_text("old card")
    other.write_text("old urdf")

    def work():
        with whole_set([one, other], overwrite=True) as scratch:
            (scratch / one.name).write_text("new card")
            (scratch / other.name).write_text("new urdf")

    found = killed_everywhere(work, tmp_path, one)
    assert found.broken() == []
    assert set(found.read) == {found.old, found.new}


def test_what_takes_the_name_meanwhile_is_not_lost(tmp_path):
    target = tmp_path / "out"

    def work():
        with whole_folder(target, overwrite=True) as scratch:
            (scratch / "a").write_text("mine")
            target.mkdir()
            (target / "b").write_text("theirs")

    with pytest.raises(OutputExists, match="also holds b"):
        work()
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "b"]

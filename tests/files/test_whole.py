"""What is refused, writers at once, a full disk, a place that may not be written, names taken meanwhile."""

import os
import resource
from pathlib import Path

import pytest

from flexmodal.errors import NotWritten, OutputExists
from flexmodal.files import complete, exchange, refuse_folder, whole_file, whole_folder, whole_set
from flexmodal.files.stage import COMMIT, stage_of

OWN = ("mark.json", "in/*.txt")


def write(target, text, overwrite=False):
    with whole_folder(target, own=OWN, overwrite=overwrite) as scratch:
        (scratch / "mark.json").write_text(text)


def held(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.mark.parametrize(
    "foreign", ["notes.txt", "in/data.csv", "in/deeper/a.txt", "empty/", "robot/mark.json"]
)
def test_a_folder_with_anything_else_in_it_stays(tmp_path, foreign):
    target = tmp_path / "out"
    write(target, "old")
    (target / foreign).parent.mkdir(parents=True, exist_ok=True)
    (target / foreign).mkdir() if foreign.endswith("/") else (target / foreign).write_text("precious")
    before = held(target)
    with pytest.raises(OutputExists, match=foreign.rstrip("/")):
        write(target, "new", overwrite=True)
    assert held(target) == before
    assert (target / "mark.json").read_text() == "old"


def test_what_comes_into_it_while_it_is_written_stays_too(tmp_path):
    target = tmp_path / "out"
    write(target, "old")

    def work():
        with whole_folder(target, own=OWN, overwrite=True) as scratch:
            (scratch / "mark.json").write_text("new")
            (target / "notes.txt").write_text("precious")

    with pytest.raises(OutputExists, match=r"notes\.txt"):
        work()
    assert held(tmp_path) == ["out", "out/mark.json", "out/notes.txt"]


def test_links_are_not_followed(tmp_path):
    write(tmp_path / "out", "old")
    (tmp_path / "link").symlink_to("out")
    with pytest.raises(OutputExists, match="link"):
        write(tmp_path / "link", "new", overwrite=True)
    assert (tmp_path / "out" / "mark.json").read_text() == "old"


def test_an_empty_folder_is_taken_and_a_full_one_is_not(tmp_path):
    (tmp_path / "out").mkdir()
    write(tmp_path / "out", "new")
    with pytest.raises(OutputExists, match="--force"):
        refuse_folder(tmp_path / "out", own=OWN)


def test_a_second_writer_is_told(tmp_path):
    target = tmp_path / "out"
    with whole_folder(target, own=OWN) as scratch:
        (scratch / "mark.json").write_text("first")
        child = os.fork()
        if child == 0:
            try:
                write(target, "second")
            except OutputExists as error:
                os._exit(7 if "another process" in str(error) else 8)
            os._exit(9)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    assert (target / "mark.json").read_text() == "first"
    assert held(tmp_path) == ["out", "out/mark.json"]


@pytest.mark.parametrize("overwrite", [False, True])
def test_many_writers_at_once(tmp_path, overwrite):
    """Of eight, those that say they wrote did: one alone without leave to replace; what is there is whole."""
    target, beside = tmp_path / "out", tmp_path / "beside"

    def work(number):
        if overwrite:
            write(target, f"{number}", overwrite=True)
            return
        with whole_set([target, beside]) as scratch:
            for name in ("out", "beside"):
                (scratch / name).write_text(f"{number}")

    for _ in range(5):
        children = []
        for number in range(8):
            children.append(os.fork())
            if children[-1] == 0:
                try:
                    work(number)
                except OutputExists:
                    os._exit(2)
                except BaseException:
                    os._exit(3)
                os._exit(0)
        ended = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
        assert set(ended) <= {0, 2}
        wrote = [number for number, status in enumerate(ended) if status == 0]
        assert wrote
        if overwrite:
            assert int((target / "mark.json").read_text()) in wrote
            assert held(tmp_path) == ["out", "out/mark.json"]
        else:
            assert len(wrote) == 1
            assert target.read_text() == beside.read_text() == str(wrote[0])
            assert held(tmp_path) == ["beside", "out"]
            target.unlink()
            beside.unlink()


def test_a_stage_that_goes_while_it_is_looked_at_is_made_again(tmp_path, monkeypatch):
    """Another writer had it when we made ours, and has removed it since."""
    plain, calls = os.mkdir, []

    def mkdir(path, *words, **options):
        if stage_of(tmp_path / "out") == Path(path):
            calls.append(path)
            if len(calls) == 1:
                raise FileExistsError(17, "File exists", str(path))
        plain(path, *words, **options)

    monkeypatch.setattr(os, "mkdir", mkdir)
    write(tmp_path / "out", "new")
    assert len(calls) == 2
    assert (tmp_path / "out" / "mark.json").read_text() == "new"


def test_a_full_disk_names_the_file_and_leaves_the_old(tmp_path):
    target = tmp_path / "file.csv"
    target.write_text("old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def work():
        with whole_file(target, overwrite=True) as scratch, scratch.open("w") as file:
            file.write("new" * 10_000)

    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(NotWritten, match=r"file\.csv: found File too large"):
            work()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert target.read_text() == "old"
    assert held(tmp_path) == ["file.csv"]


def test_a_place_that_may_not_be_written_is_named():
    place = Path("/sys/kernel")
    if not place.is_dir():
        pytest.skip("no file system that nobody may write")

    def work():
        with whole_file(place / "file.csv") as scratch:
            scratch.write_text("new")

    with pytest.raises(NotWritten, match=r"/sys/kernel/file\.csv"):
        work()


@pytest.mark.parametrize("name", ["a" * 255, "å" * 120, ".hidden", "a b\nc"])
def test_any_name(tmp_path, name):
    with whole_file(tmp_path / name) as scratch:
        scratch.write_text("new")
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_promise_whose_name_is_taken_waits(tmp_path, monkeypatch):
    """Killed between two names of a set, and then somebody takes the other: nothing of theirs is lost."""
    one, other = tmp_path / "one", tmp_path / "other"
    real = exchange._rename

    def dies(old, new, flag):
        if new.name == "other":
            raise KeyboardInterrupt
        return real(old, new, flag)

    def work():
        with whole_set([one, other]) as scratch:
            (scratch / "one").write_text("mine")
            (scratch / "other").write_text("mine")

    monkeypatch.setattr(exchange, "_rename", dies)
    with pytest.raises(KeyboardInterrupt):
        work()
    monkeypatch.undo()
    other.write_text("theirs")
    assert (stage_of(one) / COMMIT).is_file()
    with pytest.raises(OutputExists, match="took this name meanwhile"):
        complete(one)
    assert other.read_text() == "theirs"
    other.unlink()
    complete(one)
    assert (one.read_text(), other.read_text()) == ("mine", "mine")
    assert held(tmp_path) == ["one", "other"]


def test_a_folder_that_only_looks_like_a_stage_is_left_alone(tmp_path):
    stage = stage_of(tmp_path / "out")
    stage.mkdir()
    (stage / "thesis.tex").write_text("precious")
    with pytest.raises(OutputExists, match=r"thesis\.tex"):
        write(tmp_path / "out", "new")
    assert (stage / "thesis.tex").read_text() == "precious"

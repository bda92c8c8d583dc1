"""Pictures of a search: `optimise --plot KIND=FILE`."""

import numpy as np
import pytest
from PIL import Image

from flexmodal.cli import picturing

SEARCH = ("optimise", "six_link", "--hold=-2,2", "--frequency", "5", "--starts", "2", "--quiet")


@pytest.mark.slow
def test_each_kind(cli, tmp_path, monkeypatch):
    monkeypatch.setattr(picturing, "_PLACES", 3)
    monkeypatch.setattr(picturing, "_STARTS", 2)
    files = {kind: tmp_path / f"{kind}.png" for kind in picturing.KINDS}
    plots = [word for kind, file in files.items() for word in ("--plot", f"{kind}={file}")]
    ran = cli(*SEARCH, "--start", "start_2", *plots)
    assert ran.status == 0, ran.err
    assert ran.err.splitlines() == [f"wrote {file}" for file in files.values()]
    for file in files.values():
        with Image.open(file) as picture:
            assert np.asarray(picture.convert("L")).std() > 5
    again = cli(*SEARCH, "--start", "start_2", *plots[:2])
    assert again.status == 2
    assert "an existing file" in again.err
    assert again.out == ""
    assert cli(*SEARCH, "--start", "start_2", *plots[:2], "--force").status == 0


def test_one_that_cannot_be_drawn_does_not_keep_the_others(cli, tmp_path):
    """The fully held six-axis arm has no self-motion left."""
    words = ("optimise", "ur5", "--stiffness", "2e4", "--damping", "20", "--tool", "tool0")
    held = ("--hold", "0.4,0.2,0.3", "--orientation", "3,0.2,-0.5", "--frequency", "10", "--starts", "2")
    files = [tmp_path / name for name in ("self.png", "arm.svg")]
    ran = cli(
        *words, *held, "--direction", "tool0:+z", "--quiet", "--plot", f"self-motion={files[0]}",
        "--plot", f"arm={files[1]}",
    )  # fmt: skip
    assert ran.status == 0, ran.err
    assert "no picture of the self-motion" in ran.err
    assert "leaves nothing free" in ran.err
    assert not files[0].exists()
    assert files[1].read_text().lstrip().startswith("<?xml")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--plot", "arm"), "KIND=FILE"),
        (("--plot", "legs=a.png"), "KIND one of receptance, arm"),
        (("--plot", "arm=a.png", "--plot", "arm=b.png"), "arm twice"),
        (("--plot", "arm=a.gif"), ".png, .svg"),
        (("--plot", "arm=no/a.png"), "no such folder"),
        (("--plot", "descent=a.png"), "--start"),
    ],
)
def test_refused_before_the_search(cli, tmp_path, monkeypatch, words, says):
    monkeypatch.chdir(tmp_path)
    ran = cli(*SEARCH, *words)
    assert (ran.status, ran.out) == (2, "")
    assert says in ran.err


def test_pictures_of_what_is_held_need_a_hold(cli):
    ran = cli(
        "optimise", "six_link", "--free", "--frequency", "5", "--plot", "self-motion=a.png", "--plot",
        "workspace=b.png",
    )  # fmt: skip
    assert ran.status == 2
    assert ran.err.count("without --hold") == 2

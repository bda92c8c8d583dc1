"""`flexmodal export`: each kind written, read again, and never over another file."""

import mujoco
import numpy as np
import pytest
import scipy.io

import flexmodal


@pytest.mark.parametrize(
    ("kind", "name"),
    [("mujoco", "a.xml"), ("state-space", "a.npz"), ("state-space", "a.mat"), ("joint-state", "a.yaml"),
     ("krl", "a.src"), ("rapid", "a.mod")],
)  # fmt: skip
def test_every_kind(cli, tmp_path, kind, name):
    out = tmp_path / name
    asked = ("export", "six_axis", "--posture", "work", "--as", kind, "--out", out)
    assert cli(*asked).status == 0
    before = out.read_bytes()
    cli(*asked).refused("existing file")
    assert out.read_bytes() == before
    assert cli(*asked, "--force").status == 0


def test_what_was_written_is_the_model(cli, tmp_path):
    asked = ("export", "six_axis", "--posture", "work", "--as")
    posed = flexmodal.load("six_axis").at("work")
    directions = ("--response", "tool:+x", "--response", "tool:+z", "--reference", "tool:+z")
    for name, load in (("a.npz", np.load), ("a.mat", scipy.io.loadmat)):
        assert cli(*asked, "state-space", "--out", tmp_path / name, *directions).status == 0
        found = load(str(tmp_path / name))
        model = posed.to_ss(response=["tool:+x", "tool:+z"], reference="tool:+z")
        for key in "ABCD":
            assert np.array_equal(found[key], getattr(model, key))
        assert [str(one).strip() for one in np.ravel(found["outputs"])] == ["tool:+x", "tool:+z"]
    assert cli(*asked, "mujoco", "--out", tmp_path / "a.xml").status == 0
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml")).nv == 6


def test_the_ending_belongs_to_the_kind(cli, tmp_path):
    cli("export", "six_axis", "--posture", "work", "--as", "krl", "--out", tmp_path / "a.yaml").refused(
        ".src"
    )


def test_directions_are_of_a_state_space_alone(cli, tmp_path):
    words = ("export", "six_link", "--posture", "start_2", "--as", "krl", "--out", tmp_path / "go.src")
    ran = cli(*words, "--response", "tool:+x", "--reference", "tool:+z")
    assert len(ran.refused("--response", "--reference", "with --as state-space alone")) == 2
    assert list(tmp_path.iterdir()) == []

"""An atlas holds what its parts say one by one; killed and called again it is the same, bit by bit."""

import os
import pickle
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.atlas import (
    DepthOfCut,
    Grid,
    NaturalModes,
    Plan,
    Receptances,
    Sample,
    Stiffnesses,
    Task,
    best,
    build_atlas,
    open_atlas,
    whole_range,
)
from flexmodal.atlas.layout import chunk_shape
from flexmodal.errors import FlexmodalError, InvalidRequest, OutputExists
from flexmodal.files import claimed

sys.path.insert(0, str(Path(__file__).parent))
from conftest import content

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def whole(grid, tmp_path_factory):
    """The grid computed in one go."""
    path = tmp_path_factory.mktemp("whole") / "grid.zarr"
    build_atlas(grid, path)
    return path


def test_opens_in_xarray_with_labels_and_agrees_with_the_robot(whole, grid, six_link):
    xarray = pytest.importorskip("xarray")
    found = xarray.open_zarr(whole)
    assert grid.chunks == 81
    assert found.receptance.dims == ("q1", "q2", "q3", "q4", "q5", "frequency", "pair")
    assert found.frequency.attrs["units"] == "Hz"
    assert found.q1.attrs["units"] == "rad"
    posture = {"q1": -1.0, "q2": 0.0, "q3": 1.0, "q4": 0.0, "q5": float(found.q5[7])}
    here = found.sel(posture)
    where = posture | {"q6": float(found.q6)}
    one = six_link.frf(
        where, found.frequency.values, response=["tool:+z", "tool:+x"], reference="tool:+z"
    ).value
    for pair, column in (("tool:+z/tool:+z", 0), ("tool:+x/tool:+z", 1)):
        np.testing.assert_allclose(here.receptance.sel(pair=pair), one[:, column, 0], rtol=1e-9)
    np.testing.assert_allclose(here.tool, six_link.at(where).position("tool"), atol=1e-12)


def test_the_files_are_those_that_zarr_itself_writes(whole, grid, six_link, tmp_path):
    """Every array read and written again by zarr; a sample too, whose last chunk is not full."""
    import shutil

    import zarr

    ends = Plan(Sample(six_link, 50, whole_range(six_link)), grid.quantity, chunk_bytes=1 << 15)
    build_atlas(ends, tmp_path / "ends.zarr")
    for store in (whole, tmp_path / "ends.zarr"):
        path = tmp_path / "again" / store.name
        shutil.copytree(store, path)
        group = zarr.open_group(str(path), mode="r+", use_consolidated=False)
        for name in ("receptance", "tool"):
            values = group[name][...]
            shutil.rmtree(path / name / "c")
            group[name][...] = values
        assert content(path) == content(store)


def test_called_again_it_computes_nothing(whole, grid):
    before = content(whole)
    built = build_atlas(grid, whole)
    assert (built.standing, built.spoilt) == (grid.chunks, 0)
    assert content(whole) == before


def test_a_missing_a_cut_and_a_spoilt_chunk_are_computed_again(whole, grid, tmp_path):
    import shutil

    path = tmp_path / "grid.zarr"
    shutil.copytree(whole, path)
    (missing, _), (cut, size), (spoilt, _) = (grid.layout.files(path, one)[-1] for one in (3, 17, 40))
    missing.unlink()
    cut.write_bytes(cut.read_bytes()[: size // 2])
    flipped = bytearray(spoilt.read_bytes())
    flipped[100] ^= 1
    spoilt.write_bytes(flipped)
    (path / "receptance" / "c" / "0.abc.partial").write_bytes(b"half")
    with pytest.raises(FlexmodalError, match="cannot be read"):
        best(open_atlas(path), Task())
    built = build_atlas(grid, path)
    assert (built.standing, built.spoilt) == (grid.chunks - 3, 1)
    assert content(path) == content(whole)


@pytest.mark.parametrize("moment", [0.3, pytest.param(0.6, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_killed_and_called_again_it_is_the_same(whole, grid, tmp_path, moment):
    """SIGKILL once a part of the chunks stands; a chunk that stands is whole."""
    path = tmp_path / "grid.zarr"
    (tmp_path / "plan").write_bytes(pickle.dumps(grid))
    code = (
        "import pickle, sys, time; from flexmodal.atlas import build_atlas\n"
        "plan = pickle.load(open(sys.argv[1], 'rb'))\n"
        "build_atlas(plan, sys.argv[2], advance=lambda: time.sleep(0.02))\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "plan"), str(path)])
    wanted = moment * grid.chunks
    for _ in range(3000):
        standing = [one for one in range(grid.chunks) if path.is_dir() and grid.layout.stands(path, one)]
        if len(standing) >= wanted:
            break
        time.sleep(0.01)
    os.kill(child.pid, signal.SIGKILL)
    child.wait()
    standing = [one for one in range(grid.chunks) if grid.layout.stands(path, one)]
    assert wanted <= len(standing) < grid.chunks
    truth = content(whole)
    for number in standing:
        for file, _ in grid.layout.files(path, number):
            assert content(path)[str(file.relative_to(path))] == truth[str(file.relative_to(path))]
    assert not open_atlas(path).is_complete
    built = build_atlas(grid, path)
    assert (built.standing, built.spoilt) == (len(standing), 0)
    assert content(path) == truth
    assert not list(tmp_path.glob(".*"))


def test_two_writers_do_not_mix(grid, tmp_path):
    path = tmp_path / "grid.zarr"
    with claimed(path), pytest.raises(OutputExists, match="another process is writing"):
        build_atlas(grid, path)


def test_another_request_under_the_same_name_is_refused(whole, six_link, axes, grid):
    other = Plan(grid.points, Receptances.of(six_link, ["tool:+x"], [1.0]))
    with pytest.raises(OutputExists, match=r"quantity\.pairs"):
        build_atlas(other, whole)


def test_foreign_folders_are_left_alone(grid, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("years of work")
    with pytest.raises(OutputExists, match=r"thesis\.tex"):
        build_atlas(grid, tmp_path / "out")
    assert (tmp_path / "out" / "thesis.tex").read_text() == "years of work"


def test_sizes_are_looked_at_before_anything_is_made(six_link, tmp_path):
    plan = Plan(
        Sample(six_link, 10**10, whole_range(six_link)),
        Receptances.of(six_link, ["tool:+z"], np.arange(400.0)),
    )
    with pytest.raises(InvalidRequest, match="the room there"):
        build_atlas(plan, tmp_path / "huge.zarr")
    assert not list(tmp_path.iterdir())
    with pytest.raises(InvalidRequest, match="bytes for each posture"):
        Plan(plan.points, Receptances.of(six_link, ["tool:+z"], np.arange(2e7)))
    with pytest.raises(InvalidRequest, match="postures"):
        Sample(six_link, 10**13, whole_range(six_link))


@pytest.mark.slow
def test_a_sample_is_the_same_whatever_the_chunks(six_link, tmp_path):
    points = Sample(six_link, 2500, whole_range(six_link), seed=3)
    every = points.values((slice(0, 2500),))
    np.testing.assert_array_equal(every[1000:1100], points.values((slice(1000, 1100),)))
    plan = Plan(points, Stiffnesses.of(six_link, ["tool:+z"]), chunk_bytes=1 << 14)
    build_atlas(plan, tmp_path / "s.zarr")
    found = open_atlas(tmp_path / "s.zarr").dataset
    for column, name in enumerate(six_link.commanded):
        np.testing.assert_array_equal(found[name].values, every[:, column])
    one = six_link.measures(dict(zip(six_link.commanded, every[1234], strict=True)), direction="tool:+z")
    assert found.stiffness.values[1234, 0] == pytest.approx(one.stiffness, rel=1e-9)
    assert found.static_receptance.values[1234, 0] == pytest.approx(one.static_receptance, rel=1e-9)


def test_modes_are_those_of_each_posture_by_itself(six_link, tmp_path):
    plan = Plan(Sample(six_link, 30, whole_range(six_link)), NaturalModes(six_link))
    build_atlas(plan, tmp_path / "m.zarr", workers=1)
    found = open_atlas(tmp_path / "m.zarr").dataset
    values = plan.points.values((slice(0, 30),))
    for number in (0, 29):
        modes = six_link.modes(dict(zip(six_link.commanded, values[number], strict=True)))
        kept = len(modes.pole)
        np.testing.assert_allclose(found.natural_frequency[number, :kept], modes.frequency, rtol=1e-10)
        np.testing.assert_allclose(found.damping_ratio[number, :kept], modes.damping_ratio, rtol=1e-8)
        assert np.all(np.isnan(found.natural_frequency[number, kept:]))


def test_depths_are_those_of_each_posture_by_itself(tmp_path):
    from flexmodal.machining import critical_depth, read_cut

    arm = flexmodal.load("fanuc_s360")
    cut = read_cut(ROOT / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml")
    plan = Plan(Sample(arm, 3, whole_range(arm)), DepthOfCut(arm, cut, 24))
    build_atlas(plan, tmp_path / "d.zarr", workers=1)
    found = open_atlas(tmp_path / "d.zarr").dataset
    values = plan.points.values((slice(0, 3),))[2]
    pose = dict(zip(arm.commanded, map(float, values), strict=True))
    at = float(found.spindle_speed[5])
    assert float(found.limiting_depth[2, 5]) == pytest.approx(
        critical_depth(arm, pose, cut, spindle_speed=at)
    )
    assert float(found.critical_depth[2]) == pytest.approx(float(found.limiting_depth[2].min()))


def test_an_undamped_pole_is_infinite_and_its_neighbours_are_not(tmp_path):
    urdf = tmp_path / "one.urdf"
    urdf.write_text(
        '<robot name="one"><link name="base"/><link name="arm"><inertial>'
        '<origin xyz="0.5 0 0"/><mass value="2"/>'
        '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
        '<joint name="q1" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    arm = flexmodal.load(str(urdf), stiffness=100.0, damping=0.0, tool="arm")
    resonance = float(arm.modes({"q1": 0.0}).frequency[0])
    axis = [resonance / 2, resonance, resonance * 2]
    plan = Plan(Grid(arm, {"q1": np.linspace(-1, 1, 3)}), Receptances.of(arm, ["arm:+y"], axis))
    build_atlas(plan, tmp_path / "u.zarr")
    found = np.abs(open_atlas(tmp_path / "u.zarr").dataset.receptance.values[..., 0])
    assert np.all(np.isfinite(found[:, [0, 2]]))
    assert np.all(np.isinf(found[:, 1]))


def test_single_precision_is_the_same_to_seven_digits(six_link, grid, whole, tmp_path):
    quantity = grid.quantity
    half = Plan(grid.points, Receptances.of(six_link, quantity.pairs, quantity.frequency, single=True))
    build_atlas(half, tmp_path / "h.zarr")
    one, two = (open_atlas(path).dataset.receptance.values for path in (whole, tmp_path / "h.zarr"))
    assert two.dtype == np.complex64
    assert np.max(np.abs(one - two) / np.abs(one)) < 2e-7


@pytest.mark.parametrize(("shape", "most", "wanted"), [
    ((10, 10, 10), 1000, (10, 10, 10)),
    ((10, 10, 10), 120, (1, 10, 10)),
    ((10, 10, 10), 55, (1, 5, 10)),
    ((7, 13), 5, (1, 5)),
    ((100,), 33, (25,)),
    ((4,), 1, (1,)),
])  # fmt: skip
def test_chunks(shape, most, wanted):
    assert chunk_shape(shape, most) == wanted


@pytest.mark.parametrize(("change", "words"), [
    ({"q9": [0.0]}, "unknown joint 'q9'"),
    ({"q1": [1.0, 0.0]}, "ascending"),
    ({"q1": [0.0, np.nan]}, "ascending"),
    ({"q1": [0.0, 100.0]}, "limits"),
    ({"q1": []}, "0 values"),
])  # fmt: skip
def test_bad_grids(six_link, axes, change, words):
    with pytest.raises(InvalidRequest, match=words):
        Grid(six_link, {**axes, **{name: np.array(values) for name, values in change.items()}})


def test_a_grid_names_every_joint(six_link):
    with pytest.raises(InvalidRequest, match="nothing for q2, q3"):
        Grid(six_link, {"q1": np.array([0.0, 1.0])})


def test_the_extra_names_what_the_room_imports():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    named = {one.split(">")[0] for one in extras["atlas"]}
    assert named == {"dask", "distributed", "google-crc32c", "xarray", "zarr"}

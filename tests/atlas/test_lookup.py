"""Reading an atlas back: nearest, in between, the best, the map, and the search that begins there."""

import sys
from pathlib import Path

import numpy as np
import pytest

from flexmodal import Hold, PointDirection, PostureProblem, ReceptanceObjective
from flexmodal.atlas import (
    Grid,
    Plan,
    Receptances,
    Sample,
    Stiffnesses,
    Task,
    best,
    build_atlas,
    check_robot,
    interpolated,
    nearest,
    open_atlas,
    search_from,
    spread,
    whole_range,
    within,
    workspace_map,
    write_map_page,
)
from flexmodal.errors import FlexmodalError, InvalidRequest

sys.path.insert(0, str(Path(__file__).parent))
WHERE = {"q1": 0.31, "q2": -0.4, "q3": 0.9, "q4": -0.9, "q5": 0.05}


@pytest.fixture(scope="module")
def atlas(grid, tmp_path_factory):
    path = tmp_path_factory.mktemp("read") / "grid.zarr"
    build_atlas(grid, path)
    return open_atlas(path)


@pytest.fixture(scope="module")
def sampled(six_link, tmp_path_factory):
    path = tmp_path_factory.mktemp("read") / "sample.zarr"
    plan = Plan(
        Sample(six_link, 1500, whole_range(six_link)), Stiffnesses.of(six_link, ["tool:+z", "tool:+x"])
    )
    build_atlas(Plan(plan.points, plan.quantity, chunk_bytes=1 << 14), path, workers=1)
    return open_atlas(path)


def test_nearest_of_a_grid(atlas):
    spot, found = nearest(atlas, WHERE)
    assert {name: round(value, 12) for name, value in spot.posture.items()} == {
        "q1": 0.0, "q2": 0.0, "q3": 1.0, "q4": -1.0, "q5": round(float(atlas.dataset.q5[8]), 12), "q6": 0.3
    }  # fmt: skip
    assert found.receptance.shape == (40, 2)


def test_nearest_of_a_sample_is_the_nearest_of_all(sampled, six_link):
    wanted = {name: 0.2 for name in six_link.commanded}
    spot, _ = nearest(sampled, wanted)
    every = np.stack([sampled.dataset[name].values for name in six_link.commanded], axis=1)
    span = np.array([sampled.span[name] for name in six_link.commanded])
    distance = np.linalg.norm((every - 0.2) / span, axis=1)
    assert spot.distance == pytest.approx(distance.min())
    np.testing.assert_array_equal(list(spot.posture.values()), every[np.argmin(distance)])


def test_in_between_is_linear_in_every_joint(atlas):
    """At a corner the value there; half-way along one joint the mean; against the sum over all 32 corners."""
    values, weight = 0, {}
    for name in atlas.dims:
        axis = atlas.dataset[name].values
        first = int(np.searchsorted(axis, WHERE[name], side="right") - 1)
        part = (WHERE[name] - axis[first]) / (axis[first + 1] - axis[first])
        weight[name] = {first: 1 - part, first + 1: part}
    for corner in np.ndindex(*(2,) * 5):
        place = {name: list(weight[name])[bit] for name, bit in zip(atlas.dims, corner, strict=True)}
        share = np.prod([weight[name][one] for name, one in place.items()])
        values = values + share * atlas.dataset.receptance.isel(place).values
    np.testing.assert_allclose(interpolated(atlas, WHERE).receptance.values, values, rtol=1e-10)
    corner = {name: float(atlas.dataset[name].values[-1]) for name in atlas.dims}
    there = atlas.dataset.receptance.isel({name: -1 for name in atlas.dims}).values
    np.testing.assert_allclose(interpolated(atlas, corner).receptance.values, there, rtol=1e-12)


def test_in_between_comes_nearer_the_finer_the_grid(six_link, tmp_path):
    """Halved steps, a quarter of the error: second order, static so that no resonance is near."""
    where, errors = {"q1": 0.123, "q2": 0.2}, []
    held = {f"q{number}": np.array([0.3]) for number in range(3, 7)}
    for steps in (4, 8, 16):
        axes = {"q1": np.linspace(-1, 1, steps + 1), "q2": np.linspace(-1, 1, steps + 1), **held}
        quantity = Receptances.of(six_link, ["tool:+z"], [0.0], way="numpy")
        build_atlas(Plan(Grid(six_link, axes), quantity), tmp_path / f"{steps}.zarr", workers=1)
        found = interpolated(open_atlas(tmp_path / f"{steps}.zarr"), where).receptance.values[0, 0]
        truth = six_link.frf(where | {name: 0.3 for name in held}, [0.0], response="tool:+z").value[0, 0, 0]
        errors.append(abs(found - truth) / abs(truth))
    assert errors[2] < errors[0] / 6
    assert errors[2] < 1e-2


def test_best_is_the_best_of_all(atlas):
    spots = best(atlas, Task(band=(5.0, 5.0), label="tool:+z"), count=4)
    every = np.abs(atlas.dataset.receptance.sel(frequency=5.0, pair="tool:+z/tool:+z").values)
    assert spots[0].value == pytest.approx(every.min(), rel=1e-12)
    assert [one.value for one in spots] == sorted(one.value for one in spots)
    band = best(atlas, Task(band=(5.0, 9.0), label="tool:+z"), count=1)[0]
    lines = np.abs(atlas.dataset.receptance.sel(frequency=slice(5.0, 9.0), pair="tool:+z/tool:+z").values)
    assert band.value == pytest.approx(lines.max(axis=-1).min(), rel=1e-12)


def test_best_near_a_place(atlas):
    target = np.array([3.0, 0.0, 3.0])
    spots = best(atlas, Task(), count=3, where=within(np.eye(3), target, 0.5))
    assert all(np.linalg.norm(np.array(one.tool) - target) <= 0.5 for one in spots)
    with pytest.raises(FlexmodalError, match="near that place"):
        best(atlas, Task(), where=within(np.eye(3), np.array([99.0, 0, 0]), 0.1))


def test_stiffness_is_better_when_larger(sampled):
    spot = best(sampled, Task(label="tool:+x"), count=1)[0]
    assert spot.value == pytest.approx(float(sampled.dataset.stiffness.sel(direction="tool:+x").max()))


def test_a_search_begun_there_is_no_worse_than_where_it_began(atlas, six_link):
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([5.0]))
    held = np.array(best(atlas, Task(band=(5.0, 5.0), label="tool:+z"), count=3)[-1].tool)[[0, 2]]
    problem = PostureProblem(six_link, judge, Hold.at(six_link, tuple(map(float, held))))
    outcome, starts = search_from(atlas, problem, Task(band=(5.0, 5.0), label="tool:+z"), count=3, radius=0.3)
    assert outcome.best.objective <= min(one.value for one in starts) * 1.5
    assert outcome.converged
    np.testing.assert_allclose(np.array(outcome.tool)[[0, 2]], held, atol=1e-6)


def test_another_robot_is_refused(atlas):
    import flexmodal

    with pytest.raises(InvalidRequest, match="not what"):
        check_robot(atlas, flexmodal.load("fanuc_s360"))


@pytest.mark.slow
def test_the_map_counts_every_posture_and_shows_the_best(atlas, tmp_path):
    found = workspace_map(atlas, Task(band=(5.0, 5.0)), cells=20)
    assert found.plane == "xz"
    assert found.count.sum() == 1296
    every = np.abs(atlas.dataset.receptance.sel(frequency=5.0, pair="tool:+z/tool:+z").values)
    assert np.nanmin(found.value) == pytest.approx(every.min())
    assert np.array_equal(np.isnan(found.value), found.count == 0)
    path = tmp_path / "map.html"
    write_map_page(atlas, found, best(atlas, Task()), path, what="receptance at 5 Hz")
    text = path.read_text()
    assert "Content-Security-Policy" in text
    assert "1,296" in text


@pytest.mark.parametrize(("ask", "words"), [
    (lambda atlas: nearest(atlas, {"q1": 0.0}), "nothing for q2"),
    (lambda atlas: nearest(atlas, WHERE | {"q9": 0.0}), "unknown joint 'q9'"),
    (lambda atlas: interpolated(atlas, WHERE | {"q1": 1.5}), "which the atlas covers"),
    (lambda atlas: interpolated(atlas, WHERE | {"q1": float("nan")}), "which the atlas covers"),
    (lambda atlas: best(atlas, Task(band=(100.0, 200.0))), "a band with one of"),
    (lambda atlas: best(atlas, Task(label="tool:+y")), "pair"),
    (lambda atlas: best(atlas, Task(), count=0), "count"),
    (lambda atlas: workspace_map(atlas, Task(), plane="zz"), "plane"),
    (lambda atlas: workspace_map(atlas, Task(), cells=10**6), "cells"),
])  # fmt: skip
def test_bad_questions(atlas, ask, words):
    with pytest.raises(InvalidRequest, match=words):
        ask(atlas)


def test_a_sample_has_nothing_in_between(sampled):
    with pytest.raises(InvalidRequest, match="a sample of postures"):
        interpolated(sampled, {f"q{number}": 0.0 for number in range(1, 7)})


@pytest.mark.parametrize("spoil", [
    lambda path: path.write_text("{"),
    lambda path: path.write_text("[]"),
    lambda path: path.write_text('{"attributes": {"flexmodal": {"format": 1}}}'),
    lambda path: path.write_text('{"attributes": {"flexmodal": {"format": 2}}}'),
    lambda path: path.unlink(),
])  # fmt: skip
def test_stores_that_are_none(grid, tmp_path, spoil):
    from flexmodal.atlas.store import create

    create(grid, tmp_path / "a.zarr")
    spoil(tmp_path / "a.zarr" / "zarr.json")
    with pytest.raises(InvalidRequest):
        open_atlas(tmp_path / "a.zarr")


def test_what_is_not_computed_yet_is_said_and_not_read_as_numbers(grid, tmp_path):
    from flexmodal.atlas.store import create

    create(grid, tmp_path / "a.zarr")
    empty = open_atlas(tmp_path / "a.zarr")
    with pytest.raises(FlexmodalError, match="not computed yet"):
        nearest(empty, WHERE)
    with pytest.raises(FlexmodalError):
        best(empty, Task())


def test_spread_gives_every_result_once_in_processes_and_threads():
    for threads in (True, False):
        found = dict(spread(abs, range(-30, 0), workers=2, threads=threads))
        assert found == {number: -number for number in range(-30, 0)}

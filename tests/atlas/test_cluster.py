"""On a Dask cluster of several processes, workers killed, scheduler lost: nothing is lost or differs."""

import signal
import sys
import time
from pathlib import Path

import pytest

from flexmodal.atlas import build_atlas, spread
from flexmodal.errors import FlexmodalError, InvalidRequest

sys.path.insert(0, str(Path(__file__).parent))
from conftest import Cluster, content

pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def whole(grid, tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "grid.zarr"
    build_atlas(grid, path)
    return content(path)


@pytest.mark.slow
def test_workers_killed_during_the_run(grid, whole, cluster, tmp_path):
    """Three workers; two are killed while they work, one comes in their place."""
    first, second, _ = (cluster.add_worker() for _ in range(3))
    seen = 0

    def advance():
        nonlocal seen
        seen += 1
        time.sleep(0.01)
        if seen == 10:
            first.send_signal(signal.SIGKILL)
        if seen == 30:
            second.send_signal(signal.SIGKILL)
            cluster.add_worker()

    built = build_atlas(grid, tmp_path / "grid.zarr", scheduler=cluster.address, advance=advance)
    assert seen == grid.chunks
    assert built.others == ()
    assert (first.wait(), second.wait()) == (-signal.SIGKILL, -signal.SIGKILL)
    found = content(tmp_path / "grid.zarr")
    assert not [name for name in found if name.endswith(".partial")] or _only_partials(found, whole)
    assert {name: one for name, one in found.items() if not name.endswith(".partial")} == whole


def _only_partials(found, whole):
    """What a killed worker was writing lies beside the chunk, under a name that nobody reads."""
    return {name for name in found if name not in whole} == {n for n in found if n.endswith(".partial")}


@pytest.mark.slow
def test_begun_here_and_finished_on_the_cluster(grid, whole, cluster, tmp_path):
    class Stopped(Exception):
        pass

    seen = 0

    def advance():
        nonlocal seen
        seen += 1
        if seen == 20:
            raise Stopped

    with pytest.raises(Stopped):
        build_atlas(grid, tmp_path / "grid.zarr", advance=advance)
    built = build_atlas(grid, tmp_path / "grid.zarr", scheduler=cluster.address)
    assert 20 <= built.standing < grid.chunks
    assert content(tmp_path / "grid.zarr") == whole


def test_without_any_worker_it_ends_with_a_sentence(grid, tmp_path):
    alone = Cluster(tmp_path)
    try:
        with pytest.raises(FlexmodalError, match="no worker at the scheduler"):
            build_atlas(grid, tmp_path / "grid.zarr", scheduler=alone.address, patience=0.5)
    finally:
        alone.close()


@pytest.mark.slow  # Dask tries for 15 s to find it again
def test_a_scheduler_that_goes_away_ends_it_with_a_sentence(tmp_path):
    alone = Cluster(tmp_path)
    alone.add_worker()
    try:
        done = spread(abs, range(10**9), scheduler=alone.address)
        next(done)
        alone.scheduler.send_signal(signal.SIGKILL)
        alone.scheduler.wait()
        with pytest.raises(FlexmodalError, match="does not answer any more"):
            list(done)
    finally:
        alone.close()


@pytest.mark.parametrize(
    "address", ["banana", "tcp://", "tcp://127.0.0.1", "http://127.0.0.1:1", "tcp://h:99999999"]
)
def test_addresses_that_are_none(address):
    with pytest.raises(InvalidRequest, match="scheduler"):
        list(spread(abs, [1], scheduler=address))


def test_what_a_piece_raises_comes_back_as_it_is(cluster):
    with pytest.raises(TypeError):
        list(spread(abs, ["text"], scheduler=cluster.address))

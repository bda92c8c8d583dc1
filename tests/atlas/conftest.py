"""Small atlases of the six-link arm, and what is on disk of one."""

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import flexmodal
from flexmodal.atlas import Grid, Plan, Receptances

BIN = Path(sys.executable).parent


def content(store):
    """Digest of every file of a store by its path in it."""
    files = sorted(path for path in Path(store).rglob("*") if path.is_file())
    return {str(path.relative_to(store)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.fixture(scope="session")
def six_link():
    return flexmodal.load("six_link")


@pytest.fixture(scope="session")
def axes():
    return {f"q{number}": np.linspace(-1, 1, 3 if number < 5 else 4) for number in range(1, 6)} | {
        "q6": np.array([0.3])
    }


@pytest.fixture(scope="session")
def grid(six_link, axes):
    """1296 postures in 81 chunks."""
    quantity = Receptances.of(six_link, ["tool:+z", ("tool:+x", "tool:+z")], np.linspace(0.5, 20, 40))
    return Plan(Grid(six_link, {**axes, "q5": np.linspace(-1, 1, 16)}), quantity, chunk_bytes=1 << 15)


class Cluster:
    """A Dask scheduler and workers, each a process of its own, on loopback."""

    def __init__(self, folder):
        self.folder, self.workers = folder, []
        self.environment = os.environ | {
            "OPENBLAS_NUM_THREADS": "1",
            "DASK_DISTRIBUTED__ADMIN__LOG_FORMAT": "%(message)s",
        }
        told = folder / "scheduler.json"
        self.scheduler = self._start(
            "dask",
            "scheduler",
            "--host",
            "127.0.0.1",
            "--port",
            "0",
            "--no-dashboard",
            "--scheduler-file",
            str(told),
        )
        for _ in range(300):
            if told.is_file() and told.stat().st_size:
                break
            time.sleep(0.1)
        self.address = json.loads(told.read_text())["address"]

    def _start(self, *words):
        return subprocess.Popen(
            [str(BIN / words[0]), *words[1:]],
            cwd=self.folder, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def add_worker(self):
        """One more, without a nanny that would start it again."""
        self.workers.append(
            self._start(
                "dask",
                "worker",
                self.address,
                "--no-nanny",
                "--nthreads",
                "1",
                "--no-dashboard",
                "--local-directory",
                str(self.folder),
                "--host",
                "127.0.0.1",
            )
        )
        return self.workers[-1]

    def close(self):
        for process in [*self.workers, self.scheduler]:
            if process.poll() is None:
                process.send_signal(signal.SIGKILL)
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    pytest.importorskip("distributed")
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    made.add_worker()
    yield made
    made.close()

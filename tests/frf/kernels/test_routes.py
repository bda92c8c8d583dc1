"""Every route to a receptance gives the numbers of a solve with pivoting."""

import subprocess
import sys

import numpy as np
import pytest

from flexmodal.errors import InvalidRequest, MissingExtra, SingularResponse
from flexmodal.frf.kernels import route as routes
from flexmodal.frf.kernels.route import choose, run
from flexmodal.frf.kernels.task import Task

WAYS = ("LAPACK", "numpy", "compiled", "compiled any n")


def random_task(rng, n, systems, lines, rows, kind="diagonal"):
    A = rng.normal(size=(systems, n, n))
    mass = A @ np.swapaxes(A, 1, 2) + 0.1 * np.eye(n)
    stiffness = np.diag(10 ** rng.uniform(3, 6, n))
    damping, hysteresis = 1e-3 * stiffness, 0.01 * stiffness
    addition = None
    if kind != "diagonal":
        Q = rng.normal(size=(n, n))
        stiffness, damping = stiffness + 1e3 * Q @ Q.T, damping + Q @ Q.T
    if kind == "addition":
        Q = 10 * rng.normal(size=(lines, n, n))
        addition = Q @ np.swapaxes(Q, 1, 2) * (1 + 0.5j)
    jacobians = rng.normal(size=(systems, rows, n))
    pairs = tuple((i, j) for i in range(rows) for j in range(rows) if i <= j or kind == "symmetric")
    omega = 2 * np.pi * np.linspace(0, 60, lines)
    block = lambda part: (mass[part], jacobians[part])  # noqa: E731
    task = Task(systems, block, stiffness, damping, hysteresis, pairs, omega, addition)
    Z = (
        stiffness
        - omega[:, None, None] ** 2 * mass[:, None]
        + 1j * (omega[:, None, None] * damping + hysteresis)
        + (0 if addition is None else addition)
    )
    solved = np.linalg.solve(Z, np.swapaxes(jacobians, 1, 2)[:, None].astype(complex))
    full = jacobians[:, None] @ solved
    expected = np.stack([full[:, :, u, v] for u, v in pairs], axis=-1)
    return task, expected


SIZES = (1, 3, 5, 1), (2, 70, 3, 2), (4, 2, 33, 2), (9, 3, 40, 2)
NOW = (2, "addition"), (9, "diagonal"), (9, "symmetric"), (9, "addition")
"""The others are for `make slow`: each size and kind is compiled by itself, some seconds for each."""


@pytest.mark.parametrize(
    ("n", "systems", "lines", "rows", "kind"),
    [
        pytest.param(*size, kind, marks=[] if (size[0], kind) in NOW else [pytest.mark.slow])
        for size in SIZES
        for kind in ("diagonal", "symmetric", "addition")
    ],
)
def test_all_ways_agree(n, systems, lines, rows, kind):
    """Of four sizes, the last of which goes with any size."""
    task, expected = random_task(np.random.default_rng(n), n, systems, lines, rows, kind)
    size = np.max(np.abs(expected), axis=(1, 2), keepdims=True)
    for way in WAYS:
        found = run(task, choose(task, 1, way))
        # Condition numbers are some 1e3 here and elimination grows tenfold at most: 1e4 × eps.
        np.testing.assert_allclose(found / size, expected / size, atol=3e-12, err_msg=way)


@pytest.mark.parametrize("way", WAYS)
def test_threads_do_not_change_a_bit(way):
    task, _ = random_task(np.random.default_rng(1), 3, 5, 40_000, 1)
    one, two = run(task, choose(task, 1, way)), run(task, choose(task, 2, way))
    assert np.array_equal(one, two)


def lightly_damped(damping):
    """The first coordinate, held alone, resonates at 1 rad/s: Z_11 vanishes there, the system does not."""
    mass = np.array([[[1.0, 0.3, 0.1], [0.3, 2.0, 0.2], [0.1, 0.2, 1.5]]])
    stiffness = np.diag([1.0, 50.0, 700.0])
    rows = np.eye(3)[None]
    pairs = ((0, 0), (0, 1), (2, 1))
    omega = np.array([0.5, 1.0, 1.0 + 1e-15, 1.0 + 1e-9, 2.0])
    task = Task(1, lambda _: (mass, rows), stiffness, damping * stiffness, np.zeros((3, 3)), pairs, omega)
    Z = stiffness - omega[:, None, None] ** 2 * mass[0] + 1j * omega[:, None, None] * damping * stiffness
    inverse = np.linalg.inv(Z)
    return task, np.stack([inverse[:, u, v] for u, v in pairs], axis=-1)[None]


@pytest.mark.parametrize("damping", [0.0, 1e-12, 1e-6])
@pytest.mark.parametrize("way", WAYS)
def test_a_part_that_resonates_costs_no_digits(way, damping):
    task, expected = lightly_damped(damping)
    # Without the watch over growth the error is 4e-5 undamped and 2e-7 at a damping of 1e-12.
    np.testing.assert_allclose(run(task, choose(task, 1, way)), expected, rtol=1e-12)


@pytest.mark.parametrize("n", [1, 3, 9])
@pytest.mark.parametrize("way", WAYS)
def test_an_undamped_resonance_is_refused(way, n):
    mass, rows = np.eye(n)[None], np.eye(n)[:1][None]
    stiffness = np.diag((1.0 + np.arange(n)) ** 2)
    omega = np.append(np.linspace(0.1, 0.9, 40), float(n))
    task = Task(1, lambda _: (mass, rows), stiffness, 0 * stiffness, 0 * stiffness, ((0, 0),), omega)
    with pytest.raises(SingularResponse, match=f"infinite at {n / (2 * np.pi):.9g} Hz"):
        run(task, choose(task, 1, way))


def test_the_choice_and_its_reason():
    task, _ = random_task(np.random.default_rng(0), 2, 1, 3, 1)
    assert choose(task, None).way == "LAPACK"
    assert "few points (3)" in str(choose(task, None))
    large, _ = random_task(np.random.default_rng(0), 2, 1, 10, 1)
    large = Task(4_000_000, large.block, *[large.stiffness] * 3, ((0, 0),), large.omega)
    assert choose(large, 1).way == "compiled"
    assert str(choose(large, 2)).startswith("compiled on 2 threads: 40000000 points, n = 2")


def test_without_numba(monkeypatch):
    monkeypatch.setattr(routes, "has_numba", lambda: False)
    task, _ = random_task(np.random.default_rng(0), 2, 1, 10, 1)
    large = Task(400_000, task.block, *[task.stiffness] * 3, ((0, 0),), task.omega)
    assert choose(large, None).way == "numpy"
    with pytest.raises(MissingExtra, match="numba"):
        choose(large, None, "compiled")


@pytest.mark.parametrize(("threads", "way"), [(0, "auto"), (True, "auto"), (1, "fastest")])
def test_bad_requests(threads, way):
    task, _ = random_task(np.random.default_rng(0), 2, 1, 3, 1)
    with pytest.raises(InvalidRequest):
        choose(task, threads, way)


def test_nothing_heavy_is_imported_with_the_package():
    code = "import sys, flexmodal.frf; print(sorted({'numba', 'scipy', 'matplotlib'} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout == "[]\n"

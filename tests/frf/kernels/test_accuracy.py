"""Errors against fifty digits, in units of LAPACK's own; `benchmarks/engine_accuracy.py` runs thousands."""

import mpmath
import numpy as np
import pytest

from flexmodal.frf.kernels.route import choose, run
from flexmodal.frf.kernels.task import Task

KINDS = ("light", "critical", "repeated", "stiff", "parts")


def system(rng, kind, sizes):
    """Mass, damping, stiffness and the angular frequencies where it is hardest."""
    n = int(rng.choice(sizes))
    A = rng.normal(size=(n, n))
    mass = A @ A.T + 0.05 * np.eye(n)
    stiffness = np.diag(10 ** rng.uniform(0, 8 if kind == "stiff" else 2, n))
    ratio = 10 ** rng.uniform(-9, -2)
    if kind in ("critical", "repeated"):
        root = np.linalg.cholesky(mass)
        stiffness = 9 * mass  # all natural frequencies alike
        ratio = 1.0 if kind == "critical" else ratio
        damping = 2 * ratio * 3 * root @ root.T
    else:
        damping = ratio * stiffness / np.sqrt(np.max(stiffness))
    parts = range(1, n) if kind == "parts" else (n,)
    natural = np.concatenate(
        [np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass[:k, :k], stiffness[:k, :k])))) for k in parts]
    )
    return mass, damping, stiffness, np.sort(np.concatenate([natural, 1.1 * natural, [1e-3]]))


def exact(mass, damping, stiffness, row, omega):
    with mpmath.workdps(50):
        w = mpmath.mpf(float(omega))
        n = len(row)
        Z = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                k, m, c = (mpmath.mpf(float(part[i, j])) for part in (stiffness, mass, damping))
                Z[i, j] = mpmath.mpc(k - w * w * m, w * c)
        j = mpmath.matrix([float(x) for x in row])
        return (j.T * mpmath.lu_solve(Z, j))[0]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("way", "sizes"),
    [
        ("numpy", (2, 5)),
        ("compiled any n", (2, 5)),
        ("compiled", (2,)),
        pytest.param("compiled", (2, 5), marks=pytest.mark.slow),  # each size is compiled by itself
    ],
)
def test_within_ten_times_the_error_of_lapack(kind, way, sizes):
    rng = np.random.default_rng(7)
    ours, theirs = [], []
    for _ in range(8):
        mass, damping, stiffness, omega = system(rng, kind, sizes)
        row = rng.normal(size=len(mass))
        task = Task(
            1,
            lambda _, m=mass, r=row: (m[None], r[None, None]),
            stiffness,
            damping,
            0 * mass,
            ((0, 0),),
            omega,
        )
        truth = np.array([complex(exact(mass, damping, stiffness, row, w)) for w in omega])
        for errors, through in ((ours, way), (theirs, "LAPACK")):
            found = run(task, choose(task, 1, through))[0, :, 0]
            errors.append(np.max(np.abs(found - truth) / np.abs(truth)))
    # One system's errors scatter by luck; the worst and the typical one of several must not.
    floor = np.finfo(float).eps
    assert max(ours) <= 10 * max(*theirs, floor)
    assert np.median(ours) <= 10 * max(np.median(theirs), floor)

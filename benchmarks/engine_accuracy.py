"""The engine's errors against fifty digits, in units of LAPACK's own, over thousands of random systems.

Writes docs/tables/engine_accuracy.md. Each system is asked at its resonances, beside them, and near 0; in
the kind "parts" also where a part of it resonates while the rest is held, which is what unpivoted
elimination fears.
"""

from __future__ import annotations

import sys

import mpmath
import numpy as np
from tables import write

from flexmodal.frf.kernels.route import choose, run
from flexmodal.frf.kernels.task import Task

SYSTEMS = int(sys.argv[1]) if len(sys.argv) > 1 else 400
"""Of each kind."""

KINDS = {
    "light": "damping ratios of 1e-9 to 1e-2",
    "critical": "every pole defective",
    "near critical": "1e-12 to 1e-4 from defective",
    "repeated": "all natural frequencies alike",
    "stiff": "stiffnesses over eight decades",
    "parts": "a part resonating, the rest held",
    "undamped": "no damping, beside the resonances",
}
WAYS = ("numpy", "compiled", "compiled any n")


def system(rng: np.random.Generator, kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Mass, damping, stiffness and angular frequencies."""
    n = int(rng.integers(2, 9))
    A = rng.normal(size=(n, n))
    mass = A @ A.T + 0.05 * np.eye(n)
    stiffness = np.diag(10 ** rng.uniform(0, 8 if kind == "stiff" else 2, n))
    ratio = 10 ** rng.uniform(-9, -2)
    if kind in ("critical", "near critical", "repeated"):
        stiffness = 9 * mass
        ratio = {"critical": 1.0, "near critical": 1 + 10 ** rng.uniform(-12, -4)}.get(kind, ratio)
        damping = 6 * ratio * mass
    else:
        damping = (0 if kind == "undamped" else ratio) * stiffness / np.sqrt(np.max(stiffness))
    parts = range(1, n + 1) if kind == "parts" else (n,)
    natural = np.concatenate(
        [np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass[:k, :k], stiffness[:k, :k])))) for k in parts]
    )
    beside = natural * (1 + 10 ** rng.uniform(-6, -1, len(natural)))
    at = natural[:0] if kind == "undamped" else natural
    return mass, damping, stiffness, np.unique(np.concatenate([at, beside, [1e-3]]))


def exact(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, row: np.ndarray, omega: float
) -> complex:
    """The receptance by elimination with fifty digits."""
    with mpmath.workdps(50):
        w = mpmath.mpf(float(omega))
        parts = [mpmath.matrix(part.tolist()) for part in (stiffness, mass, damping)]
        Z = parts[0] - w * w * parts[1] + mpmath.mpc(0, 1) * w * parts[2]
        j = mpmath.matrix(row.tolist())
        return complex((j.T * mpmath.lu_solve(Z, j))[0])


def main() -> None:
    rows = []
    failed = False
    for kind, words in KINDS.items():
        rng = np.random.default_rng(len(kind))
        errors: dict[str, list[np.ndarray]] = {way: [] for way in ("LAPACK", *WAYS)}
        for _ in range(SYSTEMS):
            mass, damping, stiffness, omega = system(rng, kind)
            row = rng.normal(size=len(mass))
            truth = np.array([exact(mass, damping, stiffness, row, w) for w in omega])
            block = lambda _, m=mass, r=row: (m[None], r[None, None])  # noqa: E731
            task = Task(1, block, stiffness, damping, 0 * mass, ((0, 0),), omega)
            for way, found in errors.items():
                value = run(task, choose(task, 1, way))[0, :, 0]
                found.append(np.abs(value - truth) / np.abs(truth))
        flat = {way: np.concatenate(found) for way, found in errors.items()}
        lapack = flat["LAPACK"]
        cells = [f"{np.median(lapack):.1e}", f"{np.max(lapack):.1e}"]
        for way in WAYS:
            ratios = [
                float(f(flat[way]) / max(f(lapack), np.finfo(float).eps))
                for f in (np.median, lambda e: np.percentile(e, 99), np.max)
            ]
            failed |= max(ratios) > 10
            cells.append(" / ".join(f"{ratio:.2g}" for ratio in ratios))
        rows.append([f"{kind}: {words}", str(len(lapack)), *cells])
    write(
        "engine_accuracy",
        "Errors of the engine in units of LAPACK's own",
        f"Made by `make bench`: {SYSTEMS} random systems of 2 to 8 coordinates of each kind, relative errors "
        "against elimination with fifty digits. For LAPACK the median and the largest error; for each way "
        "the ratio of its median, 99th percentile and largest error to LAPACK's (2.2e-16 where below). "
        "The goal is 10.",
        [
            "kind",
            "points",
            "LAPACK median",
            "LAPACK largest",
            *(f"{way}: median / 99 % / largest" for way in WAYS),
        ],
        rows,
        "Where LAPACK's largest error is large, it fails too: Z is then nearly singular and the answer not "
        "determined by numbers of sixteen digits.",
    )
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()

"""A whole campaign fitted, beside sdypy-EMA on the same data in the same run."""

from __future__ import annotations

import contextlib
import io
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from types import SimpleNamespace

import numpy as np
from tables import write

from flexmodal.ema import Choices, fit

POSTURES, POINTS, REFERENCES, TRIALS, LINES = 7, 6, 2, 4, 800


def campaign() -> SimpleNamespace:
    """Records of four modes that move with the posture, 1 % noise."""
    rng = np.random.default_rng(2)
    axis = 0.15 * np.arange(1, LINES + 1)
    s = 2j * np.pi * axis[:, None]
    value, where = [], []
    for posture in range(POSTURES):
        natural = 2 * np.pi * np.array([8.0, 51.0, 58.0, 94.0]) * (1 + 0.01 * rng.normal(size=4))
        pole = natural * (-np.array([0.06, 0.03, 0.04, 0.05]) + 1j)
        shape = 1e-2 * rng.normal(size=(POINTS, 4))
        for point in range(POINTS):
            for reference in range(REFERENCES):
                residue = shape[point] * shape[reference] / (2j * pole.imag)
                clean = (s * (residue / (s - pole) + residue.conj() / (s - pole.conj()))).sum(-1)
                for trial in range(TRIALS):
                    noise = rng.normal(size=(2, LINES)) * 0.01 * np.max(np.abs(clean)) / np.sqrt(2)
                    value.append(clean + noise[0] + 1j * noise[1])
                    where.append((posture + 1, trial + 1, point + 1, reference + 1))
    table = np.array(where)
    three = np.full(len(table), 3)
    return SimpleNamespace(
        frequency=axis, value=np.array(value), coherence=None, posture=table[:, 0], trial=table[:, 1],
        response=np.stack([table[:, 2], three], axis=1), reference=np.stack([table[:, 3], three], axis=1),
        form="mobility",
    )  # fmt: skip


def sdypy(records: SimpleNamespace, order: int) -> int:
    """LSCF of each posture over the mean of its trials: poles of every order."""
    from sdypy import EMA

    count = 0
    for posture in range(1, POSTURES + 1):
        rows = records.posture == posture
        mean = records.value[rows].reshape(-1, TRIALS, LINES).mean(axis=1)
        inertance = np.pad(mean * (2j * np.pi * records.frequency), ((0, 0), (1, 0)))
        axis = np.append(0.0, records.frequency)  # it takes the lines to begin at 0 Hz
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            model = EMA.Model(
                inertance, axis, lower=2, upper=120, pol_order_high=order, frf_form="accelerance"
            )
            model.get_poles(method="lscf", show_progress=False)
        count += len(model.all_poles)
    return count


def main() -> None:
    records = campaign()
    ways = {
        "sdypy-EMA lscf, poles of every order up to 40, nothing chosen": lambda: sdypy(records, 40),
        "lscf, order 40, refined, poles of each posture": lambda: fit(records, "lscf", per="posture"),
        "lscf, order 40, not refined, poles of each posture": lambda: fit(
            records, "lscf", per="posture", choices=Choices(refine=False)
        ),
        "least squares, poles of each posture": lambda: fit(records, per="posture"),
        "least squares, poles of each FRF": lambda: fit(records),
        "circle, each FRF": lambda: fit(records, "circle"),
        "peaks, each FRF": lambda: fit(records, "peaks"),
    }
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(5):
        for name, way in ways.items():
            start = time.process_time()
            way()
            seconds[name].append(time.process_time() - start)
    best = {name: min(times) for name, times in seconds.items()}
    reference = best[next(iter(ways))]
    write(
        "ema_speed",
        "Time to fit a campaign",
        f"Made by `benchmarks/ema_speed.py`: {POSTURES} postures × {POINTS} points × {REFERENCES} "
        f"references × {TRIALS} trials × {LINES} lines, trials averaged, one thread, processor time, each "
        "way in turn, best of five. sdypy-EMA is spared the choice of poles and the residues, and gives no "
        "uncertainty; all others give all three.",
        ["way", "seconds", "× sdypy-EMA's speed"],
        [[name, f"{time_:.2f}", f"{reference / time_:.1f}"] for name, time_ in best.items()],
    )


if __name__ == "__main__":
    main()

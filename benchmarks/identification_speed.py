"""How long an identification takes, beside scipy's least squares with finite differences."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from tables import write

import flexmodal
from flexmodal.identification import (
    IdentificationProblem,
    build_identification,
    predict,
    solve_identification,
)
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.frf_fit import Weighting, fit, residual
from flexmodal.rig import simulate
from flexmodal.structure.solution import Entries, solved
from flexmodal.structure.stack import Structures
from flexmodal.structure.structure import Axis

FLOOR = 0.01
REPEATS = 5
"""Of the solves in one timing."""
MOST = 150
"""Jacobians that scipy may take; it has needed 15."""


def measured() -> IdentificationProblem:
    """16 parameters, 7 postures × 6 points × some 800 lines."""
    robot = flexmodal.load("fanuc_s360")
    made = simulate(robot, postures=7, references=1, trials=2, peaks=(100.0,), seed=1)
    return build_identification(replace(made.campaign, blows=()), robot)


def by_scipy(data: FrfEvidence) -> tuple[np.ndarray, int, bool]:
    """The same weights, bounds and priors from the same start; Jacobian by forward differences."""
    from scipy.optimize import least_squares

    seen, space = data.observations, data.space
    root = np.sqrt(Weighting(FLOOR, np.arange(len(seen.axis))).weight(seen))
    prior = np.sqrt(space.precision)
    calls = 0

    def residuals(x: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        r = residual(predict(data.model, x, seen), seen.value) * root
        r = r[seen.used]
        return np.concatenate([r.real, r.imag, prior * x])

    found = least_squares(
        residuals, np.zeros(len(space)), bounds=space.bounds, loss="huber", f_scale=3.0, x_scale="jac",
        max_nfev=MOST,
    )  # fmt: skip
    return found.x, calls, found.status > 0


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Seconds of this process's processor, and of the clock."""
    processor, clock = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - processor, time.perf_counter() - clock


def solves(data: FrfEvidence, steps: int, rounds: int) -> dict[str, float]:
    """Processor time [s] of the systems of equations of as many evaluations, by two ways, interleaved."""
    seen = data.observations
    groups = data.model.groups(np.zeros(len(data.space)), seen, slopes=False)
    given = [(one.structures, seen.axis_of(one.part.level), one.part.entries) for one in groups]
    for structures, axis, entries in given:
        one, other = (solved(structures, axis, entries, compiled=way).value for way in (False, True))
        np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-12 * np.abs(one).max())
    taken: dict[str, list[float]] = {"numpy": [], "compiled": []}
    for _ in range(rounds):
        for name, times in taken.items():
            work = partial(all_solved, given, compiled=name == "compiled")
            times.append(timed(work)[0] / REPEATS)
    return {name: steps * float(np.median(times)) for name, times in taken.items()}


def all_solved(given: Sequence[tuple[Structures, Axis, Entries]], *, compiled: bool) -> None:
    """Some times over."""
    for _ in range(REPEATS):
        for structures, axis, entries in given:
            solved(structures, axis, entries, compiled=compiled)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--check", action="store_true", help="compare with the table, do not write it")
    repeats = parser.parse_args().repeats
    problem = measured()
    data = problem.evidence
    assert isinstance(data, FrfEvidence)
    seen = data.observations
    whole = data.fit()
    direct = fit(data.model, seen, floors=(FLOOR,))
    x, calls, settled = by_scipy(data)
    works: list[Callable[[], object]] = [
        data.fit, lambda: fit(data.model, seen, floors=(FLOOR,)), lambda: by_scipy(data),
        lambda: solve_identification(problem),
    ]  # fmt: skip
    rounds = np.array([[timed(work) for work in works] for _ in range(repeats)])  # [round, work, 2]
    processor, clock = np.median(rounds, axis=0).T
    ratio = np.median(rounds[:, 2:3, 0] / rounds[:, :, 0], axis=0)
    # As many evaluations as a fit has: one with derivatives and one of the cost alone for each step.
    parts = solves(data, 2 * whole.steps + 1, 2 * repeats + 1)
    away = np.abs(direct.x - x) / data.uncertainty(whole).deviation
    work = (f"{whole.steps} steps", f"{direct.steps} steps",
            f"{calls} evaluations" + ("" if settled else ", stopped"))  # fmt: skip
    names = ("flexmodal, floors 0.2, 0.05, 0.01", "flexmodal, floor 0.01 at once",
             "scipy least_squares, finite differences")  # fmt: skip
    rows = [
        [names[k], f"{processor[k]:.2f}", f"{clock[k]:.1f}", work[k], f"{ratio[k]:.1f}"] for k in range(3)
    ]
    folds = len(data.folds())
    everything = "flexmodal, with intervals, and each posture and point held out"
    rows.append([everything, f"{processor[3]:.2f}", f"{clock[3]:.1f}", f"{folds + 1} fits", ""])
    write(
        "identification_speed",
        "Identification of 16 parameters, beside scipy",
        f"Made by `make recovery`: {len(data.space)} parameters, {len(seen.postures)} postures × 6 points × "
        f"{len(seen.axis)} lines ({len(seen)} FRFs with a signal in them), on one core of a shared machine, "
        f"all in one run, interleaved, medians of {repeats} rounds. Processor: time of the processor; clock: "
        "time on the wall, others computing beside. scipy gets the same residuals, weights, priors, bounds, "
        "Huber's loss and start as the second row.",
        ["", "processor [s]", "clock [s]", "work", "times as fast as scipy"],
        rows,
        f"The two answers to one question differ by at most {away.max():.3f} standard errors. flexmodal "
        "has exact derivatives; its three floors are a way around local minima that scipy's run does not "
        "take.\n\nThe systems of equations of the first row are solved by compiled loops, in "
        f"{parts['compiled']:.2f} s of its {processor[0]:.2f} s; in their numpy form, which a program "
        f"without numba takes, they need {parts['numpy']:.2f} s.",
    )


if __name__ == "__main__":
    main()

"""What a fit and a diagnosis spend their time on, and what the forms of its hot functions are worth.

`receptance` and `residual` are called some thousand times in a fit, some ten thousand in a diagnosis. Before,
derivatives went through the products of all pairs of coordinates of y_u and y_v, and residuals through
`np.log` of complex numbers; both stand here, to be put back in place of the present ones for comparison.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from tables import write

import flexmodal
from flexmodal.campaign import Campaign, read_campaign, write_campaign
from flexmodal.diagnosis import diagnose
from flexmodal.identification import build_identification, frf_fit, model, solve_identification
from flexmodal.rig import simulate
from flexmodal.structure.structure import ROUNDING, Axis, Structure

KINDS = ("mass", "damping", "stiffness", "loss")


def by_products(
    structure: Structure, axis: Axis, pairs: np.ndarray, names: tuple[str, ...] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """`flexmodal.structure.structure.receptance` by the products of all pairs of coordinates."""
    yu, yv = structure.solve(axis)
    u, v = pairs[:, 0], pairs[:, 1]
    left, right = np.moveaxis(yu, 2, 0)[u], np.moveaxis(yv, 2, 0)[v]  # [pair, line, dof]
    value = np.einsum("pd,pld->pl", structure.response[u], right)
    size = np.einsum("pd,pld->pl", np.abs(structure.response[u]), np.abs(right))
    value[np.abs(value) <= ROUNDING * size] = 0.0
    slopes = np.zeros((len(names), *value.shape), dtype=complex)
    if not names:
        return value, slopes
    moving = [(k, structure.changes[name]) for k, name in enumerate(names) if name in structure.changes]
    i, j = np.triu_indices(structure.dof)
    outer = left[..., i] * right[..., j]
    off = i != j
    outer[..., off] += left[..., j[off]] * right[..., i[off]]
    flat = outer.reshape(-1, len(i))
    grown, growth = axis.hysteresis(structure.loss_factor)
    for kind, factor in zip(KINDS, (-(axis.s**2), -axis.s, -np.ones(len(axis)), -grown), strict=True):
        some = [(k, matrix) for k, change in moving if (matrix := getattr(change, kind)) is not None]
        if some:
            stacked = np.array([matrix[i, j] for _, matrix in some]).T
            found = (flat @ stacked.astype(complex)).reshape(*value.shape, -1)
            slopes[[k for k, _ in some]] += np.moveaxis(found, 2, 0) * factor
    weights = structure.loss[i, j].astype(complex)
    for k, change in moving:
        if change.loss_factor is not None:
            slopes[k] -= change.loss_factor * (flat @ weights).reshape(value.shape) * growth
        if change.response is not None:
            slopes[k] += np.einsum("pd,pld->pl", change.response[u], right)
        if change.reference is not None:
            slopes[k] += np.einsum("pd,pld->pl", change.reference[v], left)
    return value, slopes


def by_complex_logarithm(predicted: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """`flexmodal.identification.frf_fit.residual` by `np.log` of complex numbers."""
    zero = (predicted == 0) | (measured == 0)
    ratio = np.where(zero, 1.0, predicted) / np.where(zero, 1.0, measured)
    return np.where(zero, 10.0, np.log(ratio))


@contextmanager
def replaced(receptance: Callable[..., Any], residual: Callable[..., Any]) -> Iterator[None]:
    """Other functions in the place of the two."""
    kept = model.receptance, frf_fit.residual
    model.receptance, frf_fit.residual = receptance, residual  # type: ignore[attr-defined]
    try:
        yield
    finally:
        model.receptance, frf_fit.residual = kept  # type: ignore[attr-defined]


class Watched:
    """A function with the processor time spent in it."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function, self.seconds, self.calls = function, 0.0, 0

    def __call__(self, *given: Any, **more: Any) -> Any:
        """What the function gives."""
        start = time.process_time()
        try:
            return self.function(*given, **more)
        finally:
            self.seconds += time.process_time() - start
            self.calls += 1


def seconds(work: Callable[[], Any]) -> tuple[float, np.ndarray]:
    """Processor time, and the answer as numbers."""
    start = time.process_time()
    answer = work()
    return time.process_time() - start, np.asarray(answer, dtype=float)


def shares(work: Callable[[], Any]) -> tuple[int, list[float]]:
    """How often `receptance` is called; shares of solving, of all of `receptance` and of `residual`."""
    solve, whole, logarithm = Watched(Structure.solve), Watched(model.receptance), Watched(frf_fit.residual)
    kept = Structure.solve

    def watched(self: Structure, axis: Axis) -> Any:
        return solve(self, axis)

    Structure.solve = watched  # type: ignore[method-assign]
    try:
        with replaced(whole, logarithm):
            total = seconds(work)[0]
    finally:
        Structure.solve = kept  # type: ignore[method-assign]
    return whole.calls, [one.seconds / total for one in (solve, whole, logarithm)]


def loading() -> float:
    """Processor time that numba and one kernel from its cache take to load, beside numpy alone [s]."""

    def of(code: str) -> float:
        before = getrusage(RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", code], check=True)
        after = getrusage(RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    start = "import numpy, flexmodal.identification; from flexmodal import load; "
    start += "from flexmodal.model.batch import receptance_batch as batch; robot = load('six_link'); "
    start += "batch(robot, numpy.zeros((2, 6)), ['tool:+z'], [1.0, 2.0], way='{}')"
    plain, loaded = start.format("LAPACK"), start.format("compiled")
    of(loaded)
    return float(np.median([of(loaded) - of(plain) for _ in range(5)]))


def identified(campaign: Campaign, name: str) -> Callable[[], np.ndarray]:
    """A whole identification, with intervals and each posture and point held out."""
    problem = build_identification(campaign, flexmodal.load(name))
    return lambda: np.array(list(solve_identification(problem).values.values()))


def diagnosed(campaign: Campaign, name: str) -> Callable[[], list[float]]:
    """A whole diagnosis; its gaps."""
    robot = flexmodal.load(name)

    def work() -> list[float]:
        gaps = diagnose(campaign, robot).gaps
        return [gaps.before, gaps.after, gaps.held_out_after]

    return work


def works(folder: Path) -> dict[str, Callable[[], Any]]:
    """What is timed, on campaigns as a user has them: written and read."""
    found: dict[str, Callable[[], Any]] = {}
    cases = [
        ("identify", "fanuc_s360", 4, 1, ()), ("identify", "six_link", 3, 1, ()),
        ("identify", "six_axis", 3, 1, ()), ("diagnose", "fanuc_s360", 4, 2, ("local_absorber",)),
        ("diagnose", "six_axis", 4, 2, ("joint_coupling",)),
    ]  # fmt: skip
    for number, (kind, name, postures, references, hidden) in enumerate(cases):
        made = simulate(
            flexmodal.load(name), postures=postures, references=references, trials=2, hide=hidden, seed=3,
            time=False,
        )  # fmt: skip
        write_campaign(made.campaign, folder / str(number))
        campaign = read_campaign(folder / str(number))
        what = f"{kind} {name}" + (f", {hidden[0]} hidden" if hidden else "")
        count = len(campaign.frfs) if campaign.frfs else 0
        build = identified if kind == "identify" else diagnosed
        found[f"{what}: {count} FRFs"] = build(campaign, name)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--check", action="store_true", help="compare with the table, do not write it")
    rounds = parser.parse_args().rounds
    rows, apart = [], 0.0
    with TemporaryDirectory() as folder:
        for name, work in works(Path(folder)).items():
            work()
            before, now = [], []
            for _ in range(rounds):
                with replaced(by_products, by_complex_logarithm):
                    slow, expected = seconds(work)
                quick, answer = seconds(work)
                before.append(slow)
                now.append(quick)
                apart = max(apart, float(np.max(np.abs(answer / expected - 1))))
            calls, parts = shares(work)
            ratio = np.median(np.array(before) / now)
            rows.append([
                name, f"{np.median(before):.2f}", f"{np.median(now):.2f}", f"{ratio:.2f}", str(calls),
                *(f"{100 * part:.0f}" for part in parts),
            ])  # fmt: skip
    write(
        "identification_program",
        "What fits and diagnoses spend their time on",
        f"Made by `make recovery`, one thread, processor time, medians of {rounds} interleaved rounds. "
        "Before: derivatives by the products of all pairs of coordinates, residuals by complex logarithms. "
        "Shares are those of the present form, `receptance` with the solving in it.",
        ["", "before [s]", "now [s]", "times as fast", "calls of `receptance`", "solving Z y = jᵀ [%]",
         "all of `receptance` [%]", "logarithms [%]"],
        rows,
        f"The answers of both forms differ by at most {apart:.0e} of themselves. Loading numba and one "
        f"kernel from its cache takes {loading():.2f} s of processor time; a compiled `receptance` could "
        "save no more than its column. The rest is putting structures together, poles of records that end "
        "early, and linear algebra over the parameters.",
    )  # fmt: skip


if __name__ == "__main__":
    main()

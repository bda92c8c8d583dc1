"""Every goal of the engine as a ratio in one interleaved run: docs/tables/engine.md, .json and .png.

`make bench` takes some minutes. With `--quick` fewer rounds, for a look; with `--only start_up`, or another
part, that part alone, its rows put into the last report.
"""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from engine_cpp import Reference
from engine_harness import Ratio, interleaved
from engine_peers import mujoco_frf, peers, stacked
from engine_search import BEFORE, OURS, THEIRS
from engine_search import problem as search_problem
from engine_search import variants as searches
from engine_systems import LINES, long_chain, random_postures, random_task
from tables import TABLES, write

import flexmodal
from flexmodal import PointDirection
from flexmodal.files import whole_file
from flexmodal.frf.kernels.compiled import OPTIONS, from_source
from flexmodal.frf.kernels.factor import LANES as LANE_COUNT
from flexmodal.frf.kernels.factor import write_kernel
from flexmodal.frf.kernels.planar import PLANAR
from flexmodal.frf.kernels.recursion import TURNING, write_step
from flexmodal.frf.kernels.route import choose, run
from flexmodal.frf.kernels.spatial import SPATIAL
from flexmodal.frf.kernels.task import Task
from flexmodal.model.batch import gradient_batch, receptance_batch
from flexmodal.model.gradient import receptance_and_gradient

ROUNDS = 7 if "--quick" in sys.argv else 25
UP = PointDirection("tool", "z")


@dataclass
class Report:
    """Rows of the table and what else goes into the JSON."""

    rows: list[tuple[str, str, str, str]] = field(default_factory=list)
    numbers: dict[str, Any] = field(default_factory=dict)

    def goal(
        self,
        what: str,
        goal: str,
        found: Ratio | float,
        *,
        most: float = np.inf,
        least: float = -np.inf,
    ) -> None:
        """One row; says whether the goal is reached by the median."""
        reached = least <= (found.median if isinstance(found, Ratio) else found) <= most
        self.rows.append((what, goal, _text(found), "yes" if reached else "no"))
        self.numbers[what] = {"goal": goal, "found": _plain(found), "reached": reached}

    def fact(self, what: str, found: Ratio | float | str) -> None:
        """One row without a goal."""
        self.rows.append((what, "–", _text(found), "–"))
        self.numbers[what] = _plain(found)


def _text(found: Ratio | float | str) -> str:
    return f"{found:.3g}" if isinstance(found, float) else str(found)


def _plain(found: Ratio | float | str) -> object:
    return asdict(found) if isinstance(found, Ratio) else found


def ways_of(task: Task, *ways: str) -> dict[str, tuple[Callable[[], object], int]]:
    """Our ways through a task, on one thread."""
    return {way: (lambda way=way: run(task, choose(task, 1, way)), task.points) for way in ways}


def reference(task: Task, systems: int) -> tuple[Callable[[], object], int]:
    """`np.linalg.solve` on the stack of each of the first systems."""
    masses, rows = task.block(slice(0, systems))

    def call() -> object:
        return [
            stacked(mass, task.damping, task.stiffness, row, task.omega)
            for mass, row in zip(masses, rows, strict=True)
        ]

    return call, systems * len(task.omega)


def tile_alone(task: Task) -> tuple[Callable[[], object], int]:
    """The generated kernel on one tile that stays in the cache: nothing filled in, nothing handed out."""
    kernel = from_source(write_kernel(task.shape)[0], "kernel").compiled

    def loop(tile, rows, out, pairs, work, times):  # type: ignore[no-untyped-def]
        for _ in range(times):
            kernel(tile, rows, out, 6, pairs, work)

    import numba

    compiled = numba.njit(**OPTIONS)(loop)
    tile, rows, out = np.ones(40 * LANE_COUNT), np.ones(6 * LANE_COUNT), np.empty(3 * LANE_COUNT)
    tile[: 7 * LANE_COUNT] = 1.0 + np.random.default_rng(0).uniform(size=7 * LANE_COUNT)
    times = 500
    return lambda: compiled(tile, rows, out, np.zeros((1, 2), int), np.empty(1), times), times * LANE_COUNT


def kernels(report: Report) -> None:
    """One direction, 3 × 3, n = 7, n = 30; and the share of the core's peak."""
    six = random_task(6, 60)
    compiler = _compiler()
    variants = {"solve": reference(six, 4), **ways_of(six, "compiled", "numpy", "compiled any n")}
    if compiler is not None:
        masses, rows = six.block(slice(0, 60))
        packed = masses[:, *np.triu_indices(6)]
        diagonals = np.diag(six.stiffness), np.diag(six.damping)
        variants["C++"] = (
            lambda: [compiler.receptance(packed[s], *diagonals, rows[s, 0], six.omega) for s in range(60)],
            six.points,
        )
        variants["peak 256"] = (lambda: peaks.append(compiler.peak(wide=False)), 1)
        variants["peak 512"] = (lambda: wide.append(compiler.peak(wide=True)), 1)
    variants["tile"] = tile_alone(six)
    peaks: list[float] = []
    wide: list[float] = []
    result = interleaved(variants, ROUNDS)
    report.fact("one direction, n = 6, the arithmetic alone, × stacked solve", result.faster("tile", "solve"))
    report.goal("one direction, n = 6, × stacked solve", "≥ 60", result.faster("compiled", "solve"), least=60)
    report.fact("stacked solve itself, n = 6 [µs a point]", 1e6 * result.median("solve"))
    report.fact("one direction, n = 6, × 2 µs a point", 2e-6 / result.median("compiled"))
    if compiler is not None:
        rate = write_kernel(six.shape)[1] / result.seconds["compiled"]
        share = [_ratio(100 * rate / np.max(found)) for found in (peaks, wide)]
        report.goal("share of the core's FMA peak, 256-bit vectors [%]", "≥ 40", share[0], least=40)
        report.fact("share of its peak on 512-bit vectors [%]", share[1])
        alone = write_kernel(six.shape)[1] / result.seconds["tile"]
        report.fact("the arithmetic alone: share of that peak [%]", _ratio(100 * alone / np.max(wide)))
        roof = _roof(result.seconds["solve"], write_kernel(six.shape)[1], max(peaks + wide))
        report.fact("roof: one direction, n = 6, all of the quicker peak, × stacked solve", roof)
        report.fact("C++ -O3 -march=native, × stacked solve", result.faster("C++", "solve"))
    else:
        report.fact("share of the core's FMA peak", "no C++ compiler here")
    report.fact("numpy form, × stacked solve", result.faster("numpy", "solve"))
    report.fact("kernel of any n at n = 6, × stacked solve", result.faster("compiled any n", "solve"))
    for n in (6, 7):
        many = random_task(n, 1000)
        result = interleaved({"solve": reference(many, 4), **ways_of(many, "compiled")}, ROUNDS)
        found = result.faster("compiled", "solve")
        report.fact(f"one direction, n = {n}, 1000 systems in one call, × stacked solve", found)
    full = random_task(6, 60, diagonal=False)
    result = interleaved({"solve": reference(full, 4), **ways_of(full, "compiled")}, ROUNDS)
    report.fact("one direction, n = 6, K and B full", result.faster("compiled", "solve"))
    matrix = random_task(6, 30, rows=3)
    variants = {"solve": reference(matrix, 4), **ways_of(matrix, "compiled")}
    if compiler is not None:
        variants["peak 256"] = (lambda: peaks.append(compiler.peak(wide=False)), 1)
    result = interleaved(variants, ROUNDS)
    report.goal("3 × 3 matrix, n = 6, × stacked solve", "≥ 30", result.faster("compiled", "solve"), least=30)
    if compiler is not None:
        rate = write_kernel(matrix.shape)[1] / result.seconds["compiled"]
        report.goal(
            "3 × 3: share of the 256-bit FMA peak [%]",
            "≥ 22",
            _ratio(100 * rate / np.max(peaks)),
            least=22,
        )
    seven = random_task(7, 40)
    result = interleaved({"solve": reference(seven, 4), **ways_of(seven, "compiled")}, ROUNDS)
    report.goal("n = 7, × stacked solve", "≥ 55", result.faster("compiled", "solve"), least=55)
    if compiler is not None:
        roof = _roof(result.seconds["solve"], write_kernel(seven.shape)[1], max(peaks + wide))
        report.fact("roof: n = 7, all of the quicker peak, × stacked solve", roof)
    thirty = random_task(30, 2)
    result = interleaved({"solve": reference(thirty, 1), **ways_of(thirty, "compiled any n")}, ROUNDS)
    report.goal(
        "n = 30, any matrices, by elimination, × stacked solve", "≥ 6",
        result.faster("compiled any n", "solve"), least=6,
    )  # fmt: skip


def long_chains(report: Report) -> None:
    """Chains of 30 joints by recursion, kinematics included on our side only."""
    frequency = np.linspace(0.1, 60, LINES)
    omega = 2 * np.pi * frequency
    compiler = _compiler()
    peaks: list[float] = []
    for spatial in (False, True):
        robot = long_chain(30, spatial=spatial)
        posture = random_postures(robot, 64)
        posed = robot.at(dict(zip(robot.commanded, map(float, posture[0]), strict=True)))
        system, row = posed.system, posed.rows(posed.directions("l29:+x"))
        variants: dict[str, tuple[Callable[[], object], int]] = {
            "solve": (
                lambda system=system, row=row: stacked(
                    system.mass, system.damping, system.stiffness, row, omega
                ),
                LINES,
            ),
        }
        for way in ("recursion", *(["compiled any n"] if spatial else [])):
            variants[way] = (
                lambda robot=robot, posture=posture, way=way: receptance_batch(
                    robot, posture, ["l29:+x"], frequency, way=way, threads=1
                ),
                64 * LINES,
            )
        if compiler is not None:
            variants["peak"] = (lambda: peaks.append(compiler.peak(wide=True)), 1)
        result = interleaved(variants, max(5, ROUNDS // 3))
        found = result.faster("recursion", "solve")
        if spatial:
            report.goal("n = 30, any serial chain (in space), × stacked solve", "≥ 6", found, least=6)
            report.fact("the same by elimination, × stacked solve", result.faster("compiled any n", "solve"))
        else:
            report.goal("n = 30, planar chain, × stacked solve", "≥ 80", found, least=80)
        if "peak" in variants:
            step = write_step(SPATIAL if spatial else PLANAR, ((0, 0),), TURNING).split("for p in")[1]
            flops = 30 * sum(step.count(f" {sign} ") for sign in "+-*/")
            share = 100 * flops / result.seconds["recursion"] / np.max(peaks)
            where = "in space" if spatial else "planar"
            report.fact(f"operations a point of the recursion, {where}", float(flops))
            report.fact(f"its share of the 512-bit FMA peak, {where} [%]", _ratio(share))
            roof = _roof(result.seconds["solve"], flops, max(peaks))
            report.fact(f"roof: n = 30 {where}, all of that peak, × stacked solve", roof)


def robots(report: Report) -> None:
    """Kinematics included; gradients."""
    robot = flexmodal.load("six_link")
    postures = random_postures(robot, 200)
    frequency = np.linspace(0.1, 40, LINES)
    omega = 2 * np.pi * frequency
    masses = [robot.at(dict(zip(robot.commanded, map(float, q), strict=True))) for q in postures]
    held = np.array([posed.system.mass for posed in masses]), np.array([posed.rows([UP]) for posed in masses])
    task = Task(
        200, lambda part: (held[0][part], held[1][part]), robot.stiffness, robot.damping, 0 * robot.stiffness,
        ((0, 0),), omega,
    )  # fmt: skip
    mujoco = mujoco_frf(
        str(robot.urdf.path), "link_6", np.diag(robot.stiffness), np.diag(robot.damping), _offset(robot)
    )
    expected = receptance_batch(robot, postures[:1], [UP], frequency).value[0, :, 0]
    assert np.allclose(
        mujoco(postures[0], 2, omega), expected, rtol=1e-6, atol=1e-9 * np.max(np.abs(expected))
    )
    result = interleaved(
        {
            "kernel": (lambda: run(task, choose(task, 1, "compiled")), 200),
            "posture": (
                lambda: receptance_batch(robot, postures, [UP], frequency, way="compiled", threads=1), 200,
            ),
            "mujoco": (lambda: [mujoco(q, 2, omega) for q in postures[:4]], 4),
            "posed": (
                lambda: [
                    stacked(posed.system.mass, robot.damping, robot.stiffness, posed.rows([UP]), omega)
                    for posed in (
                        robot.at(dict(zip(robot.commanded, map(float, q), strict=True))) for q in postures[:4]
                    )
                ],
                4,
            ),
        },
        ROUNDS,
    )  # fmt: skip
    report.goal(
        "posture → 400-line FRF, × the kernel alone (time)", "≤ 2", result.longer("posture", "kernel"), most=2
    )
    report.fact("posture → FRF, × MuJoCo matrices and stacked numpy", result.faster("posture", "mujoco"))
    report.fact("posture → FRF, × Pinocchio matrices and stacked numpy", result.faster("posture", "posed"))
    one = np.array([5.0])
    many = random_postures(robot, 2000)
    result = interleaved(
        {
            "value": (lambda: receptance_batch(robot, many, [UP], one, way="compiled", threads=1), 2000),
            "gradient": (lambda: gradient_batch(robot, many, [UP], one, way="compiled", threads=1), 2000),
            "pin value": (lambda: robot.at("start_1").frf(one, response=UP), 1),
            "pin gradient": (lambda: receptance_and_gradient(robot.at("start_1"), [UP], one), 1),
            "differences": (lambda: [robot.at("start_1").frf(one, response=UP) for _ in range(13)], 1),
        },
        ROUNDS,
    )
    report.goal(
        "value and gradient through Pinocchio, × a value (time)", "≤ 4",
        result.longer("pin gradient", "pin value"), most=4,
    )  # fmt: skip
    report.goal(
        "value and gradient compiled, × a value (time)", "≤ 2", result.longer("gradient", "value"), most=2
    )
    report.fact("value and central differences, × a value (time)", result.longer("differences", "pin value"))
    report.fact("gradient compiled, × gradient through Pinocchio", result.faster("gradient", "pin gradient"))


def field_of_peers(report: Report) -> None:
    """What others offer, one system, 416 frequencies."""
    task = random_task(6, 1)
    masses, rows = task.block(slice(0, 1))
    given = (masses[0], task.damping, task.stiffness, rows[0, 0], task.omega)
    expected = stacked(masses[0], task.damping, task.stiffness, rows[0], task.omega)[:, 0, 0]
    variants: dict[str, tuple[Callable[[], object], int]] = {"solve": reference(task, 1)}
    for name, call in peers(*given).items():
        found = np.asarray(call()).ravel()
        assert np.allclose(found, expected, rtol=1e-5, atol=1e-8 * np.max(np.abs(expected))), name
        variants[name] = (call, task.points)
    result = interleaved(variants, max(5, ROUNDS // 2))
    for name in list(variants)[1:]:
        report.fact(f"{name}, × stacked solve", result.faster(name, "solve"))


def before_and_after(report: Report) -> None:
    """`flexmodal.frf.receptance`, and what the rest of the program calls, against the former direct solve."""
    robot = flexmodal.load("six_link")
    posed = robot.at("start_1")
    row = posed.rows([UP])
    system = posed.system
    from flexmodal.frf.receptance import _by_factorisation, receptance

    for lines in (1, 400, 20_000, 400_000):
        frequency = np.linspace(0.1, 60, lines)
        result = interleaved(
            {
                "before": (
                    lambda f=frequency: _by_factorisation(system, row, row, f),
                    lines,
                ),
                "after": (lambda f=frequency: receptance(system, row, row, f), lines),
            },
            max(5, ROUNDS // 4),
        )
        report.fact(f"flexmodal.frf.receptance, {lines} lines, × before", result.faster("after", "before"))


def search(report: Report) -> None:
    """The posture search, and that its best is the best."""
    variants = searches(search_problem())
    best = {name: call() for name, (call, _) in variants.items()}
    assert best["ours"] <= min(best.values()) + 1e-6, best
    result = interleaved(variants, max(3, ROUNDS // 5))
    report.goal(
        f"posture search, {OURS} starts, × {THEIRS} starts of SLSQP by differences of `robot.at(q).frf`",
        "≥ 80", result.faster("ours", "package"), least=80,
    )  # fmt: skip
    report.fact(
        f"posture search, × {THEIRS} starts of SLSQP by differences of Pinocchio and numpy alone",
        result.faster("ours", "by hand"),
    )
    report.fact(
        "posture search, a start, × the descents in Python",
        result.faster("ours", "descents in Python").times(OURS / BEFORE),
    )
    gain = float(np.exp(min(best["package"], best["by hand"]) - best["ours"]))
    report.fact("receptance found by SLSQP, × ours", gain)


def scaling(report: Report) -> dict[str, list[tuple[int, float, float]]]:
    """Medians of nanoseconds a point, ours and the stacked solve, for n, postures and frequencies."""
    curves: dict[str, list[tuple[int, float, float]]] = {"n": [], "systems": [], "frequencies": []}
    rounds = max(3, ROUNDS // 4)
    for n in (1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 16, 20, 30):
        task = random_task(n, 40 if n <= 8 else 4)
        way = "compiled" if n <= 8 else "compiled any n"
        curves["n"].append((n, *_pair(task, way, 1, rounds)))
    for systems in (1, 4, 16, 64, 256, 1024):
        task = random_task(6, systems)
        curves["systems"].append((systems, *_pair(task, "compiled", 1, rounds)))
    for lines in (1, 8, 32, 128, 1024, 8192, 65536):
        task = random_task(6, max(1, 4096 // lines), lines=lines)
        curves["frequencies"].append((lines, *_pair(task, "compiled", 1, rounds)))
    report.numbers["scaling, ns a point: size, ours, stacked solve"] = curves
    return curves


def _pair(task: Task, way: str, systems: int, rounds: int) -> tuple[float, float]:
    result = interleaved({"solve": reference(task, systems), **ways_of(task, way)}, rounds)
    return 1e9 * result.median(way), 1e9 * result.median("solve")


def memory(report: Report) -> None:
    """Peak resident memory that a sweep of 512 MB of output adds, over that output (Linux)."""
    code = (
        "import resource, numpy as np, flexmodal\n"
        "from flexmodal.model.batch import receptance_batch\n"
        "robot = flexmodal.load('six_link')\n"
        "q = np.zeros((80000, 6)); f = np.linspace(0.1, 40, 400)\n"
        "receptance_batch(robot, q[:200], ['tool:+z'], f, way='compiled')\n"
        "pages = int(open('/proc/self/statm').read().split()[1])\n"
        "out = receptance_batch(robot, q, ['tool:+z'], f, way='compiled').value\n"
        "peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024\n"
        "print((peak - pages * resource.getpagesize()) / out.nbytes)\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    report.goal("memory of a sweep, × its output", "≤ 1.1", float(found.stdout), most=1.1)


def start_up(report: Report) -> None:
    """Processor seconds of whole processes."""
    frf = "import flexmodal; flexmodal.load('six_link').frf('start_1', [1.0, 2.0])"
    commands = {
        "empty": [sys.executable, "-c", ""],
        "import flexmodal [s]": [sys.executable, "-c", "import flexmodal"],
        "flexmodal --help [s]": [sys.executable, "-m", "flexmodal.cli", "--help"],
        "first FRF, warm [s]": [sys.executable, "-c", frf],
    }
    seconds: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(max(3, ROUNDS // 4) + 1):
        for name, command in commands.items():
            before = os.times()
            subprocess.run(command, capture_output=True, check=True)
            after = os.times()
            spent = after.children_user + after.children_system
            seconds[name].append(spent - before.children_user - before.children_system)
    for name, limit in zip(list(commands)[1:], (0.35, 0.25, 1.3), strict=True):
        values = seconds[name][1:]
        low, high = np.percentile(values, [25, 75])
        report.goal(name, f"≤ {limit}", Ratio(statistics.median(values), float(low), float(high)), most=limit)
    report.fact("an empty Python [s]", _ratio(np.array(seconds["empty"][1:])))


def draw(curves: dict[str, list[tuple[int, float, float]]]) -> None:
    """Time a point over n, systems and frequencies."""
    from matplotlib.figure import Figure

    from flexmodal.report import PALETTE

    figure = Figure(figsize=(10, 3.6), layout="constrained")
    labels = {"n": "Joints n [–]", "systems": "Postures [–], n = 6", "frequencies": "Frequencies [–], n = 6"}
    for axes, (name, points) in zip(figure.subplots(1, 3, sharey=True), curves.items(), strict=True):
        size, ours, theirs = zip(*points, strict=True)
        axes.plot(size, theirs, label="stacked solve", color=PALETTE[1], linestyle="--", marker="s")
        axes.plot(size, ours, label="flexmodal", color=PALETTE[0], linestyle="-", marker="o")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel(labels[name])
        axes.grid(visible=True, which="major", color="0.85")
    figure.axes[0].set_ylabel("Time for one receptance [ns]")
    figure.axes[0].legend(frameon=False)
    with whole_file(TABLES / "engine.png", overwrite=True) as scratch:
        figure.savefig(scratch, dpi=130, format="png")


def _compiler() -> Reference | None:
    try:
        return Reference()
    except (FileNotFoundError, subprocess.CalledProcessError, OSError):
        return None


def _ratio(values: np.ndarray) -> Ratio:
    low, median, high = np.percentile(values, [25, 50, 75])
    return Ratio(float(median), float(low), float(high))


def _roof(solve: np.ndarray, flops: float, peak: float) -> Ratio:
    """Times that a point's operations, at the core's peak, fit into a stacked solve: no code does better."""
    return _ratio(solve * peak / flops)


def _offset(robot: Any) -> np.ndarray:
    """Of the tool in the last link's frame [m]."""
    frame = robot.pinocchio.frames[robot.frame_of("tool")]
    return np.array(frame.placement.translation)


def main() -> None:
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        sys.exit("set OPENBLAS_NUM_THREADS=1, as `make bench` does: one thread for everybody")
    report = Report()
    only = sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else ""
    parts = (kernels, long_chains, robots, search, memory, start_up, before_and_after, field_of_peers)
    for part in parts:
        if only in ("", part.__name__):
            part(report)
    if only:
        report = _into_the_last(report)
    else:
        draw(scaling(report))
    rounds = sorted(
        {ROUNDS, *np.atleast_1d(report.numbers.get("machine", {}).get("rounds", ROUNDS)).tolist()}
    )
    often = " to ".join(map(str, (rounds[0], rounds[-1])[: len(rounds)]))
    report.numbers["machine"] = {
        "processor": _processor(), "python": platform.python_version(), "numpy": np.__version__,
        "rounds": rounds,
    }  # fmt: skip
    with whole_file(TABLES / "engine.json", overwrite=True) as scratch:
        scratch.write_text(json.dumps(report.numbers, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    write(
        "engine",
        "The engine, measured",
        f"Made by `make bench` on {_processor()}, one thread, {often} interleaved rounds: median ratio of "
        "processor times, in brackets the quartiles over the rounds. `× stacked solve` is how many times as "
        "fast as `np.linalg.solve` on a stack of matrices, a point. Times a point over n, postures and "
        "frequencies are in [engine.png](engine.png), all numbers in [engine.json](engine.json).",
        ["what", "goal", "found", "reached"],
        report.rows,
    )


def _into_the_last(part: Report) -> Report:
    """The last report with the rows of one part measured again."""
    numbers = json.loads((TABLES / "engine.json").read_text(encoding="utf-8"))
    lines = (TABLES / "engine.md").read_text(encoding="utf-8").splitlines()
    cells = [tuple(cell.strip() for cell in line.strip("|").split("|")) for line in lines if line[:2] == "| "]
    fresh = {row[0]: row for row in part.rows}
    rows = [fresh.pop(row[0], row) for row in cells[1:] if len(row) == 4]
    return Report([*rows, *fresh.values()], {**numbers, **part.numbers})


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
